//! A renderer with a scene under an environment.

use std::{sync::Arc, time::Duration};

use bevy::{
    light::{DirectionalLightShadowMap, PointLightShadowMap},
    prelude::*,
};
use farlight::{
    ibl::{EnvironmentState, environment_maps::Environment},
    prelude::*,
};

use crate::support::{self, headless::Headless, linear};

/// Edge of a picture in pixels; rows of half floats are then 256 bytes and more, without padding.
pub(crate) const SIZE: u32 = 64;

/// Cameras see with exposure 1 and no tone mapping.
pub(crate) struct Stage {
    pub(crate) headless: Headless,
    pub(crate) floats: Handle<Image>,
}

impl Stage {
    pub(crate) fn new() -> Self {
        let headless = Headless::new(UVec2::splat(SIZE), &support::assets(), |app| {
            app.add_plugins(FarlightPlugins)
                // Lights of this code, not of an earlier one.
                .insert_resource(farlight::ibl::EnvironmentCache(None))
                .insert_resource(GlobalAmbientLight::NONE)
                .insert_resource(ClearColor(Color::BLACK))
                .insert_resource(DirectionalLightShadowMap { size: 512 })
                .insert_resource(PointLightShadowMap { size: 128 });
        });
        let mut headless = headless.unwrap_or_else(|problem| panic!("{problem}"));
        headless.set_frame_time(Duration::from_millis(16));
        let mut stage = Self { headless, floats: Handle::default() };
        stage.floats = stage.target(UVec2::splat(SIZE));
        stage
    }

    pub(crate) fn world(&mut self) -> &mut World {
        self.headless.app.world_mut()
    }

    pub(crate) fn spawn(&mut self, bundle: impl Bundle) -> Entity {
        self.world().spawn(bundle).id()
    }

    /// An image that cameras may draw into.
    pub(crate) fn target(&mut self, size: UVec2) -> Handle<Image> {
        linear::target(&mut self.headless.app, size)
    }

    /// A refining camera at `from` that looks at `to`.
    pub(crate) fn camera(&mut self, from: Vec3, to: Vec3) -> Entity {
        let target = self.floats.clone();
        let camera = self.plain_camera(&target, from, to);
        self.world().entity_mut(camera).insert(ProgressiveCamera::default());
        camera
    }

    /// A camera that doesn't refine.
    pub(crate) fn plain_camera(&mut self, target: &Handle<Image>, from: Vec3, to: Vec3) -> Entity {
        let place = Transform::from_translation(from).looking_at(to, Vec3::Y);
        self.spawn((linear::camera(target), place))
    }

    pub(crate) fn mesh(&mut self, mesh: impl Into<Mesh>) -> Mesh3d {
        Mesh3d(self.world().resource_mut::<Assets<Mesh>>().add(mesh))
    }

    /// A surface without mirrored light.
    pub(crate) fn matte(&mut self, color: Color) -> MeshMaterial3d<StandardMaterial> {
        self.material(StandardMaterial {
            base_color: color,
            perceptual_roughness: 1.0,
            reflectance: 0.0,
            ..default()
        })
    }

    pub(crate) fn material(
        &mut self,
        material: StandardMaterial,
    ) -> MeshMaterial3d<StandardMaterial> {
        MeshMaterial3d(self.world().resource_mut::<Assets<StandardMaterial>>().add(material))
    }

    /// The settings of the light; the map is already there.
    pub(crate) fn light(&mut self, map: Environment, settings: ProgressiveLighting) {
        let map = EnvironmentMap(Arc::new(map));
        let environment = self.world().resource_mut::<Assets<EnvironmentMap>>().add(map);
        self.world()
            .insert_resource(ProgressiveLighting { environment: Some(environment), ..settings });
    }

    /// A ball on a floor.
    pub(crate) fn ball(&mut self) {
        let floor = (self.mesh(Plane3d::default().mesh().size(8.0, 8.0)), self.matte(Color::WHITE));
        self.spawn(floor);
        let ball = Sphere::new(0.5).mesh().uv(64, 32);
        let ball = (self.mesh(ball), self.matte(Color::srgb(0.8, 0.3, 0.2)));
        self.spawn((ball, Transform::from_xyz(0.0, 0.5, 0.0)));
    }

    pub(crate) fn update(&mut self) {
        self.headless.update().unwrap_or_else(|problem| panic!("{problem}"));
    }

    /// Frames until `done`.
    pub(crate) fn until(&mut self, what: &str, done: impl FnMut(&mut World) -> bool) {
        self.headless
            .update_until(what, Duration::from_secs(120), done)
            .unwrap_or_else(|problem| panic!("{problem}"));
    }

    /// Frames until the lights of the settings shine.
    pub(crate) fn shine(&mut self, per_frame: u32) {
        let shines = move |world: &mut World| {
            let status = world.resource::<EnvironmentStatus>();
            status.state == EnvironmentState::Ready && status.per_frame == per_frame
        };
        self.headless
            .update_until("lights", Duration::from_secs(60), shines)
            .unwrap_or_else(|problem| panic!("{problem}"));
    }

    /// The greatest difference of two pictures, in any channel.
    pub(crate) fn apart(before: &[Vec3], after: &[Vec3]) -> f32 {
        assert_eq!(before.len(), after.len());
        before
            .iter()
            .zip(after)
            .map(|(before, after)| (before - after).abs().max_element())
            .fold(0.0, f32::max)
    }

    /// Frames until the camera's picture is refined.
    pub(crate) fn refine(&mut self, camera: Entity) {
        self.until("a refined picture", |world| {
            world.get::<Refinement>(camera).is_some_and(Refinement::is_refined)
        });
    }

    /// What the camera sees in the next frames, the last of them: linear light, rows from the top.
    pub(crate) fn floats(&mut self) -> Vec<Vec3> {
        let image = self.floats.clone();
        self.read(&image)
    }

    /// The same of another image.
    pub(crate) fn read(&mut self, image: &Handle<Image>) -> Vec<Vec3> {
        linear::read(&mut self.headless, &[image]).remove(0)
    }
}

/// Saves linear light for a person to look at.
pub(crate) fn save(pixels: &[Vec3], name: &str) {
    linear::save(pixels, SIZE, &format!("ibl/{name}.png"));
}
