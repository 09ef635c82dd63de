//! Measured materials in rendered pictures.

#[path = "../support/mod.rs"]
mod support;

mod afar;
mod data;
mod lambert;
mod orientation;
mod scenes;

use std::{
    sync::{Arc, Mutex},
    time::Duration,
};

use bevy::{
    camera::{Exposure, Hdr, RenderTarget},
    core_pipeline::tonemapping::Tonemapping,
    prelude::*,
    render::{
        gpu_readback::{Readback, ReadbackComplete},
        render_resource::{TextureFormat, TextureUsages},
    },
};
use farlight::{
    btf::{BtfStatus, codec::Btf, codec::synthetic},
    prelude::*,
};
use half::f16;
use support::headless::{Headless, Picture};

/// Edge of a picture in pixels; rows of half floats are then 256 bytes and more, without padding.
const SIZE: u32 = 64;

/// A renderer; cameras see with exposure 1 and no tone mapping.
struct Stage {
    headless: Headless,
    floats: Handle<Image>,
}

impl Stage {
    fn new() -> Self {
        Self::sized(SIZE)
    }

    /// `size` is the edge of the pictures.
    fn sized(size: u32) -> Self {
        let headless = Headless::new(UVec2::splat(size), &support::assets(), |app| {
            app.add_plugins(FarlightPlugins)
                .insert_resource(GlobalAmbientLight::NONE)
                .insert_resource(ClearColor(Color::BLACK))
                .insert_resource(bevy::light::DirectionalLightShadowMap { size: 512 })
                .insert_resource(bevy::light::PointLightShadowMap { size: 512 });
        });
        Self::of(headless.unwrap_or_else(|problem| panic!("{problem}")))
    }

    fn of(mut headless: Headless) -> Self {
        headless.set_frame_time(Duration::from_millis(16));
        let mut image = Image::new_target_texture(SIZE, SIZE, TextureFormat::Rgba16Float, None);
        image.texture_descriptor.usage |= TextureUsages::COPY_SRC;
        let floats = headless.app.world_mut().resource_mut::<Assets<Image>>().add(image);
        Self { headless, floats }
    }

    fn world(&mut self) -> &mut World {
        self.headless.app.world_mut()
    }

    fn spawn(&mut self, bundle: impl Bundle) -> Entity {
        self.world().spawn(bundle).id()
    }

    /// A camera at `from` that looks at `to`, a square of `height` metres or, at 0, in perspective.
    fn camera(&mut self, from: Vec3, to: Vec3, height: f32) -> Entity {
        let projection = if height > 0.0 {
            Projection::from(OrthographicProjection {
                scaling_mode: bevy::camera::ScalingMode::Fixed { width: height, height },
                ..OrthographicProjection::default_3d()
            })
        } else {
            Projection::default()
        };
        let up = if (to - from).normalize().y.abs() > 0.99 { Vec3::NEG_Z } else { Vec3::Y };
        self.spawn((
            Camera3d::default(),
            projection,
            Msaa::Off,
            Tonemapping::None,
            // Exposure is 1 / (1.2 * 2^ev100).
            Exposure { ev100: -(1.2_f32.log2()) },
            Transform::from_translation(from).looking_at(to, up),
        ))
    }

    /// The camera draws into half floats.
    fn float_camera(&mut self, from: Vec3, to: Vec3, height: f32) -> Entity {
        let camera = self.camera(from, to, height);
        let target = RenderTarget::from(self.floats.clone());
        self.world().entity_mut(camera).insert((Hdr, target));
        camera
    }

    fn mesh(&mut self, mesh: impl Into<Mesh>) -> Handle<Mesh> {
        self.world().resource_mut::<Assets<Mesh>>().add(mesh)
    }

    fn btf(&mut self, btf: Btf) -> Handle<BtfAsset> {
        self.world().resource_mut::<Assets<BtfAsset>>().add(BtfAsset(Arc::new(btf)))
    }

    fn material(&mut self, material: BtfMaterial) -> MeshMaterial3d<BtfMaterial> {
        MeshMaterial3d(self.world().resource_mut::<Assets<BtfMaterial>>().add(material))
    }

    fn white(&mut self) -> MeshMaterial3d<BtfMaterial> {
        let btf = self.btf(white());
        self.material(BtfMaterial::new(btf))
    }

    /// What the white Lambertian material should look like.
    fn standard(&mut self) -> MeshMaterial3d<StandardMaterial> {
        let material = StandardMaterial {
            base_color: Color::WHITE,
            perceptual_roughness: 0.5,
            reflectance: 0.0,
            ..default()
        };
        MeshMaterial3d(self.world().resource_mut::<Assets<StandardMaterial>>().add(material))
    }

    /// Lets materials load and reach the GPU, then a few frames more.
    fn settle(&mut self) {
        let ready = |world: &mut World| {
            let status = world.resource::<BtfStatus>();
            status.waiting == 0 && status.resident > 0
        };
        // What was just added is not waited for before the status has heard of it.
        (0..4)
            .try_for_each(|_| self.headless.update())
            .and_then(|()| {
                self.headless.update_until("materials on the GPU", Duration::from_secs(60), ready)
            })
            .and_then(|()| (0..6).try_for_each(|_| self.headless.update()))
            .unwrap_or_else(|problem| panic!("{problem}"));
    }

    fn picture(&mut self) -> Picture {
        for _ in 0..4 {
            self.headless.update().unwrap_or_else(|problem| panic!("{problem}"));
        }
        self.headless.capture().unwrap_or_else(|problem| panic!("{problem}"))
    }

    /// What the float camera sees: linear light, rows from the top.
    fn floats(&mut self) -> Vec<Vec3> {
        let slot = Arc::new(Mutex::new(Vec::new()));
        let filled = slot.clone();
        let readback = Readback::texture(self.floats.clone());
        let reader = self
            .world()
            .spawn(readback)
            .observe(move |event: On<ReadbackComplete>| {
                *filled.lock().unwrap() = event.data.clone();
            })
            .id();
        // The first answers are of frames before.
        for _ in 0..8 {
            self.headless.update().unwrap_or_else(|problem| panic!("{problem}"));
        }
        self.world().entity_mut(reader).despawn();
        let bytes = slot.lock().unwrap().clone();
        assert_eq!(bytes.len(), (SIZE * SIZE * 8) as usize, "no answer of the GPU");
        let half = |bytes: &[u8]| f16::from_le_bytes([bytes[0], bytes[1]]).to_f32();
        bytes
            .chunks_exact(8)
            .map(|pixel| Vec3::new(half(pixel), half(&pixel[2..]), half(&pixel[4..])))
            .collect()
    }

    fn save(&self, picture: &Picture, name: &str) {
        picture.save(support::scratch(&format!("btf_material/{name}.png"))).unwrap();
    }
}

fn white() -> Btf {
    synthetic::lambert([1.0; 3], [4, 4]).unwrap()
}

fn at(pixels: &[Vec3], x: u32, y: u32) -> Vec3 {
    pixels[(y * SIZE + x) as usize]
}
