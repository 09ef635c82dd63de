//! Pictures in linear light, without tone mapping.

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

/// An image of half floats that a camera draws into.
#[derive(Clone)]
pub struct LinearTarget {
    image: Handle<Image>,
    size: u32,
}

impl LinearTarget {
    /// A square of `size` pixels.
    ///
    /// # Panics
    /// If rows are not multiples of 256 bytes: `size` is a multiple of 32.
    pub fn new(app: &mut App, size: u32) -> Self {
        assert_eq!(size % 32, 0, "rows would be padded");
        let mut image = Image::new_target_texture(size, size, TextureFormat::Rgba16Float, None);
        image.texture_descriptor.usage |= TextureUsages::COPY_SRC;
        Self { image: app.world_mut().resource_mut::<Assets<Image>>().add(image), size }
    }

    /// What makes a camera draw into it with exposure 1: a value of 1 is 1 cd/m².
    pub fn camera(&self) -> impl Bundle {
        (
            Camera3d::default(),
            Hdr,
            Msaa::Off,
            Tonemapping::None,
            DebandDither::Disabled,
            // Exposure is 1 / (1.2 * 2^ev100).
            Exposure { ev100: -(1.2_f32.log2()) },
            RenderTarget::from(self.image.clone()),
        )
    }

    /// What is in each after some frames more, rows from the top.
    ///
    /// # Panics
    /// If the GPU does not answer.
    pub fn read(targets: &[&Self], headless: &mut Headless) -> Vec<Vec<Vec3>> {
        let readers: Vec<_> = targets
            .iter()
            .map(|target| {
                let slot = Arc::new(Mutex::new(Vec::new()));
                let filled = slot.clone();
                let readback = Readback::texture(target.image.clone());
                let mut reader = headless.app.world_mut().spawn(readback);
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
        let half = |bytes: &[u8]| f16::from_le_bytes([bytes[0], bytes[1]]).to_f32();
        let mut pictures = Vec::new();
        for (target, (reader, slot)) in targets.iter().zip(readers) {
            headless.app.world_mut().entity_mut(reader).despawn();
            let bytes = slot.lock().unwrap().clone();
            let pixels = (target.size * target.size) as usize;
            assert_eq!(bytes.len(), pixels * 8, "no answer of {}", headless.adapter());
            let pixel = |p: &[u8]| Vec3::new(half(p), half(&p[2..]), half(&p[4..]));
            pictures.push(bytes.chunks_exact(8).map(pixel).collect());
        }
        pictures
    }
}
