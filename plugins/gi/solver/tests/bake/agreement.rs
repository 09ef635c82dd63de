//! What is gathered agrees with the path tracer at the same points.

use std::{path::Path, sync::Arc};

use farlight_gi_solver::{
    Scene, World,
    bake::{Density, Gathered, Gatherer, GathererSettings, Layout, LayoutSettings, volume},
    estimate::{GatherSettings, no_progress},
    import::{ImportOptions, load_scene},
    probe::gather_probes,
    receiver::{Receiver, gather_receivers},
    scene::{DirectSky, Light, LightId, LightKind, Sky, SkyImage},
    session::ProbeGrid,
    unwrap::{UnwrapOptions, ensure_uv1},
};
use glam::{Affine3A, Quat, UVec3, Vec3};

use crate::{
    common::{Builder, quad, two_rooms},
    scenes::built,
};

/// Texels that are compared.
const COMPARED: usize = 120;
/// Passes that are gathered: twice as many samples tell the noise.
const PASSES: u32 = 8;

fn luminance(c: Vec3) -> f64 {
    f64::from(c.dot(Vec3::new(0.2126, 0.7152, 0.0722)))
}

fn file(path: &Path) -> Scene {
    let options = ImportOptions { range_window: true, ..ImportOptions::default() };
    let mut scene = load_scene(path, &options).unwrap().scene;
    for mesh in scene.meshes.values_mut() {
        if let Ok(unwrapped) = ensure_uv1(mesh, &UnwrapOptions::default()) {
            *mesh = Arc::new(unwrapped.apply(mesh));
        }
    }
    scene
}

fn settings(bounces: u32) -> GathererSettings {
    GathererSettings { seed: 3, bounces, direct_sky: DirectSky::Included }
}

/// Compares texels with the path tracer: z values formed with the noise of both have mean 0 and RMS 1,
/// and the sums differ by at most their noise and `bias`.
fn agree(what: &str, scene: &Scene, page_size: u32, bounces: u32, paths: u32, bias: f64) {
    let world = World::new(scene);
    let layout_settings = LayoutSettings { page_size, max_pages: 1, density: Density::Fit };
    let layout = Layout::new(scene, &world, scene.instances.keys().copied(), &layout_settings);
    let gatherer = Gatherer::new(&world, &layout, settings(bounces), no_progress()).unwrap();
    let mut gathered = Gathered::new(&layout);
    // Sums after each pass: their differences are independent.
    let mut sums = vec![gathered.halves.clone()];
    for _ in 0..PASSES {
        gatherer.pass(&mut gathered, 1024 / PASSES, no_progress()).unwrap();
        sums.push(gathered.halves.clone());
    }
    let noise = |i: usize| {
        let rays = 512.0 / f64::from(PASSES);
        let samples: Vec<f64> = sums
            .windows(2)
            .flat_map(|s| [0, 1].map(|h| luminance(s[1][h][i] - s[0][h][i]) / rays))
            .collect();
        let n = samples.len() as f64;
        let mean = samples.iter().sum::<f64>() / n;
        let variance = samples.iter().map(|s| (s - mean).powi(2)).sum::<f64>() / (n - 1.0);
        (variance / n).sqrt()
    };

    let texels: Vec<_> = layout.texels().collect();
    let able: Vec<usize> = (0..texels.len())
        .filter(|&i| texels[i].open && texels[i].normal == texels[i].geometric)
        .collect();
    let chosen: Vec<usize> =
        (0..COMPARED).map(|k| able[(2 * k + 1) * able.len() / (2 * COMPARED)]).collect();
    let receivers: Vec<Receiver> = chosen
        .iter()
        .map(|&i| Receiver { position: texels[i].position, normal: texels[i].normal })
        .collect();
    let paths = GatherSettings { paths, seed: 9 };
    let truth = gather_receivers(&world, &receivers, &paths, no_progress()).unwrap();

    let brightest =
        (0..texels.len()).map(|i| luminance(gathered.irradiance(i))).fold(0.0, f64::max);
    let (mut z_sum, mut z_squares, mut n) = (0.0, 0.0, 0.0);
    let (mut ours_sum, mut truth_sum, mut variance) = (0.0, 0.0, 0.0);
    for ((&i, light), receiver) in chosen.iter().zip(&truth).zip(&receivers) {
        let reflected = if bounces == 1 { light.one_bounce } else { light.indirect };
        let sky = light.direct.mean - receiver.direct(&world);
        let (ours, paths) = (luminance(gathered.irradiance(i)), luminance(reflected.mean + sky));
        if paths < brightest * 1e-3 {
            continue;
        }
        // Channels share their noise, and so do light from the sky and the rest.
        let se = luminance(reflected.se) + luminance(light.direct.se);
        let noise = noise(i);
        let z = (ours - paths) / se.hypot(noise);
        z_sum += z;
        z_squares += z * z;
        n += 1.0;
        ours_sum += ours;
        truth_sum += paths;
        variance += se * se + noise * noise;
    }
    let (mean_z, rms_z): (f64, f64) = (z_sum / n, f64::sqrt(z_squares / n));
    let (error, noise) = (ours_sum / truth_sum - 1.0, f64::sqrt(variance) / truth_sum);
    println!(
        "{what}: {n} texels of {}, z mean {mean_z:+.3} rms {rms_z:.3}, sum {:+.3} % +- {:.3} %",
        texels.len(),
        error * 100.0,
        noise * 100.0
    );
    assert!(n > 60.0, "{what}");
    assert!(mean_z.abs() < 4.0 / f64::sqrt(n) + 0.15, "{what}: {mean_z}");
    assert!((0.6..1.35).contains(&rms_z), "{what}: {rms_z}");
    assert!(error.abs() < 4.0 * noise + bias, "{what}: {error} +- {noise}");
}

fn repository(path: &str) -> Scene {
    file(&Path::new(env!("CARGO_MANIFEST_DIR")).join("../../..").join(path))
}

#[test]
fn two_rooms_agree() {
    agree("TwoRooms", &repository("tests/data/TwoRooms.glb"), 128, 0, 512, 3e-3);
}

#[test]
fn one_bounce_agrees() {
    agree("one bounce", &repository("tests/data/TwoRooms.glb"), 128, 1, 512, 3e-3);
}

fn lamp(position: Vec3) -> Light {
    let (direction, intensity) = (Vec3::NEG_Y, Vec3::splat(100.0));
    Light { kind: LightKind::Point, position, direction, intensity, range: 20.0 }
}

#[test]
fn a_doorway_agrees() {
    let mut scene = repository("assets/scenes/doorway.glb");
    scene.lights.insert(LightId(9), lamp(Vec3::new(-2.6, 2.2, 0.3)));
    agree("doorway", &scene, 96, 0, 512, 3e-3);
}

/// Two texels are as high as the shade, and one reaches around its lower edge.
#[test]
fn a_lamp_in_its_shade_agrees() {
    let mut scene = repository("assets/baked/study/study.glb");
    scene.lights.insert(LightId(9), lamp(Vec3::new(-1.95, 1.56, 1.35)));
    agree("lamp", &scene, 128, 0, 2048, 4e-3);
}

#[test]
fn the_cornell_box_agrees() {
    let Some(folder) = std::env::var_os("FARLIGHT_TEST_DATA") else {
        println!("SKIPPED: CornellBox: FARLIGHT_TEST_DATA does not name the folder with test data");
        return;
    };
    agree(
        "CornellBox",
        &file(&Path::new(&folder).join("reference/CornellBox.glb")),
        96,
        0,
        512,
        3e-3,
    );
}

/// A sky with a sun, seen through a missing wall; a small lamp of emissive material; a surface without
/// texels; and a thin wall on the floor.
#[test]
fn suns_and_lamps_agree() {
    let mut b = Builder::default();
    let grey = Vec3::splat(0.6);
    let (x, y, z) = (Vec3::X * 4.0, Vec3::Y * 3.0, Vec3::Z * 4.0);
    b.quad(Vec3::ZERO, z, x, Vec3::new(0.6, 0.5, 0.4));
    b.quad(y, x, z, grey);
    b.quad(Vec3::ZERO, x, y, grey);
    b.quad(z, y, x, grey);
    b.quad(x, z, y, grey);
    // What has no second UV set: a bench and the sides of the wall.
    let without = |mut mesh: farlight_gi_solver::scene::Mesh| {
        mesh.uv1.clear();
        mesh
    };
    b.add(without(quad(Vec3::new(1.0, 0.5, 1.0), Vec3::Z, Vec3::X)), Vec3::splat(0.5), Vec3::ZERO);
    let wall = Vec3::new(2.0, 0.0, 0.0);
    b.add(without(quad(wall, Vec3::Z * 2.0, Vec3::Y * 2.0)), grey, Vec3::ZERO);
    // A lamp of 10 cm.
    let lamp = without(quad(Vec3::new(3.0, 2.0, 1.0), Vec3::X * 0.1, Vec3::Z * 0.1));
    b.add(lamp, grey, Vec3::splat(400.0));
    let (mut scene, _) = built(b);
    let texels = (0..64 * 32).map(|i| match (i % 64, i / 64) {
        (16, 10) => Vec3::new(3000.0, 2700.0, 2400.0),
        (_, row) if row < 16 => Vec3::new(2.0, 3.0, 4.0),
        _ => Vec3::splat(0.5),
    });
    scene.sky = Sky::Image {
        image: Arc::new(SkyImage { width: 64, height: 32, texels: texels.collect() }),
        rotation: Quat::IDENTITY,
        scale: 1.0,
    };
    agree("sun and lamp", &scene, 64, 0, 512, 3e-3);
}

#[test]
fn probes_agree() {
    let mut b = two_rooms(true);
    b.point_light(1, Vec3::new(2.0, 2.5, 2.0), Vec3::new(100.0, 90.0, 80.0));
    let (mut scene, receivers) = built(b);
    scene.sky = Sky::Constant(Vec3::ONE);
    let world = World::new(&scene);
    let layout_settings = LayoutSettings { page_size: 64, max_pages: 1, density: Density::Fit };
    let layout = Layout::new(&scene, &world, receivers, &layout_settings);
    let gatherer = Gatherer::new(&world, &layout, settings(0), no_progress()).unwrap();
    let (low, high) = (Vec3::new(0.2, 0.2, 0.2), Vec3::new(8.0, 2.8, 3.8));
    let grid = ProbeGrid {
        transform: Affine3A::from_scale_rotation_translation(
            high - low,
            Quat::IDENTITY,
            (low + high) * 0.5,
        ),
        resolution: UVec3::new(6, 2, 3),
    };
    let ours = volume(&world, &gatherer, &grid, 8192, no_progress()).unwrap();
    assert_eq!(ours.len(), 36);
    let positions: Vec<Vec3> = (0..36)
        .map(|i| {
            let at = UVec3::new(i % 6, i / 6 % 2, i / 12).as_vec3();
            grid.transform.transform_point3((at + 0.5) / grid.resolution.as_vec3() - 0.5)
        })
        .collect();
    let paths = GatherSettings { paths: 2048, seed: 4 };
    let truth = gather_probes(&world, &positions, &paths, no_progress()).unwrap();
    let (mut squares, mut n) = (0.0, 0.0_f64);
    for (ours, truth) in ours.iter().zip(&truth) {
        for k in 0..9 {
            let difference = luminance(ours.0[k] - truth.indirect.0[k] - truth.sky.0[k]);
            // Ours has four times as many rays and MIS: its noise is half at most.
            let se = luminance(truth.indirect_se.0[k]).hypot(luminance(truth.sky_se.0[k])) * 1.12;
            squares += (difference / se.max(1e-9)).powi(2);
            n += 1.0;
        }
    }
    let rms = (squares / n).sqrt();
    println!("probes: z rms {rms:.3}");
    assert!((0.6..1.3).contains(&rms), "{rms}");
}
