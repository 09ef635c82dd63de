//! Measured materials on a device without storage buffers, as a browser with WebGL2 has it. Alone in
//! its process, because Bevy remembers the first device's answer for all.

#[path = "support/mod.rs"]
mod support;

use std::{sync::Arc, time::Duration};

use bevy::{
    core_pipeline::tonemapping::Tonemapping,
    prelude::*,
    render::settings::{WgpuLimits, WgpuSettings},
};
use farlight::{
    btf::{BtfStatus, codec::synthetic},
    prelude::*,
};
use support::headless::Headless;

#[test]
fn the_mean_colour_is_shown() {
    let settings = WgpuSettings {
        constrained_limits: Some(WgpuLimits::downlevel_webgl2_defaults()),
        ..default()
    };
    let headless = Headless::on(settings, UVec2::splat(32), &support::assets(), |app| {
        app.add_plugins(FarlightPlugins)
            .insert_resource(GlobalAmbientLight::NONE)
            .insert_resource(ClearColor(Color::BLACK));
    });
    let mut headless = headless.unwrap_or_else(|problem| panic!("{problem}"));
    let world = headless.app.world_mut();
    let colour = Color::linear_rgb(0.2, 0.5, 0.8);
    let btf = synthetic::lambert([0.2, 0.5, 0.8], [2, 2]).unwrap();
    let btf = world.resource_mut::<Assets<BtfAsset>>().add(BtfAsset(Arc::new(btf)));
    let material = world.resource_mut::<Assets<BtfMaterial>>().add(BtfMaterial::new(btf));
    let mesh = world.resource_mut::<Assets<Mesh>>().add(Rectangle::new(9.0, 9.0));
    world.spawn((Mesh3d(mesh), MeshMaterial3d(material)));
    world.spawn((
        Camera3d::default(),
        Msaa::Off,
        Tonemapping::None,
        support::linear::exposure(),
        Transform::from_xyz(0.0, 0.0, 2.0),
    ));
    let sun = Transform::from_xyz(0.0, 0.0, 1.0).looking_at(Vec3::ZERO, Vec3::Y);
    world.spawn((DirectionalLight { illuminance: std::f32::consts::PI, ..default() }, sun));
    let ready = |world: &mut World| world.resource::<BtfStatus>().resident == 1;
    headless.update_until("the material", Duration::from_secs(30), ready).unwrap();
    for _ in 0..6 {
        headless.update().unwrap();
    }
    let picture = headless.capture().unwrap();
    let found = picture.pixels[16 * 32 + 16];
    let expected = colour.to_srgba().to_u8_array_no_alpha();
    let close = found.iter().zip(expected).all(|(found, expected)| found.abs_diff(expected) <= 2);
    assert!(close, "{found:?} instead of {expected:?}");
    let status = headless.app.world().resource::<BtfStatus>();
    let limited = status.limited.as_deref().unwrap_or_default();
    assert!(limited.contains("storage buffers"), "{status:?}");
}
