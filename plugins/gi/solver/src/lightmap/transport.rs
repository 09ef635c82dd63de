//! Rays that are traced once while the geometry stays, and what each of them met.
//!
//! Every patch owns a scrambled (0, 2)-sequence of cosine-distributed directions. It is traced in
//! blocks (16 rays, then as many as there are already), so that after each block the rays so far are a
//! well-spread set. A ray is remembered as the number of the patch that it met, four bytes; light that
//! changes asks for no ray again.

use glam::{Vec3, Vec4};
use rayon::prelude::*;

use super::{
    bury::is_hidden_back,
    patches::{Met, Patches},
    sequence::{cosine_direction, hash2, pack_direction, sobol, sphere_direction},
};
use crate::{Hit, Ray, World, visibility::offset_origin};

/// Rays of the first block.
pub(crate) const FIRST_BLOCK: u32 = 16;

/// Where a family of rays starts.
#[derive(Clone, Copy)]
pub(crate) enum Origin {
    /// A point on a surface; rays leave around the normal, cosine-distributed.
    Surface(Vec3, Vec3),
    /// A point in space; rays leave in all directions, the same from every such point.
    Space(Vec3),
}

/// The rays `first..first + count` of every origin.
#[derive(Default)]
pub(crate) struct Block {
    pub first: u32,
    pub count: u32,
    /// `count` for each origin: one more than the patch that was met, 0 for none. Sorted, so that
    /// reading walks through memory.
    pub met: Vec<u32>,
    /// Origin and packed direction of each ray that met the sky, in order of the origins.
    pub sky: Vec<(u32, u32)>,
}

/// How many rays of an origin tell that it is buried in something.
#[derive(Clone, Copy, Default)]
pub(crate) struct Buried {
    pub rays: u32,
    /// Rays that met a back face, weighed: 1 for one of a closed mesh, or nearer than the limit.
    pub inside: u32,
    /// Rays that met a back that is not drawn.
    pub hidden: u32,
    /// Rays that met any back face.
    pub back: u32,
}

impl Block {
    pub(crate) fn new(first: u32, count: u32) -> Self {
        Self { first, count, ..Self::default() }
    }

    /// How many origins have been traced.
    pub(crate) fn origins(&self) -> usize {
        self.met.len() / self.count.max(1) as usize
    }

    /// Traces the rays of the next origins and makes the patches that they meet. `near` is the
    /// distance below which a back face means that the origin is inside of something.
    pub(crate) fn trace(
        &mut self,
        world: &World,
        closed: &[bool],
        patches: &mut Patches,
        origins: &[Origin],
        near: f32,
        seed: u32,
    ) -> Vec<Buried> {
        let start = self.origins();
        let count = self.count as usize;
        let mut rays = vec![(Met::Sky, Hit::NONE, Vec3::ZERO); origins.len() * count];
        let frozen = &*patches;
        rays.par_chunks_mut(count).zip(origins).with_min_len(8).enumerate().for_each(
            |(i, (out, origin))| {
                let seed = family_seed(seed, start + i);
                for (j, out) in out.iter_mut().enumerate() {
                    let ray = family_ray(origin, self.first + j as u32, seed);
                    let hit = world.closest(&ray);
                    *out = (frozen.meet(world, &hit, ray.direction), hit, ray.direction);
                }
            },
        );
        let young = patches.len();
        let mut buried = vec![Buried::default(); origins.len()];
        for (i, rays) in rays.chunks(count).enumerate() {
            for (met, hit, direction) in rays {
                if *met == Met::Sky {
                    self.sky.push(((start + i) as u32, pack_direction(*direction)));
                } else if world.is_back(hit.triangle, *direction) {
                    let instance = world.instance_of(hit.triangle) as usize;
                    let hidden = is_hidden_back(world, hit.triangle, *direction);
                    buried[i].hidden += u32::from(hidden);
                    buried[i].inside += u32::from(closed[instance] || (hidden && hit.t < near));
                    buried[i].back += 1;
                }
                let patch = patches.patch(world, *met, hit, *direction, young);
                self.met.push(patch.map_or(0, |p| p + 1));
            }
            buried[i].rays = self.count;
            let from = self.met.len() - count;
            if matches!(origins[i], Origin::Surface(..)) {
                self.met[from..].sort_unstable();
            }
        }
        buried
    }

    /// The sum of the table's entries that the rays of an origin point at.
    pub(crate) fn gather(&self, origin: usize, table: &[Vec4]) -> Vec4 {
        let count = self.count as usize;
        let mut sums = [Vec4::ZERO; 4];
        for four in self.met[origin * count..(origin + 1) * count].chunks_exact(4) {
            for (sum, &met) in sums.iter_mut().zip(four) {
                *sum += table[met as usize];
            }
        }
        (sums[0] + sums[1]) + (sums[2] + sums[3])
    }
}

/// The seed of an origin's family.
pub(crate) fn family_seed(seed: u32, origin: usize) -> u32 {
    hash2(seed, origin as u32)
}

/// Ray `index` of an origin's family.
pub(crate) fn family_ray(origin: &Origin, index: u32, seed: u32) -> Ray {
    match *origin {
        Origin::Surface(position, normal) => {
            Ray::new(offset_origin(position, normal), cosine_direction(sobol(index, seed), normal))
        }
        Origin::Space(position) => Ray::new(position, space_direction(index)),
    }
}

/// Direction `index` from any point in space.
pub(crate) fn space_direction(index: u32) -> Vec3 {
    sphere_direction(sobol(index, 0x51ed_270b))
}
