//! The cloth in `assets/materials/`, which every checkout has: is it physically sound, seamless, and
//! what it is said to be?

use std::path::Path;

use farlight_btf_codec::{Angles, Btf, Rules, linear};
use glam::Vec3;

fn cloth() -> Btf {
    let path = Path::new(env!("CARGO_MANIFEST_DIR")).join("../../../assets/materials/cloth.fbtf");
    Btf::open(&path).expect("assets/materials/cloth.fbtf")
}

fn light(btf: &Btf, x: i32, y: i32, angles: Angles) -> Vec3 {
    (btf.evaluate(x, y, angles, Rules::SHADING) / 255.0).map(linear)
}

/// Mean over all texels, in linear light.
fn mean(btf: &Btf, angles: Angles) -> Vec3 {
    let [columns, rows] = btf.size().map(|size| size as i32);
    let texels = (0..rows).flat_map(|y| (0..columns).map(move |x| (x, y)));
    texels.map(|(x, y)| light(btf, x, y, angles)).sum::<Vec3>() / (columns * rows) as f32
}

fn degrees(theta_i: f64, phi_i: f64, theta_v: f64, phi_v: f64) -> Angles {
    Angles::from_degrees(theta_i, phi_i, theta_v, phi_v)
}

#[test]
fn it_is_small_and_says_how_large_it_is() {
    let btf = cloth();
    assert_eq!(btf.size(), [64, 64]);
    let size = btf.info().size.expect("the size of the tile in metres");
    assert!(size.iter().all(|side| (0.005..0.05).contains(side)), "{size:?}");
    let bytes = 4 * btf.words().len();
    println!("{bytes} bytes");
    assert!(bytes < BYTES, "{bytes}");
}

/// One mebibyte.
const BYTES: usize = 1 << 20;

/// Whatever the view, no more light leaves than arrives; and two yarns that reflect 1 to 70 % can
/// neither be black nor white.
#[test]
fn it_conserves_energy() {
    let btf = cloth();
    for theta_v in [0.0_f32, 20.0, 40.0, 60.0, 75.0, 89.0] {
        for phi_v in [0.0_f32, 75.0, 160.0, 290.0] {
            let albedo = btf.mean_albedo(theta_v.to_radians(), phi_v.to_radians(), 256);
            println!("{theta_v} {phi_v}: {:.3} +- {:.3}", albedo.value, albedo.error);
            assert!(albedo.conserves_energy(), "{theta_v} {phi_v}: {albedo:?}");
            let [least, most] = [albedo.value.min_element(), albedo.value.max_element()];
            assert!(least > 0.1 && most < 0.6, "{theta_v} {phi_v}: {albedo:?}");
        }
    }
    // A single texel may send out more than its share for a view, but not for all.
    for texel in 0..64 {
        let [x, y] = [texel * 7 % 64, texel];
        let albedo = btf.albedo(x, y, 0.4, 1.0);
        assert!(albedo.value.max_element() < 1.0, "{x} {y}: {albedo:?}");
    }
}

/// Helmholtz: light and view swapped give the same BRDF, as a mean over the tile (a single texel
/// sees other parts of the cloth from another side). Directions are on the grid, where nothing is
/// interpolated but the azimuth of the light; the limit is what tracing, grid and compression leave.
#[test]
fn its_mean_is_reciprocal() {
    let btf = cloth();
    let directions =
        [(15.0, 0.0), (30.0, 45.0), (45.0, 90.0), (45.0, 202.5), (60.0, 315.0), (75.0, 135.0)];
    let mut differences = Vec::new();
    for (at, a) in directions.iter().enumerate() {
        for b in &directions[at + 1..] {
            let there = mean(&btf, degrees(a.0, a.1, b.0, b.1)) / (a.0.to_radians().cos() as f32);
            let back = mean(&btf, degrees(b.0, b.1, a.0, a.1)) / (b.0.to_radians().cos() as f32);
            let difference = (there - back).abs() / (0.5 * (there + back));
            println!("{a:?} {b:?}: {there:.3} {back:.3}");
            differences.push(difference.max_element());
        }
    }
    let mean = differences.iter().sum::<f32>() / differences.len() as f32;
    let worst = differences.iter().copied().fold(0.0, f32::max);
    println!("relative difference: mean {mean:.3}, worst {worst:.3}");
    assert!(mean < 0.05 && worst < 0.16, "{mean} {worst}");
}

/// The step from the last column (row) to the first is like those inside.
#[test]
fn it_repeats_without_a_seam() {
    let btf = cloth();
    for angles in [degrees(30.0, 40.0, 10.0, 0.0), degrees(60.0, 200.0, 50.0, 120.0)] {
        let step = |x: i32, y: i32, across: bool| {
            let next = if across { (x + 1, y) } else { (x, y + 1) };
            light(&btf, x, y, angles).distance(light(&btf, next.0, next.1, angles))
        };
        for across in [true, false] {
            // Steps over one line of the tile, 64 of them.
            let lines: Vec<f32> = (0..64)
                .map(|line| {
                    let steps = (0..64).map(|at| {
                        if across { step(line, at, across) } else { step(at, line, across) }
                    });
                    steps.sum::<f32>() / 64.0
                })
                .collect();
            let seam = lines[63];
            let most = lines[..63].iter().copied().fold(0.0, f32::max);
            assert!(seam <= 1.1 * most, "across {across}: {seam} at the seam, {most} inside");
        }
    }
}

/// Indigo and ecru: some texels are blue, some cream, from every side; and the light's direction
/// shows (a texel is not the same under all lights).
#[test]
fn its_colours_are_those_of_the_yarns() {
    let btf = cloth();
    let head_on = degrees(30.0, 60.0, 0.0, 0.0);
    let texels: Vec<Vec3> =
        (0..4096).map(|texel| light(&btf, texel % 64, texel / 64, head_on)).collect();
    let blue = texels.iter().filter(|c| c.z > 1.5 * c.x).count();
    let cream = texels.iter().filter(|c| c.x > 1.2 * c.z).count();
    println!("{blue} blue, {cream} cream");
    assert!(blue > 1000 && cream > 1000, "{blue} {cream}");
    // Yarns are round: what faces a light from the left is another part than from the right.
    let sides = [degrees(60.0, 0.0, 0.0, 0.0), degrees(60.0, 180.0, 0.0, 0.0)];
    let difference = (0..4096)
        .map(|texel| {
            let [left, right] = sides.map(|side| light(&btf, texel % 64, texel / 64, side));
            (left - right).abs().element_sum() / (left + right).element_sum().max(1e-3)
        })
        .sum::<f32>()
        / 4096.0;
    println!("relative difference between two lights: {difference:.3}");
    assert!(difference > 0.1, "{difference}");
}
