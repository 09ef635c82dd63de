//! Finds points of texels that lie inside of other geometry, and better ones.
//!
//! Walls run a little into floors, furniture stands against walls: the point that stands for a texel
//! may lie where nobody sees it, while other parts of the texel are in the open. Light solved
//! there would darken the texel and everything that it lights. Short rays that skim the surface
//! tell: from inside of something they meet backs. Only backs of materials that are not double-sided count: of
//! these nobody sees the inside.

use std::f32::consts::TAU;

use glam::Vec3;
use rayon::prelude::*;

use super::patches::Patches;
use crate::{Ray, World, visibility::offset_origin};

/// Skimming rays a point.
const RAYS: u32 = 8;
/// So many of them that meet backs mean that a point is buried.
const BACKS: u32 = 2;
/// Their length in texels.
const LENGTH: f32 = 1.5;

/// Moves points of texels that are buried to parts of the texel in the open. Returns for each texel
/// whether there are any; `texel` is its edge in metres.
pub(crate) fn unbury(world: &World, patches: &mut Patches, texel: f32) -> Vec<bool> {
    let length = texel * LENGTH;
    let found: Vec<(bool, Option<u8>)> = (0..patches.fronts)
        .into_par_iter()
        .with_min_len(64)
        .map(|i| {
            let normal = patches.normal[i];
            let (backs, any) = skim(world, patches.position[i], normal, length);
            if !any {
                // Nothing is near: all of the texel is in the open.
                return (true, None);
            }
            let bad = patches.samples[i].iter().enumerate().fold(0, |bad, (k, sample)| {
                let (backs, _) = skim(world, *sample, patches.sample_normals[i][k], length);
                bad | (u8::from(backs >= BACKS) << k)
            });
            (backs < BACKS, Some(bad))
        })
        .collect();
    let mut open = vec![true; patches.fronts];
    for (i, (point_open, bad_samples)) in found.into_iter().enumerate() {
        if let Some(bad) = bad_samples {
            open[i] = patches.move_points(i, point_open, bad);
        }
    }
    open
}

/// How many skimming rays meet backs that nobody sees, and whether any meets anything.
fn skim(world: &World, point: Vec3, normal: Vec3, length: f32) -> (u32, bool) {
    let (x, y) = normal.any_orthonormal_pair();
    let origin = offset_origin(point, normal);
    let (mut backs, mut any) = (0, false);
    for k in 0..RAYS {
        let (sin, cos) = (TAU * (k as f32 + 0.5) / RAYS as f32).sin_cos();
        // Flat and steep ones by turns.
        let rise = if k % 2 == 0 { 0.25 } else { 0.8 };
        let direction = (x * cos + y * sin + normal * rise).normalize();
        let hit = world.closest(&Ray { t_max: length, ..Ray::new(origin, direction) });
        if hit.is_hit() {
            any = true;
            backs += u32::from(is_hidden_back(world, hit.triangle, direction));
        }
    }
    (backs, any)
}

/// Whether a ray meets the back of a surface whose back is not drawn. What emits lights what is
/// behind it, too, and counts as a surface to be seen.
pub(crate) fn is_hidden_back(world: &World, triangle: u32, direction: Vec3) -> bool {
    let material = &world.instances()[world.instance_of(triangle) as usize].material;
    world.is_back(triangle, direction) && !material.double_sided && material.emissive == Vec3::ZERO
}
