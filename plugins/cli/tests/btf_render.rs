//! `farlight btf render` as people run it.

mod support;

use std::path::{Path, PathBuf};
use std::process::{Command, Output};

use farlight_btf_codec::{srgb_encode, synthetic};
use support::Folder;

const ALBEDO: [f32; 3] = [0.8, 0.35, 0.05];

fn material(folder: &Folder) -> PathBuf {
    let path = folder.at("lambert.fbtf");
    synthetic::lambert(ALBEDO, [2, 2]).unwrap().write(&path).unwrap();
    path
}

fn render(material: &Path, out: &Path, options: &[&str]) -> Output {
    let mut command = Command::new(env!("CARGO_BIN_EXE_farlight"));
    command.args(["btf", "render"]).arg(material).arg("--out").arg(out);
    command.args(options).output().unwrap()
}

fn picture(material: &Path, out: &Path, options: &[&str]) -> image::RgbImage {
    let output = render(material, out, options);
    assert!(output.status.success(), "{}", String::from_utf8_lossy(&output.stderr));
    image::open(out).unwrap().into_rgb8()
}

/// Channels of a pixel for what a Lambertian surface shows under a light of that strength.
fn expected(strength: f32) -> [f32; 3] {
    ALBEDO.map(|albedo| 255.0 * srgb_encode((albedo * strength).min(1.0)))
}

fn assert_close(pixel: image::Rgb<u8>, expected: [f32; 3], tolerance: f32) {
    for (found, expected) in pixel.0.into_iter().zip(expected) {
        assert!((f32::from(found) - expected).abs() <= tolerance, "{pixel:?} {expected}");
    }
}

#[test]
fn lights_add_up_and_fall_with_the_cosine() {
    let folder = Folder::new("lights");
    let (material, out) = (material(&folder), folder.at("out.png"));
    let common = ["--object", "plane", "--view", "0,0", "--size", "32x24", "--samples", "2"];
    // 60 degrees off: half of the light; the last stands behind the plane.
    for (lights, strength) in [
        (&["--light", "0,0"][..], 1.0),
        (&["--light", "60,0"], 0.5),
        (&["--light", "0,-60,0.8"], 0.4),
        (&["--light", "60,0", "--light", "-60,0,0.5", "--light", "180,10"], 0.75),
        (&["--light", "0,0,0.25", "--exposure", "1"], 0.5),
    ] {
        let picture = picture(&material, &out, &[&common[..], lights].concat());
        assert_eq!(picture.dimensions(), (32, 24));
        // One for rounding, and what 0.2 % of the value are.
        assert_close(*picture.get_pixel(16, 12), expected(strength), 1.5);
    }
}

#[test]
fn an_even_environment_gives_the_albedo_and_the_seed_decides_the_noise() {
    let folder = Folder::new("environment");
    let (material, out) = (material(&folder), folder.at("out.png"));
    let sky = folder.at("sky.hdr");
    let even = image::Rgb32FImage::from_pixel(16, 8, image::Rgb([0.5; 3]));
    even.save(&sky).unwrap();
    let options = ["--environment", sky.to_str().unwrap(), "--size", "24x24", "--samples", "32"];
    let picture =
        |seed: &str| picture(&material, &out, &[&options[..], &["--seed", seed]].concat());
    let first = picture("1");
    // The mean of a patch: the noise of 32 samples is below one step of 255.
    let mut sum = [0.0; 3];
    for (x, y) in (8..16).flat_map(|x| (8..16).map(move |y| (x, y))) {
        for (sum, channel) in sum.iter_mut().zip(first.get_pixel(x, y).0) {
            *sum += f32::from(channel) / 64.0;
        }
    }
    for (found, expected) in sum.into_iter().zip(expected(0.5)) {
        assert!((found - expected).abs() < 2.0, "{sum:?} {expected}");
    }
    // Beside the object the environment itself.
    assert_close(*first.get_pixel(0, 0), [255.0 * srgb_encode(0.5); 3], 1.0);
    assert_eq!(first, picture("1"));
    assert_ne!(first, picture("2"));
}

#[test]
fn every_object_shows_the_material() {
    let folder = Folder::new("objects");
    let (material, out) = (material(&folder), folder.at("out.png"));
    for object in ["sphere", "plane", "cylinder", "cloth"] {
        let options = ["--object", object, "--size", "40x40", "--samples", "1", "--view", "10,20"];
        let picture = picture(&material, &out, &options);
        let red = picture.pixels().filter(|pixel| pixel.0[0] > 2 * pixel.0[2].max(40)).count();
        assert!(red > 400, "{object}: {red} of 1600");
    }
}

#[test]
fn mistakes_are_named() {
    let folder = Folder::new("mistakes");
    let (material, out) = (material(&folder), folder.at("out.png"));
    let failed = |material: &Path, options: &[&str]| {
        let output = render(material, &out, options);
        assert!(!output.status.success(), "{options:?}");
        assert!(!out.exists(), "{options:?}");
        String::from_utf8_lossy(&output.stderr).into_owned()
    };
    assert!(failed(&material, &["--light", "0,95"]).contains("elevation"));
    assert!(failed(&material, &["--size", "0x10"]).contains("WxH"));
    assert!(failed(&folder.at("none.fbtf"), &[]).contains("none.fbtf"));
    let sky = folder.at("sky.hdr");
    std::fs::write(&sky, b"#?RADIANCE\nFORMAT=32-bit_rle_rgbe\n\n-Y 99999999 +X 99999999\n")
        .unwrap();
    assert!(failed(&material, &["--environment", sky.to_str().unwrap()]).contains("sky.hdr"));
}
