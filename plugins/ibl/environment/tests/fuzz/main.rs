//! Every reader against damaged, random and lying input: no panic, memory within bounds, and what is
//! accepted becomes lights.
//!
//! A brief run of every target is part of the tests; `cargo xtask fuzz` runs longer.

#[path = "../common/files.rs"]
mod files;
#[path = "../../../../remote/wire/tests/fuzz/memory.rs"]
mod memory;
#[path = "../../../../remote/wire/tests/fuzz/mutate.rs"]
mod mutate;

use exr::prelude::{Blocks, Compression, Encoding, LineOrder, Vec2};
use farlight_environment::{Environment, Layout, LightRequest, Method};
use glam::Vec3;
use image::ImageFormat;
use ktx2::Format;
use mutate::{Random, fuzz};

/// What the largest map takes while it is made.
const MAP: usize = 200 << 20;

const SIZE: [usize; 2] = [16, 8];

fn texels() -> Vec<Vec3> {
    (0..SIZE[0] * SIZE[1]).map(|at| Vec3::new(at as f32, 0.5, (at % 9) as f32 * 0.1)).collect()
}

/// Reads within bounds; makes lights of what was read.
fn survives(random: &mut Random, input: &[u8], most: usize) -> bool {
    let layouts = [Layout::Auto, Layout::Auto, Layout::Equirect, Layout::Angular, Layout::Cube];
    let layout = layouts[random.below(layouts.len())];
    let (map, peak) = memory::peak(|| Environment::read(input, layout).ok());
    assert!(peak <= most, "{peak} bytes for {}", input.len());
    let Some(map) = map else { return false };
    for texel in map.texels() {
        assert!(texel.is_finite() && texel.min_element() >= 0.0, "{texel}");
    }
    // Tables of large maps take a moment.
    if map.width() * map.height() <= 1 << 14 {
        let method = Method::ALL[random.below(4)];
        let count = 1 + random.below(40) as u32;
        let lights = map.lights(&LightRequest { count, method, seed: random.next() });
        assert_eq!(lights.len(), count as usize);
        for light in lights {
            assert!(light.direction.is_normalized(), "{method} {}", light.direction);
            let irradiance = light.irradiance;
            assert!(irradiance.is_finite() && irradiance.min_element() >= 0.0, "{irradiance}");
        }
    }
    true
}

#[test]
fn fuzz_environment_radiance() {
    let corpus = [true, false].map(|packed| files::radiance(SIZE, &texels(), packed)).to_vec();
    fuzz("environment_radiance", 20_000, corpus, |random, input| survives(random, input, MAP));
}

#[test]
fn fuzz_environment_openexr() {
    let tiles = Blocks::Tiles(Vec2(5, 3));
    let corpus = [
        (Compression::Uncompressed, Blocks::ScanLines),
        (Compression::ZIP16, Blocks::ScanLines),
        (Compression::RLE, tiles),
        (Compression::PIZ, Blocks::ScanLines),
        (Compression::PXR24, Blocks::ScanLines),
        (Compression::B44, tiles),
    ]
    .map(|(compression, blocks)| {
        let encoding = Encoding { compression, blocks, line_order: LineOrder::Increasing };
        files::openexr(SIZE, &texels(), true, encoding)
    });
    // A piece may be large, and is there before and after decompression.
    fuzz("environment_openexr", 10_000, corpus.to_vec(), |random, input| {
        survives(random, input, MAP + (1 << 30))
    });
}

#[test]
fn fuzz_environment_ktx2() {
    let data: Vec<u8> = (0..8 * 8 * 8 * 6).map(|at| at as u8 & 0x3f).collect();
    let corpus = vec![
        files::ktx([8, 8], 6, Some(Format::R16G16B16A16_SFLOAT), &data, true),
        files::ktx([8, 8], 6, Some(Format::E5B9G9R9_UFLOAT_PACK32), &data[..1536], false),
        files::ktx([16, 8], 1, Some(Format::R32G32B32A32_SFLOAT), &data[..2048], true),
        files::ktx([16, 8], 1, Some(Format::B10G11R11_UFLOAT_PACK32), &data[..512], false),
    ];
    // The decompressor keeps a window of up to 100 MiB, as the file says.
    fuzz("environment_ktx2", 10_000, corpus, |random, input| {
        survives(random, input, MAP + (300 << 20))
    });
}

#[test]
fn fuzz_environment_screen() {
    let pixels: Vec<[u8; 3]> = (0..128).map(|at| [at, 255 - at, at / 3]).collect();
    let corpus = [ImageFormat::Png, ImageFormat::Jpeg]
        .map(|format| files::screen([16, 8], &pixels, format))
        .to_vec();
    fuzz("environment_screen", 10_000, corpus, |random, input| survives(random, input, MAP));
}
