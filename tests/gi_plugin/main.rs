//! The Bevy side of global illumination: what is read from a scene, and what is shown of updates.
//!
//! `extraction`, `sky` and `tags` need no GPU. The others render small pictures and need a Vulkan device; Mesa's
//! lavapipe will do.

mod cost;
mod derived;
mod device;
mod extraction;
#[path = "../support/game.rs"]
mod game;
mod gltf;
mod measured;
mod mock;
mod pictures;
mod rooms;
mod sky;
#[path = "../support/mod.rs"]
mod support;
mod tags;
mod volumes;

use std::time::{Duration, Instant};

use bevy::{
    app::PluginsState,
    asset::RenderAssetUsages,
    log::LogPlugin,
    prelude::*,
    render::{
        RenderPlugin,
        pipelined_rendering::PipelinedRenderingPlugin,
        settings::{RenderCreation, WgpuSettings},
    },
    window::ExitCondition,
    winit::WinitPlugin,
};
use farlight::prelude::*;

use mock::Mock;

/// An app without a renderer, and its backend.
struct Flat {
    app: App,
    mock: Mock,
}

impl Flat {
    fn new() -> Self {
        let mock = Mock::default();
        let mut app = App::new();
        let no_gpu = WgpuSettings { backends: None, ..default() };
        app.add_plugins(
            DefaultPlugins
                .set(WindowPlugin {
                    primary_window: None,
                    exit_condition: ExitCondition::DontExit,
                    ..default()
                })
                .set(RenderPlugin {
                    render_creation: RenderCreation::Automatic(Box::new(no_gpu)),
                    ..default()
                })
                .disable::<WinitPlugin>()
                .disable::<PipelinedRenderingPlugin>()
                .disable::<LogPlugin>(),
        )
        .add_plugins(FarlightPlugins.set(mock.plugin()));
        while app.plugins_state() == PluginsState::Adding {
            bevy::tasks::tick_global_task_pools_on_main_thread();
        }
        app.finish();
        app.cleanup();
        app.update();
        mock.take_changes();
        Self { app, mock }
    }

    fn world(&mut self) -> &mut World {
        self.app.world_mut()
    }

    /// Runs frames until conversions in tasks are done and nothing more is submitted.
    fn settle(&mut self) {
        let app = &mut self.app;
        let frame = || {
            app.update();
            app.world().resource::<GiStatus>().converting
        };
        settle(frame, &self.mock);
    }

    fn mesh(&mut self, mesh: impl Into<Mesh>) -> Handle<Mesh> {
        self.world().resource_mut::<Assets<Mesh>>().add(mesh)
    }

    fn material(&mut self, material: StandardMaterial) -> Handle<StandardMaterial> {
        self.world().resource_mut::<Assets<StandardMaterial>>().add(material)
    }

    /// A quad with a second UV set, not tagged.
    fn quad(&mut self) -> Entity {
        let mesh = self.mesh(lightmapped_quad(1.0));
        let material = self.material(StandardMaterial::default());
        self.world().spawn((Mesh3d(mesh), MeshMaterial3d(material))).id()
    }

    fn left_out(&mut self, entity: Entity) -> Option<String> {
        left_out(self.world(), entity)
    }
}

/// Runs frames, each of which answers how many assets are being converted, until there are none
/// and nothing more is submitted.
fn settle(mut update: impl FnMut() -> usize, mock: &Mock) {
    let patience = Instant::now() + Duration::from_secs(60);
    let mut quiet = 0;
    let mut seen = mock.lock().submitted.len();
    while quiet < 4 {
        let converting = update();
        let now = mock.lock().submitted.len();
        quiet = if now == seen && converting == 0 { quiet + 1 } else { 0 };
        seen = now;
        if converting > 0 {
            std::thread::sleep(Duration::from_millis(1));
        }
        assert!(Instant::now() < patience, "the scene doesn't come to rest");
    }
}

fn left_out(world: &World, entity: Entity) -> Option<String> {
    let status = world.resource::<GiStatus>();
    status.left_out.iter().find(|l| l.entity == entity).map(|l| l.reason.to_string())
}

/// A square of edge `size` that faces +z, with a second UV set equal to the first.
fn lightmapped_quad(size: f32) -> Mesh {
    let mut mesh = Mesh::from(Rectangle::new(size, size));
    let uv = mesh.attribute(Mesh::ATTRIBUTE_UV_0).unwrap().clone();
    mesh.insert_attribute(Mesh::ATTRIBUTE_UV_1, uv);
    mesh
}

/// The same as lines.
fn lines() -> Mesh {
    Mesh::new(bevy::mesh::PrimitiveTopology::LineList, RenderAssetUsages::default())
        .with_inserted_attribute(Mesh::ATTRIBUTE_POSITION, vec![[0.0, 0.0, 0.0], [1.0, 0.0, 0.0]])
}
