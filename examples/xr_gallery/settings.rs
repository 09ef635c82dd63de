//! What people change in the gallery's panel.

use bevy::prelude::*;
use farlight::{
    controls::{
        Controls,
        actions::{Brighter, Darker, NextLamps, Quit, ToggleTurning},
    },
    panel::{
        Notification,
        field::{Label, Step, Unit},
    },
};

/// The gallery's own settings.
#[derive(Resource, Reflect, Clone, Debug, PartialEq)]
#[reflect(Resource, Default)]
pub struct Gallery {
    /// Whether the lantern is on.
    #[reflect(@Label("Lantern"))]
    pub lamp: bool,
    /// How much light the lantern gives.
    #[reflect(@100.0..=20000.0_f32, @Unit("lm"), @Step(100.0), @Label("Lantern's light"))]
    pub lamp_power: f32,
    /// The lantern's colour as the temperature of a glowing body: low is warm.
    #[reflect(@1800.0..=8000.0_f32, @Unit("K"), @Step(100.0), @Label("Lantern's colour"))]
    pub lamp_colour: f32,
    /// Whether the sculpture in the hall turns.
    #[reflect(@Label("Sculpture turns"))]
    pub turning: bool,
    /// Whether the sun shines.
    #[reflect(@Label("Sun"))]
    pub sun: bool,
    /// How high the sun stands.
    #[reflect(@10.0..=80.0_f32, @Unit("°"), @Step(1.0))]
    pub sun_height: f32,
    /// Where the sun stands, from north over east.
    #[reflect(@0.0..=360.0_f32, @Unit("°"), @Step(1.0))]
    pub sun_direction: f32,
    /// Brighter or darker than the photographer's choice.
    #[reflect(@-3.0..=3.0_f32, @Unit("EV"), @Step(0.1))]
    pub exposure: f32,
}

impl Default for Gallery {
    fn default() -> Self {
        Self {
            lamp: true,
            lamp_power: 6000.0,
            lamp_colour: 3000.0,
            turning: true,
            sun: true,
            sun_height: 47.0,
            sun_direction: 222.0,
            exposure: 0.0,
        }
    }
}

impl Gallery {
    /// The direction to the sun.
    pub fn to_sun(&self) -> Vec3 {
        let (height, from_north) = (self.sun_height.to_radians(), self.sun_direction.to_radians());
        let flat = Vec3::new(from_north.sin(), 0.0, -from_north.cos());
        flat * height.cos() + Vec3::Y * height.sin()
    }
}

/// Does what actions say, and says what they did.
pub fn act(
    controls: Controls,
    mut gallery: ResMut<Gallery>,
    mut notifications: MessageWriter<Notification>,
    mut exit: MessageWriter<AppExit>,
) {
    let on = |on: bool| if on { "on" } else { "off" };
    let mut say = |text: String| {
        notifications.write(Notification::new(text));
    };
    if controls.started::<NextLamps>() {
        gallery.lamp = !gallery.lamp;
        say(format!("Lantern {}", on(gallery.lamp)));
    }
    if controls.started::<ToggleTurning>() {
        gallery.turning = !gallery.turning;
        say(format!("The sculpture {}", if gallery.turning { "turns" } else { "rests" }));
    }
    let stops = 0.5
        * (f32::from(u8::from(controls.started::<Brighter>()))
            - f32::from(u8::from(controls.started::<Darker>())));
    if stops != 0.0 {
        gallery.exposure = (gallery.exposure + stops).clamp(-3.0, 3.0);
        say(format!("Exposure {:+.1} EV", gallery.exposure));
    }
    if controls.started::<Quit>() {
        exit.write(AppExit::Success);
    }
}
