//! The shortest example, run without a window: light reaches the room that no lamp shines into.

#[path = "../examples/add_to_your_game.rs"]
#[expect(dead_code, reason = "its main opens a window")]
mod add_to_your_game;
mod support;

use std::time::Duration;

use bevy::prelude::*;
use farlight::prelude::*;
use support::headless::Headless;

#[test]
fn the_dark_room_is_lit() {
    let mut headless = Headless::new(UVec2::new(96, 54), &support::assets(), |app| {
        app.add_plugins(FarlightPlugins)
            .insert_resource(GlobalAmbientLight::NONE)
            .add_systems(Startup, add_to_your_game::setup);
    })
    .unwrap();
    headless
        .update_until("the first lighting", Duration::from_secs(120), |world| {
            let lit = world.resource::<GiLightmaps>().placements().count();
            lit > 0 && lit == world.resource::<GiStatus>().receivers
        })
        .unwrap();
    let status = headless.app.world().resource::<GiStatus>();
    assert!(status.receivers > 0);
    assert!(status.left_out.is_empty(), "{:?}", status.left_out);
    let lit = headless.capture().unwrap();
    headless.app.insert_resource(GiView::DirectOnly);
    headless.update().unwrap();
    headless.update().unwrap();
    let direct = headless.capture().unwrap();
    lit.save(support::scratch("add_to_your_game.png")).unwrap();
    direct.save(support::scratch("add_to_your_game.direct.png")).unwrap();
    assert_eq!(lit.problem(), None);
    // The camera stands in the dark room: without indirect light it is mostly black.
    assert!(lit.mean() > 1.5 * direct.mean(), "{} {}", lit.mean(), direct.mean());
}
