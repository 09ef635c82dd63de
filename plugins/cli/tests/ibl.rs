//! `farlight ibl` as a user runs it.

mod support;

use std::{
    fs,
    path::{Path, PathBuf},
    process::{Command, Output},
};

use glam::Vec3;
use serde_json::Value;
use support::{Folder, refused, succeeded};

const SKY: &str = concat!(env!("CARGO_MANIFEST_DIR"), "/../../assets/environments/sky.hdr");

fn ibl(command: &str, map: impl AsRef<Path>, arguments: &[&str]) -> Output {
    let mut farlight = Command::new(env!("CARGO_BIN_EXE_farlight"));
    farlight.args(["ibl", command]).arg(map.as_ref()).args(arguments).output().unwrap()
}

/// Direction and irradiance of each light of a file.
fn lights(path: &Path) -> Vec<(Vec3, Vec3)> {
    let all: Value = serde_json::from_slice(&fs::read(path).unwrap()).unwrap();
    let vector = |light: &Value, name: &str| {
        let numbers = light[name].as_array().unwrap();
        assert_eq!(numbers.len(), 3);
        Vec3::from_array([0, 1, 2].map(|at| numbers[at].as_f64().unwrap() as f32))
    };
    let all = all.as_array().unwrap().iter();
    all.map(|light| (vector(light, "direction"), vector(light, "irradiance"))).collect()
}

/// A Radiance picture of 8 x 4 texels, black but for one above the horizon, ahead to the right.
fn one_texel(folder: &Folder) -> PathBuf {
    let mut bytes = b"#?RADIANCE\n\n-Y 4 +X 8\n".to_vec();
    for at in 0..32 {
        // Mantissas of half with an exponent of 1: radiance 1, green a half.
        bytes.extend(if at == 8 + 4 { [128, 64, 128, 129] } else { [0; 4] });
    }
    let path = folder.at("one.hdr");
    fs::write(&path, bytes).unwrap();
    path
}

#[test]
fn lights_are_written_whole_with_direction_and_irradiance() {
    let folder = Folder::new("lights");
    let map = one_texel(&folder);
    let solid_angle = std::f32::consts::FRAC_1_SQRT_2 * std::f32::consts::TAU / 8.0;
    for method in ["independent", "stratified", "regions", "centroids"] {
        let out = folder.at("lights.json");
        let options = ["--count", "9", "--seed", "5", "--method", method, "--out"];
        let said =
            succeeded(&ibl("lights", &map, &[&options[..], &[out.to_str().unwrap()]].concat()));
        assert!(said.contains(&format!("9 lights ({method})")), "{said}");
        let lights = lights(&out);
        assert_eq!(lights.len(), 9);
        let sum: Vec3 = lights.iter().map(|(_, irradiance)| *irradiance).sum();
        let expected = solid_angle * Vec3::new(1.0, 0.5, 1.0);
        assert!((sum - expected).length() < 1e-4, "{method}: {sum} is not {expected}");
        for (direction, _) in lights {
            assert!((direction.length() - 1.0).abs() < 1e-5);
            // Towards the light: up, to the right, ahead.
            assert!(direction.y > 0.0 && direction.x > 0.0 && direction.z < 0.0, "{direction}");
        }
    }
}

#[test]
fn the_seed_decides_and_the_best_method_is_the_default() {
    let folder = Folder::new("seed");
    let run = |name: &str, options: &[&str]| {
        let out = folder.at(name);
        let all = [&["--count", "50", "--out", out.to_str().unwrap()], options].concat();
        succeeded(&ibl("lights", SKY, &all));
        fs::read(out).unwrap()
    };
    let default = run("a.json", &[]);
    assert_eq!(default, run("b.json", &["--seed", "0", "--method", "centroids"]));
    assert_ne!(default, run("c.json", &["--seed", "1"]));
    assert_ne!(default, run("d.json", &["--method", "regions"]));
}

#[test]
fn a_picture_shows_the_lights() {
    let folder = Folder::new("picture");
    let map = one_texel(&folder);
    let (out, picture) = (folder.at("lights.json"), folder.at("lights.png"));
    let options = ["--count", "4", "--out", out.to_str().unwrap(), "--picture"];
    succeeded(&ibl("lights", &map, &[&options[..], &[picture.to_str().unwrap()]].concat()));
    let picture = image::open(&picture).unwrap().into_rgb8();
    assert_eq!(picture.dimensions(), (1024, 512));
    let is_dot = |pixel: &image::Rgb<u8>| pixel.0[0] > 200 && pixel.0[1] < 80;
    for (x, y, pixel) in picture.enumerate_pixels() {
        // All within the texel: columns 512 to 640, rows 128 to 256, and the width of a dot.
        let inside = (506..646).contains(&x) && (120..262).contains(&y);
        assert!(inside || !is_dot(pixel), "{x} {y}");
    }
    assert!(picture.pixels().any(is_dot));
}

#[test]
fn methods_are_compared_in_a_table_and_a_plot() {
    let folder = Folder::new("compare");
    let out = folder.at("plot.svg");
    let options = ["--counts", "20,200", "--seeds", "8", "--out", out.to_str().unwrap()];
    let said = succeeded(&ibl("compare", SKY, &options));
    let row = |count: &str| -> Vec<f64> {
        let line = said.lines().find(|line| line.trim_start().starts_with(count)).unwrap();
        line.split_whitespace().skip(1).map(|number| number.parse().unwrap()).collect()
    };
    let (few, many) = (row("20 "), row("200 "));
    assert_eq!(few.len(), 4, "{said}");
    for (few, many) in few.iter().zip(&many) {
        assert!(many < few, "{said}");
    }
    // In %: lights drawn by themselves err by about 10, those in the middle of regions by less than 1.
    assert!(many[0] > 4.0 && many[3] < 1.0, "{said}");
    let svg = fs::read_to_string(out).unwrap();
    assert_eq!(svg.matches("stroke-width=\"2\"").count(), 4);
}

#[test]
fn what_is_wrong_is_said_and_nothing_is_written() {
    let folder = Folder::new("wrong");
    let out = folder.at("lights.json");
    let out_option = ["--out", out.to_str().unwrap()];
    let with = |options: &[&str]| refused(&ibl("lights", SKY, &[&out_option, options].concat()));
    let said = with(&["--method", "best"]);
    assert!(said.contains("known: independent, stratified, regions, centroids"), "{said}");
    assert!(with(&["--layout", "dome"]).contains("known: auto, equirect, angular, cube"));
    assert!(with(&["--count", "0"]).contains("4096"));
    assert!(with(&["--layout", "angular"]).contains("is no square"));
    assert!(with(&["--picture", "x.gif"]).contains("must end in .png"));
    let text = folder.at("sky.txt");
    fs::write(&text, "no picture").unwrap();
    let said = refused(&ibl("lights", &text, &out_option));
    assert!(said.contains("sky.txt") && said.contains("OpenEXR (.exr)"), "{said}");
    assert!(refused(&ibl("lights", folder.at("none.hdr"), &out_option)).contains("none.hdr"));
    assert!(refused(&ibl("compare", SKY, &["--counts", "5,5000"])).contains("1 to 4096"));
    assert!(fs::read_dir(folder.path()).unwrap().count() == 1, "only the text is there");
}

#[test]
fn a_black_map_and_values_that_are_no_radiance_are_warned_of() {
    let folder = Folder::new("black");
    let (map, out) = (folder.at("black.hdr"), folder.at("lights.json"));
    let mut bytes = b"#?RADIANCE\n\n-Y 1 +X 2\n".to_vec();
    bytes.extend([0; 8]);
    fs::write(&map, bytes).unwrap();
    let output = ibl("lights", &map, &["--count", "3", "--out", out.to_str().unwrap()]);
    succeeded(&output);
    assert!(String::from_utf8_lossy(&output.stderr).contains("the map is black"));
    assert!(lights(&out).iter().all(|(_, irradiance)| *irradiance == Vec3::ZERO));
    assert!(refused(&ibl("compare", &map, &[])).contains("nothing to compare"));
}
