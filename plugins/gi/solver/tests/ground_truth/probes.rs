//! Probes against integrals over simple shapes.

use std::f32::consts::PI;

use farlight_gi_solver::{
    estimate::{Estimate, no_progress},
    path::PathTracer,
    probe::{gather_probe, gather_probes},
    sh::sh_basis,
};
use glam::Vec3;

use crate::{
    build::{Build, disc, emitter},
    check::{agrees, paths},
};

/// A glowing disc seen under the half angle θ on each axis: c₀ = L Y₀ 2π (1 - cos θ) and, for the
/// first band, L Y₁ π sin² θ along the axis.
#[test]
fn a_disc_on_each_axis() {
    let emitted = Vec3::new(1.0, 2.0, 4.0);
    let here = Vec3::new(0.5, -1.0, 2.0);
    // Places of y, z and x in the first band.
    for (axis, place) in [(Vec3::X, 3), (Vec3::Y, 1), (Vec3::Z, 2)] {
        for sign in [1.0, -1.0] {
            let axis = axis * sign;
            let world = Build::default()
                .mesh(disc(here + axis, axis, 1.0), emitter(Vec3::ZERO, emitted))
                .world();
            let probe =
                gather_probe(&PathTracer::new(&world), here, &paths(8192), 0, no_progress())
                    .unwrap();
            let coefficient =
                |i: usize| Estimate { mean: probe.indirect.0[i], se: probe.indirect_se.0[i] };
            let cos = 0.5_f32.sqrt();
            let basis = sh_basis(axis);
            agrees("l = 0", coefficient(0), emitted * (basis[0] * 2.0 * PI * (1.0 - cos)), 1e-4);
            agrees("axis", coefficient(place), emitted * (basis[place] * PI * 0.5), 1e-4);
            for other in (1..4).filter(|i| *i != place) {
                let e = coefficient(other);
                agrees("across", e, Vec3::ZERO, 0.0);
            }
            // Second band, rotationally symmetric about the axis: ∫ P₂ = π (cos θ - cos³ θ).
            for (i, y) in basis.iter().enumerate().skip(4) {
                let e = coefficient(i);
                agrees("l = 2", e, emitted * (y * PI * (cos - cos.powi(3))), 1e-4);
            }
        }
    }
}

/// The sky is kept apart from what surfaces send.
#[test]
fn the_sky_is_kept_apart() {
    let sky = Vec3::new(1.0, 0.5, 0.25);
    let world = Build::default()
        .mesh(disc(Vec3::Y, Vec3::Y, 1.0), emitter(Vec3::ZERO, Vec3::ONE))
        .sky(sky)
        .world();
    let probes =
        gather_probes(&world, &[Vec3::ZERO, Vec3::Y * 1e6], &paths(4096), no_progress()).unwrap();
    let free = probes[1];
    // The disc is still there, 10⁶ metres away.
    assert!(free.indirect.0[0].x > 0.0 && free.indirect.0[0].x < 1e-11);
    // A constant sky: c₀ = L √(4π).
    assert!(free.sky.0[0].distance(sky * (4.0 * PI).sqrt()) < 1e-3, "{:?}", free.sky.0[0]);
    let cos = 0.5_f32.sqrt();
    let seen = sky * ((4.0 * PI).sqrt() * (1.0 + cos) / 2.0);
    let e = Estimate { mean: probes[0].sky.0[0], se: probes[0].sky_se.0[0] };
    agrees("sky beside the disc", e, seen, 1e-4);
}
