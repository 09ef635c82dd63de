//! The manifest: what a bake made, for whom, and how.
//!
//! A text file in RON, `NAME.baked.ron`, beside the files that it names. It is written last: what it
//! does not name does not count.

use glam::{Affine3A, Mat3A, UVec3, Vec3, Vec3A};
use serde::{Deserialize, Serialize};
use thiserror::Error;

use crate::Fingerprint;

mod text;
mod validate;

pub use validate::{MOST_PAGES, MOST_PROBES, PAGE_SIZE, VOLUME_TEXELS};

/// The version of the format that this crate reads and writes.
pub const VERSION: u32 = 1;

/// What the names of manifests end with.
pub const EXTENSION: &str = "baked.ron";

/// Everything that a bake made.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields, rename = "BakedManifest")]
pub struct Manifest {
    /// [`VERSION`].
    pub version: u32,
    /// The lit scene: a .glb file in the manifest's folder.
    pub scene: String,
    /// Fingerprint of everything that the bake read: files, lights, settings.
    pub input: Fingerprint,
    /// Whether the bake came to its end; if not, what is there is right but noisier, and the next run
    /// goes on.
    pub complete: bool,
    /// How it was baked.
    pub settings: Settings,
    /// Edge of the square lightmap pages in texels: 1 to [`PAGE_SIZE`], or 0 if there are none.
    pub page_size: u32,
    /// How many pages each scenario has, at most [`MOST_PAGES`].
    pub pages: u32,
    /// Primitives that are lit by a lightmap, by node and primitive.
    pub receivers: Vec<Receiver>,
    /// Primitives that have none, and why.
    #[serde(default)]
    pub left_out: Vec<LeftOut>,
    /// Boxes of probes.
    #[serde(default)]
    pub volumes: Vec<Volume>,
    /// What was baked from the scene: at least one, the first is shown where nobody chooses.
    pub scenarios: Vec<Scenario>,
}

/// How a bake was made, for people and for comparing.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields, default)]
pub struct Settings {
    /// Metres a unit of the source file.
    pub scale: f32,
    /// Lightmap texels a metre that came out.
    pub texels_per_metre: f32,
    /// Gather rays a texel that were asked for.
    pub samples: u32,
    /// Most reflections of light; 0 is no limit.
    pub bounces: u32,
    /// Whether noise was filtered.
    pub denoise: bool,
    /// Seed of all random numbers.
    pub seed: u64,
}

impl Default for Settings {
    fn default() -> Self {
        Self { scale: 1.0, texels_per_metre: 0.0, samples: 0, bounces: 0, denoise: false, seed: 0 }
    }
}

/// A primitive of a node's mesh that is lit by a lightmap.
#[derive(Clone, Debug, Default, PartialEq, Eq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Receiver {
    /// Index of the node in the glTF file (`extras.farlight_node` in the lit scene).
    pub node: u32,
    /// Index of the primitive in the node's mesh.
    pub primitive: u32,
    /// The node's name, for people.
    #[serde(default)]
    pub name: String,
    /// Index of the page.
    pub page: u32,
    /// The texels `(x, y, width, height)` that the primitive's second UV square 0..1 covers, rows from
    /// the top.
    pub rect: [u32; 4],
    /// [`Fingerprint::of_uv`] of the primitive's second UV set in the lit scene.
    pub uv: Fingerprint,
}

/// A primitive without a lightmap.
#[derive(Clone, Debug, Default, PartialEq, Eq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct LeftOut {
    /// Index of the node in the glTF file.
    pub node: u32,
    /// Index of the primitive in the node's mesh.
    pub primitive: u32,
    /// The node's name, for people.
    #[serde(default)]
    pub name: String,
    /// Why.
    pub reason: String,
}

/// A box of probes: an irradiance volume of Bevy.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Volume {
    /// The columns x, y, z and translation of the transform from the unit cube (-0.5..0.5) to the lit scene
    /// in metres. Probe `(i, j, k)` sits at `((ijk + 0.5) / resolution - 0.5)`.
    pub transform: [[f32; 3]; 4],
    /// Probes along x, y, z: at least one, at most [`MOST_PROBES`] in all, and no side of the texture
    /// longer than [`VOLUME_TEXELS`].
    pub resolution: [u32; 3],
}

/// One state of the lights, and the light that it makes.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Scenario {
    /// How a game calls it; no two have the same one.
    pub name: String,
    /// One a page.
    pub pages: Vec<Page>,
    /// One KTX2 file a volume.
    #[serde(default)]
    pub volumes: Vec<String>,
    /// Every light that shines in it.
    #[serde(default)]
    pub lights: Vec<Light>,
    /// Radiance of the sky in cd/m² where it is the same from everywhere, for a game's ambient
    /// light and background.
    #[serde(default)]
    pub sky: [f32; 3],
    /// Gather rays a texel that were traced.
    pub samples: u32,
    /// Estimated median relative error of the lit texels (0.01 = 1 %), before noise was filtered.
    pub relative_error: f32,
}

/// A lightmap page.
#[derive(Clone, Debug, Default, PartialEq, Eq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Page {
    /// KTX2, what the engine loads.
    pub ktx2: String,
    /// OpenEXR, for people and other programs; empty if it was not asked for.
    #[serde(default)]
    pub exr: String,
}

/// A light of a scenario.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Light {
    /// Its node in the glTF file, once in a scenario; `None` for one that was added, which the engine
    /// makes from the rest of this description.
    #[serde(default)]
    pub node: Option<u32>,
    /// Its name.
    #[serde(default)]
    pub name: String,
    /// Whether the lightmap holds what arrives straight from it. If not, the engine adds it.
    pub direct: Direct,
    /// Its shape.
    pub kind: LightKind,
    /// World position in metres.
    #[serde(default)]
    pub position: [f32; 3],
    /// Unit direction in which it shines, of spot and directional lights.
    #[serde(default)]
    pub direction: [f32; 3],
    /// Luminous intensity in cd, or illuminance in lx of a directional light: linear RGB.
    pub intensity: [f32; 3],
    /// Distance in metres at which it ends; 0 for none.
    #[serde(default)]
    pub range: f32,
    /// Radius in metres of a point or spot light, or half the angle in radians of a directional one, for
    /// soft shadows.
    #[serde(default)]
    pub radius: f32,
}

/// Who shows what arrives straight from a light.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize)]
pub enum Direct {
    /// The lightmap: shadows never change, and cost nothing.
    #[default]
    Baked,
    /// The engine, as for any light; the lightmap holds only what surfaces reflect of it.
    Realtime,
}

/// Shapes of lights.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub enum LightKind {
    /// To all sides.
    Point,
    /// A cone; half angles in radians, 0 <= inner <= outer <= π/2.
    Spot {
        /// Full intensity inside.
        inner: f32,
        /// Nothing outside.
        outer: f32,
    },
    /// Parallel light.
    Directional,
}

/// Why a manifest can't be used.
#[derive(Clone, Debug, Error, PartialEq)]
pub enum ManifestError {
    /// Not RON, or not a manifest; the text starts with line and column.
    #[error("{0}")]
    Syntax(String),
    /// Another version of the format.
    #[error("version {found} of the format, this is {VERSION}: bake the scene again")]
    Version {
        /// What the file says.
        found: u32,
    },
    /// A value that can't be.
    #[error("{field}: {problem}")]
    Field {
        /// Where, as in the file.
        field: String,
        /// What is wrong.
        problem: String,
    },
}

impl Manifest {
    /// The scenario of a name.
    #[must_use]
    pub fn scenario(&self, name: &str) -> Option<&Scenario> {
        self.scenarios.iter().find(|scenario| scenario.name == name)
    }
}

impl Volume {
    /// From the unit cube to the lit scene.
    #[must_use]
    pub fn affine(&self) -> Affine3A {
        let [x, y, z, translation] = self.transform.map(Vec3A::from);
        Affine3A { matrix3: Mat3A::from_cols(x, y, z), translation }
    }

    /// A box of probes with the given place.
    #[must_use]
    pub fn new(transform: &Affine3A, resolution: UVec3) -> Self {
        let matrix = transform.matrix3;
        let columns = [matrix.x_axis, matrix.y_axis, matrix.z_axis, transform.translation];
        Self { transform: columns.map(|c| Vec3::from(c).to_array()), resolution: resolution.into() }
    }
}
