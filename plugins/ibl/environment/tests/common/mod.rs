//! Maps and errors that several tests share.

use std::{fs, path::Path};

use farlight_environment::measure::{Error, Truth};
use farlight_environment::{Environment, Layout, LightExtractor, Method};

/// Normals of a measure.
pub(crate) const NORMALS: usize = 64;

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

/// Mean over seeds.
pub(crate) fn mean_error(map: &Environment, count: u32, method: Method, seeds: u64) -> Error {
    let (truth, extractor) = (Truth::new(map, NORMALS), LightExtractor::new(map, method));
    let mut sum = Error::default();
    for seed in 0..seeds {
        let error = truth.error(&extractor.lights(count, seed));
        sum.mean += error.mean / seeds as f64;
        sum.signed += error.signed / seeds as f64;
    }
    sum
}
