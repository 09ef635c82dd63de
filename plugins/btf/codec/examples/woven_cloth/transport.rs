//! What light does in the cloth: rays against the yarns, and light that has been reflected before.
//!
//! For one azimuth of the view, all lights are followed at once: they share the rays.

use farlight_gi_solver::sampling::{Frame, concentric_disk, cosine_hemisphere, sobol_owen_4d};
use farlight_gi_solver::{Ray, Tracer};
use std::f32::consts::TAU;

use glam::{Vec2, Vec3};
use rayon::prelude::*;

use crate::fibre::{DIFFUSE, Shading};
use crate::weave::{Mesh, Place, Surface, TILE, Weave, YARNS};

/// Cells along a yarn in the tile, and round it: of reflected light, and of shadows.
const COARSE: Cells = Cells { along: 64, round: 16 };
const FINE: Cells = Cells { along: 160, round: 28 };
/// Rays to a light from a fine cell, spread over the light's cone. A texel sees a dozen cells.
const SHADOW_RAYS: u32 = 8;
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
    /// The fine cells that can be seen from above, by their numbers; the others have none.
    exposed: Vec<Option<u32>>,
}

/// What arrives in the cells from some lights.
pub(crate) struct Arriving {
    /// For each exposed fine cell and light, the share of the light's cone that is seen.
    shadows: Vec<f32>,
    /// For each coarse cell and light, irradiance over that of a plane across the light, by light
    /// that was reflected at least once (diffusely).
    reflected: Vec<Vec3>,
}

impl Cloth {
    pub(crate) fn new(weave: Weave, mesh: Mesh, seed: u64) -> Self {
        let tracer = Tracer::new(&mesh.triangles);
        let places: Vec<Place> = (0..COARSE.count()).map(|cell| COARSE.place(cell)).collect();
        let cells: Vec<Surface> = places.par_iter().map(|place| weave.surface(*place)).collect();
        let points = places.par_iter().map(|place| weave.position(*place)).collect();
        let mut cloth =
            Self { weave, mesh, tracer, cells, points, links: Vec::new(), exposed: Vec::new() };
        cloth.links =
            (0..cloth.cells.len()).into_par_iter().map(|cell| cloth.links_of(cell, seed)).collect();
        let seen: Vec<bool> =
            (0..FINE.count()).into_par_iter().map(|cell| cloth.seen_from_above(cell)).collect();
        let mut next = 0..;
        cloth.exposed = seen.into_iter().map(|seen| seen.then(|| next.next()).flatten()).collect();
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
                let place = self.mesh.hit(hit.triangle, hit.u, hit.v);
                let met = COARSE.at(place);
                // From inside a yarn nothing is seen.
                if self.cells[met].normal.dot(direction) < 0.0 {
                    links.push(met as u32);
                }
            }
        }
        links
    }

    fn seen_from_above(&self, cell: usize) -> bool {
        let (origin, _) = self.start(FINE.place(cell));
        (0..48).any(|ray| {
            let [u, v, ..] = sobol_owen_4d(ray, 0);
            self.lit(origin, cosine_hemisphere(Vec2::new(u, v)))
        })
    }

    /// Where rays from a place start, and the normal there.
    fn start(&self, place: Place) -> (Vec3, Vec3) {
        let normal = self.weave.surface(place).normal;
        (self.inside_tile(self.weave.position(place)) + LIFT * normal, normal)
    }

    fn inside_tile(&self, point: Vec3) -> Vec3 {
        Vec3::new(point.x.rem_euclid(TILE), point.y.rem_euclid(TILE), point.z)
    }

    /// Where a line of sight meets the cloth: `point` lies in the middle plane.
    pub(crate) fn seen(&self, point: Vec3, view: Vec3) -> Option<Place> {
        let start = (self.mesh.heights[1] + 0.01 - point.z) / view.z;
        let hit = self.tracer.closest(&Ray::new(point + start * view, -view));
        hit.is_hit().then(|| self.mesh.hit(hit.triangle, hit.u, hit.v))
    }

    fn lit(&self, origin: Vec3, light: Vec3) -> bool {
        !self.tracer.occluded(&Ray::new(origin, light))
    }

    /// Follows light to the cells.
    pub(crate) fn arriving(&self, lights: &[Vec3]) -> Arriving {
        Arriving { shadows: self.shadows(lights), reflected: self.reflected(lights) }
    }

    fn shadows(&self, lights: &[Vec3]) -> Vec<f32> {
        let cells: Vec<usize> =
            (0..FINE.count()).filter(|cell| self.exposed[*cell].is_some()).collect();
        let mut shadows = vec![0.0; cells.len() * lights.len()];
        shadows.par_chunks_mut(lights.len()).zip(cells).for_each(|(shadows, cell)| {
            let (origin, _) = self.start(FINE.place(cell));
            let shifts: Vec<Vec2> = (0..SHADOW_RAYS)
                .map(|ray| {
                    let [u, v, ..] = sobol_owen_4d(ray, cell as u64);
                    concentric_disk(Vec2::new(u, v))
                })
                .collect();
            for (shadow, light) in shadows.iter_mut().zip(lights) {
                let seen = shifts.iter().filter(|shift| self.lit(origin, blurred(*light, **shift)));
                *shadow = seen.count() as f32 / SHADOW_RAYS as f32;
            }
        });
        shadows
    }

    fn reflected(&self, lights: &[Vec3]) -> Vec<Vec3> {
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
        view: Vec3,
        lights: &[Vec3],
        arriving: &Arriving,
        sum: &mut [Vec3],
    ) {
        let count = lights.len();
        let surface = self.weave.surface(place);
        let albedo = DIFFUSE * surface.albedo;
        let shading = Shading::new(&surface, view);
        let mut shadows = vec![0.0; count];
        let mut total = 0.0;
        for (cell, weight) in FINE.around(place) {
            if let Some(cell) = self.exposed[cell] {
                total += weight;
                let row = &arriving.shadows[cell as usize * count..][..count];
                shadows.iter_mut().zip(row).for_each(|(sum, shadow)| *sum += weight * shadow);
            }
        }
        let total = f32::max(total, 1e-6);
        for ((sum, light), shadow) in sum.iter_mut().zip(lights).zip(shadows) {
            let cosine = surface.normal.dot(*light);
            if cosine > 0.0 && shadow > 0.0 {
                *sum += shadow / total * cosine * (albedo + shading.facets(*light, cosine));
            }
        }
        for (cell, weight) in COARSE.around(place) {
            let reflected = &arriving.reflected[cell * count..][..count];
            for (sum, reflected) in sum.iter_mut().zip(reflected) {
                *sum += weight * albedo * *reflected;
            }
        }
    }
}

/// A division of all yarns into cells.
#[derive(Clone, Copy)]
struct Cells {
    along: usize,
    round: usize,
}

impl Cells {
    fn count(self) -> usize {
        2 * YARNS * self.along * self.round
    }

    fn place(self, cell: usize) -> Place {
        let (ring, round) = (cell / self.round, cell % self.round);
        Place {
            yarn: ring / self.along,
            along: (ring % self.along) as f32 * TILE / self.along as f32,
            round: round as f32 * TAU / self.round as f32,
        }
    }

    /// A place in steps of cells.
    fn steps(self, place: Place) -> [f32; 2] {
        [
            place.along.rem_euclid(TILE) * self.along as f32 / TILE,
            place.round.rem_euclid(TAU) * self.round as f32 / TAU,
        ]
    }

    fn cell(self, yarn: usize, along: usize, round: usize) -> usize {
        (yarn * self.along + along % self.along) * self.round + round % self.round
    }

    fn at(self, place: Place) -> usize {
        let [along, round] = self.steps(place).map(|step| step.round() as usize);
        self.cell(place.yarn, along, round)
    }

    /// The four cells round a place, with weights.
    fn around(self, place: Place) -> [(usize, f32); 4] {
        let [along, round] = self.steps(place);
        let (a, r) = (along as usize, round as usize);
        let (s, t) = (along - a as f32, round - r as f32);
        [
            (self.cell(place.yarn, a, r), (1.0 - s) * (1.0 - t)),
            (self.cell(place.yarn, a + 1, r), s * (1.0 - t)),
            (self.cell(place.yarn, a, r + 1), (1.0 - s) * t),
            (self.cell(place.yarn, a + 1, r + 1), s * t),
        ]
    }
}

/// Radius in radians of the cone round a direction that a sample stands for. The samples are 15 to
/// 22 degrees apart: sharper shadows than these would only make steps between them.
const CONE: f32 = 0.16;

/// A direction moved inside its cone, by a point of the unit disk.
pub(crate) fn blurred(direction: Vec3, shift: Vec2) -> Vec3 {
    let mut moved = Frame::new(direction).to_world((CONE * shift).extend(1.0));
    // The cloth is traced up to a tile away: nothing comes from nearer to the horizon.
    let height = 0.06 * moved.truncate().length();
    moved.z = moved.z.max(height);
    moved.normalize()
}

/// The lines of sight of a texel: a place in it, 0 to 1 and a little over its neighbours, and a
/// shift of the view for [`blurred`]. All texels have the same.
pub(crate) fn sights(count: u32) -> Vec<[Vec2; 2]> {
    let sight = |[u, v, s, t]: [f32; 4]| {
        // Wider than the texel by half: neighbours overlap, nothing aliases.
        [(Vec2::new(u, v) - 0.5) * 1.5 + 0.5, concentric_disk(Vec2::new(s, t))]
    };
    (0..count).map(|index| sight(sobol_owen_4d(index, 1))).collect()
}
