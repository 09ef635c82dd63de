//! Which texels, and which parts of them, lie where somebody sees them.
//!
//! [`unbury`](crate::lightmap) has found points inside of other geometry by short rays that skim the
//! surface. Two things are left: texels with a thin wall across them, and texels that are enclosed in
//! something from afar, like the floor under a wide box.

use glam::Vec3;
use rayon::prelude::*;

use crate::{
    Ray, World,
    lightmap::{Patches, SAMPLES, is_closed, is_hidden_back},
    sampling::{Frame, PathSampler, cosine_hemisphere, hash_pair},
    visibility::offset_origin,
};

/// How high above the surface the way between two points of a texel runs, in texels.
const LIFT: f32 = 0.1;
/// Rays a texel that look for backs; where none meets one, that is all.
const FEW_RAYS: u32 = 8;
/// Rays that decide.
const MORE_RAYS: u32 = 32;
/// A texel is enclosed if this part of its rays meets the inside of closed meshes, or backs near by.
const BURIED: f32 = 0.5;
/// It is also if this part of its rays meets backs that are not drawn, however far away.
const ENCLOSED: f32 = 0.8;

/// Gives up those sample points of texels that something parts from the texel's point. Returns for each
/// texel whether there are any.
pub(super) fn part_sides(world: &World, patches: &mut Patches, texel: f32) -> Vec<bool> {
    let lift = texel * LIFT;
    let bad: Vec<u8> = (0..patches.fronts)
        .into_par_iter()
        .with_min_len(64)
        .map(|i| {
            let normal = patches.normal[i];
            let from = patches.position[i] + normal * lift;
            let samples = patches.samples[i].iter().zip(&patches.sample_normals[i]);
            samples.enumerate().fold(0, |bad, (k, (to, to_normal))| {
                let way = *to + *to_normal * lift - from;
                let parted = way.length_squared() > 0.0
                    && world.occluded(&Ray { t_max: 1.0, ..Ray::new(from, way) });
                bad | (u8::from(parted) << k)
            })
        })
        .collect();
    for (i, bad) in bad.iter().enumerate() {
        if *bad == (1 << SAMPLES) - 1 {
            // Each of them is on some other side: the texel's point stands for all.
            patches.gather_samples_at_point(i);
        } else if *bad != 0 {
            patches.move_points(i, true, *bad);
        }
    }
    bad.into_iter().map(|bad| bad != 0).collect()
}

/// Which of the texels that have a point in the `open` are not enclosed in something.
pub(super) fn not_enclosed(
    world: &World,
    patches: &Patches,
    open: &[bool],
    texel: f32,
) -> Vec<bool> {
    let closed: Vec<bool> = world.instances().iter().map(|i| is_closed(&i.mesh)).collect();
    let near = texel * 0.5;
    open.par_iter()
        .with_min_len(64)
        .enumerate()
        .map(|(i, open)| {
            let tells =
                |rays| tell(world, &closed, patches.position[i], patches.normal[i], near, i, rays);
            if !open || tells(FEW_RAYS) == (0, 0) {
                return *open;
            }
            let (inside, hidden) = tells(MORE_RAYS);
            (inside as f32) < BURIED * MORE_RAYS as f32
                && (hidden as f32) < ENCLOSED * MORE_RAYS as f32
        })
        .collect()
}

/// How many rays from a point meet the inside of closed meshes or hidden backs nearer than `near`, and how
/// many meet hidden backs.
fn tell(
    world: &World,
    closed: &[bool],
    point: Vec3,
    normal: Vec3,
    near: f32,
    texel: usize,
    rays: u32,
) -> (u32, u32) {
    let (origin, frame) = (offset_origin(point, normal), Frame::new(normal));
    let set = hash_pair(1, texel as u64);
    let (mut inside, mut hidden) = (0, 0);
    for ray in 0..rays {
        let local = cosine_hemisphere(PathSampler::new(set, ray, 8).next_2d());
        let ray = Ray::new(origin, frame.to_world(local));
        let hit = world.closest(&ray);
        if hit.is_hit() && world.is_back(hit.triangle, ray.direction) {
            let is_hidden = is_hidden_back(world, hit.triangle, ray.direction);
            let in_closed = closed[world.instance_of(hit.triangle) as usize];
            inside += u32::from(in_closed || (is_hidden && hit.t < near));
            hidden += u32::from(is_hidden);
        }
    }
    (inside, hidden)
}
