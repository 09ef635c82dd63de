//! Measured materials with the values of an existing evaluator, where the data is there.

use std::path::{Path, PathBuf};

use farlight_btf_codec::{Angles, Btf, Query, read};
use glam::Vec3;

/// The folder of measured materials, or a word that the test was skipped.
pub(crate) fn materials() -> Option<PathBuf> {
    match std::env::var_os("FARLIGHT_TEST_DATA") {
        Some(data) => Some(PathBuf::from(data).join("btfbase")),
        None => {
            println!("SKIPPED: FARLIGHT_TEST_DATA is not set");
            None
        }
    }
}

/// Tags of rows whose angles f32 resolves badly (FORMAT.md, section 9).
const LOOSE: [&str; 3] = ["exact90", "beta_pole", "beta_guard"];

/// Compares an evaluator with the vectors of text tables.
pub(crate) fn compare_text(folder: &Path, evaluate: impl Fn(&Btf, &[Query]) -> Vec<Vec3>) {
    for name in ["alu", "wallpaper"] {
        let folder = folder.join(name);
        let btf = read::read_text(&folder, &read::Options::default()).unwrap();
        compare(&folder, "csv", |queries| evaluate(&btf, queries));
    }
}

/// The same of binaries, as they are stored and repaired.
pub(crate) fn compare_binaries(folder: &Path, evaluate: impl Fn(&Btf, &[Query]) -> Vec<Vec3>) {
    for name in ["alu", "corduroy", "wallpaper"] {
        let folder = folder.join(name);
        let path = folder.join("binary.btf");
        let plain = read::Options { repairs: read::Repairs::No, ..Default::default() };
        let plain = read::read_binary(&path, &plain).unwrap();
        compare(&folder, "binary.csv", |queries| evaluate(&plain, queries));
        let repaired = read::read_binary(&path, &read::Options::default()).unwrap();
        compare(&folder, "binary_repaired.csv", |queries| evaluate(&repaired, queries));
    }
}

/// Compares with the vectors in the file `name.kind`.
fn compare(folder: &Path, kind: &str, evaluate: impl FnOnce(&[Query]) -> Vec<Vec3>) {
    let name = folder.file_name().unwrap().to_str().unwrap();
    let file = |end: &str| std::fs::read_to_string(folder.join(format!("{name}.{end}"))).unwrap();
    let (vectors, tags) = (file(kind), file("tags.txt"));
    let rows: Vec<Vec<f64>> = vectors
        .lines()
        .skip(1)
        .map(|line| line.split(',').map(|field| field.parse().unwrap()).collect())
        .collect();
    let queries: Vec<Query> = rows
        .iter()
        .map(|n| Query {
            x: n[0] as i32,
            y: n[1] as i32,
            angles: Angles::from_degrees(n[2], n[3], n[4], n[5]),
        })
        .collect();
    let values = evaluate(&queries);
    assert_eq!(values.len(), rows.len());
    let mut worst = [0.0_f32; 2];
    for ((n, tag), value) in rows.iter().zip(tags.lines()).zip(values) {
        let expected = Vec3::new(n[6] as f32, n[7] as f32, n[8] as f32);
        let error = (value - expected).abs().max_element();
        let loose = LOOSE.contains(&tag);
        worst[usize::from(loose)] = worst[usize::from(loose)].max(error);
        let limit = if loose { 0.5 } else { 0.02 };
        assert!(error <= limit, "{n:?} ({tag}): {value} instead of {expected}");
    }
    let [worst, loose] = worst;
    println!("{name}.{kind}: worst {worst:.4}, where f32 is loose {loose:.4}");
}
