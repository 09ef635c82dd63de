//! The converged answer: the lightmap's texel centres as receivers of the solver's path tracer.
//!
//! Nothing here shares code with the live lightmap besides the scene, the tracer and the places of
//! the charts: which texels are covered is found out anew, from the second UV sets.

use std::{
    collections::BTreeMap,
    ops::ControlFlow,
    sync::atomic::{AtomicU64, Ordering},
};

use bevy::math::{Affine3A, UVec3, Vec2, Vec3};
use farlight_gi_solver::{
    Ray, Scene, World,
    estimate::{GatherSettings, no_progress},
    probe::gather_probes,
    receiver::{Receiver, ReceiverLight, gather_receivers},
    scene::{DirectSky, Mesh},
    session::{GridId, GridUpdate, Placement, ProbeGrid},
};

/// A texel whose centre lies on a surface.
#[derive(Clone, Copy, Debug)]
pub struct TexelCentre {
    /// Page, column, row.
    pub texel: [u32; 3],
    /// The surface there.
    pub receiver: Receiver,
}

/// All texels of the placed instances whose centres lie on a surface in the open, in the order of
/// pages and rows. What is buried under or inside of something is never seen.
pub fn texel_centres(scene: &Scene, placements: &[Placement]) -> Vec<TexelCentre> {
    let mut centres = Vec::new();
    for placement in placements {
        let Some(instance) = scene.instances.get(&placement.instance) else { continue };
        let Some(mesh) = scene.meshes.get(&instance.mesh) else { continue };
        centres_of(mesh, &instance.transform, placement, &mut centres);
    }
    centres.sort_by_key(|c| [c.texel[0], c.texel[2], c.texel[1]]);
    centres.dedup_by_key(|c| c.texel);
    let world = World::new(scene);
    centres.retain(|c| is_open(&world, &c.receiver));
    centres
}

/// Whether less than half of the rays from a point meet surfaces from behind.
fn is_open(world: &World, receiver: &Receiver) -> bool {
    const RAYS: u32 = 64;
    let (x, y) = receiver.normal.any_orthonormal_pair();
    let behind = (0..RAYS).filter(|&i| {
        // A spiral of directions with density cos θ / π.
        let radius = ((i as f32 + 0.5) / RAYS as f32).sqrt();
        let (sin, cos) = (i as f32 * 2.399_963_2).sin_cos();
        let up = (1.0 - radius * radius).sqrt();
        let direction = (x * cos + y * sin) * radius + receiver.normal * up;
        let hit = world.tracer.closest(&Ray::new(receiver.origin(), direction));
        hit.is_hit() && world.surface(&hit, direction).back
    });
    (behind.count() as u32) < RAYS / 2
}

fn centres_of(
    mesh: &Mesh,
    transform: &Affine3A,
    placement: &Placement,
    centres: &mut Vec<TexelCentre>,
) {
    if mesh.uv1.is_empty() {
        return;
    }
    let rect = placement.rect;
    let (origin, size) =
        (Vec2::new(rect.x as f32, rect.y as f32), Vec2::new(rect.width as f32, rect.height as f32));
    let side = transform.matrix3.determinant().signum();
    for corners in &mesh.triangles {
        let uv = corners.map(|i| origin + mesh.uv1[i as usize] * size);
        let p = corners.map(|i| transform.transform_point3(mesh.positions[i as usize]));
        let normal = (p[1] - p[0]).cross(p[2] - p[0]).normalize_or_zero() * side;
        let area = (uv[1] - uv[0]).perp_dot(uv[2] - uv[0]);
        if area == 0.0 || normal == Vec3::ZERO {
            continue;
        }
        let low = uv[0].min(uv[1]).min(uv[2]).floor().max(origin).as_uvec2();
        let high = uv[0].max(uv[1]).max(uv[2]).ceil().min(origin + size).as_uvec2();
        for y in low.y..high.y {
            for x in low.x..high.x {
                let centre = Vec2::new(x as f32 + 0.5, y as f32 + 0.5) - uv[0];
                let b = centre.perp_dot(uv[2] - uv[0]) / area;
                let c = (uv[1] - uv[0]).perp_dot(centre) / area;
                if b >= 0.0 && c >= 0.0 && b + c <= 1.0 {
                    let position = p[0] + (p[1] - p[0]) * b + (p[2] - p[0]) * c;
                    centres.push(TexelCentre {
                        texel: [placement.page.0, x, y],
                        receiver: Receiver { position, normal },
                    });
                }
            }
        }
    }
}

/// Converged texels.
pub struct Converged {
    /// Irradiance / π: indirect, and that of the sky unless the scene leaves it out.
    pub texels: Vec<Vec3>,
    /// Standard error of each texel over its value, channels summed.
    pub relative_se: Vec<f32>,
}

/// What the texels hold when converged. Shows its progress on the terminal.
pub fn converge(scene: &Scene, centres: &[TexelCentre], settings: &GatherSettings) -> Converged {
    let world = World::new(scene);
    let receivers: Vec<Receiver> = centres.iter().map(|c| c.receiver).collect();
    let all = settings.traced() * receivers.len() as u64;
    let done = AtomicU64::new(0);
    let shown = AtomicU64::new(0);
    let progress = |paths: u64| {
        let tenths = (done.fetch_add(paths, Ordering::Relaxed) + paths) * 10 / all.max(1);
        if shown.fetch_max(tenths, Ordering::Relaxed) < tenths {
            eprint!(".");
        }
        ControlFlow::Continue(())
    };
    let light = gather_receivers(&world, &receivers, settings, &progress).unwrap_or_default();
    // What arrives straight from the sky, and its standard error.
    let sky = |light: &ReceiverLight, receiver: &Receiver| match scene.direct_sky {
        DirectSky::Included => (light.direct.mean - receiver.direct(&world), light.direct.se),
        DirectSky::LeftOut => (Vec3::ZERO, Vec3::ZERO),
    };
    let both = || light.iter().zip(&receivers);
    let texels = both()
        .map(|(l, r)| (l.indirect.mean + sky(l, r).0) * std::f32::consts::FRAC_1_PI)
        .collect();
    // Errors of the channels stem from the same paths, so they add up; so do those of the sky.
    let relative_se = both()
        .map(|(l, r)| {
            let (sky, sky_se) = sky(l, r);
            let whole = (l.indirect.mean + sky).element_sum();
            (l.indirect.se + sky_se).element_sum() / whole.max(f32::MIN_POSITIVE)
        })
        .collect();
    Converged { texels, relative_se }
}

/// The probes of all grids, converged, as [`converge`] has it for texels.
pub fn converge_grids(
    scene: &Scene,
    grids: &BTreeMap<GridId, ProbeGrid>,
    settings: &GatherSettings,
) -> Vec<GridUpdate> {
    let world = World::new(scene);
    grids
        .iter()
        .map(|(&id, grid)| {
            let n = grid.resolution;
            let positions: Vec<Vec3> = (0..n.element_product())
                .map(|i| {
                    let cell = UVec3::new(i % n.x, i / n.x % n.y, i / (n.x * n.y)).as_vec3();
                    grid.transform.transform_point3((cell + 0.5) / n.as_vec3() - 0.5)
                })
                .collect();
            let light = gather_probes(&world, &positions, settings, no_progress());
            let probes = light
                .unwrap_or_default()
                .iter()
                .map(|p| match scene.direct_sky {
                    DirectSky::Included => p.indirect + p.sky,
                    DirectSky::LeftOut => p.indirect,
                })
                .collect();
            GridUpdate { grid: id, resolution: n, probes }
        })
        .collect()
}

/// Fills texels without a value from their neighbours, ring by ring, so that filtering finds no
/// black at the edges of charts.
pub fn dilate(texels: &mut [Option<Vec3>], width: usize, rings: usize) {
    for _ in 0..rings {
        let last = texels.to_vec();
        let height = last.len() / width.max(1);
        for (i, texel) in texels.iter_mut().enumerate().filter(|(_, t)| t.is_none()) {
            let (x, y) = (i % width, i / width);
            let neighbours: Vec<Vec3> = (y.saturating_sub(1)..(y + 2).min(height))
                .flat_map(|y| (x.saturating_sub(1)..(x + 2).min(width)).map(move |x| (x, y)))
                .filter_map(|(x, y)| last[y * width + x])
                .collect();
            if !neighbours.is_empty() {
                *texel = Some(neighbours.iter().sum::<Vec3>() / neighbours.len() as f32);
            }
        }
    }
}
