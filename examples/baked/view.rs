//! The scene, the camera, and the sky behind the windows.

use bevy::{
    camera::{Exposure, primitives::Aabb},
    core_pipeline::tonemapping::Tonemapping,
    prelude::*,
};
use farlight::prelude::*;

use super::{args::Args, walk::Walker};

/// Makes everything.
pub fn spawn(mut commands: Commands, args: Res<Args>, server: Res<AssetServer>) {
    let mut lighting = BakedLighting::new(server.load(args.manifest.clone()));
    lighting.bicubic = args.bicubic;
    if let Some(name) = &args.scenario {
        lighting.scenarios.show(name.clone());
    }
    commands.spawn((BakedScene(args.manifest.clone()), lighting));
    let (eye, target) = (args.eye.unwrap_or_default(), args.target);
    let transform = Transform::from_translation(eye);
    let transform = match target.filter(|target| *target != eye) {
        Some(target) => transform.looking_at(target, Vec3::Y),
        None => transform,
    };
    commands.spawn((
        Camera3d::default(),
        Projection::from(PerspectiveProjection {
            fov: args.fov.to_radians(),
            near: 0.05,
            ..default()
        }),
        Exposure { ev100: args.ev100 },
        Tonemapping::TonyMcMapface,
        Msaa::Sample4,
        Walker::from(&transform),
        transform,
    ));
}

/// Puts the camera into the middle of a scene that it doesn't know.
pub fn place_camera(
    args: Res<Args>,
    status: Res<BakedStatus>,
    boxes: Query<(&Aabb, &GlobalTransform), With<Mesh3d>>,
    mut cameras: Query<&mut Transform, With<Walker>>,
    mut done: Local<bool>,
) {
    if *done || args.eye.is_some() || !status.is_ready() {
        return;
    }
    *done = true;
    let (mut low, mut high) = (Vec3::splat(f32::MAX), Vec3::splat(f32::MIN));
    for (aabb, transform) in &boxes {
        for corner in 0..8_u32 {
            let sign = UVec3::new(corner & 1, corner >> 1 & 1, corner >> 2).as_vec3() * 2.0 - 1.0;
            let point = Vec3::from(aabb.center) + sign * Vec3::from(aabb.half_extents);
            let point = transform.transform_point(point);
            (low, high) = (low.min(point), high.max(point));
        }
    }
    let middle = low.midpoint(high);
    for mut camera in &mut cameras {
        camera.translation = middle.with_y((low.y + 1.6).min(middle.y.max(low.y)));
        if let Some(target) = args.target {
            camera.look_at(target, Vec3::Y);
        }
    }
}

/// Shows each scenario's sky behind windows, as bright as the camera sees it.
pub fn paint_sky(
    status: Res<BakedStatus>,
    lighting: Query<&BakedLighting>,
    manifests: Res<Assets<BakedManifest>>,
    cameras: Query<&Exposure>,
    mut clear: ResMut<ClearColor>,
) {
    let (Ok(lighting), Ok(exposure)) = (lighting.single(), cameras.single()) else { return };
    let Some(manifest) = manifests.get(&lighting.manifest) else { return };
    let weights = status.roots.first().into_iter().flat_map(|root| &root.scenarios);
    let sky: Vec3 = weights
        .filter_map(|(name, weight)| Some(Vec3::from(manifest.scenario(name)?.sky) * *weight))
        .sum();
    let sky = sky * exposure.exposure();
    let colour = Color::linear_rgb(sky.x, sky.y, sky.z);
    if clear.0 != colour {
        clear.0 = colour;
    }
}
