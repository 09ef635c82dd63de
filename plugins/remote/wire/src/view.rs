//! Where a client looks from. Lightmaps and probes don't need it; services that render views do.

use glam::{Mat4, Quat, UVec2, Vec3};

/// A camera of the client at one frame.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct View {
    /// Which view, for clients with several (the eyes of a headset).
    pub id: u32,
    /// The client's frame.
    pub frame: u64,
    /// Position in the world, metres.
    pub position: Vec3,
    /// From the camera's space (looking along -z, y up) to the world.
    pub rotation: Quat,
    /// From the camera's space to clip space (Bevy's: reverse z, depth 1 near to 0 far).
    pub projection: Mat4,
    /// Pixels.
    pub size: UVec2,
    /// Poses that the client expects to have, each so many microseconds after this frame.
    pub predicted: Vec<(u32, Vec3, Quat)>,
}
