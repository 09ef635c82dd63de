//! Patches: the pieces of surface between which light is exchanged.
//!
//! A patch is one side of a lightmap texel, or, on surfaces without a lightmap, one side of a *surfel*:
//! the part of an instance that lies in one cell of a world grid and faces one of six directions.
//! The front sides of all texels are there from the start and come first; backs and surfels are
//! made when a ray meets them, so that what nothing sees costs nothing.

use std::{collections::HashMap, sync::Arc};

use glam::{Vec2, Vec3};

use super::raster::{MeshTexels, NONE, SAMPLES, SurfacePoint};
use crate::{Hit, World};

/// Past this many patches that are not fronts of texels, surfels get coarser; past twice as many no
/// more are made and what would be one counts as black.
const MANY: usize = 60_000;

/// A receiver whose texels are patches.
pub(crate) struct Receiver {
    /// Index into [`World::instances`].
    pub instance: u32,
    /// The patch of its first texel.
    pub first: u32,
    pub texels: Arc<MeshTexels>,
}

/// All patches, one array an attribute.
#[derive(Default)]
pub(crate) struct Patches {
    pub position: Vec<Vec3>,
    /// Unit normal of the patch's side.
    pub normal: Vec<Vec3>,
    /// Points at which direct light is sampled.
    pub samples: Vec<[Vec3; SAMPLES]>,
    /// Unit normals there, on the patch's side: a texel may lie across an edge.
    pub sample_normals: Vec<[Vec3; SAMPLES]>,
    pub albedo: Vec<Vec3>,
    pub emission: Vec<Vec3>,
    pub receivers: Vec<Receiver>,
    /// Patches below this are the fronts of texels.
    pub fronts: usize,
    /// The surface points behind `samples`, with triangles of the world.
    pub points: Vec<[SurfacePoint; SAMPLES]>,
    filled: Vec<u8>,
    receiver_of_instance: Vec<u32>,
    /// Patch of the back of each texel, or [`NONE`].
    backs: Vec<u32>,
    surfels: HashMap<u64, u32>,
    cell: f32,
}

/// What a ray met, before patches that do not exist yet are made.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Met {
    Sky,
    Front(u32),
    Back(u32),
    Surfel(u64),
}

impl Patches {
    /// The fronts of all receivers' texels; surfels will have cells with edges of `cell` metres.
    pub(crate) fn new(world: &World, receivers: Vec<(u32, Arc<MeshTexels>)>, cell: f32) -> Self {
        let mut patches = Self {
            receiver_of_instance: vec![NONE; world.instances().len()],
            cell,
            ..Self::default()
        };
        for (instance, texels) in receivers {
            patches.receiver_of_instance[instance as usize] = patches.receivers.len() as u32;
            let first = patches.position.len() as u32;
            let offset = world.instances()[instance as usize].first_triangle;
            for (point, samples) in texels.points.iter().zip(&texels.samples) {
                let to_world =
                    |p: SurfacePoint| SurfacePoint { triangle: p.triangle + offset, ..p };
                let samples = samples.map(to_world);
                patches.push(world, to_world(*point), samples, false);
            }
            patches.receivers.push(Receiver { instance, first, texels });
        }
        patches.fronts = patches.len();
        patches.backs = vec![NONE; patches.fronts];
        patches
    }

    /// Gives up those sample points of a texel whose bit in `bad` is set, and the point that stands for
    /// it if that is not `open`. Returns whether a point is left.
    pub(crate) fn move_points(&mut self, texel: usize, open: bool, bad: u8) -> bool {
        let Some(good) = (0..SAMPLES).find(|k| bad >> k & 1 == 0) else { return open };
        if !open {
            self.position[texel] = self.samples[texel][good];
        }
        for k in (0..SAMPLES).filter(|k| bad >> k & 1 != 0) {
            self.samples[texel][k] = self.samples[texel][good];
            self.sample_normals[texel][k] = self.sample_normals[texel][good];
            self.points[texel][k] = self.points[texel][good];
        }
        true
    }

    /// Makes a texel's point stand for all its sample points.
    pub(crate) fn gather_samples_at_point(&mut self, texel: usize) {
        self.samples[texel] = [self.position[texel]; SAMPLES];
        self.sample_normals[texel] = [self.normal[texel]; SAMPLES];
    }

    pub(crate) fn len(&self) -> usize {
        self.position.len()
    }

    /// Reads reflectance and emission anew, after materials changed.
    pub(crate) fn refresh_materials(&mut self, world: &World) {
        for i in 0..self.len() {
            (self.albedo[i], self.emission[i]) = appearance(world, &self.points[i]);
        }
    }

    /// Which patch answers for a hit (or would, if it existed).
    pub(crate) fn meet(&self, world: &World, hit: &Hit, direction: Vec3) -> Met {
        if !hit.is_hit() {
            return Met::Sky;
        }
        let back = world.is_back(hit.triangle, direction);
        let instance = world.instance_of(hit.triangle);
        let receiver = self.receiver_of_instance[instance as usize];
        if receiver != NONE {
            let receiver = &self.receivers[receiver as usize];
            let triangle = hit.triangle - world.instances()[instance as usize].first_triangle;
            let uv = world.uv1(hit.triangle, Vec2::new(hit.u, hit.v));
            if let Some(texel) = receiver.texels.lookup(triangle, uv) {
                let texel = receiver.first + texel;
                return if back { Met::Back(texel) } else { Met::Front(texel) };
            }
        }
        let extra = self.len() - self.fronts;
        let cell = if extra < MANY { self.cell } else { self.cell * 16.0 };
        let [a, b, c] = world.corners(hit.triangle);
        let p = a + (b - a) * hit.u + (c - a) * hit.v;
        let normal = world.normal(hit.triangle) * if back { -1.0 } else { 1.0 };
        Met::Surfel(surfel_key(p, normal, instance, cell))
    }

    /// The patch of what was met, made now if need be; `None` for sky and where there are too many.
    /// Surfels numbered from `young` on were made in the same batch of rays and gain sample points.
    pub(crate) fn patch(
        &mut self,
        world: &World,
        met: Met,
        hit: &Hit,
        direction: Vec3,
        young: usize,
    ) -> Option<u32> {
        match met {
            Met::Sky => None,
            Met::Front(texel) => Some(texel),
            Met::Back(texel) => {
                let known = self.backs[texel as usize];
                if known != NONE {
                    return Some(known);
                }
                let patch = self.room()?;
                self.backs[texel as usize] = patch;
                let t = texel as usize;
                self.position.push(self.position[t]);
                self.normal.push(-self.normal[t]);
                self.samples.push(self.samples[t]);
                self.sample_normals.push(self.sample_normals[t].map(|n| -n));
                self.albedo.push(self.albedo[t]);
                self.emission.push(self.emission[t]);
                self.points.push(self.points[t]);
                self.filled.push(SAMPLES as u8);
                Some(patch)
            }
            Met::Surfel(key) => {
                let point = SurfacePoint { triangle: hit.triangle, bary: Vec2::new(hit.u, hit.v) };
                if let Some(&known) = self.surfels.get(&key) {
                    self.add_sample(world, known as usize, point, young);
                    return Some(known);
                }
                let patch = self.room()?;
                self.surfels.insert(key, patch);
                let back = world.is_back(hit.triangle, direction);
                self.push(world, point, [point; SAMPLES], back);
                self.filled[patch as usize] = 1;
                Some(patch)
            }
        }
    }

    /// The patch of what was met, if it exists.
    pub(crate) fn find(&self, met: Met) -> Option<u32> {
        match met {
            Met::Sky => None,
            Met::Front(texel) => Some(texel),
            Met::Back(texel) => Some(self.backs[texel as usize]).filter(|b| *b != NONE),
            Met::Surfel(key) => self.surfels.get(&key).copied(),
        }
    }

    fn room(&self) -> Option<u32> {
        (self.len() - self.fronts < 2 * MANY).then_some(self.len() as u32)
    }

    fn push(
        &mut self,
        world: &World,
        point: SurfacePoint,
        samples: [SurfacePoint; SAMPLES],
        back: bool,
    ) {
        let normal = world.normal(point.triangle);
        self.position.push(world_position(world, point));
        self.normal.push(if back { -normal } else { normal });
        self.samples.push(samples.map(|p| world_position(world, p)));
        let side = if back { -1.0 } else { 1.0 };
        self.sample_normals.push(samples.map(|p| world.normal(p.triangle) * side));
        let (albedo, emission) = appearance(world, &samples);
        self.albedo.push(albedo);
        self.emission.push(emission);
        self.points.push(samples);
        self.filled.push(SAMPLES as u8);
    }

    fn add_sample(&mut self, world: &World, patch: usize, point: SurfacePoint, young: usize) {
        let filled = usize::from(self.filled[patch]);
        if patch < young || filled == SAMPLES {
            return;
        }
        self.points[patch][filled] = point;
        self.samples[patch][filled] = world_position(world, point);
        // Surfels face one of six directions: all their points look about the same way.
        let normal = world.normal(point.triangle);
        self.sample_normals[patch][filled] = normal * normal.dot(self.normal[patch]).signum();
        self.filled[patch] += 1;
        if filled + 1 == SAMPLES {
            (self.albedo[patch], self.emission[patch]) = appearance(world, &self.points[patch]);
        }
    }
}

fn world_position(world: &World, point: SurfacePoint) -> Vec3 {
    let [a, b, c] = world.corners(point.triangle);
    a + (b - a) * point.bary.x + (c - a) * point.bary.y
}

fn appearance(world: &World, points: &[SurfacePoint; SAMPLES]) -> (Vec3, Vec3) {
    let mut sum = (Vec3::ZERO, Vec3::ZERO);
    for point in points {
        let surface = world.surface_at(point.triangle, point.bary, false);
        sum.0 += surface.albedo;
        sum.1 += surface.emission;
    }
    (sum.0 / SAMPLES as f32, sum.1 / SAMPLES as f32)
}

/// Names the cell, the side and the instance; cells wrap after 4096, which only merges what is far
/// apart.
fn surfel_key(p: Vec3, normal: Vec3, instance: u32, cell: f32) -> u64 {
    let cells = (p / cell).floor();
    let axis = |v: f32| u64::from((v as i64 as u32) & 0xfff);
    let a = normal.abs();
    let (axis_index, value) = if a.x >= a.y && a.x >= a.z {
        (0, normal.x)
    } else if a.y >= a.z {
        (1, normal.y)
    } else {
        (2, normal.z)
    };
    let side = axis_index * 2 + u64::from(value < 0.0);
    axis(cells.x)
        | axis(cells.y) << 12
        | axis(cells.z) << 24
        | side << 36
        | u64::from(instance) << 39
}
