//! What actions do to what is shown. Each says so.

use bevy::{ecs::system::SystemParam, prelude::*};
use farlight::{
    prelude::*,
    xr::{XrHead, XrStatus},
};

use super::{
    config::{Rig, Viewer},
    shown::{Evaluation, MOST_COARSE, Shown, degrees},
    state::Config,
    view::ResetView,
    viewpoint::Viewpoint,
};

/// What actions read and tell.
#[derive(SystemParam)]
pub struct Said<'w> {
    notifications: MessageWriter<'w, Notification>,
}

impl Said<'_> {
    /// Shows a line.
    pub fn say(&mut self, text: impl Into<String>) {
        self.notifications.write(Notification::new(text));
    }

    /// Shows a line about what went wrong.
    pub fn fail(&mut self, text: impl Into<String>) {
        self.notifications.write(Notification::problem(text));
    }
}

/// The one after or before of `count`.
fn beside(index: usize, count: usize, step: i32) -> usize {
    (index as i64 + i64::from(step)).rem_euclid(count.max(1) as i64) as usize
}

/// How many times two actions want to go on: 1, -1 or 0.
fn step(more: bool, less: bool) -> i32 {
    i32::from(more) - i32::from(less)
}

fn on_off(on: bool) -> &'static str {
    if on { "on" } else { "off" }
}

/// Changes what is shown.
pub fn act(
    controls: Controls,
    config: Res<Config>,
    mut shown: ResMut<Shown>,
    status: Res<XrStatus>,
    heads: Query<&GlobalTransform, With<XrHead>>,
    cameras: Query<&GlobalTransform, With<Viewpoint>>,
    mut reset: MessageWriter<ResetView>,
    mut exit: MessageWriter<AppExit>,
    mut said: Said,
) {
    let mut new = shown.clone();
    choose(&controls, &config.0, &mut new, &mut said);
    material(&controls, &mut new, &mut said);
    light(&controls, &mut new, &mut said);
    picture(&controls, &config.0, &mut new, &mut said);
    let by = controls.axis2::<actions::RotateObject>();
    if by != Vec2::ZERO {
        let head = heads.iter().next().filter(|_| *status == XrStatus::Running);
        let viewer = head.or_else(|| cameras.iter().next());
        new.object.roll(by, viewer.map_or(Vec3::X, |viewer| *viewer.right()));
    }
    if controls.started::<actions::Reset>() {
        new = Shown::start(&config.0);
        reset.write(ResetView);
        said.say("As at the start");
    }
    if controls.started::<actions::Quit>() {
        exit.write(AppExit::Success);
    }
    shown.set_if_neq(new);
}

/// Material, object, environment, lamps.
fn choose(controls: &Controls, config: &Viewer, new: &mut Shown, said: &mut Said) {
    let by = step(
        controls.started::<actions::NextMaterial>(),
        controls.started::<actions::PreviousMaterial>(),
    );
    if by != 0 {
        new.material.choice = beside(new.material.choice, config.materials.len(), by);
        match config.materials.get(new.material.choice) {
            Some(material) => said.say(format!("Material: {}", material.name)),
            None => said.fail("no materials: the configuration lists none"),
        }
    }
    let by = step(
        controls.started::<actions::NextModel>(),
        controls.started::<actions::PreviousModel>(),
    );
    if by != 0 {
        new.object.choice = beside(new.object.choice, config.models.len(), by);
        if let Some(model) = config.models.get(new.object.choice) {
            said.say(format!("Object: {}", model.name));
        }
    }
    let by = step(
        controls.started::<actions::NextEnvironment>(),
        controls.started::<actions::PreviousEnvironment>(),
    );
    if by != 0 {
        // None comes after the last.
        let count = config.environments.len();
        let then = beside(new.light.environment.unwrap_or(count), count + 1, by);
        new.light.environment = (then < count).then_some(then);
        let name = config.environments.get(then).map_or("none", |e| e.name.as_str());
        said.say(format!("Environment: {name}"));
    }
    if controls.started::<actions::NextLamps>() {
        let now = Rig::ALL.iter().position(|&rig| rig == new.light.lamps).unwrap_or(0);
        new.light.lamps = Rig::ALL[beside(now, Rig::ALL.len(), 1)];
        said.say(format!("Lamps: {}", new.light.lamps.label()));
    }
    if controls.started::<actions::ToggleTurning>() {
        new.object.turning ^= true;
        said.say(format!("Turntable {}", on_off(new.object.turning)));
    }
    if controls.started::<actions::ToggleFloor>() {
        new.object.plinth ^= true;
        said.say(format!("Plinth {}", on_off(new.object.plinth)));
    }
}

/// How the material is evaluated.
fn material(controls: &Controls, new: &mut Shown, said: &mut Said) {
    let chosen = [
        controls.started::<actions::Evaluation1>(),
        controls.started::<actions::Evaluation2>(),
        controls.started::<actions::Evaluation3>(),
    ];
    if let Some(chosen) = chosen.iter().position(|&chosen| chosen) {
        new.material.evaluation = Evaluation::ALL[chosen];
        said.say(format!("Evaluation: {}", new.material.evaluation.label()));
    }
    let by = step(
        controls.started::<actions::CoarserMaterial>(),
        controls.started::<actions::FinerMaterial>(),
    );
    if by != 0 {
        new.material.halvings = (new.material.halvings.round() + by as f32).clamp(0.0, MOST_COARSE);
        said.say(match new.material.halvings as u32 {
            0 => "Material at its whole resolution".into(),
            halvings => format!("Material at 1/{} of its resolution", 1 << halvings),
        });
    }
}

/// Environment's light and lamps.
fn light(controls: &Controls, new: &mut Shown, said: &mut Said) {
    if controls.started::<actions::ToggleProgressive>() {
        new.light.progressive ^= true;
        said.say(format!("Progressive light {}", on_off(new.light.progressive)));
    }
    if controls.started::<actions::ToggleImageBased>() {
        new.light.shines ^= true;
        said.say(format!("Environment's light {}", on_off(new.light.shines)));
    }
    if controls.started::<actions::ToggleBackdrop>() {
        new.light.backdrop ^= true;
        said.say(format!("Backdrop {}", on_off(new.light.backdrop)));
    }
    let by =
        step(controls.started::<actions::MoreLights>(), controls.started::<actions::FewerLights>());
    if by != 0 {
        let (least, most) = (1, 10);
        new.light.per_frame = new.light.per_frame.saturating_add_signed(by).clamp(least, most);
        said.say(format!("Lights a frame: {}", new.light.per_frame));
    }
    let by = controls.axis2::<actions::RotateEnvironment>();
    if by != Vec2::ZERO {
        new.light.turn = degrees(new.light.turn + by.x);
        new.light.height = (new.light.height + by.y).clamp(-89.0, 89.0);
    }
}

/// Exposure and resolution.
fn picture(controls: &Controls, config: &Viewer, new: &mut Shown, said: &mut Said) {
    let by = step(controls.started::<actions::Brighter>(), controls.started::<actions::Darker>());
    if by != 0 {
        new.picture.exposure = (new.picture.exposure - by as f32 / 3.0).clamp(-10.0, 25.0);
        said.say(format!("Exposure: {:.1} EV", new.picture.exposure));
    }
    let by = step(
        controls.started::<actions::FinerPicture>(),
        controls.started::<actions::CoarserPicture>(),
    );
    if by != 0 {
        let limits = config.resolution;
        new.picture.resolution =
            (new.picture.resolution * 1.25_f32.powi(by)).clamp(limits.least, limits.greatest);
        said.say(format!("Resolution: {:.0} %", new.picture.resolution * 100.0));
    }
}
