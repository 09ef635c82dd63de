//! What happens when the graphics device is lost and made anew.

use bevy::{
    app::SubApp,
    prelude::*,
    render::{RenderApp, RenderStartup},
};
use farlight::prelude::*;

use crate::mock::Mock;

/// Bevy runs `RenderStartup` for every new device; here it is run by hand, in a render world without
/// a renderer.
#[test]
fn a_new_device_brings_all_light_again() {
    let mock = Mock::default();
    let mut app = App::new();
    app.add_plugins((MinimalPlugins, AssetPlugin::default()))
        .init_asset::<Mesh>()
        .init_asset::<Image>()
        .init_asset::<StandardMaterial>();
    let mut render = SubApp::new();
    render.add_schedule(Schedule::new(RenderStartup));
    app.insert_sub_app(RenderApp, render);
    app.add_plugins(FarlightPlugins.set(mock.plugin()));
    app.finish();
    app.cleanup();
    let new_device = |app: &mut App| {
        app.sub_app_mut(RenderApp).world_mut().run_schedule(RenderStartup);
        app.update();
        app.update();
    };
    new_device(&mut app);
    assert_eq!(mock.lock().resyncs, 0, "the first device has lost nothing");
    new_device(&mut app);
    assert_eq!(mock.lock().resyncs, 1);
    new_device(&mut app);
    assert_eq!(mock.lock().resyncs, 2);
}
