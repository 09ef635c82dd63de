//! Maps, normals and the measure of error that several tests share.

use std::{f32::consts::TAU, fmt, fs, path::Path};

use farlight_environment::{Environment, EnvironmentLight, Layout, LightExtractor, Method};
use glam::Vec3;

/// Normals of a measure.
const NORMALS: usize = 64;

/// The project's own maps, and measured ones where `FARLIGHT_TEST_DATA` has them.
pub(crate) fn maps() -> Vec<(String, Environment)> {
    let own = Path::new(env!("CARGO_MANIFEST_DIR")).join("../../../assets/environments");
    let mut folders = vec![own];
    match std::env::var_os("FARLIGHT_TEST_DATA") {
        Some(data) => folders.push(Path::new(&data).join("environments")),
        None => println!("SKIPPED: measured maps: FARLIGHT_TEST_DATA is not set"),
    }
    let mut paths: Vec<_> = folders
        .iter()
        .flat_map(|folder| fs::read_dir(folder).into_iter().flatten().flatten())
        .map(|entry| entry.path())
        .filter(|path| path.extension().is_some_and(|ending| ending == "hdr"))
        .collect();
    paths.sort();
    assert!(!paths.is_empty(), "there is no map at all");
    let name = |path: &Path| path.file_name().unwrap().to_string_lossy().into_owned();
    let map = |path: &Path| Environment::open(path, Layout::Auto).unwrap();
    paths.iter().map(|path| (name(path), map(path))).collect()
}

/// Unit vectors evenly over the sphere (a Fibonacci sphere).
pub(crate) fn normals() -> Vec<Vec3> {
    (0..NORMALS)
        .map(|at| {
            let y = 1.0 - (2.0 * at as f32 + 1.0) / NORMALS as f32;
            let azimuth = TAU * (at as f32 * 0.618_034).fract();
            let radius = (1.0 - y * y).sqrt();
            Vec3::new(radius * azimuth.cos(), y, radius * azimuth.sin())
        })
        .collect()
}

/// Irradiance of the normals.
pub(crate) fn irradiances(lights: &[EnvironmentLight]) -> Vec<Vec3> {
    let lit = |normal: Vec3| {
        let lit = lights.iter().map(|l| l.irradiance * l.direction.dot(normal).max(0.0));
        lit.sum()
    };
    normals().into_iter().map(lit).collect()
}

/// Irradiance of the normals under the whole map.
pub(crate) fn exact(map: &Environment) -> Vec<Vec3> {
    normals().into_iter().map(|normal| map.irradiance(normal)).collect()
}

/// Relative errors of irradiance, summed over the channels.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Error {
    /// Mean over the normals of the absolute relative error.
    pub(crate) mean: f64,
    /// Mean with its sign.
    pub(crate) bias: f64,
}

impl Error {
    pub(crate) fn of(found: &[Vec3], exact: &[Vec3]) -> Self {
        let errors = found.iter().zip(exact).map(|(found, exact)| {
            let [found, exact] = [found, exact].map(|sum| f64::from(sum.element_sum()));
            (found - exact) / exact
        });
        let count = exact.len() as f64;
        Self {
            mean: errors.clone().map(f64::abs).sum::<f64>() / count,
            bias: errors.sum::<f64>() / count,
        }
    }
}

impl fmt::Display for Error {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(f, "{:6.3} % (signed {:+.3} %)", 100.0 * self.mean, 100.0 * self.bias)
    }
}

/// Mean over seeds.
pub(crate) fn mean_error(map: &Environment, count: u32, method: Method, seeds: u64) -> Error {
    let exact = exact(map);
    let extractor = LightExtractor::new(map, method);
    let mut sum = Error { mean: 0.0, bias: 0.0 };
    for seed in 0..seeds {
        let lights = extractor.lights(count, seed);
        let error = Error::of(&irradiances(&lights), &exact);
        sum.mean += error.mean / seeds as f64;
        sum.bias += error.bias / seeds as f64;
    }
    sum
}
