//! A game without a renderer and without a window: a room with a lamp, tagged for indirect light.
#![allow(dead_code, reason = "every test uses its own part")]

use std::time::{Duration, Instant};

use bevy::{asset::RenderAssetUsages, mesh::Indices, prelude::*};
use farlight::prelude::*;

/// Nothing passes visibility on here: that is done by a plugin of the renderer.
const VISIBLE: (Visibility, InheritedVisibility) =
    (Visibility::Visible, InheritedVisibility::VISIBLE);

/// The game.
pub(crate) struct Game {
    pub(crate) app: App,
    /// The walls.
    pub(crate) walls: Vec<Entity>,
    pub(crate) lamp: Entity,
}

impl Game {
    /// A game whose indirect light comes from a plugin's backend.
    pub(crate) fn new(gi: GiPlugin) -> Self {
        Self::with(|app| {
            // Light alone: what inputs and panels cost is another matter.
            let plugins = FarlightPlugins.set(gi);
            app.add_plugins(plugins.disable::<ControlsPlugin>().disable::<PanelPlugin>())
                .insert_resource(farlight::ibl::EnvironmentCache(None));
        })
    }

    /// A game without indirect light.
    pub(crate) fn bare() -> Self {
        Self::with(|_| {})
    }

    fn with(add: impl FnOnce(&mut App)) -> Self {
        let mut app = App::new();
        app.add_plugins((MinimalPlugins, AssetPlugin::default(), TransformPlugin));
        add(&mut app);
        app.init_asset::<Mesh>()
            .init_asset::<Image>()
            .init_asset::<StandardMaterial>()
            .insert_resource(settings());
        app.finish();
        app.cleanup();

        let (walls, lamp) = furnish(app.world_mut());
        Self { app, walls, lamp }
    }

    pub(crate) fn status(&self) -> &GiStatus {
        self.app.world().resource::<GiStatus>()
    }

    pub(crate) fn move_lamp(&mut self, to: Vec3) {
        self.app.world_mut().get_mut::<Transform>(self.lamp).unwrap().translation = to;
    }

    /// Frames until something is so; panics if it never is.
    pub(crate) fn until(&mut self, what: &str, mut done: impl FnMut(&Self) -> bool) {
        let patience = Instant::now() + Duration::from_secs(60);
        while !done(self) {
            if Instant::now() > patience {
                let GiStatus { state, link, submitted, shown, left_out, .. } = self.status();
                panic!("{what}: {state:?}, {shown:?} of {submitted:?}, {left_out:?}, {link:?}");
            }
            self.app.update();
            std::thread::sleep(Duration::from_millis(2));
        }
    }

    /// Frames until the newest state of the scene is solved and shown.
    pub(crate) fn settle(&mut self) {
        // A change is submitted in the frame after.
        self.app.update();
        self.until("light", |game| {
            let status = game.status();
            status.state == GiState::Converged && status.shown == status.submitted
        });
    }
}

/// Quick to solve.
pub(crate) fn settings() -> GiSettings {
    GiSettings {
        page_size: 64,
        max_pages: 1,
        texels_per_metre: 4.0,
        rays_per_texel: 64,
        rays_per_probe: 64,
        converged_paths: 64,
        ..default()
    }
}

/// The walls of a closed room of 4 x 3 x 4 m, and a lamp in it.
pub(crate) fn furnish(world: &mut World) -> (Vec<Entity>, Entity) {
    let (x, y, z) = (Vec3::X * 4.0, Vec3::Y * 3.0, Vec3::Z * 4.0);
    let sides = [
        (Vec3::ZERO, z, x),
        (y, x, z),
        (Vec3::ZERO, y, z),
        (x, z, y),
        (Vec3::ZERO, x, y),
        (z, y, x),
    ];
    let material =
        world.resource_mut::<Assets<StandardMaterial>>().add(StandardMaterial::default());
    let walls = sides.map(|(origin, u, v)| {
        let mesh = world.resource_mut::<Assets<Mesh>>().add(wall(origin, u, v));
        let parts = (Mesh3d(mesh), MeshMaterial3d(material.clone()), GiScene);
        world.spawn((parts, Transform::default(), VISIBLE)).id()
    });
    let light = PointLight { intensity: 100_000.0, range: 100.0, ..default() };
    let lamp = world.spawn((light, Transform::from_xyz(1.0, 1.5, 2.0), VISIBLE)).id();
    (walls.to_vec(), lamp)
}

/// A parallelogram from `origin` along `u` and `v`, facing `u x v`, its second UV set 0..1.
fn wall(origin: Vec3, u: Vec3, v: Vec3) -> Mesh {
    let corners = [origin, origin + u, origin + u + v, origin + v].map(|p| p.to_array());
    let uv = [[0.0, 0.0], [1.0, 0.0], [1.0, 1.0], [0.0, 1.0]];
    Mesh::new(
        bevy::mesh::PrimitiveTopology::TriangleList,
        RenderAssetUsages::MAIN_WORLD | RenderAssetUsages::RENDER_WORLD,
    )
    .with_inserted_attribute(Mesh::ATTRIBUTE_POSITION, corners.to_vec())
    .with_inserted_attribute(Mesh::ATTRIBUTE_NORMAL, vec![u.cross(v).normalize().to_array(); 4])
    .with_inserted_attribute(Mesh::ATTRIBUTE_UV_1, uv.to_vec())
    .with_inserted_indices(Indices::U32(vec![0, 1, 2, 0, 2, 3]))
}
