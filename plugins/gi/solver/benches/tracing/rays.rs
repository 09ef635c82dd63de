//! The rays: a camera's, bounces off surfaces, and segments towards lights.

use farlight_gi_solver::tracer::{Ray, Tracer};
use glam::{Vec2, Vec3};

/// Pixels of a camera's picture, and its four directions.
const SIDE: usize = 256;

/// PCG32, numbers in 0 to 1.
pub(crate) struct Random(u64);

impl Random {
    pub(crate) fn new(seed: u64) -> Self {
        Self(seed.wrapping_mul(0x9e37_79b9_7f4a_7c15) | 1)
    }

    pub(crate) fn next(&mut self) -> f32 {
        let old = self.0;
        self.0 =
            old.wrapping_mul(6_364_136_223_846_793_005).wrapping_add(1_442_695_040_888_963_407);
        let word = ((((old >> 18) ^ old) >> 27) as u32).rotate_right((old >> 59) as u32);
        (word >> 8) as f32 / (1 << 24) as f32
    }
}

pub(crate) struct Sets {
    /// Four pictures from the middle of the scene, row by row.
    pub(crate) camera: Vec<Ray>,
    /// Cosine-distributed directions from random visible points.
    pub(crate) bounce: Vec<Ray>,
    /// From random visible points to one of four points under the ceiling.
    pub(crate) shadow: Vec<Ray>,
}

impl Sets {
    pub(crate) fn new(tracer: &Tracer, triangles: &[[Vec3; 3]]) -> Self {
        let (min, max) = triangles
            .iter()
            .flatten()
            .fold((Vec3::INFINITY, Vec3::NEG_INFINITY), |(a, b), &p| (a.min(p), b.max(p)));
        println!("from {min} to {max}");
        let eye = (min + max) * 0.5;
        let camera = camera(eye);
        // Points are where rays end that leave the eye in all directions, in random order, and
        // one bounce further on.
        let mut random = Random::new(1);
        let count = camera.len();
        let mut bounce = Vec::with_capacity(count);
        let mut shadow = Vec::with_capacity(count);
        while bounce.len() < count {
            let direction = sphere(Vec2::new(random.next(), random.next()));
            let mut ray = Ray::new(eye, direction);
            for _ in 0..2 {
                let hit = tracer.closest(&ray);
                if !hit.is_hit() {
                    break;
                }
                let [a, b, c] = triangles[hit.triangle as usize];
                let normal = (b - a).cross(c - a).normalize_or_zero();
                let normal = if normal.dot(ray.direction) > 0.0 { -normal } else { normal };
                let point = ray.origin + hit.t * ray.direction + normal * 1e-4;
                let sample = sphere(Vec2::new(random.next(), random.next()));
                ray = Ray::new(point, (normal + sample * 0.999).normalize());
                bounce.push(ray);
                let light = Vec3::new(
                    if random.next() < 0.5 { 0.25 } else { 0.75 },
                    0.9,
                    if random.next() < 0.5 { 0.25 } else { 0.75 },
                );
                let light = min + (max - min) * light;
                let segment = Ray { t_max: 0.9999, ..Ray::new(point, light - point) };
                shadow.push(segment);
            }
        }
        bounce.truncate(count);
        shadow.truncate(count);
        Self { camera, bounce, shadow }
    }
}

fn sphere(u: Vec2) -> Vec3 {
    let z = 1.0 - 2.0 * u.x;
    let r = (1.0 - z * z).max(0.0).sqrt();
    let (s, c) = (u.y * std::f32::consts::TAU).sin_cos();
    Vec3::new(r * c, r * s, z)
}

fn camera(eye: Vec3) -> Vec<Ray> {
    let mut rays = Vec::with_capacity(4 * SIDE * SIDE);
    for view in 0..4 {
        let (s, c) = (0.3 + view as f32 * std::f32::consts::FRAC_PI_2).sin_cos();
        let (forward, right) = (Vec3::new(c, 0.0, s), Vec3::new(-s, 0.0, c));
        for y in 0..SIDE {
            for x in 0..SIDE {
                let p = |i: usize| (i as f32 + 0.5) / SIDE as f32 * 2.0 - 1.0;
                rays.push(Ray::new(eye, (forward + p(x) * right - p(y) * Vec3::Y).normalize()));
            }
        }
    }
    rays
}
