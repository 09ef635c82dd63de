//! Results repeat, standard errors are honest, means are unbiased.

use std::{
    ops::ControlFlow,
    sync::atomic::{AtomicU64, Ordering},
};

use farlight_gi_solver::{
    World,
    estimate::{GatherSettings, no_progress},
    path::PathTracer,
    probe::gather_probes,
    receiver::{Receiver, gather_receivers},
};
use glam::Vec3;

use crate::build::{Build, diffuse, disc, emitter, point, room, sphere};

fn furnished_room() -> World {
    let mut build = Build::default().light(point(Vec3::new(0.6, 1.8, 0.7), Vec3::splat(5.0)));
    for (i, wall) in room(Vec3::ZERO, Vec3::splat(2.0)).into_iter().enumerate() {
        let albedo = Vec3::new(0.2 + 0.1 * i as f32, 0.5, 0.8 - 0.1 * i as f32);
        build = build.mesh(wall, diffuse(albedo));
    }
    build.mesh(sphere(Vec3::splat(1.0), 0.4), diffuse(Vec3::splat(0.7))).world()
}

fn some_receivers() -> Vec<Receiver> {
    (0..5)
        .map(|i| Receiver { position: Vec3::new(0.3 + 0.3 * i as f32, 0.0, 0.4), normal: Vec3::Y })
        .collect()
}

/// Equal seeds give equal bits on one thread and on several; other seeds give other numbers.
#[test]
fn results_depend_on_the_seed_and_not_on_threads() {
    let world = furnished_room();
    let run = |threads: usize, seed| {
        let settings = GatherSettings { paths: 300, seed };
        let pool = rayon::ThreadPoolBuilder::new().num_threads(threads).build().unwrap();
        pool.install(|| {
            let receivers =
                gather_receivers(&world, &some_receivers(), &settings, no_progress()).unwrap();
            let probes =
                gather_probes(&world, &[Vec3::splat(0.4)], &settings, no_progress()).unwrap();
            (receivers, probes)
        })
    };
    let one = run(1, 7);
    assert_eq!(one, run(3, 7));
    assert_eq!(one, run(2, 7));
    let other = run(1, 8);
    assert_ne!(one.0[0].indirect, other.0[0].indirect);
    assert_ne!(one.1[0].indirect, other.1[0].indirect);
    assert_eq!(one.0[0].direct, other.0[0].direct, "direct light is exact");
}

/// Work can be stopped, and progress adds up to what was promised.
#[test]
fn progress_adds_up_and_can_stop_the_work() {
    let world = furnished_room();
    let settings = GatherSettings { paths: 1000, seed: 1 };
    let done = AtomicU64::new(0);
    let count = |paths| {
        done.fetch_add(paths, Ordering::Relaxed);
        ControlFlow::Continue(())
    };
    assert!(gather_receivers(&world, &some_receivers(), &settings, &count).is_some());
    assert_eq!(done.load(Ordering::Relaxed), settings.traced() * 5);
    assert!(settings.traced() >= 1000 && settings.traced() < 1032);
    let stop = |_| ControlFlow::Break(());
    assert!(gather_receivers(&world, &some_receivers(), &settings, &stop).is_none());
}

/// Over many seeds, z = (estimate - truth) / standard error has mean 0 and RMS 1.03 (Student's t
/// with 31 degrees of freedom), although the paths of one set are not independent. The truth: a
/// glowing disc, and what a second disc reflects of it, from a run with very many paths.
#[test]
fn standard_errors_are_honest() {
    let world = Build::default()
        .mesh(disc(Vec3::new(0.6, 1.0, 0.0), Vec3::Y, 0.7), emitter(Vec3::ZERO, Vec3::ONE))
        .mesh(
            disc(Vec3::new(-1.0, 0.5, 0.0), Vec3::X, 1.0),
            emitter(Vec3::new(0.8, 0.5, 0.2), Vec3::ZERO),
        )
        .world();
    let receiver = Receiver { position: Vec3::ZERO, normal: Vec3::Y };
    let many = GatherSettings { paths: 1 << 20, seed: 99 };
    let truth =
        receiver.gather(&PathTracer::new(&world), &many, 0, no_progress()).unwrap().indirect;
    let runs = 400;
    let (mut sum, mut squares) = (0.0_f64, 0.0_f64);
    for seed in 0..runs {
        let settings = GatherSettings { paths: 1024, seed };
        let found = receiver
            .gather(&PathTracer::new(&world), &settings, 0, no_progress())
            .unwrap()
            .indirect;
        let z = f64::from(found.mean.x - truth.mean.x) / f64::from(found.se.x.hypot(truth.se.x));
        sum += z;
        squares += z * z;
    }
    let n = runs as f64;
    let (mean, rms) = (sum / n, (squares / n).sqrt());
    // The mean of 400 z values has a standard deviation of 0.05, their RMS one of 0.037.
    assert!(mean.abs() < 0.22, "mean z = {mean}");
    assert!((0.88..1.19).contains(&rms), "RMS z = {rms}");
}

/// More paths give a smaller error, and faster than independent ones would.
#[test]
fn errors_shrink() {
    let world = furnished_room();
    let receiver = some_receivers()[2];
    let se = |paths| {
        let settings = GatherSettings { paths, seed: 3 };
        receiver
            .gather(&PathTracer::new(&world), &settings, 0, no_progress())
            .unwrap()
            .one_bounce
            .se
            .y
    };
    let (few, many) = (se(1 << 10), se(1 << 16));
    // Independent paths: a factor of 8. Known to 18 % (two standard errors, 32 replicates each).
    assert!(many < few / 8.0, "{few} to {many}");
}
