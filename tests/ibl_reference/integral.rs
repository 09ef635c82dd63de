//! The sum over an environment is right.

use std::{path::Path, time::Instant};

use farlight_environment::{Environment, Layout};

use crate::{
    support::{
        ball::Seen,
        integral::{Grain, environment_reference},
    },
    *,
};

/// Turned about an axis that is none of the map's.
pub(crate) const ROTATION: Quat = Quat::from_xyzw(0.1, 0.7, -0.1, 0.7);

pub(crate) const GLOSSY: Surface = Surface::Standard {
    base_color: DVec3::new(0.8, 0.8, 0.8),
    metallic: 1.0,
    perceptual_roughness: 0.4,
    reflectance: 0.5,
};

/// An environment of this project.
pub(crate) fn environment(name: &str) -> Environment {
    let path = support::assets().join("environments").join(name).with_extension("hdr");
    Environment::open(&path, Layout::Equirect).unwrap_or_else(|e| panic!("{e}"))
}

/// A photographed one; says so where there is none.
pub(crate) fn measured(name: &str) -> Option<Environment> {
    let Some(folder) = std::env::var_os("FARLIGHT_TEST_DATA") else {
        println!("SKIPPED: {name}, FARLIGHT_TEST_DATA is not set");
        return None;
    };
    let path = Path::new(&folder).join("environments").join(name).with_extension("hdr");
    if !path.exists() {
        println!("SKIPPED: there is no {}", path.display());
        return None;
    }
    Some(Environment::open(&path, Layout::Equirect).unwrap_or_else(|e| panic!("{e}")))
}

/// What every `step`th pixel shows at its centre.
pub(crate) fn points(step: u32) -> Vec<Seen> {
    let ball = Ball::filling(SIZE);
    ball.pixels(step).iter().filter_map(|&(_, centre)| ball.seen_at(centre)).collect()
}

pub(crate) fn deviation(ours: &[DVec3], reference: &[DVec3]) -> Deviation {
    let pairs: Vec<_> = ours.iter().copied().zip(reference.iter().copied()).collect();
    Deviation::over(&pairs)
}

/// A white Lambertian ball in light of one radiance cannot be seen: to 0.02 %, what the sum over
/// texels differs from the integral of the cosine.
#[test]
fn a_white_ball_vanishes_in_even_light() {
    let even = Environment::from_equirect(256, 128, vec![Vec3::splat(3.0); 256 * 128]).unwrap();
    let white = Surface::Lambert { albedo: DVec3::ONE };
    let points = points(5);
    let seen = environment_reference(&white, &even, ROTATION, Grain::TEXEL, &points);
    let deviation = deviation(&seen, &vec![DVec3::splat(3.0); points.len()]);
    println!("white ball in even light: {deviation}");
    assert!(deviation.absolute < 2e-4, "{deviation}");
}

/// `Environment::irradiance` integrates cosines exactly, in another way: 0.1 % apart.
#[test]
fn a_lambertian_ball_shows_the_environments_irradiance() {
    let white = Surface::Lambert { albedo: DVec3::ONE };
    let points = points(7);
    for name in ["sky", "interior"] {
        let environment = environment(name);
        let seen = environment_reference(&white, &environment, ROTATION, Grain::TEXEL, &points);
        let exact: Vec<_> = points
            .iter()
            .map(|point| {
                let normal = ROTATION.normalize().inverse() * point.normal.as_vec3();
                environment.irradiance(normal).as_dvec3() / std::f64::consts::PI
            })
            .collect();
        let deviation = deviation(&seen, &exact);
        println!("{name}: Lambert against the exact irradiance: {deviation}");
        assert!(deviation.absolute < 1e-3, "{name}: {deviation}");
    }
}

/// A light a texel is fine enough for a lobe of roughness 0.4: cutting texels changes the mean by less
/// than 0.05 %. Of a map of twice the size blocks of 2 x 2 texels are, to 0.1 %.
#[test]
fn grain_does_not_show() {
    let points = points(6);
    let of = |name: &str, environment: &Environment, grain| {
        let start = Instant::now();
        let seen = environment_reference(&GLOSSY, environment, ROTATION, grain, &points);
        println!("{name}, {grain:?}: {} points in {:?}", points.len(), start.elapsed());
        seen
    };
    for name in ["sky", "interior"] {
        let environment = environment(name);
        let fine = of(name, &environment, Grain::Split(2));
        let deviation = deviation(&of(name, &environment, Grain::TEXEL), &fine);
        println!("{name}, a light a texel against four: {deviation}");
        assert!(deviation.absolute < 5e-4, "{name}: {deviation}");
    }
    for name in ["noon_grass_1k", "vestibule_1k"] {
        let Some(environment) = measured(name) else { return };
        let deviation = deviation(
            &of(name, &environment, Grain::Merged(2)),
            &of(name, &environment, Grain::TEXEL),
        );
        println!("{name}, a light a block of 2 x 2 texels against a light a texel: {deviation}");
        assert!(deviation.absolute < 1e-3, "{name}: {deviation}");
    }
}
