//! Probes on a grid.

use rayon::prelude::*;

use super::{Gatherer, lobe::Sphere};
use crate::{
    Ray, World,
    estimate::Progress,
    lightmap::{Buried, GridState, is_closed, is_hidden_back},
    sampling::{PathSampler, hash_pair, uniform_sphere},
    scene::DirectSky,
    session::{GridId, ProbeGrid},
    sh::{ShRgb, sh_basis},
};

/// Keeps the random numbers of probes apart from those of texels.
const STREAM: u64 = 0x0070_726f_6265;
/// Rays a probe that tell whether it is inside of something.
const FEELERS: u32 = 64;

/// Radiance at the probes of a grid in spherical harmonics, x fastest, then y, then z: from surfaces,
/// and straight from the sky unless the gatherer's settings leave it out. What punctual lights send
/// straight is not part of it. `paths` rays a probe; `world` is the gatherer's. Probes inside of
/// something take their neighbours' light. `None` if `progress` stopped the work.
///
/// Rays see what gather rays of texels see, so that a probe costs about as much as a texel with as many
/// rays. The result doesn't depend on the number of threads.
#[must_use]
pub fn volume(
    world: &World,
    gatherer: &Gatherer<'_>,
    grid: &ProbeGrid,
    paths: u32,
    progress: Progress<'_>,
) -> Option<Vec<ShRgb>> {
    let mut state = GridState::new(GridId(0), *grid);
    let positions = state.positions();
    let settings = gatherer.settings();
    let sky = settings.direct_sky == DirectSky::Included;
    state.result = positions
        .par_iter()
        .enumerate()
        .map(|(i, position)| {
            let set = hash_pair(settings.seed ^ STREAM, i as u64);
            let mut sum = ShRgb::ZERO;
            for ray in 0..paths {
                let mut sampler = PathSampler::new(set, ray, 16);
                gatherer.field.sample(*position, &Sphere, sky, &mut sampler, |direction, light| {
                    for (sum, y) in sum.0.iter_mut().zip(sh_basis(direction)) {
                        *sum += light * y;
                    }
                });
            }
            progress(u64::from(paths)).is_continue().then(|| sum * (1.0 / paths.max(1) as f32))
        })
        .collect::<Option<_>>()?;

    let closed: Vec<bool> = world.instances().iter().map(|i| is_closed(&i.mesh)).collect();
    let near = 0.5 / gatherer.field.layout.texels_per_metre;
    state.buried = positions
        .par_iter()
        .map(|position| {
            let mut buried = Buried { rays: FEELERS, ..Buried::default() };
            for ray in 0..FEELERS {
                let u = PathSampler::new(STREAM, ray, 16).next_2d();
                let direction = uniform_sphere(u);
                let hit = world.closest(&Ray::new(*position, direction));
                if hit.is_hit() && world.is_back(hit.triangle, direction) {
                    let instance = world.instance_of(hit.triangle) as usize;
                    let hidden = is_hidden_back(world, hit.triangle, direction);
                    buried.inside += u32::from(closed[instance] || (hidden && hit.t < near));
                    buried.back += 1;
                }
            }
            buried
        })
        .collect();
    state.fill_buried();
    Some(state.result)
}
