//! The Cornell box in direct and converged indirect light, compared with a committed picture.

mod support;

use std::time::Duration;

use bevy::{light::PointLightShadowMap, prelude::*};
use farlight::prelude::*;
use support::{cornell, flip, headless::Headless};

#[test]
fn indirect_light_matches_reference() {
    let mut headless = Headless::new(UVec2::new(96, 96), &support::assets(), |app| {
        let settings = GiSettings {
            page_size: 128,
            max_pages: 1,
            texels_per_metre: 8.0,
            converged_paths: 512,
            seed: 1,
            ..default()
        };
        app.insert_resource(settings)
            .add_plugins(GiPlugin::default())
            .insert_resource(GlobalAmbientLight::NONE)
            .insert_resource(PointLightShadowMap { size: 256 })
            .add_systems(Startup, (cornell::spawn, tag.after(cornell::spawn)));
    })
    .unwrap();
    headless.set_frame_time(Duration::from_millis(16));
    let converged = headless.update_until("converged light", Duration::from_secs(120), |world| {
        let status = world.resource::<GiStatus>();
        status.state == GiState::Converged && status.shown == status.submitted
    });
    let status = headless.app.world().resource::<GiStatus>();
    assert_eq!(converged, Ok(()), "{status:?}");
    let picture = headless.capture_still().unwrap();
    // Wide enough for another number of threads or another renderer, far below what a seam, a leak
    // or a wrong factor makes.
    let limits = flip::Limits { mean: 0.02, p95: 0.08 };
    flip::assert_matches(&picture, "cornell-indirect", limits, &headless.adapter());
}

fn tag(mut commands: Commands, roots: Query<Entity, With<cornell::CornellRoot>>) {
    for root in &roots {
        commands.entity(root).insert(GiScene);
    }
}
