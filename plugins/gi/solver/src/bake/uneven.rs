//! Texels that are too coarse for the light of a lamp.
//!
//! What a lampshade's inside sends through the room is not the mean of what its few texels get: the upper
//! edge, which the ceiling sees, is darker than the middle. And where a texel reaches around an edge, its
//! inside says nothing about its outside.

use glam::Vec3;
use rayon::prelude::*;

use super::{Layout, map::alike};
use crate::{World, scene::LightKind};

/// Nearer to a lamp than so many edges of a texel, what arrives at the texel's points differs by more than a
/// quarter.
const NEAR_LAMP: f32 = 8.0;

/// Texels within which what arrives straight from lights varies much: nearer than [`NEAR_LAMP`] of their
/// edges to a lamp, or with surfaces that face another way than their point.
pub(super) fn uneven(world: &World, layout: &Layout) -> Vec<bool> {
    let near = NEAR_LAMP / layout.texels_per_metre;
    let lamps: Vec<Vec3> = world
        .lights
        .iter()
        .filter(|light| !matches!(light.kind, LightKind::Directional))
        .map(|light| light.position)
        .collect();
    let patches = &layout.patches;
    let of = |texel: usize| {
        let receiver = layout.receiver_of(texel as u32);
        let first = world.instances()[receiver.instance as usize].first_triangle;
        let triangles = receiver.texels.triangles_in(texel - receiver.first as usize);
        let (position, normal) = (patches.position[texel], patches.normal[texel]);
        lamps.iter().any(|lamp| lamp.distance_squared(position) < near * near)
            || triangles.iter().any(|t| !alike(world.normal(first + t), normal))
    };
    (0..layout.len()).into_par_iter().map(of).collect()
}
