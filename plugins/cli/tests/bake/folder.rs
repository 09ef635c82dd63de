//! Running bakes, and looking into their folders.

use std::{
    collections::BTreeMap,
    fs,
    path::{Path, PathBuf},
    process::{Command, Output},
};

use farlight_baked_format::{Fingerprint, Manifest, exr, ktx2};

/// Two rooms of 9.2 x 4 x 3 m with a doorway, and one lamp.
pub(crate) const SCENE: &str =
    concat!(env!("CARGO_MANIFEST_DIR"), "/../../tests/data/TwoRooms.glb");

/// The command, for a scene and a folder.
pub(crate) fn command(scene: &str, out: &Path, more: &[&str]) -> Command {
    let mut command = Command::new(env!("CARGO_BIN_EXE_farlight"));
    command.args(["bake", scene, "--out", out.to_str().unwrap()]).args(more);
    command
}

/// A bake of the two rooms.
pub(crate) fn bake(out: &Path, more: &[&str]) -> Output {
    command(SCENE, out, more).output().unwrap()
}

/// What a good bake says.
#[track_caller]
pub(crate) fn baked(out: &Path, more: &[&str]) -> String {
    crate::support::succeeded(&bake(out, more))
}

/// All files of a folder but those of the cache.
pub(crate) fn contents(out: &Path) -> BTreeMap<String, Vec<u8>> {
    let Ok(entries) = fs::read_dir(out) else { return BTreeMap::new() };
    entries
        .map(Result::unwrap)
        .filter(|entry| entry.path().is_file())
        .map(|entry| (entry.file_name().into_string().unwrap(), fs::read(entry.path()).unwrap()))
        .collect()
}

pub(crate) fn manifest_path(out: &Path) -> PathBuf {
    out.join("TwoRooms.baked.ron")
}

/// Checks that a manifest and all that it names belong together; `None` where there is none.
#[track_caller]
pub(crate) fn checked(out: &Path) -> Option<Manifest> {
    let text = fs::read_to_string(manifest_path(out)).ok()?;
    let manifest = Manifest::parse(&text).unwrap();
    let read = |name: &str| {
        let bytes = fs::read(out.join(name)).unwrap_or_else(|error| panic!("{name}: {error}"));
        let hash = name.rsplit('.').nth(1).unwrap();
        assert_eq!(Fingerprint::of(&bytes).short(), hash, "{name}");
        bytes
    };
    for scenario in &manifest.scenarios {
        assert_eq!(scenario.pages.len(), manifest.pages as usize);
        for page in &scenario.pages {
            let texture = ktx2::Texture::read(&read(&page.ktx2)).unwrap();
            assert_eq!(texture.texels.len(), (manifest.page_size * manifest.page_size) as usize);
            if !page.exr.is_empty() {
                let picture = exr::Picture::read(&read(&page.exr)).unwrap();
                assert_eq!([picture.width, picture.height], [manifest.page_size; 2]);
            }
        }
        for volume in &scenario.volumes {
            ktx2::Texture::read(&read(volume)).unwrap();
        }
    }
    let glb = fs::read(out.join(&manifest.scene)).unwrap();
    assert!(glb.starts_with(b"glTF"));
    Some(manifest)
}

/// The texels of a page of the first scenario.
pub(crate) fn page(out: &Path, manifest: &Manifest, page: usize) -> exr::Picture {
    let name = &manifest.scenarios[0].pages[page].exr;
    exr::Picture::read(&fs::read(out.join(name)).unwrap()).unwrap()
}
