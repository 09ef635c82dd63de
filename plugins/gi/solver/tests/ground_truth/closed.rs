//! Closed rooms: furnaces, integrating spheres, conservation of energy.

use std::f32::consts::PI;

use farlight_gi_solver::{
    World,
    estimate::{Estimate, no_progress},
    path::PathTracer,
    receiver::Receiver,
    sampling::Rng,
};
use glam::{DVec3, Vec2, Vec3};

use crate::{
    build::{Build, diffuse, emitter, point, room, sphere},
    check::{agrees, paths, sharp},
};

/// The middle of a world's triangle, on the side that looks towards `eye`.
fn on_triangle(world: &World, triangle: usize, eye: Vec3) -> Receiver {
    let third = Vec2::splat(1.0 / 3.0);
    let s = world.surface_at(triangle as u32, third, false);
    let normal = if s.normal.dot(eye - s.position) > 0.0 { s.normal } else { -s.normal };
    Receiver { position: s.position, normal }
}

/// Everything emits L and reflects ρ: the radiance is L / (1 - ρ) everywhere, E = π L / (1 - ρ), and
/// with one reflection at most π L (1 + ρ). Things inside change nothing.
#[test]
fn furnace() {
    let (rho, emitted) = (Vec3::new(0.2, 0.5, 0.8), Vec3::new(1.0, 2.0, 0.5));
    let mut build = Build::default();
    for wall in room(Vec3::ZERO, Vec3::new(3.0, 2.0, 4.0)) {
        build = build.mesh(wall, emitter(rho, emitted));
    }
    let world = build.mesh(sphere(Vec3::ONE, 0.5), emitter(rho, emitted)).world();
    for receiver in [
        Receiver { position: Vec3::new(0.5, 0.0, 0.5), normal: Vec3::Y },
        Receiver { position: Vec3::new(3.0, 0.001, 3.999), normal: -Vec3::X },
        Receiver { position: Vec3::new(1.0, 1.5, 1.0), normal: Vec3::Y },
    ] {
        let light =
            receiver.gather(&PathTracer::new(&world), &paths(8192), 0, no_progress()).unwrap();
        agrees("furnace", light.indirect, PI * emitted / (Vec3::ONE - rho), 0.0);
        agrees("furnace, one bounce", light.one_bounce, PI * emitted * (Vec3::ONE + rho), 0.0);
        assert_eq!(light.direct, Estimate::default());
        sharp("furnace", light.indirect, 0.02);
    }
}

/// A white, open, crooked shape under a constant sky: whatever leaves the sky comes back, E = π L.
#[test]
fn white_shape_under_the_sky() {
    let sky = Vec3::new(1.0, 2.0, 3.0);
    let mut build = Build::default().sky(sky);
    for wall in room(Vec3::ZERO, Vec3::splat(2.0)).into_iter().skip(2) {
        build = build.mesh(wall, diffuse(Vec3::ONE));
    }
    let world = build.mesh(sphere(Vec3::ONE, 0.4), diffuse(Vec3::ONE)).world();
    for (i, position) in [Vec3::new(0.3, 1.0, 0.0), Vec3::new(1.0, 0.01, 0.0)].iter().enumerate() {
        let receiver = Receiver { position: *position, normal: Vec3::Z };
        let light = receiver
            .gather(&PathTracer::new(&world), &paths(8192), i as u64, no_progress())
            .unwrap();
        // Both parts come from the same paths: what one lacks, the other has. Only Russian
        // roulette adds noise to the sum, which is less than that of the indirect part.
        let sum = Estimate {
            mean: light.direct.mean + light.indirect.mean,
            se: light.indirect.se.max(light.direct.se),
        };
        agrees("white shape", sum, PI * sky, 0.0);
        sharp("white shape", sum, 0.02);
        assert!(light.direct.mean.x > 0.1 && light.indirect.mean.x > 0.1, "{light:?}");
    }
}

/// Inside a sphere of radius R every point receives the same from every other, wherever the light
/// stands: one reflection gives ρ I / R², all of them ρ / (1 - ρ) I / R².
#[test]
fn integrating_sphere() {
    let (radius, intensity) = (2.0, Vec3::new(10.0, 5.0, 20.0));
    let rho = Vec3::new(0.3, 0.5, 0.8);
    let world = Build::default()
        .mesh(sphere(Vec3::ZERO, radius), diffuse(rho))
        .light(point(Vec3::new(0.7, -0.4, 0.3), intensity))
        .world();
    let one = rho * intensity / (radius * radius);
    let all = one / (Vec3::ONE - rho);
    let step = world.triangle_count() / 7;
    for i in 0..6 {
        let receiver = on_triangle(&world, i * step + 11, Vec3::ZERO);
        let light = receiver
            .gather(&PathTracer::new(&world), &paths(8192), i as u64, no_progress())
            .unwrap();
        agrees("integrating sphere, one bounce", light.one_bounce, one, 1e-3);
        agrees("integrating sphere", light.indirect, all, 1e-3);
        sharp("integrating sphere, one bounce", light.one_bounce, 0.01);
        sharp("integrating sphere", light.indirect, 0.02);
    }
}

/// With twenty lights one is drawn at each vertex; the answer is the sum all the same.
#[test]
fn integrating_sphere_with_many_lights() {
    let (radius, rho) = (2.0, Vec3::new(0.3, 0.5, 0.7));
    let mut build = Build::default().mesh(sphere(Vec3::ZERO, radius), diffuse(rho));
    let mut sum = Vec3::ZERO;
    let mut rng = Rng::new(4, 0);
    for _ in 0..20 {
        let place = Vec3::from_array(std::array::from_fn(|_| rng.next_f32() * 1.6 - 0.8));
        let intensity = Vec3::from_array(std::array::from_fn(|_| rng.next_f32()));
        sum += intensity;
        build = build.light(point(place, intensity));
    }
    let world = build.world();
    let receiver = on_triangle(&world, 77, Vec3::ZERO);
    let light =
        receiver.gather(&PathTracer::new(&world), &paths(16_384), 0, no_progress()).unwrap();
    let one = rho * sum / (radius * radius);
    agrees("many lights, one bounce", light.one_bounce, one, 1e-3);
    agrees("many lights", light.indirect, one / (Vec3::ONE - rho), 1e-3);
    sharp("many lights", light.indirect, 0.02);
}

/// In a closed room what is absorbed of the indirect light is what was reflected of the direct
/// light: ∫ (1 - ρ) E_indirect dA = ∫ ρ E_direct dA, the latter = 4π I ρ for equal walls. Here the
/// walls differ, so both sides are integrated over points drawn on the walls.
#[test]
fn energy_is_conserved() {
    let size = Vec3::new(3.0, 2.5, 4.0);
    let albedos = [0.2, 0.8, 0.5, 0.7, 0.1, 0.9].map(|a| Vec3::new(a, 1.0 - a, 0.5));
    let mut build = Build::default().light(point(Vec3::new(1.0, 1.6, 2.8), Vec3::splat(10.0)));
    let walls = room(Vec3::ZERO, size);
    let areas = walls
        .clone()
        .map(|w| (w.positions[1] - w.positions[0]).cross(w.positions[3] - w.positions[0]).length());
    for (wall, albedo) in walls.iter().zip(albedos) {
        build = build.mesh(wall.clone(), diffuse(albedo));
    }
    let world = build.world();
    let mut rng = Rng::new(8, 0);
    // Stratified over walls: the sum over walls of area times the mean difference.
    let (mut total, mut variance) = (DVec3::ZERO, DVec3::ZERO);
    let mut flux = Vec3::ZERO;
    let each = 48;
    for (w, wall) in walls.iter().enumerate() {
        let (u, v) = (wall.positions[1] - wall.positions[0], wall.positions[3] - wall.positions[0]);
        let normal = u.cross(v).normalize();
        let differences: Vec<_> = (0..each)
            .map(|i| {
                let [a, b] = rng.next_2d();
                let receiver = Receiver { position: wall.positions[0] + u * a + v * b, normal };
                let stream = (w * each + i) as u64;
                let light = receiver
                    .gather(&PathTracer::new(&world), &paths(1024), stream, no_progress())
                    .unwrap();
                let (rho, direct) = (albedos[w], light.direct.mean);
                flux += rho * direct * areas[w] / each as f32;
                let lost = (Vec3::ONE - rho) * light.indirect.mean - rho * direct;
                lost.as_dvec3() * f64::from(areas[w])
            })
            .collect();
        let n = each as f64;
        let mean = differences.iter().sum::<DVec3>() / n;
        total += mean;
        variance +=
            differences.iter().map(|d| (d - mean) * (d - mean)).sum::<DVec3>() / (n * (n - 1.0));
    }
    for c in 0..3 {
        let se = variance[c].sqrt();
        let z = total[c] / se;
        assert!(z.abs() < 4.5, "channel {c}: balance {} +- {se}", total[c]);
        assert!(se < 0.15 * f64::from(flux[c]), "channel {c}: {se} of {}", flux[c]);
    }
}
