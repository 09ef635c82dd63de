//! Where the object stands, and how large it is: on a desk as the configuration says, in a headset in
//! front of the person, at a height that is good to look at.

use bevy::prelude::*;
use farlight::xr::XrStatus;

use super::{
    config::{Headset, Viewer},
    state::Config,
};

/// The place of the object, which lamps and plinth share.
#[derive(Resource, Clone, Copy, Debug, PartialEq)]
pub struct Stage {
    /// The object's middle.
    pub middle: Vec3,
    /// Factor on sizes; 1 is an object of about two metres.
    pub scale: f32,
    /// Objects have the size that their files give them, whatever `scale` is.
    pub life_size: bool,
    /// What the plinth stands on; without, it is a disc that hangs in the air.
    pub floor: Option<f32>,
}

/// Height of the cylinder that objects fit at a scale of 1.
const HEIGHT: f32 = 1.9;

impl Stage {
    /// On a screen, or in a headset whose person stands at the origin and looks along -z.
    pub fn new(config: &Viewer, in_headset: bool) -> Self {
        let offset = Vec3::from(config.base_offset);
        if !in_headset {
            let scale = config.base_scale;
            return Self { middle: offset, scale, life_size: false, floor: None };
        }
        let Headset { height, distance, size, .. } = config.xr;
        Self {
            middle: Vec3::new(0.0, height, -distance) + offset,
            scale: config.base_scale * size.unwrap_or(0.6) / HEIGHT,
            life_size: size.is_none(),
            floor: Some(0.0),
        }
    }
}

/// Follows the configuration and the headset.
pub fn set(config: Res<Config>, status: Option<Res<XrStatus>>, mut stage: ResMut<Stage>) {
    let in_headset = status.is_some_and(|status| *status == XrStatus::Running);
    stage.set_if_neq(Stage::new(&config.0, in_headset));
}
