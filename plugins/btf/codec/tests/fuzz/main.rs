//! Every reader against damaged, random and lying input: no panic, memory within bounds, and what is
//! accepted can be evaluated everywhere.
//!
//! A brief run of every target is part of the tests; `cargo xtask fuzz` runs longer.

#[path = "../common/mod.rs"]
mod common;
#[path = "../../../../remote/wire/tests/fuzz/memory.rs"]
mod memory;
#[path = "../../../../remote/wire/tests/fuzz/mutate.rs"]
mod mutate;

use std::fs;
use std::io::{Cursor, Write};

use common::{base::Base, small};
use farlight_btf_codec::{Angles, Btf, Query, Rules, read};
use glam::Vec3;
use mutate::{Random, fuzz};

/// What a reader may hold for itself, whatever the input.
const FIXED: usize = 1 << 20;
/// Bytes in memory for a byte of input: integers may take a bit there and two words here.
const FACTOR: usize = 400;
/// A picture of the largest size, decoded and converted.
const PICTURES: usize = 1 << 30;

/// Reads within bounds; evaluates what was read.
fn survives(random: &mut Random, input: &[u8], read: impl FnOnce() -> Option<Btf>) -> bool {
    let (btf, peak) = memory::peak(read);
    assert!(peak <= FIXED + FACTOR * input.len(), "{peak} bytes for {}", input.len());
    let Some(btf) = btf else { return false };
    let queries: Vec<Query> = (0..32)
        .map(|_| {
            let mut angle = |most: usize| random.below(most + 1) as f64;
            let angles = Angles::from_degrees(angle(95), angle(720), angle(95), angle(720));
            Query { x: random.next() as i32, y: random.next() as i32, angles }
        })
        .collect();
    let mut values = vec![Vec3::ZERO; queries.len()];
    btf.evaluate_batch(&queries, Rules::COMPATIBLE, &mut values);
    for query in &queries {
        btf.evaluate(query.x, query.y, query.angles, Rules::SHADING);
    }
    _ = btf.table_sizes();
    true
}

#[test]
fn fuzz_material_own() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("small.fbtf");
    small().write(&path).unwrap();
    let corpus = vec![fs::read(path).unwrap()];
    fuzz("material_own", 20_000, corpus, |random, input| {
        let mut input = input.to_vec();
        // A liar knows how to make a checksum.
        if input.len() > 64 && !random.once_in(8) {
            let hash = blake3::Hasher::new().update(&input[..32]).update(&input[64..]).finalize();
            input[32..64].copy_from_slice(hash.as_bytes());
        }
        survives(random, &input, || Btf::from_bytes(&input).ok())
    });
}

#[test]
fn fuzz_material_binary() {
    let corpus = vec![Base::new().binary(), Base { factor: "0.5", ..Base::new() }.binary()];
    fuzz("material_binary", 20_000, corpus, |random, input| {
        survives(random, input, || Btf::from_bytes(input).ok())
    });
}

/// The first byte of an input says which file of the folder the others are.
#[test]
fn fuzz_material_text() {
    let folder = tempfile::tempdir().unwrap();
    let base = Base::new();
    base.write_texts(folder.path());
    let texts = base.texts();
    let corpus = (0..).zip(&texts).map(|(n, (_, text))| [&[n], text.as_bytes()].concat()).collect();
    let rest: usize = texts.iter().map(|(_, text)| text.len()).sum();
    fuzz("material_text", 4_000, corpus, |random, input| {
        let Some((file, text)) = input.split_first() else { return false };
        let (name, good) = &texts[usize::from(*file) % texts.len()];
        fs::write(folder.path().join(name), text).unwrap();
        let read = || read::read_text(folder.path(), &read::Options::default()).ok();
        let accepted = survives(random, &[input, &vec![0; rest]].concat(), read);
        fs::write(folder.path().join(name), good).unwrap();
        accepted
    });
}

fn picture(level: u8) -> Vec<u8> {
    let mut bytes = Cursor::new(Vec::new());
    let picture = image::RgbImage::from_pixel(3, 2, image::Rgb([level, 1, 2]));
    picture.write_to(&mut bytes, image::ImageFormat::Png).unwrap();
    bytes.into_inner()
}

/// Opens pictures and evaluates some values.
fn pictures_survive(path: &std::path::Path) -> bool {
    let work = || {
        let Ok(read::Material::Images(images)) = read::open(path, &read::Options::default()) else {
            return false;
        };
        for (theta, phi) in [(0.0, 0.0), (20.0, 100.0), (80.0, 300.0)] {
            _ = images.evaluate(1, 1, Angles::from_degrees(theta, phi, theta, -phi));
        }
        true
    };
    let (accepted, peak) = memory::peak(work);
    assert!(peak <= PICTURES, "{peak} bytes");
    accepted
}

#[test]
fn fuzz_material_archive() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("set.zip");
    let archive = |method| {
        let mut archive = zip::ZipWriter::new(Cursor::new(Vec::new()));
        for (level, light) in [(10, "tl000 pl000"), (90, "tl030 pl000"), (200, "tl030 pl180")] {
            let options = zip::write::SimpleFileOptions::default().compression_method(method);
            archive.start_file(format!("{light} tv000 pv000.png"), options).unwrap();
            archive.write_all(&picture(level)).unwrap();
        }
        archive.finish().unwrap().into_inner()
    };
    let corpus =
        vec![archive(zip::CompressionMethod::Stored), archive(zip::CompressionMethod::Deflated)];
    fuzz("material_archive", 4_000, corpus, |_, input| {
        fs::write(&path, input).unwrap();
        pictures_survive(&path)
    });
}

#[test]
fn fuzz_material_list() {
    let folder = tempfile::tempdir().unwrap();
    for level in [10, 90] {
        fs::write(folder.path().join(format!("{level}.png")), picture(level)).unwrap();
    }
    let list = "Directions(name: Some(\"a\"), size: Some((0.1, 0.2)), images: [
        (file: \"10.png\", light: (15, 0), view: (0, 0)),
        (file: \"90.png\", light: (15.5, 60), view: (0, 0)),
        (file: \"90.png\", light: (15, 300), view: (40, 90)),
    ])";
    let corpus = vec![list.as_bytes().to_vec()];
    fuzz("material_list", 4_000, corpus, |_, input| {
        fs::write(folder.path().join("directions.ron"), input).unwrap();
        pictures_survive(folder.path())
    });
}
