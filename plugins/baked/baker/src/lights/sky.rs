//! Pictures of skies.

use std::{
    collections::BTreeMap,
    path::{Path, PathBuf},
    sync::Arc,
};

use farlight_baked_format::Fingerprint;
use farlight_environment::{Environment, EnvironmentError, Layout};
use farlight_gi_solver::scene::SkyImage;

use super::{BakeLights, LightsError, SkySpec};

/// A picture, read but not decoded.
pub(crate) struct SkySource {
    pub(crate) path: PathBuf,
    pub(crate) fingerprint: Fingerprint,
    /// The field that names it first.
    pub(crate) field: String,
    bytes: Vec<u8>,
}

/// Reads the pictures that scenarios name, by those names. `file` and `text` are those of the lights.
pub(crate) fn read_skies(
    file: &Path,
    text: &str,
    lights: &BakeLights,
) -> Result<BTreeMap<String, SkySource>, LightsError> {
    let folder = file.parent().unwrap_or(Path::new("."));
    let mut skies = BTreeMap::new();
    for (i, scenario) in lights.scenarios.iter().enumerate() {
        let Some(SkySpec::Image { file: name, .. }) = &scenario.sky else { continue };
        if skies.contains_key(name) {
            continue;
        }
        let path = folder.join(name);
        let field = format!("scenarios[{i}].sky.file");
        let bytes = std::fs::read(&path).map_err(|source| {
            let problem = EnvironmentError::Io { path: path.clone(), source };
            LightsError::of_field(file, text, field.clone(), &problem)
        })?;
        let fingerprint = Fingerprint::of(&bytes);
        skies.insert(name.clone(), SkySource { path, fingerprint, bytes, field });
    }
    Ok(skies)
}

impl SkySource {
    /// Decodes the picture.
    pub(crate) fn decode(&self) -> Result<Arc<SkyImage>, EnvironmentError> {
        let map = Environment::read(&self.bytes, Layout::Equirect).map_err(|problem| {
            EnvironmentError::File { path: self.path.clone(), source: Box::new(problem) }
        })?;
        let (width, height) = (map.width(), map.height());
        Ok(Arc::new(SkyImage { width, height, texels: map.texels().to_vec() }))
    }
}
