//! The file that is baked.

use std::path::{Path, PathBuf};

use farlight_baked_format::Fingerprint;
use farlight_gi_solver::import::{
    ImportError, ImportLimits, ImportOptions, ImportProblem, ImportedScene, Package, load_scene,
};
use serde_json::Value;

/// A glTF file with its buffers and images.
#[derive(Clone, Debug)]
pub struct Source {
    pub(super) json: Value,
    pub(super) buffers: Vec<Vec<u8>>,
    pub(super) images: Vec<Option<Vec<u8>>>,
    files: Vec<PathBuf>,
    warnings: Vec<String>,
    fingerprint: Fingerprint,
    name: String,
}

impl Source {
    /// Reads a `.glb` or `.gltf` file, its buffers and images.
    ///
    /// # Errors
    /// As [`farlight_gi_solver::import::load_scene`].
    pub fn open(path: &Path, limits: &ImportLimits) -> Result<Self, ImportError> {
        Self::new(Package::open(path, limits)?, path.display().to_string())
    }

    /// Reads a file that is in memory. It cannot refer to other files.
    ///
    /// # Errors
    /// As [`farlight_gi_solver::import::load_scene_from_slice`].
    pub fn from_slice(bytes: &[u8], limits: &ImportLimits) -> Result<Self, ImportError> {
        Self::new(Package::from_slice(bytes, limits)?, "glTF data in memory".into())
    }

    fn new(package: Package, name: String) -> Result<Self, ImportError> {
        let Package { json, buffers, images, files, warnings } = package;
        let mut hasher = blake3::Hasher::new();
        let mut part = |bytes: &[u8]| {
            hasher.update(&(bytes.len() as u64).to_le_bytes());
            hasher.update(bytes);
        };
        part(&json);
        buffers.iter().for_each(|buffer| part(buffer));
        images.iter().for_each(|image| part(image.as_deref().unwrap_or_default()));
        let fingerprint = Fingerprint::from(&hasher.finalize());
        let json = serde_json::from_slice(&json).map_err(|error| ImportError {
            file: name.clone(),
            problem: ImportProblem::NotGltf(error.to_string()),
        })?;
        Ok(Self { json, buffers, images, files, warnings, fingerprint, name })
    }

    /// The scene of the file as it was when the source was opened, for
    /// [`second_sets`](crate::uv::second_sets).
    ///
    /// # Errors
    /// As [`farlight_gi_solver::import::load_scene`].
    pub fn scene(&self, options: &ImportOptions) -> Result<ImportedScene, ImportError> {
        load_scene(&self.files[0], options)
    }

    /// The file and the files beside it that were read; empty for data in memory.
    #[must_use]
    pub fn files(&self) -> &[PathBuf] {
        &self.files
    }

    /// Of everything that was read: JSON, buffers, images.
    #[must_use]
    pub fn fingerprint(&self) -> Fingerprint {
        self.fingerprint
    }

    /// What could not be read (images that are missing, ...).
    #[must_use]
    pub fn warnings(&self) -> &[String] {
        &self.warnings
    }

    /// The path, or `glTF data in memory`.
    #[must_use]
    pub fn name(&self) -> &str {
        &self.name
    }

    /// The JSON of the file.
    #[must_use]
    pub fn json(&self) -> &Value {
        &self.json
    }
}
