//! Thousands of damaged variants of a small valid file: an error or a file that can be read, never a
//! panic.

use farlight_baker::{
    gltf::{Source, write},
    uv::{NoCache, UvOptions, second_sets},
};
use farlight_gi_solver::import::{ImportLimits, ImportOptions, load_scene_from_slice};

use crate::{
    damage::{Random, count, replace, replacement},
    glb::{rich, write as glb},
};

/// Whether the variant was written.
fn survive(bytes: &[u8], what: &str) -> bool {
    let limits = ImportLimits {
        file_bytes: 1 << 20,
        json_values: 20_000,
        triangles: 10_000,
        vertices: 100_000,
        texture_texels: 1 << 18,
        depth: 100,
    };
    let Ok(source) = Source::from_slice(bytes, &limits) else { return false };
    let import = ImportOptions { limits: limits.clone(), ..Default::default() };
    let Ok(imported) = source.scene(&import) else { return false };
    let options = UvOptions { max_texels: 64, ..Default::default() };
    let sets = second_sets(&imported, &source, &options, &NoCache, &|_, _| true).unwrap();
    let Ok(written) = write(&source, &sets, 0.5) else { return false };
    assert!(written.len() < 2 << 20, "{what}: {} bytes", written.len());
    let limits = ImportLimits { file_bytes: 2 << 20, json_values: 40_000, ..limits };
    let options = ImportOptions { limits, ..Default::default() };
    let read = load_scene_from_slice(&written, &options);
    let read = read.unwrap_or_else(|error| panic!("{what}: {error}"));
    assert!(read.scene.instances.len() <= imported.scene.instances.len(), "{what}");
    true
}

#[test]
fn random_bytes_are_survived() {
    let file = rich().bytes();
    let json = u32::from_le_bytes(file[12..16].try_into().unwrap()) as usize;
    let mut random = Random(1);
    let mut written = 0;
    for i in 0..3000 {
        let mut bytes = file.clone();
        for _ in 0..=random.below(4) {
            let from = if random.below(2) == 0 { 20 + json } else { 0 };
            let at = from + random.below(bytes.len() - from);
            match random.below(3) {
                0 => bytes[at] = random.next() as u8,
                1 => bytes[at] ^= 1 << random.below(8),
                _ => {
                    let length = random.below(40).min(bytes.len() - at);
                    let from = random.below(bytes.len() - length);
                    bytes.copy_within(from..from + length, at);
                }
            }
        }
        written += u32::from(survive(&bytes, &format!("variant {i}")));
    }
    println!("{written} of 3000 variants were written");
    assert!(written > 200, "damage must not always be so bad that nothing is tested: {written}");
}

#[test]
fn random_json_values_are_survived() {
    let base = rich();
    let mut random = Random(2);
    let mut written = 0;
    for i in 0..6000 {
        let mut json = base.json.clone();
        for _ in 0..=random.below(2) {
            let count = count(&json);
            let mut target = random.below(count);
            let value = replacement(&mut random);
            replace(&mut json, &mut target, &value);
        }
        let bytes = glb(json.to_string().as_bytes(), &base.bin);
        written += u32::from(survive(&bytes, &format!("variant {i}: {json}")));
    }
    println!("{written} of 6000 variants were written");
    assert!(written > 500, "damage must not always be so bad that nothing is tested: {written}");
}
