//! What light does in the cloth: rays against the yarns, and light that has been reflected before.
//!
//! For one azimuth of the view, all lights are followed at once: they share the rays.

use farlight_gi_solver::sampling::{Frame, concentric_disk, cosine_hemisphere, sobol_owen_4d};
use farlight_gi_solver::{Ray, Tracer};
use glam::{Vec2, Vec3};
use rayon::prelude::*;

use crate::fibre::{DIFFUSE, Shading};
use crate::weave::{Mesh, Place, Surface, TILE, Weave, YARNS};

/// Cells of the reflected light along a yarn in the tile, and round it.
const CELLS: [usize; 2] = [64, 16];
/// Rays by which a cell gathers.
const LINKS: u32 = 96;
/// Reflections before the last one.
const BOUNCES: usize = 4;
/// How far shadow rays start off the surface, so that facets don't shade each other.
const LIFT: f32 = 0.012;

/// The cloth, ready for rays.
pub(crate) struct Cloth {
    pub(crate) weave: Weave,
    pub(crate) mesh: Mesh,
    tracer: Tracer,
    cells: Vec<Surface>,
    points: Vec<Vec3>,
    /// For each cell, those that its rays met; the others left the cloth.
    links: Vec<Vec<u32>>,
}

impl Cloth {
    pub(crate) fn new(weave: Weave, mesh: Mesh, seed: u64) -> Self {
        let tracer = Tracer::new(&mesh.triangles);
        let places: Vec<Place> = (0..2 * YARNS * CELLS[0] * CELLS[1]).map(place_of_cell).collect();
        let cells: Vec<Surface> = places.par_iter().map(|place| weave.surface(*place)).collect();
        let points = places.par_iter().map(|place| weave.position(*place)).collect();
        let mut cloth = Self { weave, mesh, tracer, cells, points, links: Vec::new() };
        cloth.links =
            (0..cloth.cells.len()).into_par_iter().map(|cell| cloth.links_of(cell, seed)).collect();
        cloth
    }

    fn links_of(&self, cell: usize, seed: u64) -> Vec<u32> {
        let normal = self.cells[cell].normal;
        let frame = Frame::new(normal);
        let origin = self.inside_tile(self.points[cell]) + LIFT * normal;
        let mut links = Vec::new();
        for ray in 0..LINKS {
            let [u, v, ..] = sobol_owen_4d(ray, seed ^ (cell as u64) << 20);
            let direction = frame.to_world(cosine_hemisphere(Vec2::new(u, v)));
            let hit = self.tracer.closest(&Ray::new(origin, direction));
            if hit.is_hit() {
                let (place, _) = self.mesh.hit(hit.triangle, hit.u, hit.v);
                let met = cell_at(place);
                // From inside a yarn nothing is seen.
                if self.cells[met].normal.dot(direction) < 0.0 {
                    links.push(met as u32);
                }
            }
        }
        links
    }

    fn inside_tile(&self, point: Vec3) -> Vec3 {
        Vec3::new(point.x.rem_euclid(TILE), point.y.rem_euclid(TILE), point.z)
    }

    /// Where a line of sight meets the cloth: `point` lies in the middle plane.
    pub(crate) fn seen(&self, point: Vec3, view: Vec3) -> Option<(Place, Vec3)> {
        let start = (self.mesh.heights[1] + 0.01 - point.z) / view.z;
        let hit = self.tracer.closest(&Ray::new(point + start * view, -view));
        hit.is_hit().then(|| {
            let (place, copy) = self.mesh.hit(hit.triangle, hit.u, hit.v);
            let at = point + (start - hit.t) * view;
            (place, self.inside_tile(at - Mesh::offsets()[copy]))
        })
    }

    fn lit(&self, origin: Vec3, light: Vec3) -> bool {
        !self.tracer.occluded(&Ray::new(origin, light))
    }

    /// Irradiance over that of a plane across the light, of each cell for each light, by light
    /// that was reflected at least once (diffusely).
    pub(crate) fn reflected(&self, lights: &[Vec3]) -> Vec<Vec3> {
        let count = lights.len();
        let mut direct = vec![0.0_f32; self.cells.len() * count];
        direct.par_chunks_mut(count).enumerate().for_each(|(cell, direct)| {
            let normal = self.cells[cell].normal;
            let origin = self.inside_tile(self.points[cell]) + LIFT * normal;
            for (direct, light) in direct.iter_mut().zip(lights) {
                let cosine = normal.dot(*light);
                if cosine > 0.0 && self.lit(origin, *light) {
                    *direct = cosine;
                }
            }
        });
        let mut reflected = vec![Vec3::ZERO; direct.len()];
        let mut leaving = reflected.clone();
        for _ in 0..BOUNCES {
            leaving.par_chunks_mut(count).enumerate().for_each(|(cell, leaving)| {
                let albedo = DIFFUSE * self.cells[cell].albedo;
                let arriving = &reflected[cell * count..][..count];
                let direct = &direct[cell * count..][..count];
                for ((leaving, arriving), direct) in leaving.iter_mut().zip(arriving).zip(direct) {
                    *leaving = albedo * (*arriving + *direct);
                }
            });
            reflected.par_chunks_mut(count).enumerate().for_each(|(cell, reflected)| {
                reflected.fill(Vec3::ZERO);
                for link in &self.links[cell] {
                    let leaving = &leaving[*link as usize * count..][..count];
                    for (sum, leaving) in reflected.iter_mut().zip(leaving) {
                        *sum += *leaving;
                    }
                }
                reflected.iter_mut().for_each(|sum| *sum /= LINKS as f32);
            });
        }
        reflected
    }

    /// Adds what is seen at a place, for each light: pi times radiance over the irradiance of a
    /// plane across the light.
    pub(crate) fn shade(
        &self,
        place: Place,
        at: Vec3,
        view: Vec3,
        lights: &[Vec3],
        shift: Vec2,
        reflected: &[Vec3],
        sum: &mut [Vec3],
    ) {
        let surface = self.weave.surface(place);
        let albedo = DIFFUSE * surface.albedo;
        let shading = Shading::new(&surface, view);
        let origin = at + LIFT * surface.normal;
        for (sum, light) in sum.iter_mut().zip(lights) {
            let light = &blurred(*light, shift);
            let cosine = surface.normal.dot(*light);
            if cosine > 0.0 && self.lit(origin, *light) {
                *sum += cosine * (albedo + shading.facets(*light, cosine));
            }
        }
        for (cell, weight) in cells_around(place) {
            let reflected = &reflected[cell * lights.len()..][..lights.len()];
            for (sum, reflected) in sum.iter_mut().zip(reflected) {
                *sum += weight * albedo * *reflected;
            }
        }
    }
}

fn place_of_cell(cell: usize) -> Place {
    let (ring, round) = (cell / CELLS[1], cell % CELLS[1]);
    Place {
        yarn: ring / CELLS[0],
        along: (ring % CELLS[0]) as f32 * TILE / CELLS[0] as f32,
        round: round as f32 * std::f32::consts::TAU / CELLS[1] as f32,
    }
}

/// A place in steps of cells.
fn steps(place: Place) -> [f32; 2] {
    [
        place.along.rem_euclid(TILE) * CELLS[0] as f32 / TILE,
        place.round.rem_euclid(std::f32::consts::TAU) * CELLS[1] as f32 / std::f32::consts::TAU,
    ]
}

fn cell(yarn: usize, along: usize, round: usize) -> usize {
    (yarn * CELLS[0] + along % CELLS[0]) * CELLS[1] + round % CELLS[1]
}

fn cell_at(place: Place) -> usize {
    let [along, round] = steps(place).map(|step| step.round() as usize);
    cell(place.yarn, along, round)
}

/// The four cells round a place, with weights.
fn cells_around(place: Place) -> [(usize, f32); 4] {
    let [along, round] = steps(place);
    let (a, r) = (along as usize, round as usize);
    let (s, t) = (along - a as f32, round - r as f32);
    [
        (cell(place.yarn, a, r), (1.0 - s) * (1.0 - t)),
        (cell(place.yarn, a + 1, r), s * (1.0 - t)),
        (cell(place.yarn, a, r + 1), (1.0 - s) * t),
        (cell(place.yarn, a + 1, r + 1), s * t),
    ]
}

/// Radius in radians of the cone round a direction that a sample stands for. The samples are 15 to
/// 22 degrees apart: sharper shadows than these would only make steps between them.
const CONE: f32 = 0.19;

/// A direction moved inside its cone, by a point of the unit disk.
pub(crate) fn blurred(direction: Vec3, shift: Vec2) -> Vec3 {
    let mut moved = Frame::new(direction).to_world((CONE * shift).extend(1.0));
    // The cloth is traced up to a tile away: nothing comes from nearer to the horizon.
    let height = 0.06 * moved.truncate().length();
    moved.z = moved.z.max(height);
    moved.normalize()
}

/// One line of sight.
pub(crate) struct Sample {
    /// Place in the texel, 0 to 1, and a little over its neighbours.
    pub(crate) point: Vec2,
    /// Shifts of view and light for [`blurred`].
    pub(crate) view: Vec2,
    pub(crate) light: Vec2,
}

/// The lines of sight of a texel.
pub(crate) fn samples(count: u32, seed: u64) -> impl Iterator<Item = Sample> {
    (0..count).map(move |sample| {
        let [u, v, s, t] = sobol_owen_4d(sample, seed);
        let [a, b, ..] = sobol_owen_4d(sample, !seed);
        Sample {
            // Wider than the texel by half: neighbours overlap, nothing aliases.
            point: (Vec2::new(u, v) - 0.5) * 1.5 + 0.5,
            view: concentric_disk(Vec2::new(s, t)),
            light: concentric_disk(Vec2::new(a, b)),
        }
    })
}
