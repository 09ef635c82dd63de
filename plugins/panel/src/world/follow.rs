//! A panel that stays put while it is looked at, and comes after when the viewer turns away or walks.

use bevy::prelude::*;

use super::{WorldPanel, viewer};
use crate::{PanelSettings, PanelViewer, screen::Screen};

/// The viewer may look so far past its centre, in radians, before it comes after.
const TURNED: f32 = 0.6;
/// Then it comes until it is nearly ahead.
const ARRIVED: f32 = 0.05;
/// How far the viewer may go from where it belongs, in parts of its distance.
const WALKED: f32 = 0.35;
/// How far up or down it goes with the look of somebody in a headset, in radians.
const STEEPEST: f32 = 0.45;

/// The pose of a panel, on springs.
#[derive(Clone, Debug, Default)]
pub(super) struct Followed {
    centre: Spring,
    /// What it faces.
    eye: Spring,
    coming: bool,
    placed: bool,
}

/// A point that comes to rest where it is wanted, critically damped: without overshoot.
#[derive(Clone, Copy, Debug, Default)]
struct Spring {
    at: Vec3,
    speed: Vec3,
    to: Vec3,
}

impl Spring {
    fn place(at: Vec3) -> Self {
        Self { at, speed: Vec3::ZERO, to: at }
    }

    /// The exact solution over `seconds`, so that the frame rate doesn't matter. `rate` is in 1/s.
    fn pass(&mut self, seconds: f32, rate: f32) {
        let away = self.at - self.to;
        let slope = self.speed + rate * away;
        let decay = (-rate * seconds).exp();
        self.at = self.to + (away + slope * seconds) * decay;
        self.speed = (self.speed - rate * slope * seconds) * decay;
    }
}

impl Followed {
    pub(super) fn pose(&self) -> Transform {
        let pose = Transform::from_translation(self.centre.at);
        let back = self.centre.at - self.eye.at;
        // Towards the viewer is +z, as of a quad.
        if back.length_squared() > 1e-8 { pose.looking_to(back, Vec3::Y) } else { pose }
    }

    /// It will be placed anew.
    pub(super) fn forget(&mut self) {
        self.placed = false;
    }

    /// A frame passes. `headset`: a head's look up and down is followed only in part.
    fn pass(
        &mut self,
        viewer: &GlobalTransform,
        distance: f32,
        rate: f32,
        seconds: f32,
        headset: bool,
    ) {
        let eye = viewer.translation();
        let mut look = *viewer.forward();
        if headset {
            let flat = Vec2::new(look.x, look.z).length();
            let pitch = look.y.atan2(flat).clamp(-STEEPEST, STEEPEST);
            let yaw = Vec2::new(look.x, look.z).normalize_or(Vec2::NEG_Y);
            look = Vec3::new(yaw.x * pitch.cos(), pitch.sin(), yaw.y * pitch.cos());
        }
        let ahead = eye + look * distance;
        if !self.placed {
            *self = Self {
                centre: Spring::place(ahead),
                eye: Spring::place(eye),
                coming: false,
                placed: true,
            };
            return;
        }
        let towards = (self.centre.at - eye).normalize_or(look);
        let turned = towards.angle_between(look);
        let gone = (self.centre.at.distance(eye) - distance).abs() / distance;
        if turned > TURNED || gone > WALKED {
            self.coming = true;
        } else if turned < ARRIVED && gone < ARRIVED {
            self.coming = false;
        }
        if self.coming {
            self.centre.to = ahead;
            self.eye.to = eye;
        }
        self.centre.pass(seconds, rate);
        self.eye.pass(seconds, rate);
    }
}

/// Lets it follow.
pub(super) fn follow(
    mut panel: ResMut<WorldPanel>,
    settings: Res<PanelSettings>,
    screen: Res<Screen>,
    heads: Query<&GlobalTransform, With<PanelViewer>>,
    all: Query<&GlobalTransform>,
    time: Res<Time>,
) {
    if !panel.shown {
        return;
    }
    let Some(viewer) = viewer(&screen, &heads, &all) else { return };
    // A critically damped spring does 95 % of the way in 4.7 / rate.
    let rate = 4.7 * settings.follow.clamp(0.05, 50.0);
    let distance = settings.distance.clamp(0.1, 50.0);
    panel.followed.pass(&viewer, distance, rate, time.delta_secs(), !heads.is_empty());
}

#[cfg(test)]
mod tests {
    use super::*;

    fn turned(degrees: f32) -> GlobalTransform {
        Transform::from_rotation(Quat::from_rotation_y(degrees.to_radians())).into()
    }

    #[test]
    fn it_stays_until_one_turns_away_and_comes_without_overshoot() {
        let mut followed = Followed::default();
        followed.pass(&turned(0.0), 1.25, 7.0, 0.0, true);
        let start = followed.pose().translation;
        assert!(start.abs_diff_eq(Vec3::new(0.0, 0.0, -1.25), 1e-5), "{start}");
        for _ in 0..100 {
            followed.pass(&turned(20.0), 1.25, 7.0, 0.01, true);
        }
        assert_eq!(followed.pose().translation, start, "one looks about on it");
        let ahead = turned(70.0).forward() * 1.25;
        let mut before = start.distance(ahead);
        for _ in 0..400 {
            followed.pass(&turned(70.0), 1.25, 7.0, 0.01, true);
            let now = followed.pose().translation.distance(ahead);
            assert!(now <= before + 1e-5, "{now} after {before}");
            before = now;
        }
        assert!(before < 0.1, "{before} m are left");
        let facing = followed.pose().forward().dot(*turned(70.0).forward());
        assert!(facing > 0.99, "it faces the viewer: {facing}");
    }

    #[test]
    fn frame_rates_do_not_matter() {
        let after = |frames: u32| {
            let mut spring =
                Spring { at: Vec3::ZERO, speed: Vec3::X, to: Vec3::new(1.0, 2.0, 3.0) };
            (0..frames).for_each(|_| spring.pass(0.5 / frames as f32, 6.0));
            spring.at
        };
        assert!(after(10).abs_diff_eq(after(1000), 1e-4), "{} {}", after(10), after(1000));
    }
}
