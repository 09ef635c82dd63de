//! The shape of the cloth: a twill of two-ply yarns, periodic in both directions.
//!
//! Lengths count in the distance of two yarns. x runs along the columns of the picture, y against
//! its rows, z out of the cloth.

use std::f32::consts::{FRAC_PI_2, TAU};

use farlight_gi_solver::sampling::Rng;
use glam::{Vec2, Vec3};

/// Yarns of each direction in the tile, and its width.
pub(crate) const YARNS: usize = 8;
/// The tile's width as a length.
pub(crate) const TILE: f32 = YARNS as f32;
/// Half the width of a yarn, lying in the cloth.
const HALF_WIDTH: f32 = 0.49;
/// Half its thickness, across the cloth.
const HALF_THICKNESS: f32 = 0.19;
/// How far a yarn goes up and down.
const AMPLITUDE: f32 = 0.19;
/// Radians by which the plies turn a length: three turns a tile.
const TWIST: f32 = TAU * 3.0 / TILE;

/// A place on a yarn's surface.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Place {
    /// Warp yarns first, then weft.
    pub(crate) yarn: usize,
    /// Along the yarn.
    pub(crate) along: f32,
    /// Round it; a quarter turn is up.
    pub(crate) round: f32,
}

/// What light meets there.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Surface {
    pub(crate) normal: Vec3,
    /// Along the fibres.
    pub(crate) fibre: Vec3,
    /// Diffuse albedo.
    pub(crate) albedo: Vec3,
}

/// A slow function of period [`TILE`], about -1 to 1.
#[derive(Clone, Copy)]
struct Wave([[f32; 2]; 4]);

impl Wave {
    fn new(rng: &mut Rng) -> Self {
        Self(std::array::from_fn(|_| [0.3 + 0.7 * rng.next_f32(), TAU * rng.next_f32()]))
    }

    fn at(&self, along: f32) -> f32 {
        let harmonic = |(k, [size, phase]): (f32, &[f32; 2])| {
            size * (TAU / TILE * k * along + phase).sin() / (0.7 + 0.3 * k)
        };
        0.7 * [1.0, 2.0, 3.0, 5.0].into_iter().zip(&self.0).map(harmonic).sum::<f32>()
    }
}

struct Yarn {
    width: Wave,
    aside: Wave,
    height: Wave,
    dye: Wave,
    shade: f32,
    twist_phase: f32,
}

/// All yarns of the tile.
pub(crate) struct Weave {
    yarns: Vec<Yarn>,
    colours: [Vec3; 2],
    seed: u64,
}

impl Weave {
    pub(crate) fn new(seed: u64, colours: [Vec3; 2]) -> Self {
        let yarns = (0..2 * YARNS)
            .map(|index| {
                let mut rng = Rng::new(seed, index as u64);
                Yarn {
                    width: Wave::new(&mut rng),
                    aside: Wave::new(&mut rng),
                    height: Wave::new(&mut rng),
                    dye: Wave::new(&mut rng),
                    shade: 2.0 * rng.next_f32() - 1.0,
                    // As if spun alike: each float shows the same turns.
                    twist_phase: -TWIST * (index % YARNS) as f32,
                }
            })
            .collect();
        Self { yarns, colours, seed }
    }

    /// Middle of a yarn.
    fn centre(&self, yarn: usize, along: f32) -> Vec3 {
        let own = &self.yarns[yarn];
        let index = (yarn % YARNS) as f32;
        let aside = index + 0.5 + 0.008 * own.aside.at(along);
        let lift = 0.004 * own.height.at(along);
        // 2/2 twill: warp i is above the wefts i and i - 1 (modulo 4), between which y = i.
        let (middle, side) = if yarn < YARNS { (index, 1.0) } else { (index + 1.0, -1.0) };
        let wave = (TAU / 4.0 * (along - middle)).cos();
        // A float lies flatter than a cosine.
        let height = side * AMPLITUDE * wave * (1.5 - 0.5 * wave * wave) + lift;
        if yarn < YARNS { Vec3::new(aside, along, height) } else { Vec3::new(along, aside, height) }
    }

    /// Point of the surface.
    pub(crate) fn position(&self, place: Place) -> Vec3 {
        const STEP: f32 = 0.02;
        let Place { yarn, along, round } = place;
        let own = &self.yarns[yarn];
        let centre = self.centre(yarn, along);
        let tangent = self.centre(yarn, along + STEP) - self.centre(yarn, along - STEP);
        let across = if yarn < YARNS { Vec3::X } else { Vec3::NEG_Y };
        let up = across.cross(tangent).normalize();
        // Two plies, a groove between them.
        let ply = (round - TWIST * along - own.twist_phase).cos().abs();
        let radius = (1.0 - 0.24 * (1.0 - ply) * (1.0 - ply)) * (1.0 + 0.012 * own.width.at(along));
        let (sin, cos) = round.sin_cos();
        // A little squarer than an ellipse: yarns press each other flat.
        let square = 1.0 / (cos.powi(4) + sin.powi(4)).powf(0.12);
        centre + radius * square * (HALF_WIDTH * cos * across + HALF_THICKNESS * sin * up)
    }

    pub(crate) fn surface(&self, place: Place) -> Surface {
        const STEP: f32 = 0.01;
        let moved = |along: f32, round: f32| {
            self.position(Place { along: place.along + along, round: place.round + round, ..place })
        };
        let along = (moved(STEP, 0.0) - moved(-STEP, 0.0)) / (2.0 * STEP);
        let round = (moved(0.0, STEP) - moved(0.0, -STEP)) / (2.0 * STEP);
        let normal = along.cross(round).normalize();
        let outward = normal * normal.dot(moved(0.0, 0.0) - self.centre(place.yarn, place.along));
        let normal = outward.normalize();
        // Fibres turn in their ply against the twist of the plies; single ones stray.
        let stray = 0.2 * self.noise(place, [6.0, 9.0], 1);
        let fibre = (along + (0.35 + stray) * round).normalize();
        let fibre = (fibre - normal * fibre.dot(normal)).normalize();
        Surface { normal, fibre, albedo: self.albedo(place) }
    }

    fn albedo(&self, place: Place) -> Vec3 {
        let own = &self.yarns[place.yarn];
        let weft = place.yarn >= YARNS;
        let base = self.colours[usize::from(weft)];
        // Indigo takes unevenly, down to the fibre; undyed cotton hardly varies.
        let depth = if weft { 0.5 } else { 1.0 };
        let streaks = self.noise(place, [2.5, 14.0], 2) + 0.6 * self.noise(place, [7.0, 30.0], 3);
        let dye = depth * (0.16 * own.shade + 0.14 * own.dye.at(place.along) + 0.3 * streaks);
        // A dye absorbs along a path: what varies is the exponent.
        base.powf((1.0 - 0.5 * dye).max(0.3)).min(Vec3::splat(0.92))
    }

    /// Value noise on the surface, -1 to 1; `cells` along a length and round.
    fn noise(&self, place: Place, cells: [f32; 2], kind: u64) -> f32 {
        let counts = Vec2::new((cells[0] * TILE).round(), cells[1]);
        let along = place.along.rem_euclid(TILE) / TILE * counts.x;
        let turned = place.round - TWIST * place.along - self.yarns[place.yarn].twist_phase;
        let round = (turned / TAU).rem_euclid(1.0) * counts.y;
        let at = |i: f32, j: f32| {
            let cell = (i.rem_euclid(counts.x) * counts.y + j.rem_euclid(counts.y)) as u64;
            let stream = (kind * 64 + place.yarn as u64) << 32 | cell;
            2.0 * Rng::new(self.seed ^ 0x005e_ed00, stream).next_f32() - 1.0
        };
        let smooth = |t: f32| t * t * (3.0 - 2.0 * t);
        let (i, j) = (along.floor(), round.floor());
        let (s, t) = (smooth(along - i), smooth(round - j));
        let mix = |a: f32, b: f32, t: f32| a + t * (b - a);
        mix(mix(at(i, j), at(i + 1.0, j), s), mix(at(i, j + 1.0), at(i + 1.0, j + 1.0), s), t)
    }
}

/// The yarns as triangles: `steps_along` rings a tile of `steps_round` quads.
pub(crate) struct Mesh {
    pub(crate) steps_along: usize,
    pub(crate) steps_round: usize,
    /// Those of the tile nine times, with its neighbours.
    pub(crate) triangles: Vec<[Vec3; 3]>,
    /// Least and greatest height.
    pub(crate) heights: [f32; 2],
}

impl Mesh {
    pub(crate) fn new(weave: &Weave, steps_along: usize, steps_round: usize) -> Self {
        let mut mesh =
            Self { steps_along, steps_round, triangles: Vec::new(), heights: [f32::MAX, f32::MIN] };
        let mut tile = Vec::new();
        for yarn in 0..2 * YARNS {
            let corner = |a: usize, r: usize| weave.position(mesh.place(yarn, a as f32, r as f32));
            for a in 0..steps_along {
                for r in 0..steps_round {
                    let quad =
                        [corner(a, r), corner(a + 1, r), corner(a + 1, r + 1), corner(a, r + 1)];
                    tile.push([quad[0], quad[1], quad[2]]);
                    tile.push([quad[0], quad[2], quad[3]]);
                }
            }
        }
        for height in tile.iter().flatten().map(|corner| corner.z) {
            mesh.heights = [mesh.heights[0].min(height), mesh.heights[1].max(height)];
        }
        for offset in Self::offsets() {
            mesh.triangles.extend(tile.iter().map(|corners| corners.map(|corner| corner + offset)));
        }
        mesh
    }

    /// The tile and its neighbours.
    fn offsets() -> [Vec3; 9] {
        std::array::from_fn(|i| Vec3::new((i % 3) as f32 - 1.0, (i / 3) as f32 - 1.0, 0.0) * TILE)
    }

    fn place(&self, yarn: usize, along: f32, round: f32) -> Place {
        Place {
            yarn,
            along: along * TILE / self.steps_along as f32,
            // From below, so that the seam is hidden.
            round: round * TAU / self.steps_round as f32 - FRAC_PI_2,
        }
    }

    /// Place where a triangle was hit.
    pub(crate) fn hit(&self, triangle: u32, u: f32, v: f32) -> Place {
        let tile = 4 * YARNS * self.steps_along * self.steps_round;
        let triangle = triangle as usize % tile;
        let quad = triangle / 2;
        let round = (quad % self.steps_round) as f32;
        let ring = quad / self.steps_round;
        let (yarn, along) = (ring / self.steps_along, (ring % self.steps_along) as f32);
        let (a, r) = if triangle.is_multiple_of(2) { (u + v, v) } else { (u, u + v) };
        self.place(yarn, along + a, round + r)
    }
}
