//! Files of every format, as they are and damaged.

#[path = "../common/files.rs"]
mod files;

use exr::prelude::{Blocks, Compression, Encoding, LineOrder, Vec2};
use farlight_environment::{Environment, EnvironmentError, Layout};
use glam::Vec3;
use image::ImageFormat;
use ktx2::Format;

const SIZE: [usize; 2] = [32, 16];

/// Texels that every format but those for screens holds exactly: few bits, exponents near 0.
fn texels() -> Vec<Vec3> {
    let value = |at: usize| [0.25, 0.5, 0.75, 1.0, 1.5, 3.0][at % 6];
    (0..SIZE[0] * SIZE[1]).map(|at| Vec3::new(value(at), value(at / 7), value(at / 50))).collect()
}

fn read(bytes: &[u8]) -> Environment {
    Environment::read(bytes, Layout::Auto).unwrap()
}

fn assert_same(map: &Environment, texels: &[Vec3], what: &str) {
    assert_eq!([map.width() as usize, map.height() as usize], SIZE, "{what}");
    for (found, expected) in map.texels().iter().zip(texels) {
        assert!((found - expected).abs().max_element() < 1e-6, "{what}: {found} {expected}");
    }
}

#[test]
fn radiance_pictures() {
    let texels = texels();
    assert_same(&read(&files::radiance(SIZE, &texels, true)), &texels, "run lengths by channel");
    let plain = files::radiance(SIZE, &texels, false);
    assert_same(&read(&plain), &texels, "plain");
    // From the bottom, and from the right: two turns of the picture's order.
    let turned = b"#?RADIANCE\n# plain\n\n+Y 16 -X 32\n";
    let bytes = [turned, &plain[turned.len()..]].concat();
    let reversed: Vec<Vec3> = texels.iter().rev().copied().collect();
    assert_same(&read(&bytes), &reversed, "turned");
    // Runs of whole pixels: 3 after the first, then 7 + 1 * 256 in two counts.
    let mut bytes = b"#?RADIANCE\nFORMAT=32-bit_rle_rgbe\n\n-Y 2 +X 268\n".to_vec();
    for _ in 0..2 {
        bytes.extend(files::rgbe(Vec3::ONE));
        bytes.extend([1, 1, 1, 3]);
        bytes.extend(files::rgbe(Vec3::splat(0.5)));
        bytes.extend([1, 1, 1, 7, 1, 1, 1, 1]);
    }
    let map = Environment::read(&bytes, Layout::Equirect).unwrap();
    assert_eq!(map.texels()[267 + 4], Vec3::ONE);
    assert!((map.texels()[266] - 0.5).abs().max_element() < 1e-6);
}

#[test]
fn openexr_pictures() {
    let texels = texels();
    let tiles = Blocks::Tiles(Vec2(7, 5));
    for half in [true, false] {
        for compression in [
            Compression::Uncompressed,
            Compression::RLE,
            Compression::ZIP1,
            Compression::ZIP16,
            Compression::PIZ,
        ] {
            for blocks in [Blocks::ScanLines, tiles] {
                let encoding = Encoding { compression, blocks, line_order: LineOrder::Increasing };
                let bytes = files::openexr(SIZE, &texels, half, encoding);
                assert_same(&read(&bytes), &texels, &format!("{half} {encoding:?}"));
            }
        }
    }
}

#[test]
fn ktx_textures() {
    let texels = texels();
    let halves: Vec<u8> = texels
        .iter()
        .flat_map(|t| t.extend(1.0).to_array().map(half::f16::from_f32))
        .flat_map(half::f16::to_le_bytes)
        .collect();
    let floats: Vec<u8> =
        texels.iter().flat_map(|t| t.extend(1.0).to_array()).flat_map(f32::to_le_bytes).collect();
    let size = SIZE.map(|side| side as u32);
    for zstd in [false, true] {
        for (format, data) in
            [(Format::R16G16B16A16_SFLOAT, &halves), (Format::R32G32B32A32_SFLOAT, &floats)]
        {
            let bytes = files::ktx(size, 1, Some(format), data, zstd);
            assert_same(&read(&bytes), &texels, &format!("{format:?} {zstd}"));
        }
    }
    let colours: Vec<u8> = texels.iter().flat_map(|t| [(t.x * 80.0) as u8, 0, 255, 255]).collect();
    let map = read(&files::ktx(size, 1, Some(Format::R8G8B8A8_UNORM), &colours, false));
    assert!((map.texels()[0] - Vec3::new(20.0 / 255.0, 0.0, 1.0)).length() < 1e-6);
    let map = read(&files::ktx(size, 1, Some(Format::R8G8B8A8_SRGB), &colours, false));
    // 20 of 255 in sRGB.
    assert!((map.texels()[0].x - 0.006_995).abs() < 1e-5, "{}", map.texels()[0]);
}

/// A cube with a face of another colour in each direction, from every kind of file.
#[test]
fn cubes() {
    let colours =
        [Vec3::X, Vec3::Y, Vec3::Z, Vec3::ONE, Vec3::new(1.0, 1.0, 0.0), Vec3::splat(0.5)];
    // Ahead, +Z of a cube, is -z.
    let directions = [Vec3::X, -Vec3::X, Vec3::Y, -Vec3::Y, -Vec3::Z, Vec3::Z];
    let check = |map: &Environment, what: &str| {
        for (direction, colour) in directions.into_iter().zip(colours) {
            for aside in [Vec3::ZERO, Vec3::splat(0.3), Vec3::new(0.6, -0.6, 0.6)] {
                let found = map.radiance(direction + aside - aside.dot(direction) * direction);
                // Energy is kept for blocks of samples, which catch a block to within 1 %.
                assert!((found - colour).length() < 0.03, "{what}: {direction} {found}");
            }
        }
        // A sixth of the sphere each.
        let sums = colours.iter().zip(directions).map(|(colour, d)| *colour * d.y.max(0.0));
        assert!(map.irradiance(Vec3::Y).cmpge(sums.sum()).all(), "{what}");
    };
    let edge = 24;
    let faces = colours.map(|colour| vec![colour; edge * edge]);
    let cube = Environment::from_cube(edge as u32, faces.each_ref().map(|f| &f[..])).unwrap();
    check(&cube, "from_cube");

    let data: Vec<u8> = faces
        .iter()
        .flatten()
        .flat_map(|t| t.extend(1.0).to_array().map(half::f16::from_f32))
        .flat_map(half::f16::to_le_bytes)
        .collect();
    let size = [edge as u32; 2];
    let bytes = files::ktx(size, 6, Some(Format::R16G16B16A16_SFLOAT), &data, true);
    check(&read(&bytes), "KTX2");

    // A cross lying: the faces' places in squares; and a strip.
    let cross = [[2, 1], [0, 1], [1, 0], [1, 2], [1, 1], [3, 1]];
    let strip = [[0, 0], [1, 0], [2, 0], [3, 0], [4, 0], [5, 0]];
    for (squares, places) in [([4, 3], cross), ([6, 1], strip)] {
        let mut texels = vec![Vec3::ZERO; squares[0] * squares[1] * edge * edge];
        for ([column, row], colour) in places.into_iter().zip(colours) {
            for at in 0..edge * edge {
                let (x, y) = (column * edge + at % edge, row * edge + at / edge);
                texels[y * squares[0] * edge + x] = colour;
            }
        }
        let size = squares.map(|count| count * edge);
        check(&read(&files::radiance(size, &texels, true)), "a picture of six squares");
    }
}

#[test]
fn angular_maps() {
    // Ahead red, to the right green: the middle, and halfway out to the right.
    let edge = 64;
    let texels: Vec<Vec3> = (0..edge * edge)
        .map(|at| {
            let [x, y] =
                [at % edge, at / edge].map(|at| (2.0 * at as f32 + 1.0) / edge as f32 - 1.0);
            let near = |to: f32| (x - to).hypot(y) < 0.1;
            Vec3::new(f32::from(near(0.0)), f32::from(near(0.5)), 0.25)
        })
        .collect();
    for map in [
        Environment::from_angular(edge as u32, &texels).unwrap(),
        read(&files::radiance([edge; 2], &texels, true)),
    ] {
        let at = |direction| map.radiance(direction);
        assert!((at(-Vec3::Z) - Vec3::new(1.0, 0.0, 0.25)).length() < 0.02, "{}", at(-Vec3::Z));
        assert!((at(Vec3::X) - Vec3::new(0.0, 1.0, 0.25)).length() < 0.02, "{}", at(Vec3::X));
        assert!((at(-Vec3::X) - Vec3::new(0.0, 0.0, 0.25)).length() < 0.02, "{}", at(-Vec3::X));
        let blue = map.irradiance(Vec3::Y).z;
        // The circle is cut into quarters of texels.
        assert!((blue / (0.25 * std::f32::consts::PI) - 1.0).abs() < 3e-3, "{blue}");
    }
}

#[test]
fn pictures_for_screens() {
    let pixels = vec![[255, 128, 0]; 32 * 16];
    // 128 of 255 in sRGB.
    let expected = Vec3::new(1.0, 0.215_86, 0.0);
    for (format, tolerance) in [(ImageFormat::Png, 1e-4), (ImageFormat::Jpeg, 0.03)] {
        let map = read(&files::screen([32, 16], &pixels, format));
        let found = map.texels()[77];
        assert!((found - expected).length() < tolerance, "{format:?}: {found}");
    }
}

#[test]
fn what_cannot_be_read_is_said() {
    let error = |bytes: &[u8]| Environment::read(bytes, Layout::Auto).unwrap_err().to_string();
    assert!(error(b"GIF89a").contains("Radiance (.hdr), OpenEXR"));
    let blocks = files::ktx([8, 8], 6, Some(Format::BC6H_UFLOAT_BLOCK), &[0; 384], false);
    let said = error(&blocks);
    assert!(said.contains("BC6H_UFLOAT_BLOCK; convert it to R16G16B16A16_SFLOAT"), "{said}");
    assert!(error(&files::ktx([8, 8], 6, None, &[0; 384], false)).contains("Basis Universal"));
    let faces = files::ktx([8, 4], 6, Some(Format::R8G8B8A8_UNORM), &[0; 768], false);
    assert!(error(&faces).contains("8 x 4 texels are no squares"));
    let xyz = b"#?RADIANCE\nFORMAT=32-bit_rle_xyze\n\n-Y 1 +X 2\n12345678";
    assert!(error(xyz).contains("convert it to RGBE"));
    let sky = files::radiance([30, 17], &vec![Vec3::ONE; 510], true);
    assert!(error(&sky).contains("30 x 17 texels doesn't say how it is laid out"));
}

#[test]
fn files_that_end_early_or_lie_are_errors() {
    let texels = texels();
    let encoding = Encoding {
        compression: Compression::ZIP16,
        blocks: Blocks::ScanLines,
        line_order: LineOrder::Increasing,
    };
    let pixels = vec![[9, 8, 7]; 512];
    let data = vec![0; 512 * 8];
    let size = SIZE.map(|side| side as u32);
    let all = [
        files::radiance(SIZE, &texels, true),
        files::radiance(SIZE, &texels, false),
        files::openexr(SIZE, &texels, true, encoding),
        files::ktx(size, 1, Some(Format::R16G16B16A16_SFLOAT), &data, true),
        files::screen(size, &pixels, ImageFormat::Png),
    ];
    for bytes in all {
        assert!(Environment::read(&bytes, Layout::Auto).is_ok());
        for end in [bytes.len() / 3, bytes.len() - 30] {
            let map = Environment::read(&bytes[..end], Layout::Auto);
            assert!(map.is_err(), "{:?} with {end} of {} bytes", &bytes[..4], bytes.len());
        }
    }
    let huge = b"#?RADIANCE\n\n-Y 60000 +X 65000\n";
    let error = Environment::read(huge, Layout::Equirect).unwrap_err();
    assert!(matches!(error, EnvironmentError::Size(_)), "{error}");
    let lying = b"#?RADIANCE\n\n-Y 8192 +X 16384\n".to_vec();
    let error = Environment::read(&lying, Layout::Auto).unwrap_err().to_string();
    assert!(error.contains("ends in row 0 of 8192"), "{error}");
}

#[test]
fn a_file_is_named_in_its_error() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("sky.hdr");
    let missing = Environment::open(&path, Layout::Auto).unwrap_err().to_string();
    assert!(missing.contains("cannot read") && missing.contains("sky.hdr"), "{missing}");
    std::fs::write(&path, b"nothing").unwrap();
    let error = Environment::open(&path, Layout::Auto).unwrap_err().to_string();
    assert!(error.contains("sky.hdr: of no known format"), "{error}");
    std::fs::write(&path, files::radiance(SIZE, &texels(), true)).unwrap();
    assert!(Environment::open(&path, Layout::Auto).is_ok());
}
