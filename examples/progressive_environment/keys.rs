//! Keys.

use bevy::{prelude::*, render::view::screenshot::save_to_disk};
use farlight::{ibl::environment_maps::Method, prelude::*};

use super::{orbit::Orbit, panel::Hud, scene, shown::Shown};

/// Numbers of lights that the key goes through.
const LIGHTS: [u32; 9] = [1, 5, 20, 50, 100, 200, 500, 1000, 4096];
const METHODS: [Method; 4] =
    [Method::Regions, Method::Centroids, Method::Stratified, Method::Independent];
/// Degrees a second that the environment turns.
const TURN: f32 = 45.0;
/// Where screenshots go, below the folder that the program was started in.
const SCREENSHOTS: &str = "screenshots";

/// The next or the last of `all`.
fn next<T: Copy + PartialEq>(all: &[T], now: T, back: bool) -> T {
    let at = all.iter().position(|one| *one == now).unwrap_or(0);
    all[(at + if back { all.len() - 1 } else { 1 }) % all.len()]
}

/// Acts on keys.
pub fn keys(
    mut commands: Commands,
    time: Res<Time>,
    keys: Res<ButtonInput<KeyCode>>,
    mut shown: ResMut<Shown>,
    mut huds: Query<&mut Visibility, With<Hud>>,
    mut cameras: Query<(Entity, &mut Orbit, &mut Transform)>,
    mut taken: Local<u32>,
) {
    let back = keys.any_pressed([KeyCode::ShiftLeft, KeyCode::ShiftRight]);
    let pressed = |key| keys.just_pressed(key);
    let mut new = shown.clone();
    if pressed(KeyCode::KeyE) {
        let all: Vec<usize> = (0..new.environments.len()).collect();
        new.environment = next(&all, new.environment, back);
    }
    if pressed(KeyCode::KeyM) {
        new.method = next(&METHODS, new.method, back);
    }
    if pressed(KeyCode::KeyN) {
        let more = LIGHTS.into_iter().find(|n| *n > new.lights);
        let fewer = LIGHTS.into_iter().rev().find(|n| *n < new.lights);
        new.lights = if back { fewer } else { more }.unwrap_or(new.lights);
    }
    if pressed(KeyCode::KeyK) {
        new.per_frame = if back { new.per_frame - 1 } else { new.per_frame + 1 }.clamp(1, 10);
    }
    new.progressive ^= pressed(KeyCode::KeyP);
    new.accumulate ^= pressed(KeyCode::KeyA);
    new.image_based ^= pressed(KeyCode::KeyI);
    new.shadows ^= pressed(KeyCode::KeyS);
    new.sway ^= pressed(KeyCode::KeyW);
    new.dots ^= pressed(KeyCode::KeyD);
    new.map ^= pressed(KeyCode::KeyF);
    let step = |more: bool, less: bool| f32::from(i8::from(more) - i8::from(less));
    let turn = step(keys.pressed(KeyCode::Period), keys.pressed(KeyCode::Comma));
    if turn != 0.0 {
        new.turn = (new.turn + turn * TURN * time.delta_secs()) % 360.0;
    }
    new.exposure -= step(
        keys.any_just_pressed([KeyCode::Equal, KeyCode::NumpadAdd]),
        keys.any_just_pressed([KeyCode::Minus, KeyCode::NumpadSubtract]),
    ) / 3.0;
    new.exposure = new.exposure.clamp(-10.0, 25.0);
    if pressed(KeyCode::KeyR) {
        new = Shown { environments: new.environments, ..Shown::default() };
        for (_, mut orbit, mut transform) in &mut cameras {
            *orbit = scene::START;
            *transform = orbit.transform();
        }
    }
    if pressed(KeyCode::KeyC) {
        *taken += 1;
        let path = format!("{SCREENSHOTS}/{}-{}.png", new.chosen().name, *taken);
        if let Err(error) = std::fs::create_dir_all(SCREENSHOTS) {
            error!("{SCREENSHOTS}: {error}");
        }
        for (camera, ..) in &cameras {
            commands.spawn(RefinedScreenshot(camera)).observe(save_to_disk(path.clone()));
        }
    }
    shown.set_if_neq(new);
    if pressed(KeyCode::KeyH) {
        for mut visibility in &mut huds {
            visibility.toggle_visible_hidden();
        }
    }
}
