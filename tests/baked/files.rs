//! What Bevy's loader makes of the files of `farlight_baked_format`.

use bevy::{
    asset::RenderAssetUsages,
    image::{CompressedImageFormats, ImageSampler, ImageType},
    prelude::*,
    render::render_resource::{TextureDimension, TextureFormat},
};
use farlight::{
    baked::format::{ktx2, rgb9e5},
    gi::EncodedGrid,
};

use farlight_gi_solver::{session::GridId, sh::ShRgb};

fn load(file: &[u8]) -> Image {
    Image::from_buffer(
        file,
        ImageType::Extension("ktx2"),
        CompressedImageFormats::NONE,
        false,
        ImageSampler::Default,
        RenderAssetUsages::default(),
    )
    .unwrap()
}

#[test]
fn a_page_is_a_texture_of_shared_exponents() {
    let texels: Vec<Vec3> =
        (0..64 * 64).map(|i| Vec3::new(i as f32, 0.5, 2e3 / (i + 1) as f32)).collect();
    let image = load(&ktx2::lightmap_page(64, 64, &texels));
    let descriptor = &image.texture_descriptor;
    assert_eq!(descriptor.format, TextureFormat::Rgb9e5Ufloat);
    assert_eq!((descriptor.dimension, descriptor.mip_level_count), (TextureDimension::D2, 1));
    assert_eq!((image.width(), image.height(), descriptor.size.depth_or_array_layers), (64, 64, 1));
    let words: Vec<u8> =
        texels.iter().flat_map(|&texel| rgb9e5::encode(texel).to_le_bytes()).collect();
    assert!(image.data.unwrap() == words);
}

/// The file and the live textures of global illumination have one layout.
#[test]
fn a_volume_is_the_texture_that_a_live_grid_writes() {
    let resolution = UVec3::new(3, 2, 4);
    let mut probes = vec![ShRgb::ZERO; 24];
    for (i, probe) in probes.iter_mut().enumerate() {
        let direction = Vec3::new(i as f32 - 9.0, 0.5 * i as f32, 3.0).normalize();
        probe.add_direction(direction, Vec3::new(1.0, 0.25 * i as f32, 1e4));
    }
    let cubes: Vec<_> = probes.iter().map(ShRgb::ambient_cube).collect();
    let image = load(&ktx2::volume(resolution, &cubes));
    let descriptor = &image.texture_descriptor;
    assert_eq!(descriptor.format, TextureFormat::Rgba16Float);
    assert_eq!((descriptor.dimension, descriptor.mip_level_count), (TextureDimension::D3, 1));
    assert_eq!((image.width(), image.height(), descriptor.size.depth_or_array_layers), (3, 4, 12));
    let live = EncodedGrid::from_probes(GridId(0), resolution, &probes);
    assert!(image.data.unwrap() == live.texels);
}
