//! Pictures in linear light, without tone mapping: images of half floats that cameras draw into.

use std::sync::{Arc, Mutex};

use bevy::{
    camera::{Exposure, Hdr, RenderTarget},
    core_pipeline::tonemapping::{DebandDither, Tonemapping},
    prelude::*,
    render::{
        gpu_readback::{Readback, ReadbackComplete},
        render_resource::{TextureFormat, TextureUsages},
    },
};
use half::f16;

use super::headless::Headless;

/// Bytes of a pixel.
const PIXEL: usize = 8;

/// An image that cameras may draw into.
///
/// # Panics
/// If rows are not multiples of 256 bytes: `size.x` is a multiple of 32.
pub fn target(app: &mut App, size: UVec2) -> Handle<Image> {
    assert_eq!(size.x % 32, 0, "rows would be padded");
    let mut image = Image::new_target_texture(size.x, size.y, TextureFormat::Rgba16Float, None);
    image.texture_descriptor.usage |= TextureUsages::COPY_SRC;
    app.world_mut().resource_mut::<Assets<Image>>().add(image)
}

/// What makes a camera draw into it with exposure 1: a value of 1 is 1 cd/m².
pub fn camera(target: &Handle<Image>) -> impl Bundle {
    (
        Camera3d::default(),
        Hdr,
        Msaa::Off,
        Tonemapping::None,
        DebandDither::Disabled,
        exposure(),
        RenderTarget::from(target.clone()),
    )
}

/// Exposure 1, which is 1 / (1.2 * 2^ev100).
pub fn exposure() -> Exposure {
    Exposure { ev100: -(1.2_f32.log2()) }
}

/// What is in each image after some frames more, rows from the top.
///
/// # Panics
/// If the GPU does not answer.
pub fn read(headless: &mut Headless, targets: &[&Handle<Image>]) -> Vec<Vec<Vec3>> {
    let readers: Vec<_> = targets
        .iter()
        .map(|target| {
            let slot = Arc::new(Mutex::new(Vec::new()));
            let filled = slot.clone();
            let mut reader = headless.app.world_mut().spawn(Readback::texture((*target).clone()));
            reader.observe(move |event: On<ReadbackComplete>| {
                filled.lock().unwrap().clone_from(&event.data);
            });
            (reader.id(), slot)
        })
        .collect();
    // The first answers are of frames before.
    for _ in 0..8 {
        headless.update().unwrap_or_else(|problem| panic!("{problem}"));
    }
    let mut pictures = Vec::new();
    for (target, (reader, slot)) in targets.iter().zip(readers) {
        let world = headless.app.world_mut();
        world.entity_mut(reader).despawn();
        let size = world.resource::<Assets<Image>>().get(*target).unwrap().size();
        let bytes = slot.lock().unwrap();
        let expected = size.element_product() as usize * PIXEL;
        assert_eq!(bytes.len(), expected, "no answer of {}", headless.adapter());
        pictures.push(texels(&bytes));
    }
    pictures
}

/// The colours of an answer of the GPU.
pub fn texels(bytes: &[u8]) -> Vec<Vec3> {
    let half = |bytes: &[u8]| f16::from_le_bytes([bytes[0], bytes[1]]).to_f32();
    let texel = |p: &[u8]| Vec3::new(half(p), half(&p[2..]), half(&p[4..]));
    bytes.chunks_exact(PIXEL).map(texel).collect()
}

/// Saves linear light of square pictures for a person to look at, as `name` in the folder of
/// [`scratch`](super::scratch).
pub fn save(pixels: &[Vec3], size: u32, name: &str) {
    let path = super::scratch(name);
    std::fs::create_dir_all(path.parent().unwrap()).unwrap();
    let picture = image::RgbImage::from_fn(size, size, |x, y| {
        let pixel = pixels[(y * size + x) as usize];
        let color = Color::linear_rgb(pixel.x, pixel.y, pixel.z).to_srgba();
        image::Rgb(color.to_f32_array_no_alpha().map(|v| (v.clamp(0.0, 1.0) * 255.0).round() as u8))
    });
    picture.save(path).unwrap();
}
