//! Manifests and textures, damaged and random: no panic, memory within bounds, and what is accepted
//! can be written and read again.
//!
//! A brief run of every target is part of the tests; `cargo xtask fuzz` runs longer.

#[path = "../../../../remote/wire/tests/fuzz/memory.rs"]
mod memory;
#[path = "../../../../remote/wire/tests/fuzz/mutate.rs"]
mod mutate;
#[path = "../common/sample.rs"]
mod sample;

use farlight_baked_format::{
    Manifest,
    exr::{self, Picture},
    ktx2::{self, Texture},
};
use glam::{UVec3, Vec3};
use mutate::fuzz;

#[test]
fn fuzz_baked_manifest() {
    let compact = ron::to_string(&sample::manifest(1)).unwrap();
    let corpus = vec![sample::manifest(3).to_text().into_bytes(), compact.into_bytes()];
    fuzz("baked_manifest", 5_000, corpus, |_, input| {
        let text = String::from_utf8_lossy(input);
        let (read, peak) = memory::peak(|| Manifest::parse(&text));
        assert!(peak <= (64 << 10) + 100 * text.len(), "{peak} bytes for {}", text.len());
        match read {
            Ok(manifest) => {
                let written = manifest.to_text();
                let again = Manifest::parse(&written).unwrap_or_else(|e| panic!("{e}\n{written}"));
                assert_eq!(again, manifest);
                true
            }
            Err(error) => {
                assert!(!error.to_string().is_empty());
                false
            }
        }
    });
}

#[test]
fn fuzz_baked_ktx2() {
    let texels: Vec<Vec3> = (0..35).map(|at| Vec3::new(at as f32, 0.5, 1e-3)).collect();
    let cubes = [[Vec3::ONE; 6]; 12];
    let corpus = vec![
        ktx2::lightmap_page(7, 5, &texels),
        ktx2::lightmap_page(64, 64, &texels),
        ktx2::volume(UVec3::new(3, 2, 2), &cubes),
    ];
    fuzz("baked_ktx2", 10_000, corpus, |_, input| {
        let (read, peak) = memory::peak(|| Texture::read(input).ok());
        // The decompressor keeps a window of up to 100 MiB, as the file says; a page of the largest size
        // takes 256 MiB packed and 768 MiB as vectors.
        assert!(peak <= 2 << 30, "{peak} bytes for {}", input.len());
        let Some(texture) = read else { return false };
        assert_eq!(Texture::read_size(input), Ok(texture.size));
        assert_eq!(texture.texels.len() as u32, texture.size.element_product());
        true
    });
}

#[test]
fn fuzz_baked_exr() {
    let texels: Vec<Vec3> = (0..35).map(|at| Vec3::new(at as f32, 0.5, 1e-3)).collect();
    let corpus = [(7, 5), (40, 33)]
        .map(|(width, height)| exr::write(width, height, &texels).unwrap())
        .to_vec();
    fuzz("baked_exr", 500, corpus, |_, input| {
        let (read, peak) = memory::peak(|| Picture::read(input));
        // A page of the largest size takes 768 MiB; a piece is there before and after decompression.
        assert!(peak <= 2 << 30, "{peak} bytes for {}", input.len());
        let Ok(picture) = read else { return false };
        assert_eq!(picture.texels.len() as u32, picture.width * picture.height);
        true
    });
}
