//! The file that is baked.

use std::path::{Path, PathBuf};

use farlight_baked_format::Fingerprint;
use farlight_gi_solver::import::{
    ImportError, ImportLimits, ImportOptions, ImportProblem, ImportedScene, Package,
};
use serde_json::Value;

/// A glTF file with its buffers and images.
#[derive(Clone, Debug)]
pub struct Source {
    pub(super) package: Package,
    pub(super) json: Value,
    fingerprint: Fingerprint,
}

impl Source {
    /// Reads a `.glb` or `.gltf` file, its buffers and images.
    ///
    /// # Errors
    /// As [`farlight_gi_solver::import::load_scene`].
    pub fn open(path: &Path, limits: &ImportLimits) -> Result<Self, ImportError> {
        Self::new(Package::open(path, limits)?)
    }

    /// Reads a file that is in memory. It cannot refer to other files.
    ///
    /// # Errors
    /// As [`farlight_gi_solver::import::load_scene_from_slice`].
    pub fn from_slice(bytes: &[u8], limits: &ImportLimits) -> Result<Self, ImportError> {
        Self::new(Package::from_slice(bytes, limits)?)
    }

    fn new(package: Package) -> Result<Self, ImportError> {
        let mut hasher = blake3::Hasher::new();
        let mut part = |bytes: &[u8]| {
            hasher.update(&(bytes.len() as u64).to_le_bytes());
            hasher.update(bytes);
        };
        part(&package.json);
        package.buffers.iter().for_each(|buffer| part(buffer));
        package.images.iter().for_each(|image| part(image.as_deref().unwrap_or_default()));
        let fingerprint = Fingerprint::from(&hasher.finalize());
        let json = serde_json::from_slice(&package.json).map_err(|error| ImportError {
            file: package.name(),
            problem: ImportProblem::NotGltf(error.to_string()),
        })?;
        // The importer takes a list for an object where it can.
        if !Value::is_object(&json) {
            return Err(ImportError {
                file: package.name(),
                problem: ImportProblem::NotGltf("its JSON is no object".into()),
            });
        }
        Ok(Self { package, json, fingerprint })
    }

    /// The scene of the file as it was when the source was opened, for
    /// [`second_sets`](crate::uv::second_sets).
    ///
    /// # Errors
    /// As [`farlight_gi_solver::import::load_scene`].
    pub fn scene(&self, options: &ImportOptions) -> Result<ImportedScene, ImportError> {
        self.package.scene(options)
    }

    /// The file and the files beside it that were read; empty for data in memory.
    #[must_use]
    pub fn files(&self) -> &[PathBuf] {
        &self.package.files
    }

    /// Of everything that was read: JSON, buffers, images.
    #[must_use]
    pub fn fingerprint(&self) -> Fingerprint {
        self.fingerprint
    }

    /// What could not be read (images that are missing, ...).
    #[must_use]
    pub fn warnings(&self) -> &[String] {
        &self.package.warnings
    }

    /// The path, or `glTF data in memory`.
    #[must_use]
    pub fn name(&self) -> String {
        self.package.name()
    }

    /// The JSON of the file.
    #[must_use]
    pub fn json(&self) -> &Value {
        &self.json
    }
}
