//! Values of the GPU, against test vectors and against the CPU.

mod contract;
mod made;
mod twins;

use std::path::{Path, PathBuf};

use farlight_btf_codec::gpu::{Gpu, GpuEvaluator};
use farlight_btf_codec::{Angles, Btf, Query, Rules, read};
use glam::Vec3;

fn gpu() -> Option<Gpu> {
    match Gpu::new() {
        Ok(gpu) => {
            println!("on {}", gpu.adapter());
            Some(gpu)
        }
        Err(error) => {
            println!("SKIPPED: {error}");
            None
        }
    }
}

/// The folder of measured materials, or a word that the test was skipped.
fn materials() -> Option<PathBuf> {
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

fn compare(evaluator: &GpuEvaluator, vectors: &str, tags: &str) -> [f32; 2] {
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
    let values = evaluator.evaluate(&queries).unwrap();
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
    worst
}

/// Compares with the vectors in the file `name.kind`.
fn compare_file(gpu: &Gpu, folder: &Path, btf: &Btf, kind: &str) {
    let name = folder.file_name().unwrap().to_str().unwrap();
    let file = |end: &str| std::fs::read_to_string(folder.join(format!("{name}.{end}"))).unwrap();
    let evaluator = GpuEvaluator::new(gpu, btf, Rules::COMPATIBLE).unwrap();
    let [worst, loose] = compare(&evaluator, &file(kind), &file("tags.txt"));
    println!("{name}.{kind}: worst {worst:.4}, where f32 is loose {loose:.4}");
}

#[test]
fn text_tables_give_the_vectors() {
    let (Some(folder), Some(gpu)) = (materials(), gpu()) else { return };
    for name in ["alu", "wallpaper"] {
        let folder = folder.join(name);
        let btf = read::read_text(&folder, &read::Options::default()).unwrap();
        compare_file(&gpu, &folder, &btf, "csv");
    }
}

#[test]
fn binaries_give_the_vectors() {
    let (Some(folder), Some(gpu)) = (materials(), gpu()) else { return };
    for name in ["alu", "corduroy", "wallpaper"] {
        let folder = folder.join(name);
        let path = folder.join("binary.btf");
        let plain = read::Options { repairs: read::Repairs::No, ..Default::default() };
        let btf = read::read_binary(&path, &plain).unwrap();
        compare_file(&gpu, &folder, &btf, "binary.csv");
        let repaired = read::read_binary(&path, &read::Options::default()).unwrap();
        compare_file(&gpu, &folder, &repaired, "binary_repaired.csv");
    }
}
