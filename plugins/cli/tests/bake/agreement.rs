//! The same light in files and as numbers: texels and probes of `--out` against `--receivers
//! --range-window` at the same points, in units of the standard error of their difference.

use std::{fs, path::Path, process::Command};

use farlight_baked_format::{Manifest, ktx2::Texture, manifest::Receiver, volume};
use farlight_gi_solver::{
    import::{ImportOptions, load_scene},
    scene::{InstanceId, Scene},
    sh::ShRgb,
};
use glam::{UVec3, Vec2, Vec3};
use serde_json::{Value, json};

use crate::{
    folder::{SCENE, baked, checked, page},
    support::{Folder, succeeded},
};

/// Independent bakes: their spread is the standard error of their mean, with seven degrees of freedom.
const SEEDS: usize = 8;
/// Texels that are compared.
const TEXELS: usize = 160;
/// Points inside of a texel along its edges at which direct light is averaged.
const GRID: usize = 4;

/// Mean and standard error of the mean.
fn estimate(values: &[f64]) -> (f64, f64) {
    let n = values.len() as f64;
    let mean = values.iter().sum::<f64>() / n;
    let squares: f64 = values.iter().map(|v| (v - mean).powi(2)).sum();
    (mean, (squares / (n * (n - 1.0))).sqrt())
}

/// Checks that z values are those of an unbiased estimate with a known error.
#[track_caller]
fn check(what: &str, z: &[f64], rms: std::ops::Range<f64>) {
    let n = z.len() as f64;
    let mean = z.iter().sum::<f64>() / n;
    let root = (z.iter().map(|z| z * z).sum::<f64>() / n).sqrt();
    println!("{what}: {n} values, RMS z {root:.3}, mean z {mean:.3}");
    assert!(rms.contains(&root), "{what}: RMS z {root}");
    // Four standard errors of a mean of such values.
    assert!(mean.abs() < 4.0 * rms.end / n.sqrt(), "{what}: mean z {mean}");
}

/// Runs the other form of the command.
fn numbers(folder: &Folder, job: &Value, samples: &str, seed: usize) -> Value {
    let receivers = folder.write("in.json", &job.to_string());
    let result = folder.at("out.json");
    let output = Command::new(env!("CARGO_BIN_EXE_farlight"))
        .args(["bake", SCENE, "--range-window", "--samples", samples])
        .args(["--seed", &seed.to_string()])
        .args(["--receivers", receivers.to_str().unwrap(), "--result", result.to_str().unwrap()])
        .output()
        .unwrap();
    succeeded(&output);
    serde_json::from_str(&fs::read_to_string(&result).unwrap()).unwrap()
}

/// The surface point behind a place of a receiver's second UV square: position and normal.
fn surface(scene: &Scene, receiver: &Receiver, uv: Vec2) -> Option<(Vec3, Vec3)> {
    let id = InstanceId(u64::from(receiver.node) << 32 | u64::from(receiver.primitive));
    let instance = &scene.instances[&id];
    let mesh = &scene.meshes[&instance.mesh];
    mesh.triangles.iter().find_map(|triangle| {
        let [a, b, c] = triangle.map(|i| mesh.uv1[i as usize]);
        let area = (b - a).perp_dot(c - a);
        let v = (uv - a).perp_dot(c - a) / area;
        let w = (b - a).perp_dot(uv - a) / area;
        if !(v >= 0.0 && w >= 0.0 && v + w <= 1.0) {
            return None;
        }
        let [a, b, c] =
            triangle.map(|i| instance.transform.transform_point3(mesh.positions[i as usize]));
        Some((a + (b - a) * v + (c - a) * w, (b - a).cross(c - a).normalize()))
    })
}

struct Texel {
    page: usize,
    index: usize,
    normal: Vec3,
    center: Vec3,
    grid: Vec<Vec3>,
}

/// Texels that lie well inside of flat charts.
fn texels(scene: &Scene, manifest: &Manifest) -> Vec<Texel> {
    let mut texels = Vec::new();
    for receiver in &manifest.receivers {
        let [x0, y0, width, height] = receiver.rect;
        let size = Vec2::new(width as f32, height as f32);
        for (x, y) in (0..height).flat_map(|y| (0..width).map(move |x| (x, y))) {
            let at = |offset: Vec2| {
                let texel = Vec2::new(x as f32, y as f32) + 0.5 + offset;
                surface(scene, receiver, texel / size)
            };
            let Some((center, normal)) = at(Vec2::ZERO) else { continue };
            let flat = (0..16).all(|k| {
                let angle = std::f32::consts::TAU * k as f32 / 16.0;
                at(Vec2::from_angle(angle) * 2.0).is_some_and(|(_, n)| n.dot(normal) > 0.999)
            });
            if !flat {
                continue;
            }
            let step = |k: usize| (k as f32 + 0.5) / GRID as f32 - 0.5;
            let grid = (0..GRID * GRID)
                .filter_map(|k| at(Vec2::new(step(k % GRID), step(k / GRID))))
                .map(|(point, _)| point)
                .collect();
            let index = ((y0 + y) * manifest.page_size + x0 + x) as usize;
            texels.push(Texel { page: receiver.page as usize, index, normal, center, grid });
        }
    }
    let every = (texels.len() / TEXELS).max(1);
    texels.into_iter().step_by(every).collect()
}

fn green(value: &Value) -> f64 {
    value[1].as_f64().unwrap()
}

fn surface_job(points: impl Iterator<Item = (Vec3, Vec3)>) -> Value {
    let points: Vec<Value> =
        points.map(|(p, n)| json!({ "position": p.to_array(), "normal": n.to_array() })).collect();
    json!({ "surface": points })
}

fn bake_all(folder: &Folder, more: &[&str]) -> Vec<(std::path::PathBuf, Manifest)> {
    (0..SEEDS)
        .map(|seed| {
            let out = folder.at(&format!("out{seed}"));
            let seed = (seed + 1).to_string();
            baked(&out, &[more, &["--no-denoise", "--seed", &seed]].concat());
            let manifest = checked(&out).unwrap();
            (out, manifest)
        })
        .collect()
}

#[test]
fn texels_agree_with_receivers() {
    let folder = Folder::new("bake-texels");
    let all = bake_all(&folder, &["--size", "128", "--samples", "64", "--no-probes"]);
    let (out, manifest) = &all[0];
    let lit = load_scene(&out.join(&manifest.scene), &ImportOptions::default()).unwrap().scene;
    let texels = texels(&lit, manifest);
    let job = surface_job(texels.iter().map(|t| (t.center, t.normal)));
    let expected = numbers(&folder, &job, "2048", 99);
    let job = surface_job(texels.iter().flat_map(|t| t.grid.iter().map(|p| (*p, t.normal))));
    let direct = numbers(&folder, &job, "1", 99);
    let direct = direct["surface"].as_array().unwrap();

    let pages: Vec<Vec<Vec<Vec3>>> = all
        .iter()
        .map(|(out, manifest)| {
            (0..manifest.pages as usize).map(|i| page(out, manifest, i).texels).collect()
        })
        .collect();
    let (mut z, mut ratios) = (Vec::new(), Vec::new());
    for ((texel, expected), direct) in
        texels.iter().zip(expected["surface"].as_array().unwrap()).zip(direct.chunks(GRID * GRID))
    {
        let direct: Vec<f64> = direct.iter().map(|value| green(&value["direct"])).collect();
        // Where a shadow crosses the texel, how exactly the light is averaged matters.
        let lit = direct.iter().filter(|light| **light > 0.0).count();
        if lit % (GRID * GRID) != 0 {
            continue;
        }
        let direct = direct.iter().sum::<f64>() / direct.len() as f64;
        let baked: Vec<f64> = pages
            .iter()
            .map(|pages| f64::from(pages[texel.page][texel.index].y) * std::f64::consts::PI)
            .collect();
        let (mean, error) = estimate(&baked);
        let reference = direct + green(&expected["indirect"]);
        let other = green(&expected["indirect_se"]);
        z.push((mean - reference) / error.hypot(other));
        ratios.push(mean / reference);
    }
    assert!(z.len() > TEXELS / 2, "{}", z.len());
    // Student's t with 7 to 14 degrees of freedom: 1.08 to 1.18.
    check("texels", &z, 0.85..1.4);
    ratios.sort_by(f64::total_cmp);
    let median = ratios[ratios.len() / 2];
    assert!((median - 1.0).abs() < 0.03, "median ratio {median}");
    // What the engine loads holds the same as the picture: 9 bits a channel, a common exponent.
    let texture = fs::read(out.join(&manifest.scenarios[0].pages[0].ktx2)).unwrap();
    let texture = Texture::read(&texture).unwrap();
    for (a, b) in texture.texels.iter().zip(&pages[0][0]) {
        assert!((*a - *b).abs().max_element() <= b.max_element() / 300.0 + 1e-5, "{a} {b}");
    }
}

/// Ambient cubes by probe.
fn cubes(out: &Path, manifest: &Manifest) -> Vec<[Vec3; 6]> {
    let resolution = UVec3::from(manifest.volumes[0].resolution);
    let bytes = fs::read(out.join(&manifest.scenarios[0].volumes[0])).unwrap();
    let texture = Texture::read(&bytes).unwrap();
    let mut cubes = vec![[Vec3::ZERO; 6]; resolution.element_product() as usize];
    for ((probe, face), texel) in volume::order(resolution).zip(&texture.texels) {
        cubes[probe][face] = *texel;
    }
    cubes
}

#[test]
fn the_volume_agrees_with_probes() {
    let folder = Folder::new("bake-volume");
    let all = bake_all(
        &folder,
        &["--size", "64", "--samples", "2", "--probe-spacing", "1.2", "--no-exr"],
    );
    let manifest = &all[0].1;
    let resolution = UVec3::from(manifest.volumes[0].resolution);
    let transform = manifest.volumes[0].affine();
    let [nx, ny, nz] = resolution.to_array();
    let cells =
        (0..nz).flat_map(|z| (0..ny).flat_map(move |y| (0..nx).map(move |x| UVec3::new(x, y, z))));
    let places: Vec<Vec3> = cells
        .map(|cell| transform.transform_point3((cell.as_vec3() + 0.5) / resolution.as_vec3() - 0.5))
        .collect();
    let job = json!({ "probes": places.iter().map(|p| p.to_array()).collect::<Vec<_>>() });
    let expected: Vec<Vec<[Vec3; 6]>> = (0..SEEDS)
        .map(|seed| {
            let out = numbers(&folder, &job, "256", 100 + seed);
            let probe = |value: &Value| {
                let sh: [[f32; 3]; 9] = serde_json::from_value(value["sh"].clone()).unwrap();
                ShRgb(sh.map(Vec3::from)).ambient_cube()
            };
            out["probes"].as_array().unwrap().iter().map(probe).collect()
        })
        .collect();
    let found: Vec<Vec<[Vec3; 6]>> =
        all.iter().map(|(out, manifest)| cubes(out, manifest)).collect();
    let mut z = Vec::new();
    for (i, place) in places.iter().enumerate() {
        // Inside of the wall and of the ball probes take the light of their neighbours.
        let wall = (place.x - 5.1).abs() < 0.2;
        let ball = place.distance(Vec3::new(6.6, 0.6, 3.3)) < 0.6;
        if wall || ball {
            continue;
        }
        for face in 0..6 {
            let of = |all: &[Vec<[Vec3; 6]>]| {
                estimate(&all.iter().map(|one| f64::from(one[i][face].y)).collect::<Vec<_>>())
            };
            let ((found, a), (expected, b)) = (of(&found), of(&expected));
            z.push((found - expected) / a.hypot(b));
        }
    }
    assert!(z.len() > 100, "{}", z.len());
    check("faces of probes", &z, 0.8..1.4);
}
