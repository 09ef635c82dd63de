//! What is in the scene: two rooms from a file, a lamp, a ball, a camera.
//!
//! Coordinates in metres, as `assets/scenes/README.md` has them: the bright room lies at x < 0, the
//! dark one at x > 0, the doorway between them at z = 0.15 to 1.05.

use bevy::{
    camera::Exposure,
    core_pipeline::tonemapping::Tonemapping,
    light::{NotShadowCaster, PointLightShadowMap},
    prelude::*,
    render::renderer::RenderAdapterInfo,
};
use farlight::prelude::*;

use super::{
    motion::{ClosedPath, Traveller},
    orbit::Orbit,
};

/// The file with the two rooms.
pub const ROOMS: &str = "scenes/doorway.glb";
/// Luminous power of the lamp in lumens.
pub const LAMP_LUMENS: f32 = 2_000.0;
/// Speed of the lamp in metres a second.
pub const LAMP_SPEED: f32 = 0.5;
/// Speed of the ball in metres a second.
pub const BALL_SPEED: f32 = 0.6;
/// Radius of the ball in metres.
pub const BALL_RADIUS: f32 = 0.16;

/// Where the lamp is in the pictures, as a fraction of its round.
pub const PICTURE_LAMP: f32 = 0.95;
/// Where the ball is in the pictures.
pub const PICTURE_BALL: f32 = 0.46;
/// Corners of the box of probes.
const PROBES: [Vec3; 2] = [Vec3::new(-5.0, 0.1, -2.4), Vec3::new(5.0, 2.9, 2.4)];

/// The light that moves.
#[derive(Component)]
pub struct Lamp;

/// The ball that moves, lit by probes.
#[derive(Component)]
pub struct Ball;

/// The lamp's round: in the bright room, past the doorway.
pub fn lamp_path() -> ClosedPath {
    ClosedPath::ellipse(Vec3::new(-2.0, 2.25, 0.5), 1.4, 1.1)
}

/// The ball's way through the doorway and back.
pub fn ball_path() -> ClosedPath {
    ClosedPath::back_and_forth(&[
        Vec3::new(-1.9, 0.9, 0.6),
        Vec3::new(0.6, 0.9, 0.6),
        Vec3::new(2.6, 0.9, 0.9),
    ])
}

/// Size of the shadow map's sides in pixels.
pub fn shadow_map() -> PointLightShadowMap {
    PointLightShadowMap { size: 512 }
}

/// Leaves multisampling to graphics processors: drawing on the CPU it would halve the frame rate.
pub fn smooth_edges(adapter: Option<Res<RenderAdapterInfo>>, mut cameras: Query<&mut Msaa>) {
    let drawn_on_cpu = adapter.is_some_and(|info| format!("{:?}", info.device_type) == "Cpu");
    if drawn_on_cpu {
        cameras.iter_mut().for_each(|mut camera| *camera = Msaa::Off);
    }
}

/// Makes everything.
pub fn spawn(
    mut commands: Commands,
    assets: Res<AssetServer>,
    mut meshes: ResMut<Assets<Mesh>>,
    mut materials: ResMut<Assets<StandardMaterial>>,
) {
    commands
        .spawn((GiScene, WorldAssetRoot(assets.load(GltfAssetLabel::Scene(0).from_asset(ROOMS)))));
    let lamp = lamp_path();
    let start = Transform::from_translation(lamp.at(0.0));
    commands
        .spawn((
            Lamp,
            PointLight {
                color: Color::srgb(1.0, 0.86, 0.68),
                intensity: LAMP_LUMENS,
                range: 20.0,
                radius: 0.0,
                shadow_maps_enabled: true,
                ..default()
            },
            start,
            Traveller::new(lamp, LAMP_SPEED, 0.0),
        ))
        .with_child((
            Mesh3d(meshes.add(Sphere::new(0.05))),
            MeshMaterial3d(materials.add(StandardMaterial {
                base_color: Color::BLACK,
                emissive: LinearRgba::rgb(40.0, 34.0, 26.0),
                ..default()
            })),
            NotShadowCaster,
        ));
    let ball = ball_path();
    commands.spawn((
        Ball,
        GiDynamic,
        Mesh3d(meshes.add(Sphere::new(BALL_RADIUS).mesh().uv(48, 24))),
        MeshMaterial3d(materials.add(StandardMaterial {
            base_color: Color::srgb(0.9, 0.9, 0.88),
            perceptual_roughness: 0.6,
            ..default()
        })),
        Transform::from_translation(ball.at(0.0)),
        Traveller::new(ball, BALL_SPEED, 0.0),
    ));
    commands.spawn((
        GiProbeVolume { resolution: UVec3::new(20, 6, 10) },
        Transform::from_translation(PROBES[0].midpoint(PROBES[1]))
            .with_scale(PROBES[1] - PROBES[0]),
    ));
    // At eye height in the dark room's far corner: what is not in the lamp's beam is lit indirectly,
    // and the bright room is seen through the doorway.
    let orbit = Orbit { target: Vec3::new(0.8, 1.1, 0.95), distance: 4.1, yaw: 2.06, pitch: 0.12 };
    commands.spawn((
        Camera3d::default(),
        Projection::Perspective(PerspectiveProjection { fov: 56.0_f32.to_radians(), ..default() }),
        orbit.transform(),
        orbit,
        Exposure { ev100: 0.6 },
        Tonemapping::TonyMcMapface,
        Msaa::Sample4,
    ));
}
