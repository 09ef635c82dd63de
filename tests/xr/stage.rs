//! A renderer with the cameras of two eyes.

use std::time::Duration;

use bevy::prelude::*;
use farlight::{
    prelude::*,
    xr::{Fov, XrPlugin, XrTracking, XrView, eye_camera},
};

use crate::support::{self, headless::Headless, linear};

/// Edge of an eye's picture in pixels.
pub(crate) const SIZE: u32 = 128;
/// Metres between the eyes.
pub(crate) const APART: f32 = 0.063;
/// What the left eye sees: farther outwards than inwards. The right one sees the mirrored.
pub(crate) const LEFT: Fov = Fov { left: -0.9, right: 0.7, up: 0.8, down: -0.85 };

/// Eyes see with exposure 1 and no tone mapping.
pub(crate) struct Stage {
    pub(crate) headless: Headless,
    pub(crate) targets: [Handle<Image>; 2],
    pub(crate) eyes: [Entity; 2],
}

/// What a right eye sees of what a left one does.
pub(crate) fn mirrored(fov: Fov) -> Fov {
    Fov { left: -fov.right, right: -fov.left, ..fov }
}

/// Both eyes of a head.
pub(crate) fn views(head: Isometry3d) -> [XrView; 2] {
    let eye =
        |x: f32, fov: Fov| XrView { pose: head * Isometry3d::from_translation(Vec3::X * x), fov };
    [eye(-APART / 2.0, LEFT), eye(APART / 2.0, mirrored(LEFT))]
}

impl Stage {
    /// With a head at the origin, looking along -z.
    pub(crate) fn new() -> Self {
        // Nothing is pressed here.
        let plugins = FarlightPlugins.build().disable::<PanelPlugin>().disable::<ControlsPlugin>();
        Self::with(|app| {
            app.add_plugins(plugins);
        })
    }

    /// The same with other plugins of the suite.
    pub(crate) fn with(add: impl FnOnce(&mut App)) -> Self {
        let headless = Headless::new(UVec2::splat(SIZE), &support::assets(), |app| {
            add(app);
            app.add_plugins(XrPlugin::default())
                .insert_resource(farlight::ibl::EnvironmentCache(None))
                .insert_resource(GlobalAmbientLight::NONE)
                .insert_resource(ClearColor(Color::BLACK))
                .insert_resource(bevy::light::DirectionalLightShadowMap { size: 256 });
        });
        let mut headless = headless.unwrap_or_else(|problem| panic!("{problem}"));
        headless.set_frame_time(Duration::from_millis(16));
        let targets =
            std::array::from_fn(|_| linear::target(&mut headless.app, UVec2::splat(SIZE)));
        let mut stage = Self { headless, targets, eyes: [Entity::PLACEHOLDER; 2] };
        stage.look(Isometry3d::IDENTITY);
        for index in 0..2 {
            let camera = linear::camera(&stage.targets[index]);
            let world = stage.world();
            stage.eyes[index] = world.spawn(eye_camera(index as u32, 0.05)).insert(camera).id();
        }
        stage
    }

    pub(crate) fn world(&mut self) -> &mut World {
        self.headless.app.world_mut()
    }

    /// Moves the head.
    pub(crate) fn look(&mut self, head: Isometry3d) {
        self.world().resource_mut::<XrTracking>().eyes = Some(views(head));
    }

    pub(crate) fn spawn(&mut self, bundle: impl Bundle) -> Entity {
        self.world().spawn(bundle).id()
    }

    pub(crate) fn mesh(&mut self, mesh: impl Into<Mesh>) -> Mesh3d {
        Mesh3d(self.world().resource_mut::<Assets<Mesh>>().add(mesh))
    }

    pub(crate) fn material(
        &mut self,
        material: StandardMaterial,
    ) -> MeshMaterial3d<StandardMaterial> {
        MeshMaterial3d(self.world().resource_mut::<Assets<StandardMaterial>>().add(material))
    }

    /// A lamp behind the head, so that what faces it is lit.
    pub(crate) fn sun(&mut self) {
        self.spawn(DirectionalLight { illuminance: 3.0, ..default() });
    }

    pub(crate) fn update(&mut self) {
        self.headless.update().unwrap_or_else(|problem| panic!("{problem}"));
    }

    /// What both eyes see.
    pub(crate) fn read(&mut self) -> [Vec<Vec3>; 2] {
        let [left, right] = self.targets.clone();
        let mut both = linear::read(&mut self.headless, &[&left, &right]).into_iter();
        std::array::from_fn(|_| both.next().unwrap())
    }
}

/// The middle of what is brighter than a tenth of the brightest, in pixels from the top left corner.
pub(crate) fn middle(picture: &[Vec3]) -> Vec2 {
    let brightest = picture.iter().map(|p| p.max_element()).fold(0.0, f32::max);
    assert!(brightest > 1e-3, "the picture is black");
    let mut sum = Vec2::ZERO;
    let mut count = 0.0;
    for (i, pixel) in picture.iter().enumerate() {
        if pixel.max_element() > 0.1 * brightest {
            let (x, y) = (i as u32 % SIZE, i as u32 / SIZE);
            sum += Vec2::new(x as f32, y as f32) + 0.5;
            count += 1.0;
        }
    }
    sum / count
}

/// Where a place of the world is in an eye's picture, by the angles alone.
pub(crate) fn seen_at(view: &XrView, place: Vec3) -> Vec2 {
    let local = view.pose.inverse() * place;
    let tangents = local.xy() / -local.z;
    let low = Vec2::new(view.fov.left.tan(), view.fov.down.tan());
    let high = Vec2::new(view.fov.right.tan(), view.fov.up.tan());
    let part = (tangents - low) / (high - low);
    Vec2::new(part.x, 1.0 - part.y) * SIZE as f32
}

/// Keeps a picture for a person to look at.
pub(crate) fn save(pixels: &[Vec3], name: &str) {
    linear::save(pixels, SIZE, &format!("xr/{name}.png"));
}
