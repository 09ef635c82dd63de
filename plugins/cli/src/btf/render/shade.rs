//! What a pixel shows.

use std::f32::consts::PI;
use std::ops::Range;

use farlight_btf_codec::{
    Angles, ColourSpace, LightSampler, Query, Rules, ViewFrame, fade_slope, read::Material,
};
use farlight_gi_solver::sampling::{cosine_hemisphere, hash_pair, sobol_owen_4d};
use glam::{Vec2, Vec3};

use super::Camera;
use super::environment::Environment;
use super::object::{Hit, Shape};
use crate::error::CliError;

/// A light that is infinitely far away.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct Sun {
    /// Unit vector to it.
    pub(super) direction: Vec3,
    /// Irradiance across its direction, over pi.
    pub(super) strength: f32,
}

/// Directions drawn from the material, and as many from the environment, for each sample of a pixel.
const DRAWS: usize = 2;

/// What is behind the object where there is no environment.
const BACKGROUND: Vec3 = Vec3::splat(0.02);

/// Queries that are evaluated at once for a set of pictures, which is decoded anew each time.
const MOST_QUERIES: usize = 1 << 22;

/// A scene.
pub(super) struct Shader {
    material: Material,
    shape: Shape,
    environment: Option<Environment>,
    suns: Vec<Sun>,
    /// Texels a unit of length.
    density: Vec2,
    /// Of light that stands lower than was measured.
    fade: f32,
}

/// How a picture is divided.
#[derive(Clone, Copy, Debug)]
pub(super) struct Blocks {
    /// Rows at once, at least one.
    pub(super) rows: usize,
    pub(super) threads: usize,
}

/// What is to be evaluated for some rows of pixels.
#[derive(Default)]
struct Batch {
    queries: Vec<Query>,
    /// Pixel of each query, and the light that its value is multiplied by.
    places: Vec<(usize, Vec3)>,
}

impl Batch {
    fn push(&mut self, texel: [i32; 2], angles: Angles, pixel: usize, light: Vec3) {
        let [x, y] = texel;
        self.queries.push(Query { x, y, angles });
        self.places.push((pixel, light));
    }
}

impl Shader {
    /// `repeat` tells for a number of columns how often the picture repeats over two units of length.
    pub(super) fn new(
        material: Material,
        shape: Shape,
        environment: Option<Environment>,
        suns: Vec<Sun>,
        repeat: impl Fn(f32) -> f32,
    ) -> Self {
        let [columns, rows] = material.size().map(|side| side as f32);
        let width = 2.0 / repeat(columns);
        // Texels are square unless the material says how large the picture is.
        let [real_width, real_height] = material.info().size.unwrap_or([columns, rows]);
        let height = width * (real_height / real_width);
        let density = Vec2::new(columns / width, rows / height) * shape.scale(width);
        let fade = fade_slope(material.info().light_limit);
        Self { material, shape, environment, suns, density, fade }
    }

    /// Tables are evaluated row by row on each processor; pictures in large blocks, by threads of their
    /// own.
    pub(super) fn block(&self, camera: &Camera, samples: u32) -> Blocks {
        match &self.material {
            Material::Tables(_) => Blocks {
                rows: 1,
                threads: std::thread::available_parallelism().map_or(1, usize::from),
            },
            Material::Images(_) => {
                let draws = if self.environment.is_some() { 2 * DRAWS } else { 0 };
                let each = samples as usize * (4 * self.suns.len() + draws).max(1);
                let rows = MOST_QUERIES / (each * camera.size.x as usize).max(1);
                Blocks { rows: rows.max(1), threads: 1 }
            }
        }
    }

    /// Light of each pixel of some rows, over pi: 1 is white.
    pub(super) fn rows(
        &self,
        camera: &Camera,
        rows: Range<usize>,
        samples: u32,
        seed: u64,
    ) -> Result<Vec<Vec3>, CliError> {
        let width = camera.size.x as usize;
        let mut light = vec![Vec3::ZERO; width * rows.len()];
        let mut batch = Batch::default();
        let weight = 1.0 / samples as f32;
        let first = rows.start * width;
        for (pixel, light) in light.iter_mut().enumerate() {
            let place = first + pixel;
            let corner = Vec2::new((place % width) as f32, (place / width) as f32);
            let seed = hash_pair(seed, place as u64);
            for sample in 0..samples {
                let [a, b, c, d] = sobol_owen_4d(sample, seed);
                let ray = camera.ray(corner + Vec2::new(a, b));
                let Some(hit) = self.shape.hit(&ray) else {
                    *light += weight * self.background(ray.direction);
                    continue;
                };
                let view = hit.local(-ray.direction);
                let (texel, part) = self.texel(&hit);
                self.add_suns(&mut batch, pixel, weight, &hit, view, (texel, part));
                if let Some(environment) = &self.environment {
                    // One of the four texels, as often as its weight says.
                    let texel = texel + Vec2::new((c < part.x).into(), (d < part.y).into());
                    let texel = [texel.x as i32, texel.y as i32];
                    let seed = hash_pair(seed, 1);
                    let draw = |at| sobol_owen_4d(sample * DRAWS as u32 + at as u32, seed);
                    for (angles, arriving) in self.surround(environment, &hit, view, texel, draw) {
                        batch.push(texel, angles, pixel, weight * arriving);
                    }
                }
            }
        }
        for (value, (pixel, arriving)) in
            self.evaluate(&batch.queries)?.into_iter().zip(batch.places)
        {
            light[pixel] += arriving * value;
        }
        Ok(light)
    }

    /// Values in linear light.
    fn evaluate(&self, queries: &[Query]) -> Result<Vec<Vec3>, CliError> {
        let (mut values, space) = match &self.material {
            Material::Tables(btf) => {
                let mut values = vec![Vec3::ZERO; queries.len()];
                btf.evaluate_batch(queries, Rules::SHADING, &mut values);
                (values, btf.colour_space())
            }
            Material::Images(images) => (images.evaluate_all(queries)?, ColourSpace::YCbCr),
        };
        for value in &mut values {
            *value = space.to_linear(*value);
        }
        Ok(values)
    }

    fn background(&self, direction: Vec3) -> Vec3 {
        self.environment.as_ref().map_or(BACKGROUND, |it| it.radiance(direction))
    }

    /// The upper left of four texels round a point, and how far it is from that to the others.
    fn texel(&self, hit: &Hit) -> (Vec2, Vec2) {
        let at = hit.place * self.density - 0.5;
        (at.floor(), at - at.floor())
    }

    /// Queries for all four texels under each light that reaches the point.
    fn add_suns(
        &self,
        batch: &mut Batch,
        pixel: usize,
        weight: f32,
        hit: &Hit,
        view: Vec3,
        (corner, part): (Vec2, Vec2),
    ) {
        for sun in &self.suns {
            let light = hit.local(sun.direction);
            if light.z <= 0.0 || self.shape.shadows(hit, sun.direction) {
                continue;
            }
            let angles = Angles::from_directions(light, view);
            let strength = weight * sun.strength * (self.fade * light.z).min(1.0);
            for (dx, wx) in [(0, 1.0 - part.x), (1, part.x)] {
                for (dy, wy) in [(0, 1.0 - part.y), (1, part.y)] {
                    let texel = [corner.x as i32 + dx, corner.y as i32 + dy];
                    batch.push(texel, angles, pixel, Vec3::splat(strength * wx * wy));
                }
            }
        }
    }

    /// Directions to the environment and the light from there, over pi and the density: drawn by the
    /// material (or, for pictures, by the cosine) and by the environment, weighed by the balance
    /// heuristic (Veach, *Robust Monte Carlo Methods for Light Transport Simulation*, 1997, section
    /// 9.2.2).
    fn surround(
        &self,
        environment: &Environment,
        hit: &Hit,
        view: Vec3,
        [x, y]: [i32; 2],
        draw: impl Fn(usize) -> [f32; 4],
    ) -> Vec<(Angles, Vec3)> {
        let frame = ViewFrame::new(view);
        let sampler = match &self.material {
            Material::Tables(btf) => {
                let theta_v = view.truncate().length().atan2(view.z);
                Some(LightSampler::new(btf, &btf.view_slices(x, y, theta_v, frame.phi())))
            }
            Material::Images(_) => None,
        };
        let by_material = |u: [f32; 2]| match &sampler {
            Some(sampler) => frame.direction(sampler.sample(u).light),
            None => cosine_hemisphere(u.into()),
        };
        let density = |local: Vec3| match &sampler {
            Some(sampler) => sampler.pdf(frame.slice_angles(local)),
            None => local.z / PI,
        };
        let mut lights = Vec::with_capacity(2 * DRAWS);
        for at in 0..DRAWS {
            let [a, b, c, d] = draw(at);
            for local in [by_material([a, b]), hit.local(environment.sample([c, d]))] {
                let world = hit.world(local);
                if local.z <= 0.0 || self.shape.shadows(hit, world) {
                    continue;
                }
                let density = density(local) + environment.pdf(world);
                let share = (self.fade * local.z).min(1.0) / (PI * density * DRAWS as f32);
                let arriving = share * environment.radiance(world);
                lights.push((Angles::from_directions(local, view), arriving));
            }
        }
        lights
    }
}
