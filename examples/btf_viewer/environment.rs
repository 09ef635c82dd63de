//! The environment: the object's light, and what is seen behind it.
//!
//! Its light is refined from frame to frame by directional lights with shadows, or is Bevy's
//! image-based light without; both are of the same map.

use std::time::SystemTime;

use bevy::{
    asset::AssetPath,
    core_pipeline::prepass::{DepthPrepass, MotionVectorPrepass},
    light::Skybox,
    prelude::*,
    render::camera::TemporalJitter,
};
use farlight::{ibl::EnvironmentState, prelude::*};

use super::{
    config::{self, Progressive},
    state::{self, Config, Problems, Shown},
};

/// The multisampling that a camera has while it doesn't refine its picture.
#[derive(Component, Clone, Copy)]
pub struct Plain(Msaa);

fn path(chosen: &config::Environment) -> AssetPath<'static> {
    AssetPath::from_path_buf(chosen.path.clone().into())
}

/// Gives the chosen environment to the light and to the camera.
pub fn show(
    mut commands: Commands,
    config: Res<Config>,
    shown: Res<Shown>,
    server: Res<AssetServer>,
    mut lighting: ResMut<ProgressiveLighting>,
    cameras: Query<(Entity, &Msaa, Option<&Plain>, Has<ProgressiveCamera>), With<Camera3d>>,
) {
    if !config.is_changed() && !shown.is_changed() {
        return;
    }
    let chosen = shown.environment.and_then(|i| config.0.environments.get(i));
    // It turns with the lamps.
    let turn = chosen
        .map_or(0.0, |chosen| chosen.turn + shown.light_direction.x - config.0.light.direction.0);
    let Progressive { lights, per_frame, shadows, .. } = config.0.progressive;
    lighting.set_if_neq(ProgressiveLighting {
        enabled: shown.progressive,
        environment: chosen.map(|chosen| server.load(path(chosen))),
        rotation: Quat::from_rotation_y(turn.to_radians()),
        brightness: chosen.map_or(0.0, |chosen| chosen.brightness),
        lights,
        per_frame,
        shadows,
        shadow_distance: 30.0 * config.0.base_scale.max(1.0),
        ..default()
    });
    for (entity, msaa, plain, refines) in &cameras {
        let mut camera = commands.entity(entity);
        camera.insert_if_new(ImageBasedFallback);
        match (shown.progressive && chosen.is_some(), refines) {
            (true, false) => {
                camera.insert((Plain(*msaa), ProgressiveCamera::default()));
            }
            (false, true) => {
                camera.remove::<(ProgressiveCamera, Refinement, TemporalJitter)>();
                camera.remove::<(DepthPrepass, MotionVectorPrepass)>();
                camera.insert(plain.map_or(Msaa::Sample4, |plain| plain.0));
            }
            _ => {}
        }
        if shown.backdrop {
            camera.insert_if_new(EnvironmentBackdrop::default());
        } else {
            camera.remove::<EnvironmentBackdrop>();
        }
    }
}

/// Says what is wrong with the environment, and reads it again when its file changes: looks once a
/// second.
pub fn watch(
    time: Res<Time<Real>>,
    config: Res<Config>,
    shown: Res<Shown>,
    status: Res<EnvironmentStatus>,
    server: Res<AssetServer>,
    mut problems: ResMut<Problems>,
    mut seen: Local<(f32, String, Option<SystemTime>)>,
) {
    let problem = match &status.state {
        EnvironmentState::Failed(reason) => Some(reason.to_string()),
        _ => None,
    };
    if problems.environment != problem {
        problems.environment = problem;
    }
    let now = time.elapsed_secs();
    let chosen = shown.environment.and_then(|i| config.0.environments.get(i));
    let Some(chosen) = chosen.filter(|_| now - seen.0 > 1.0) else { return };
    let written = state::written(&state::on_disk(&chosen.path));
    if seen.1 == chosen.path && seen.2 != written && written.is_some() {
        server.reload(path(chosen));
    }
    *seen = (now, chosen.path.clone(), written);
}

/// Whether what the chosen environment does is still being prepared.
pub fn is_busy(world: &mut World) -> bool {
    let shown = world.resource::<Shown>();
    let (wanted, progressive) = (shown.environment.is_some(), shown.progressive);
    let backdrop = wanted && shown.backdrop;
    let mut cameras =
        world.query_filtered::<(Has<Skybox>, Has<EnvironmentMapLight>), With<Camera3d>>();
    let missing = cameras
        .iter(world)
        .any(|(sky, light)| (backdrop && !sky) || (wanted && !progressive && !light));
    match world.resource::<EnvironmentStatus>().state {
        EnvironmentState::Failed(_) => false,
        EnvironmentState::None => wanted,
        EnvironmentState::Ready => missing,
        EnvironmentState::Loading | EnvironmentState::Choosing => true,
    }
}
