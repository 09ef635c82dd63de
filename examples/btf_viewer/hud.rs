//! Keys, and what is on screen about them.

use bevy::{input::mouse::AccumulatedMouseMotion, prelude::*};
use farlight::{ibl::EnvironmentState, prelude::*};

use super::{
    camera,
    config::Rig,
    material::{self, Materials},
    orbit::Orbit,
    panel::{self, Hud, State},
    state::{Config, Problems, Shown},
};

/// The text about what is wrong.
#[derive(Component)]
pub struct Wrong;

const KEYS: &str = "\
O  M  L  N    next object, material, lamps, environment
with Shift    the one before
B  F          backdrop, plinth
G             environment's light: refined, or image-based
+  -          brighter, darker
[  ]          finer, larger pattern
4  6          coarser, finer picture
Space         turn the object
drag, arrows, wheel   look around
right drag    move the light
P             screenshot
R  H          as at the start, hide this
";

/// Degrees a pixel of mouse motion, for the light.
const LIGHT_DRAG: f32 = 0.35;

/// Makes the panel.
pub fn spawn(mut commands: Commands) {
    panel::spawn(&mut commands, KEYS);
    // Problems stay when the panel is hidden.
    let place = Node {
        position_type: PositionType::Absolute,
        bottom: px(12),
        left: px(12),
        right: px(12),
        ..default()
    };
    let red = TextColor(Color::srgb(1.0, 0.45, 0.4));
    let font = TextFont { font_size: FontSize::Px(15.0), ..default() };
    commands.spawn((Wrong, place, Text::default(), font, red));
}

/// The next or the last of `count`.
fn next(index: usize, count: usize, back: bool) -> usize {
    let count = count.max(1);
    (index + if back { count - 1 } else { 1 }) % count
}

/// Acts on keys and on the right mouse button.
pub fn keys(
    keys: Res<ButtonInput<KeyCode>>,
    buttons: Res<ButtonInput<MouseButton>>,
    motion: Res<AccumulatedMouseMotion>,
    config: Res<Config>,
    mut shown: ResMut<Shown>,
    mut huds: Query<&mut Visibility, With<Hud>>,
    mut cameras: Query<(&mut Orbit, &mut Transform)>,
) {
    let config = &config.0;
    let back = keys.any_pressed([KeyCode::ShiftLeft, KeyCode::ShiftRight]);
    let mut new = shown.clone();
    if keys.just_pressed(KeyCode::KeyO) {
        new.object = next(new.object, config.models.len(), back);
    }
    if keys.just_pressed(KeyCode::KeyM) {
        new.material = next(new.material, config.materials.len(), back);
    }
    if keys.just_pressed(KeyCode::KeyL) {
        let now = Rig::ALL.iter().position(|&rig| rig == new.light).unwrap_or(0);
        new.light = Rig::ALL[next(now, Rig::ALL.len(), back)];
    }
    if keys.just_pressed(KeyCode::KeyN) {
        // None comes after the last.
        let count = config.environments.len();
        let now = new.environment.unwrap_or(count);
        let then = next(now, count + 1, back);
        new.environment = (then < count).then_some(then);
    }
    new.backdrop ^= keys.just_pressed(KeyCode::KeyB);
    new.progressive ^= keys.just_pressed(KeyCode::KeyG);
    new.floor ^= keys.just_pressed(KeyCode::KeyF);
    new.turning ^= keys.just_pressed(KeyCode::Space);
    let step = |more: bool, less: bool| f32::from(i8::from(more) - i8::from(less));
    new.exposure -= step(
        keys.any_just_pressed([KeyCode::Equal, KeyCode::NumpadAdd]),
        keys.any_just_pressed([KeyCode::Minus, KeyCode::NumpadSubtract]),
    ) / 3.0;
    new.exposure = new.exposure.clamp(-10.0, 25.0);
    let larger =
        step(keys.just_pressed(KeyCode::BracketRight), keys.just_pressed(KeyCode::BracketLeft));
    new.pattern = (new.pattern * 1.25_f32.powf(larger)).clamp(0.01, 100.0);
    let finer = step(
        keys.any_just_pressed([KeyCode::Digit6, KeyCode::Numpad6]),
        keys.any_just_pressed([KeyCode::Digit4, KeyCode::Numpad4]),
    );
    let limits = config.resolution;
    new.resolution = (new.resolution * 1.25_f32.powf(finer)).clamp(limits.least, limits.greatest);
    if buttons.pressed(MouseButton::Right) {
        new.light_direction.x = (new.light_direction.x + motion.delta.x * LIGHT_DRAG) % 360.0;
        new.light_direction.y =
            (new.light_direction.y - motion.delta.y * LIGHT_DRAG).clamp(-89.0, 89.0);
    }
    if keys.just_pressed(KeyCode::KeyR) {
        new = Shown::start(config);
        for (mut orbit, mut transform) in &mut cameras {
            *orbit = camera::orbit(config);
            *transform = orbit.transform();
        }
    }
    shown.set_if_neq(new);
    if keys.just_pressed(KeyCode::KeyH) {
        for mut visibility in &mut huds {
            visibility.toggle_visible_hidden();
        }
    }
}

/// Writes what is shown into the panel.
pub fn show(
    time: Res<Time<Real>>,
    config: Res<Config>,
    shown: Res<Shown>,
    materials: Res<Materials>,
    status: Res<EnvironmentStatus>,
    cameras: Query<&Refinement>,
    problems: Res<Problems>,
    mut states: Query<&mut Text, (With<State>, Without<Wrong>)>,
    mut wrongs: Query<&mut Text, With<Wrong>>,
    mut frames: Local<(f32, u32, f32)>,
) {
    let (since, count, rate) = &mut *frames;
    let now = time.elapsed_secs();
    *count += 1;
    if now - *since > 0.5 {
        *rate = *count as f32 / (now - *since);
        (*since, *count) = (now, 0);
    }
    let config = &config.0;
    let object = config.models.get(shown.object).map_or("nothing", |m| m.name.as_str());
    let material = config.materials.get(shown.material).map_or("no material".into(), |m| {
        let Some(about) = materials.about(m) else {
            let state = if materials.busy() { "reading ..." } else { "not there" };
            return format!("{}, {state}", m.name);
        };
        let [width, height] = about.texels;
        let size = material::size(m, about) * shown.pattern * 1e3;
        format!(
            "{}: {width} x {height} texels on {:.0} x {:.0} mm, {:.1} MB, read in {:.1} s",
            m.name,
            size.x,
            size.y,
            about.bytes as f32 * 1e-6,
            about.seconds,
        )
    });
    let environment = shown.environment.and_then(|i| config.environments.get(i));
    let environment = environment.map_or("no environment", |e| e.name.as_str());
    let reading = match status.state {
        EnvironmentState::Loading | EnvironmentState::Choosing => " (reading ...)",
        _ => "",
    };
    let refined = cameras.iter().next().map_or("image-based".into(), |refinement| {
        let crowded = if status.crowded_out { " (crowded out)" } else { "" };
        let lights = format!("{} lights, {} a frame{crowded}", status.lights, status.per_frame);
        if refinement.is_refined() {
            format!("{lights}, refined")
        } else {
            format!("{lights}, {} of {} frames", refinement.frames, refinement.of)
        }
    });
    let refined = if shown.environment.is_some() { format!(": {refined}") } else { String::new() };
    let lamps = match shown.light {
        Rig::None => "no lamps",
        Rig::Point => "one point light",
        Rig::Five => "five point lights",
        Rig::Sun => "sun",
        Rig::Spot => "spot light",
    };
    let text = format!(
        "{object}\n{material}\n{lamps}, {environment}{reading}{refined}\nexposure {:.1} EV, resolution {:.0} %, \
         {rate:.0} frames/s",
        shown.exposure,
        shown.resolution * 100.0,
    );
    let wrong = problems.all().collect::<Vec<_>>().join("\n");
    for mut state in &mut states {
        state.set_if_neq(Text::new(text.clone()));
    }
    for mut state in &mut wrongs {
        state.set_if_neq(Text::new(wrong.clone()));
    }
}
