//! What is lit: three models and a row of spheres on a round floor.

use bevy::{
    camera::Exposure, core_pipeline::tonemapping::Tonemapping, gltf::GltfAssetLabel, prelude::*,
};
use farlight::prelude::*;

use super::orbit::Orbit;

/// Radius of the floor in metres.
const FLOOR: f32 = 1.0;
/// Metres of cloth that its picture is; twice what was measured, so that the weave is seen.
const WEAVE: f32 = 0.024;

/// Where the camera begins.
pub const START: Orbit =
    Orbit { target: Vec3::new(0.0, 0.15, 0.05), distance: 1.7, yaw: 0.22, pitch: 0.2 };
/// From where the sky is seen, with its lights.
pub const SKY: Orbit =
    Orbit { target: Vec3::new(0.0, 0.62, 0.0), distance: 2.6, yaw: 0.22, pitch: 0.02 };

/// What is still being read.
#[derive(Resource)]
pub struct Loading(pub Vec<UntypedHandle>);

/// Makes the scene and the camera.
pub fn spawn(
    mut commands: Commands,
    server: Res<AssetServer>,
    mut meshes: ResMut<Assets<Mesh>>,
    mut materials: ResMut<Assets<StandardMaterial>>,
    mut cloths: ResMut<Assets<BtfMaterial>>,
) {
    let mut loading = Vec::new();
    let mut part = |model: &str, primitive| -> Handle<Mesh> {
        let label = GltfAssetLabel::Primitive { mesh: 0, primitive };
        let mesh = server.load(label.from_asset(format!("models/{model}.glb")));
        loading.push(mesh.clone().untyped());
        mesh
    };
    let mut surface = |color: Color, roughness: f32, metallic: f32| {
        MeshMaterial3d(materials.add(StandardMaterial {
            base_color: color,
            perceptual_roughness: roughness,
            metallic,
            ..default()
        }))
    };

    let stone = surface(Color::srgb(0.62, 0.60, 0.57), 0.75, 0.0);
    let floor = Cylinder::new(FLOOR, 0.06).mesh().resolution(128);
    commands.spawn((
        Mesh3d(meshes.add(floor)),
        stone.clone(),
        Transform::from_xyz(0.0, -0.03, 0.0),
    ));
    let plinth = meshes.add(Cylinder::new(0.22, 0.09).mesh().resolution(96));
    let chalk = surface(Color::srgb(0.72, 0.71, 0.69), 0.9, 0.0);
    let bead = surface(Color::srgb(0.01, 0.01, 0.01), 0.18, 0.0);

    // A rabbit of terracotta and a hippopotamus of glazed ceramic, each on a plinth.
    let clay = surface(Color::srgb(0.70, 0.34, 0.21), 0.6, 0.0);
    let glaze = surface(Color::srgb(0.04, 0.22, 0.24), 0.35, 0.0);
    for (model, look, place, turn) in [
        ("bunny", clay, Vec3::new(-0.46, 0.09, -0.06), 0.5_f32),
        ("hippo", glaze, Vec3::new(0.46, 0.09, -0.06), -0.1),
    ] {
        let below = Transform::from_translation(place - Vec3::Y * 0.045);
        commands.spawn((Mesh3d(plinth.clone()), chalk.clone(), below));
        let at = Transform::from_translation(place + Vec3::Y * 0.003)
            .with_rotation(Quat::from_rotation_y(turn));
        commands.spawn((Mesh3d(part(model, 0)), look, at));
        commands.spawn((Mesh3d(part(model, 1)), bead.clone(), at));
    }

    // Measured cloth over a ball between them.
    let weave = server.load("materials/cloth.fbtf");
    let cloth = BtfMaterial { repeat: Vec2::splat(1.0 / WEAVE), ..BtfMaterial::new(weave.clone()) };
    let at = Transform::from_xyz(0.0, 0.001, -0.22).with_rotation(Quat::from_rotation_y(0.5));
    commands.spawn((Mesh3d(part("drape", 0)), MeshMaterial3d(cloths.add(cloth)), at));
    commands.spawn((Mesh3d(part("drape", 1)), chalk, at));
    loading.push(weave.untyped());

    // Glossy to matte, gold in between.
    let ball = meshes.add(Sphere::new(0.07).mesh().uv(64, 32));
    let gold = Color::srgb(0.93, 0.72, 0.36);
    let white = Color::srgb(0.85, 0.85, 0.83);
    for (i, (color, roughness, metallic)) in [
        (white, 0.3, 0.0),
        (gold, 0.4, 1.0),
        (white, 0.5, 0.0),
        (gold, 0.6, 1.0),
        (white, 1.0, 0.0),
    ]
    .into_iter()
    .enumerate()
    {
        let x = (i as f32 - 2.0) * 0.19;
        let place = Vec3::new(x, 0.07, 0.42 - 0.25 * x * x);
        let look = surface(color, roughness, metallic);
        commands.spawn((Mesh3d(ball.clone()), look, Transform::from_translation(place)));
    }

    commands.spawn((
        ProgressiveCamera::default(),
        IsDefaultUiCamera,
        EnvironmentBackdrop::default(),
        START.transform(),
        START,
        Projection::Perspective(PerspectiveProjection {
            fov: 34_f32.to_radians(),
            near: 0.02,
            ..default()
        }),
        Exposure::default(),
        Tonemapping::TonyMcMapface,
    ));
    commands.insert_resource(Loading(loading));
}
