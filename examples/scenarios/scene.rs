//! The room, the camera, and a ball that rolls.

use bevy::{camera::Exposure, core_pipeline::tonemapping::Tonemapping, prelude::*};
use farlight::prelude::*;

use super::{day::Day, walk::Walker};

/// What `farlight bake` made of `assets/scenes/study.glb`.
const ROOM: &str = "baked/study/study.baked.ron";

/// Radius of the ball in metres.
const RADIUS: f32 = 0.17;

/// The ball, which has no lightmap.
#[derive(Component)]
pub struct Ball;

/// Makes everything.
pub fn spawn(
    mut commands: Commands,
    mut meshes: ResMut<Assets<Mesh>>,
    mut materials: ResMut<Assets<StandardMaterial>>,
) {
    commands.spawn(BakedScene(ROOM.into()));
    commands.spawn((
        Ball,
        Mesh3d(meshes.add(Sphere::new(RADIUS).mesh().uv(48, 24))),
        MeshMaterial3d(materials.add(StandardMaterial {
            base_color: Color::srgb(0.9, 0.9, 0.88),
            perceptual_roughness: 0.7,
            ..default()
        })),
        Transform::default(),
    ));
    let eye =
        Transform::from_xyz(2.25, 1.55, 1.75).looking_at(Vec3::new(-0.7, 0.85, -1.0), Vec3::Y);
    commands.spawn((
        Camera3d::default(),
        Projection::from(PerspectiveProjection {
            fov: 60.0_f32.to_radians(),
            near: 0.05,
            ..default()
        }),
        Exposure::default(),
        Tonemapping::TonyMcMapface,
        Msaa::Sample4,
        Walker::from(&eye),
        eye,
    ));
}

/// Blends the scenarios of the hour. Where nothing changes, nothing is blended.
pub fn light(day: Res<Day>, mut lighting: Query<&mut BakedLighting>) {
    let weights = day.weights();
    for mut lighting in &mut lighting {
        if lighting.scenarios != weights {
            lighting.scenarios = weights.clone();
        }
    }
}

/// The camera's exposure, and the sky behind the window as bright as the camera sees it.
pub fn expose(
    day: Res<Day>,
    lighting: Query<&BakedLighting>,
    manifests: Res<Assets<BakedManifest>>,
    mut cameras: Query<&mut Exposure>,
    mut clear: ResMut<ClearColor>,
) {
    let exposure = Exposure { ev100: day.ev100() };
    cameras.iter_mut().for_each(|mut camera| *camera = exposure);
    let Ok(lighting) = lighting.single() else { return };
    let Some(manifest) = manifests.get(&lighting.manifest) else { return };
    let sky: Vec3 = lighting
        .scenarios
        .iter()
        .filter_map(|(name, weight)| Some(Vec3::from(manifest.scenario(name)?.sky) * weight))
        .sum();
    let sky = sky * exposure.exposure();
    clear.0 = Color::linear_rgb(sky.x, sky.y, sky.z);
}

/// Rolls the ball over the rug; where it is follows from the hour, so that pictures are always the same.
pub fn roll(day: Res<Day>, mut balls: Query<&mut Transform, With<Ball>>) {
    let angle = day.hour * 0.9;
    for mut ball in &mut balls {
        ball.translation =
            Vec3::new(0.9 * angle.cos() + 0.05, RADIUS + 0.014, 0.5 * angle.sin() + 0.2);
    }
}
