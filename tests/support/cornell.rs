//! A small box with coloured walls and two blocks, made in code: the fixed scene of picture tests.

use bevy::prelude::*;

/// The root of the box; tag its entity to light it indirectly.
#[derive(Component)]
pub struct CornellRoot;

/// Half the edge of the box in metres.
pub const HALF: f32 = 1.0;

/// Spawns five walls (open towards +z), two blocks, a point light and a camera.
pub fn spawn(
    mut commands: Commands,
    mut meshes: ResMut<Assets<Mesh>>,
    mut materials: ResMut<Assets<StandardMaterial>>,
) {
    let mut matte = |r: f32, g: f32, b: f32| {
        materials.add(StandardMaterial {
            base_color: Color::linear_rgb(r, g, b),
            perceptual_roughness: 1.0,
            reflectance: 0.0,
            ..default()
        })
    };
    let (white, red, green) =
        (matte(0.73, 0.73, 0.73), matte(0.65, 0.06, 0.05), matte(0.12, 0.45, 0.09));
    let wall = meshes.add(Cuboid::new(2.0 * HALF, 0.1, 2.0 * HALF));
    let walls = [
        (Vec3::NEG_Y, &white),
        (Vec3::Y, &white),
        (Vec3::NEG_Z, &white),
        (Vec3::NEG_X, &red),
        (Vec3::X, &green),
    ];
    let blocks = [
        (Vec3::new(-0.35, -0.4, -0.3), Vec3::new(0.6, 1.2, 0.6), 0.3),
        (Vec3::new(0.35, -0.7, 0.25), Vec3::splat(0.6), -0.3),
    ];
    commands
        .spawn((CornellRoot, Name::new("Cornell"), Transform::default(), Visibility::default()))
        .with_children(|parent| {
            for (outward, material) in walls {
                parent.spawn((
                    Mesh3d(wall.clone()),
                    MeshMaterial3d(material.clone()),
                    Transform::from_translation(outward * (HALF + 0.05))
                        .with_rotation(Quat::from_rotation_arc(Vec3::Y, -outward)),
                ));
            }
            for (centre, size, angle) in blocks {
                parent.spawn((
                    Mesh3d(meshes.add(Cuboid::from_size(size))),
                    MeshMaterial3d(white.clone()),
                    Transform::from_translation(centre).with_rotation(Quat::from_rotation_y(angle)),
                ));
            }
        });
    commands.spawn((
        PointLight { intensity: 12_000.0, shadow_maps_enabled: true, radius: 0.0, ..default() },
        Transform::from_xyz(0.0, 0.75, 0.1),
    ));
    commands.spawn((
        Camera3d::default(),
        Msaa::Off,
        Transform::from_xyz(0.0, 0.0, 3.6).looking_at(Vec3::ZERO, Vec3::Y),
    ));
}
