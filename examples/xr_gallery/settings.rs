//! What people change in the gallery's panel.

use bevy::prelude::*;

/// The gallery's own settings.
#[derive(Resource, Reflect, Clone, Debug, PartialEq)]
#[reflect(Resource, Default)]
pub struct Gallery {
    /// Whether the lamp is on.
    pub lamp: bool,
    /// How much light the lamp gives, in lumens.
    #[reflect(@100.0..=20000.0_f32)]
    pub lamp_power: f32,
    /// The lamp's colour as the temperature of a glowing body, in kelvin: low is warm.
    #[reflect(@1800.0..=8000.0_f32)]
    pub lamp_colour: f32,
    /// Whether the sculpture in the hall turns.
    pub turning: bool,
    /// Whether the sun shines.
    pub sun: bool,
    /// How high the sun stands, in degrees.
    #[reflect(@10.0..=80.0_f32)]
    pub sun_height: f32,
    /// Where the sun stands, in degrees from north over east.
    #[reflect(@0.0..=360.0_f32)]
    pub sun_direction: f32,
    /// Brighter or darker than the photographer's choice, in stops.
    #[reflect(@-3.0..=3.0_f32)]
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
