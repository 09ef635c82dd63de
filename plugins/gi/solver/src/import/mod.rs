//! glTF 2.0 files into scenes, with limits and clear errors.
//!
//! [`load_scene`] reads `.glb` and `.gltf` (buffers and images inside, as data URIs, or in files
//! below the file's folder) into a [`Scene`]:
//!
//! - one [`Mesh`](crate::scene::Mesh) a primitive, one [`Instance`](crate::scene::Instance) a node
//!   and primitive. All primitives of a glTF mesh share one UV square, as exporters write them.
//! - `KHR_lights_punctual`: numbers 1:1 (`color * intensity`), no photometric factor.
//! - `emissiveFactor * KHR_materials_emissive_strength` 1:1 as radiance.
//! - `KHR_texture_transform` of the base colour, `KHR_mesh_quantization`, sparse accessors.
//!
//! Ids follow from the file: [`LightId`] is the node's index, a mesh id is `mesh << 32 | primitive`,
//! an instance id is `node << 32 | primitive`, a material id is the material's index
//! ([`DEFAULT_MATERIAL`] for primitives without one).
//!
//! Nothing in a file makes this panic or take memory beyond [`ImportLimits`]: every offset is checked
//! before it is used and every count before it is allocated. What is broken but can be left out
//! (NaN positions, triangles without area, images that do not decode) is left out with a warning.

mod accessor;
mod container;
mod error;
mod geometry;
mod material;
mod nodes;
mod package;

use std::{collections::BTreeMap, path::Path, sync::Arc};

pub use error::{ImportError, ImportProblem};
pub use package::Package;

use crate::scene::{InstanceId, LightId, MaterialId, MeshId, Scene};
use error::Warnings;

/// The material of primitives that name none.
pub const DEFAULT_MATERIAL: MaterialId = MaterialId(u64::MAX);

/// The two numbers that the id of a mesh or of an instance is made of: the index of the mesh or of the
/// node, and that of the primitive.
#[must_use]
pub fn split_id(id: u64) -> [u32; 2] {
    [(id >> 32) as u32, id as u32]
}

/// How to read a file.
#[derive(Clone, Debug)]
pub struct ImportOptions {
    /// Metres a unit of the file: applied to positions, translations and light ranges. Intensities
    /// stay as they are.
    pub scale: f32,
    /// Whether point and spot lights get Bevy's range window (the file's range, 20 m where it has
    /// none, as Bevy's loader does). Otherwise they fall off with 1/r² alone.
    pub range_window: bool,
    /// What a file may ask for.
    pub limits: ImportLimits,
}

impl Default for ImportOptions {
    fn default() -> Self {
        Self { scale: 1.0, range_window: false, limits: ImportLimits::default() }
    }
}

/// What a file may ask for. The defaults keep a scene under about 3 GB.
#[derive(Clone, Debug)]
pub struct ImportLimits {
    /// Bytes of the file and of all files that it refers to.
    pub file_bytes: u64,
    /// Values (objects, arrays and their elements) in the JSON part.
    pub json_values: u64,
    /// Triangles, each counted once an instance.
    pub triangles: u64,
    /// Vertices of all meshes.
    pub vertices: u64,
    /// Texels of all textures in use.
    pub texture_texels: u64,
    /// Levels of the node hierarchy.
    pub depth: u64,
}

impl Default for ImportLimits {
    fn default() -> Self {
        Self {
            file_bytes: 1 << 30,
            json_values: 4_000_000,
            triangles: 16_000_000,
            vertices: 24_000_000,
            texture_texels: 1 << 28,
            depth: 1000,
        }
    }
}

/// A file's scene.
#[derive(Clone, Debug, Default)]
pub struct ImportedScene {
    /// The default scene of the file (the first where none is named).
    pub scene: Scene,
    /// The lights in the order in which their nodes occur in the file.
    pub light_ids: Vec<LightId>,
    /// Names of instances, for messages: node, and mesh and primitive where they tell more.
    pub instance_names: BTreeMap<InstanceId, String>,
    /// Of meshes that do not use all vertices of their primitive: the vertex in the file of each
    /// vertex of the mesh, ascending. The others have the vertices of the file.
    pub file_vertices: BTreeMap<MeshId, Arc<[u32]>>,
    /// What was left out or repaired, and why. At most about a hundred.
    pub warnings: Vec<String>,
}

/// Reads a `.glb` or `.gltf` file.
///
/// # Errors
/// [`ImportError`] with the file's path: it cannot be read, is not glTF, is damaged, needs an
/// extension that is not supported, or is larger than the limits.
pub fn load_scene(path: &Path, options: &ImportOptions) -> Result<ImportedScene, ImportError> {
    let name = |problem| ImportError { file: path.display().to_string(), problem };
    let mut budget = container::FileBudget::new(&options.limits);
    let bytes = budget.read(path).map_err(name)?;
    let folder = path.parent().unwrap_or(Path::new("."));
    load(&bytes, Some(folder), budget, options).map_err(name)
}

/// Reads a `.glb` or `.gltf` file that is in memory. It cannot refer to other files.
///
/// # Errors
/// As [`load_scene`].
pub fn load_scene_from_slice(
    bytes: &[u8],
    options: &ImportOptions,
) -> Result<ImportedScene, ImportError> {
    let mut budget = container::FileBudget::new(&options.limits);
    budget
        .take(bytes.len() as u64)
        .and_then(|()| load(bytes, None, budget, options))
        .map_err(|problem| ImportError { file: "glTF data in memory".into(), problem })
}

fn load(
    bytes: &[u8],
    folder: Option<&Path>,
    budget: container::FileBudget,
    options: &ImportOptions,
) -> Result<ImportedScene, ImportProblem> {
    let mut warnings = Warnings::default();
    let file = container::File::open(bytes, folder, budget, options, &mut warnings)?;
    read(&file, options, warnings)
}

fn read(
    file: &container::File<'_>,
    options: &ImportOptions,
    mut warnings: Warnings,
) -> Result<ImportedScene, ImportProblem> {
    let mut imported = ImportedScene::default();
    nodes::read(file, options, &mut imported, &mut warnings)?;
    if imported.scene.instances.is_empty() {
        warnings.push(|| "the scene has no triangles".into());
    }
    imported.warnings = warnings.finish();
    Ok(imported)
}
