//! What all measured materials share.

use bevy::{prelude::*, render::extract_resource::ExtractResource};
use farlight_core::field::{Label, Unit};

/// Settings of the plugin. Changes take effect at once.
#[derive(Resource, ExtractResource, Clone, Debug, PartialEq, Reflect)]
#[reflect(Resource, Default)]
pub struct BtfSettings {
    /// Directions from which light of an environment map is met, 1 to 64: more is sharper and
    /// costs as much as so many lights.
    #[reflect(@1..=64_u32)]
    pub environment_directions: u32,
    /// Directions that tell how much of a lightmap's, an irradiance volume's or ambient light is
    /// reflected, where there is no environment map, 1 to 64.
    #[reflect(@1..=64_u32)]
    pub albedo_directions: u32,
    /// Bytes of new materials that are sent to the GPU in a frame, at least 4096. A material is
    /// shown when all of it is there. One that takes the place of another, changed on disk, is sent
    /// in one frame.
    #[reflect(@4_096..=268_435_456_u64, @Unit("B"), @Label("Upload a frame"))]
    pub upload_bytes_per_frame: u64,
    /// The largest buffer of materials, in bytes. The device has a limit of its own. Materials that
    /// find no room in one buffer go into another; those of different buffers are not drawn
    /// together.
    #[reflect(@1_048_576..=4_294_967_296_u64, @Unit("B"), @Label("Largest buffer"))]
    pub max_buffer_bytes: u64,
}

impl Default for BtfSettings {
    fn default() -> Self {
        Self {
            environment_directions: 12,
            albedo_directions: 6,
            upload_bytes_per_frame: 8 << 20,
            max_buffer_bytes: 1 << 30,
        }
    }
}

/// What the shader is told for every material.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub(crate) struct Directions {
    pub(crate) environment: u32,
    pub(crate) albedo: u32,
}

impl BtfSettings {
    pub(crate) fn directions(&self) -> Directions {
        Directions {
            environment: self.environment_directions.clamp(1, 64),
            albedo: self.albedo_directions.clamp(1, 64),
        }
    }
}
