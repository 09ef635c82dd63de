//! Measured materials in rendered pictures.

#[path = "../support/mod.rs"]
mod support;

mod afar;
mod data;
mod lambert;
mod orientation;
mod scenes;

use std::{sync::Arc, time::Duration};

use bevy::{
    camera::{Hdr, RenderTarget},
    core_pipeline::tonemapping::Tonemapping,
    prelude::*,
};
use farlight::{
    btf::{BtfStatus, codec::Btf, codec::synthetic},
    prelude::*,
};
use support::{
    headless::{Headless, Picture},
    linear,
};

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
        let floats = linear::target(&mut headless.app, UVec2::splat(SIZE));
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
            linear::exposure(),
            Transform::from_translation(from).looking_at(to, up),
        ))
    }

    /// A square of two metres seen from in front, in linear light, under a light from there that
    /// shows a white surface as 1.
    fn light_in_front(&mut self) {
        self.float_camera(Vec3::new(0.0, 0.0, 3.0), Vec3::ZERO, 2.0);
        self.spawn((
            DirectionalLight { illuminance: std::f32::consts::PI, ..default() },
            Transform::from_xyz(0.0, 0.0, 1.0).looking_at(Vec3::ZERO, Vec3::Y),
        ));
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
        linear::read(&mut self.headless, &[&self.floats]).remove(0)
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
