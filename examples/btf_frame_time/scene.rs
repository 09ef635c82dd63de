//! What is drawn: a plane that fills the screen, and lights without shadows.

use std::{path::PathBuf, sync::Arc};

use bevy::{core_pipeline::tonemapping::Tonemapping, prelude::*};
use farlight::btf::{BtfAsset, BtfFilter, BtfMaterial};
use farlight_btf_codec::{Btf, synthetic};
use serde::Serialize;

use crate::options::Options;

/// Numbers of lights: the first is directional, the others are points.
pub(crate) const LIGHTS: [usize; 2] = [1, 5];

/// What fills the screen.
#[derive(Component, Clone, Copy, Debug, PartialEq, Eq, Serialize)]
#[serde(rename_all = "snake_case")]
pub(crate) enum Subject {
    Nothing,
    Standard,
    Nearest,
    Bilinear,
}

impl Subject {
    pub(crate) const ALL: [Self; 4] =
        [Self::Nothing, Self::Standard, Self::Nearest, Self::Bilinear];

    pub(crate) fn name(self) -> &'static str {
        match self {
            Self::Nothing => "empty",
            Self::Standard => "StandardMaterial",
            Self::Nearest => "BTF nearest texel",
            Self::Bilinear => "BTF bilinear",
        }
    }
}

/// The how many-th light it is, from 0 on.
#[derive(Component)]
struct Lamp(usize);

/// The material that was asked for, or what there is.
pub(crate) fn material(options: &Options) -> Result<Btf, String> {
    let measured = || {
        let data = PathBuf::from(std::env::var_os("FARLIGHT_TEST_DATA")?);
        Some(data.join("btfbase/wallpaper/binary.btf"))
    };
    let Some(path) = options.material.clone().or_else(measured) else {
        println!("measured material SKIPPED: FARLIGHT_TEST_DATA is not set");
        return synthetic::lambert([0.5; 3], [256, 256]).map_err(|error| error.to_string());
    };
    let bytes = std::fs::read(&path).map_err(|error| format!("{}: {error}", path.display()))?;
    Btf::from_bytes(bytes).map_err(|error| format!("{}: {error}", path.display()))
}

/// The scene, of which [`show`] picks something.
pub(crate) fn build(app: &mut App, btf: Btf) {
    app.insert_resource(GlobalAmbientLight::NONE);
    let world = app.world_mut();
    let btf = world.resource_mut::<Assets<BtfAsset>>().add(BtfAsset(Arc::new(btf)));
    let plane = world.resource_mut::<Assets<Mesh>>().add(Rectangle::new(4.0, 4.0));
    // About a texel a pixel at 512x512: four times as much lies outside of the screen.
    let with =
        |filter| BtfMaterial { repeat: Vec2::splat(8.0), filter, ..BtfMaterial::new(btf.clone()) };
    let [nearest, bilinear] = [BtfFilter::Nearest, BtfFilter::Bilinear]
        .map(|filter| world.resource_mut::<Assets<BtfMaterial>>().add(with(filter)));
    let standard = world.resource_mut::<Assets<StandardMaterial>>().add(Color::srgb(0.6, 0.5, 0.4));
    world.spawn((Subject::Standard, Mesh3d(plane.clone()), MeshMaterial3d(standard)));
    world.spawn((Subject::Nearest, Mesh3d(plane.clone()), MeshMaterial3d(nearest)));
    world.spawn((Subject::Bilinear, Mesh3d(plane), MeshMaterial3d(bilinear)));

    world.spawn((
        Lamp(0),
        DirectionalLight { illuminance: 3_000.0, shadow_maps_enabled: false, ..default() },
        Transform::from_xyz(0.5, 0.8, 1.0).looking_at(Vec3::ZERO, Vec3::Y),
    ));
    let corners = [(-0.4, -0.4), (0.4, -0.4), (-0.4, 0.4), (0.4, 0.4)];
    for (lamp, (x, y)) in (1..).zip(corners) {
        world.spawn((
            Lamp(lamp),
            PointLight { intensity: 5_000.0, shadow_maps_enabled: false, ..default() },
            Transform::from_xyz(x, y, 0.5),
        ));
    }
    world.spawn((
        Camera3d::default(),
        Msaa::Off,
        Tonemapping::None,
        Transform::from_xyz(0.3, -0.4, 1.1).looking_at(Vec3::ZERO, Vec3::Y),
    ));
}

/// Shows one subject under the first `lights` lights.
pub(crate) fn show(world: &mut World, subject: Subject, lights: usize) {
    let visible = |shown| if shown { Visibility::Visible } else { Visibility::Hidden };
    for (which, mut visibility) in world.query::<(&Subject, &mut Visibility)>().iter_mut(world) {
        *visibility = visible(*which == subject);
    }
    for (lamp, mut visibility) in world.query::<(&Lamp, &mut Visibility)>().iter_mut(world) {
        *visibility = visible(lamp.0 < lights);
    }
}
