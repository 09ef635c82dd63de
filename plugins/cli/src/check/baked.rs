//! `farlight check`: manifests of baked lighting, and whether the files that they name are there.

use std::path::Path;

use farlight_baked_format::{
    Manifest, exr::Picture, ktx2::Texture, manifest::ManifestError, volume::texture_size,
};
use glam::UVec3;

use crate::error::CliError;

/// Checks a manifest and all files that it names.
pub(super) fn check(path: &Path, text: &str) -> Result<(), CliError> {
    let manifest = Manifest::parse(text).map_err(|error| match error {
        // It begins with line and column.
        ManifestError::Syntax(text) => CliError::beside(path, text),
        error => CliError::beside(path, format_args!(" {error}")),
    })?;
    let folder = path.parent().unwrap_or(Path::new(""));
    let named = |field: String, file: &str, check: &dyn Fn(&[u8]) -> Result<(), String>| {
        let bytes = std::fs::read(folder.join(file)).map_err(|error| error.to_string());
        bytes
            .and_then(|bytes| check(&bytes))
            .map_err(|problem| CliError::beside(path, format_args!(" {field}: {file}: {problem}")))
    };
    named("scene".to_owned(), &manifest.scene, &|bytes| {
        let good = bytes.starts_with(b"glTF");
        if good { Ok(()) } else { Err("is no binary glTF file".to_owned()) }
    })?;
    let page = UVec3::new(manifest.page_size, manifest.page_size, 1);
    for (at, scenario) in manifest.scenarios.iter().enumerate() {
        for (i, files) in scenario.pages.iter().enumerate() {
            let field = |what| format!("scenarios[{at}].pages[{i}].{what}");
            named(field("ktx2"), &files.ktx2, &|bytes| texture(bytes, page))?;
            if !files.exr.is_empty() {
                named(field("exr"), &files.exr, &|bytes| {
                    let picture = Picture::read(bytes).map_err(|error| error.to_string())?;
                    sized(UVec3::new(picture.width, picture.height, 1), page)
                })?;
            }
        }
        for (i, (file, volume)) in scenario.volumes.iter().zip(&manifest.volumes).enumerate() {
            let size = texture_size(UVec3::from(volume.resolution));
            let field = format!("scenarios[{at}].volumes[{i}]");
            named(field, file, &|bytes| texture(bytes, size))?;
        }
    }
    Ok(())
}

fn texture(bytes: &[u8], size: UVec3) -> Result<(), String> {
    let texture = Texture::read(bytes).map_err(|error| error.to_string())?;
    sized(texture.size, size)
}

fn sized(found: UVec3, expected: UVec3) -> Result<(), String> {
    if found == expected {
        Ok(())
    } else {
        Err(format!("has {found} texels, the manifest says {expected}"))
    }
}

#[cfg(test)]
mod tests {
    use std::fs;

    use farlight_baked_format::{
        exr, ktx2,
        manifest::{Page, Scenario, VERSION, Volume},
    };
    use glam::{Affine3A, Vec3};

    use super::*;

    const RESOLUTION: UVec3 = UVec3::new(2, 1, 3);

    fn manifest() -> Manifest {
        Manifest {
            version: VERSION,
            scene: "room.glb".to_owned(),
            page_size: 8,
            pages: 1,
            volumes: vec![Volume::new(&Affine3A::IDENTITY, RESOLUTION)],
            scenarios: vec![Scenario {
                name: "day".to_owned(),
                pages: vec![Page { ktx2: "day.ktx2".to_owned(), exr: "day.exr".to_owned() }],
                volumes: vec!["volume.ktx2".to_owned()],
                samples: 1,
                ..Default::default()
            }],
            ..Default::default()
        }
    }

    #[test]
    fn what_is_named_must_be_there_and_fit() {
        let folder = std::env::temp_dir().join(format!("farlight-check-{}", std::process::id()));
        fs::create_dir_all(&folder).unwrap();
        let path = folder.join("room.baked.ron");
        let put = |file: &str, bytes: &[u8]| fs::write(folder.join(file), bytes).unwrap();
        let error = || {
            let error = check(&path, &manifest().to_text()).unwrap_err().to_string();
            error.strip_prefix(&format!("{}: ", path.display())).unwrap_or(&error).to_owned()
        };
        assert!(error().starts_with("scene: room.glb: "), "{}", error());
        put("room.glb", b"glTF\0");
        assert!(error().starts_with("scenarios[0].pages[0].ktx2: day.ktx2: "), "{}", error());
        put("day.ktx2", &ktx2::lightmap_page(4, 8, &[]));
        let expected = "scenarios[0].pages[0].ktx2: day.ktx2: has [4, 8, 1] texels, the manifest says \
                        [8, 8, 1]";
        assert_eq!(error(), expected);
        put("day.ktx2", &ktx2::lightmap_page(8, 8, &[Vec3::ONE]));
        put("day.exr", b"no picture");
        assert!(
            error().starts_with("scenarios[0].pages[0].exr: day.exr: OpenEXR: "),
            "{}",
            error()
        );
        put("day.exr", &exr::write(8, 8, &[Vec3::ONE]).unwrap());
        put("volume.ktx2", &ktx2::volume(UVec3::ONE, &[]));
        assert!(error().contains("volumes[0]: volume.ktx2: has [1, 2, 3] texels"), "{}", error());
        put("volume.ktx2", &ktx2::volume(RESOLUTION, &[]));
        assert!(check(&path, &manifest().to_text()).is_ok());

        let text = manifest().to_text().replace("pages: 1,", "pages: 2,");
        let error = check(&path, &text).unwrap_err().to_string();
        assert!(
            error.ends_with(
                "room.baked.ron: scenarios[0].pages: it has 1 pages, the manifest says 2"
            ),
            "{error}"
        );
        let text = manifest().to_text().replace("version: 1,", "version: one,");
        let error = check(&path, &text).unwrap_err().to_string();
        assert!(error.contains("room.baked.ron:2:"), "{error}");
        fs::remove_dir_all(&folder).unwrap();
    }
}
