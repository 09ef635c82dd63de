//! The picture harness itself: the Cornell box in Bevy's own direct light, compared with a committed
//! picture. When this fails and `flip_indirect` does too, the renderer differs, not the lighting.

mod support;

use std::time::Duration;

use bevy::{light::PointLightShadowMap, prelude::*};
use support::{cornell, flip, headless::Headless};

#[test]
fn direct_light_matches_reference() {
    let mut headless = Headless::new(UVec2::new(96, 96), &support::assets(), |app| {
        app.insert_resource(GlobalAmbientLight::NONE)
            .insert_resource(PointLightShadowMap { size: 256 })
            .add_systems(Startup, cornell::spawn);
    })
    .unwrap();
    headless.set_frame_time(Duration::from_millis(16));
    let picture = headless.capture_still().unwrap();
    let limits = flip::Limits { mean: 0.01, p95: 0.06 };
    flip::assert_matches(&picture, "cornell-direct", limits, &headless.adapter());
}
