//! A file with everything that belongs to it, for programs that write glTF.

use std::path::{Path, PathBuf};

use super::{
    ImportError, ImportLimits, ImportOptions, ImportProblem, ImportedScene,
    container::{File, FileBudget},
    error::{Warnings, label},
};

/// The parts of a `.glb` or `.gltf` file as they are, read with the checks and limits of
/// [`load_scene`](super::load_scene).
#[derive(Clone, Debug, Default)]
pub struct Package {
    /// The JSON text.
    pub json: Vec<u8>,
    /// The data of each buffer, from wherever it was; at least as long as the JSON says.
    pub buffers: Vec<Vec<u8>>,
    /// The data of each image that has a URI; `None` for images in buffers, and for those that can't
    /// be read (which a warning tells).
    pub images: Vec<Option<Vec<u8>>>,
    /// The file and all files beside it that were read. Empty for data in memory.
    pub files: Vec<PathBuf>,
    /// What could not be read.
    pub warnings: Vec<String>,
}

impl Package {
    /// Reads a file.
    ///
    /// # Errors
    /// As [`load_scene`](super::load_scene).
    pub fn open(path: &Path, limits: &ImportLimits) -> Result<Self, ImportError> {
        let name = |problem| ImportError { file: path.display().to_string(), problem };
        let mut budget = FileBudget::new(limits);
        let bytes = budget.read(path).map_err(name)?;
        let folder = path.parent().unwrap_or(Path::new("."));
        let mut package = Self::read(&bytes, Some(folder), budget, limits).map_err(name)?;
        package.files.insert(0, path.to_path_buf());
        Ok(package)
    }

    /// Reads a file that is in memory. It cannot refer to other files.
    ///
    /// # Errors
    /// As [`load_scene`](super::load_scene).
    pub fn from_slice(bytes: &[u8], limits: &ImportLimits) -> Result<Self, ImportError> {
        let mut budget = FileBudget::new(limits);
        budget
            .take(bytes.len() as u64)
            .and_then(|()| Self::read(bytes, None, budget, limits))
            .map_err(|problem| ImportError { file: "glTF data in memory".into(), problem })
    }

    /// The scene of the file, as it was when it was read.
    ///
    /// # Errors
    /// As [`load_scene`](super::load_scene).
    pub fn scene(&self, options: &ImportOptions) -> Result<ImportedScene, ImportError> {
        let mut warnings = Warnings::default();
        File::of_package(self, options, &mut warnings)
            .and_then(|file| super::read(&file, options, warnings))
            .map_err(|problem| ImportError { file: self.name(), problem })
    }

    /// The file's path, or `glTF data in memory`.
    #[must_use]
    pub fn name(&self) -> String {
        match self.files.first() {
            Some(path) => path.display().to_string(),
            None => "glTF data in memory".into(),
        }
    }

    fn read(
        bytes: &[u8],
        folder: Option<&Path>,
        budget: FileBudget,
        limits: &ImportLimits,
    ) -> Result<Self, ImportProblem> {
        let options = ImportOptions { limits: limits.clone(), ..Default::default() };
        // What opening warns of, reading the scene warns of too.
        let file = File::open(bytes, folder, budget, &options, &mut Warnings::default())?;
        let mut warnings = Warnings::default();
        let mut images = Vec::with_capacity(file.root.images.len());
        for (i, image) in file.root.images.iter().enumerate() {
            images.push(match &image.uri {
                Some(uri) if image.buffer_view.is_none() => match file.image(i, uri) {
                    Ok(bytes) => Some(bytes.into_owned()),
                    Err(limit @ ImportProblem::Limit { .. }) => return Err(limit),
                    Err(problem) => {
                        let name = label("image", i, image.name.as_deref());
                        warnings.push(|| format!("{name} {problem}; it stays outside"));
                        None
                    }
                },
                _ => None,
            });
        }
        Ok(Self {
            json: file.json.to_vec(),
            images,
            files: file.read.take(),
            buffers: file.into_buffers(),
            warnings: warnings.finish(),
        })
    }
}
