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
    config,
    shown::Shown,
    stage::Stage,
    state::{self, Config, Problems},
};

/// The multisampling that a camera has while it doesn't refine its picture.
#[derive(Component, Clone, Copy)]
pub struct Plain(Msaa);

fn path(chosen: &config::Environment) -> AssetPath<'static> {
    AssetPath::from_path_buf(chosen.path.clone().into())
}

/// What was written last, to tell what others changed: the suite's own section of the panel.
#[derive(Resource, Default)]
pub struct Written(Option<ProgressiveLighting>);

/// Takes over what was changed elsewhere.
pub fn adopt(lighting: Res<ProgressiveLighting>, written: Res<Written>, mut shown: ResMut<Shown>) {
    let Some(written) = written.0.as_ref().filter(|_| lighting.is_changed()) else { return };
    if *written == *lighting {
        return;
    }
    let light = &mut shown.light;
    if lighting.enabled != written.enabled {
        light.progressive = lighting.enabled;
        light.shines |= lighting.enabled;
    }
    if lighting.brightness != written.brightness && written.brightness > 0.0 {
        let factor = lighting.brightness / written.brightness;
        light.brightness = (light.brightness * factor).clamp(0.01, 100.0);
    }
    (light.lights, light.per_frame) = (lighting.lights, lighting.per_frame);
    light.shadows = lighting.shadows;
}

/// Gives the chosen environment to the light and to all cameras.
pub fn show(
    mut commands: Commands,
    config: Res<Config>,
    shown: Res<Shown>,
    stage: Res<Stage>,
    server: Res<AssetServer>,
    mut lighting: ResMut<ProgressiveLighting>,
    mut written: ResMut<Written>,
    cameras: Query<(Entity, &Msaa, Option<&Plain>, Has<ProgressiveCamera>), With<Camera3d>>,
    added: Query<(), Added<Camera3d>>,
) {
    if !config.is_changed() && !shown.is_changed() && !stage.is_changed() && added.is_empty() {
        return;
    }
    let light = &shown.light;
    let chosen = light.environment.and_then(|i| config.0.environments.get(i));
    // It turns with the lamps.
    let turn = chosen.map_or(0.0, |chosen| chosen.turn + light.turn - config.0.light.direction.0);
    let refines_all = light.progressive && light.shines;
    lighting.set_if_neq(ProgressiveLighting {
        enabled: refines_all,
        environment: chosen.map(|chosen| server.load(path(chosen))),
        rotation: Quat::from_rotation_y(turn.to_radians()),
        brightness: chosen.map_or(0.0, |chosen| chosen.brightness * light.brightness),
        lights: light.lights,
        per_frame: light.per_frame,
        shadows: light.shadows,
        shadow_distance: 30.0 * stage.scale.max(0.2),
        ..lighting.clone()
    });
    written.0 = Some(lighting.clone());
    for (entity, msaa, plain, refines) in &cameras {
        let mut camera = commands.entity(entity);
        if light.shines {
            camera.insert_if_new(ImageBasedFallback);
        } else {
            camera.remove::<ImageBasedFallback>();
        }
        match (refines_all && chosen.is_some(), refines) {
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
        if light.backdrop {
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
    let chosen = shown.light.environment.and_then(|i| config.0.environments.get(i));
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
    let light = &shown.light;
    let (wanted, shines) = (light.environment.is_some(), light.shines);
    let (progressive, backdrop) = (light.progressive, wanted && light.backdrop);
    let mut cameras =
        world.query_filtered::<(Has<Skybox>, Has<EnvironmentMapLight>), With<Camera3d>>();
    let missing = cameras
        .iter(world)
        .any(|(sky, image)| (backdrop && !sky) || (wanted && shines && !progressive && !image));
    match world.resource::<EnvironmentStatus>().state {
        EnvironmentState::Failed(_) => false,
        EnvironmentState::None => wanted,
        EnvironmentState::Ready => missing,
        EnvironmentState::Loading | EnvironmentState::Choosing => true,
    }
}
