//! The rooms and what stands on the floor, as static meshes that take part in the indirect light.

use bevy::prelude::*;
use farlight::prelude::*;

use super::{
    building::Surface,
    plan::{BARS, DOORS, Floor, HALL, Look, OPENINGS, RED, SPACES, STANDS, Stand, WINDOW},
    textures,
};

/// The root of all that stands still.
#[derive(Component)]
pub struct Rooms;

/// What surfaces are made of.
struct Paints {
    oak: Handle<StandardMaterial>,
    ceiling: Handle<StandardMaterial>,
    white: Handle<StandardMaterial>,
    warm: Handle<StandardMaterial>,
    red: Handle<StandardMaterial>,
    blue: Handle<StandardMaterial>,
    furniture: Handle<StandardMaterial>,
    bars: Handle<StandardMaterial>,
}

impl Paints {
    fn new(materials: &mut Assets<StandardMaterial>, images: &mut Assets<Image>) -> Self {
        let mut paint = |r: f32, g: f32, b: f32, roughness: f32| {
            materials.add(StandardMaterial {
                base_color: Color::linear_rgb(r, g, b),
                perceptual_roughness: roughness,
                reflectance: 0.35,
                ..default()
            })
        };
        Self {
            ceiling: paint(0.82, 0.82, 0.81, 0.95),
            white: paint(0.74, 0.735, 0.715, 0.9),
            warm: paint(0.68, 0.655, 0.61, 0.9),
            red: paint(0.52, 0.058, 0.035, 0.85),
            blue: paint(0.075, 0.20, 0.245, 0.85),
            bars: paint(0.10, 0.10, 0.105, 0.6),
            furniture: paint(0.34, 0.20, 0.10, 0.6),
            oak: materials.add(StandardMaterial {
                base_color_texture: Some(images.add(textures::planks())),
                perceptual_roughness: 0.62,
                reflectance: 0.35,
                uv_transform: bevy::math::Affine2::from_scale(Vec2::splat(1.0 / textures::PLANKS)),
                ..default()
            }),
        }
    }

    /// What a surface of the building is painted with.
    fn of(&self, surface: &Surface) -> Handle<StandardMaterial> {
        let normal = surface.normal;
        let north = normal.z > 0.5 && surface.at < -2.5;
        let paint = match surface.space {
            HALL | RED | WINDOW | DOORS if normal.y > 0.5 => &self.oak,
            HALL | RED | WINDOW if normal.y < -0.5 => &self.ceiling,
            RED if north => &self.red,
            RED => &self.warm,
            WINDOW if north => &self.blue,
            OPENINGS => &self.ceiling,
            _ => &self.white,
        };
        paint.clone()
    }
}

/// Makes them, and the probes that light what moves.
pub fn spawn(
    mut commands: Commands,
    floor: Res<Floor>,
    mut meshes: ResMut<Assets<Mesh>>,
    mut materials: ResMut<Assets<StandardMaterial>>,
    mut images: ResMut<Assets<Image>>,
) {
    let paints = Paints::new(&mut materials, &mut images);
    let still = (Transform::default(), Visibility::default());
    let root = commands.spawn((Rooms, GiScene, Name::new("rooms"), still)).id();
    for surface in floor.building.surfaces() {
        let paint = MeshMaterial3d(paints.of(&surface));
        commands.spawn((Mesh3d(meshes.add(surface.mesh)), paint, ChildOf(root)));
    }
    // It keeps the sun out, and nobody sees it: no part of the indirect light.
    commands.spawn((
        Name::new("shell"),
        Mesh3d(meshes.add(floor.building.shell())),
        MeshMaterial3d(paints.white.clone()),
    ));
    for stand in STANDS {
        let paint = match stand.look {
            Look::White => &paints.white,
            Look::Oak => &paints.furniture,
        };
        for (mesh, middle) in parts(stand) {
            commands.spawn((
                Mesh3d(meshes.add(mesh)),
                MeshMaterial3d(paint.clone()),
                Transform::from_translation(stand.place + middle),
                ChildOf(root),
            ));
        }
    }
    for bar in BARS {
        commands.spawn((
            Mesh3d(meshes.add(Cuboid::from_size(bar.max - bar.min))),
            MeshMaterial3d(paints.bars.clone()),
            Transform::from_translation(bar.min.midpoint(bar.max)),
            ChildOf(root),
        ));
    }
    for (space, room) in SPACES.iter().filter(|(space, _)| matches!(*space, HALL | RED | WINDOW)) {
        // Half of the doors' depth belongs to either room; no probe is in a wall.
        let deeper = Vec3::X * 0.2;
        let size = room.max - room.min + 2.0 * deeper;
        let resolution = (size / Vec3::new(0.6, 0.6, 0.6)).round().as_uvec3();
        commands.spawn((
            Name::new(format!("probes {}", space.0)),
            GiProbeVolume { resolution },
            Transform::from_translation(room.min.midpoint(room.max)).with_scale(size),
        ));
    }
}

/// What something that stands on the floor is made of, from the middle of its foot: plinths are
/// massive, tables and benches have a top and two sides.
fn parts(stand: &Stand) -> Vec<(Mesh, Vec3)> {
    let Stand { size, height, .. } = *stand;
    let middle = Vec3::Y * (0.5 * height);
    match stand.look {
        Look::White if stand.round => {
            let mesh = Cylinder::new(0.5 * size.x, height).mesh().resolution(64).build();
            vec![(mesh, middle)]
        }
        Look::White => vec![(Cuboid::new(size.x, height, size.y).into(), middle)],
        Look::Oak => {
            const THICK: f32 = 0.045;
            let top = Cuboid::new(size.x, THICK, size.y);
            let leg = height - THICK;
            // The sides stand at the ends of the longer edge, a little in from them.
            let (side, along) = if size.x > size.y {
                (Cuboid::new(THICK, leg, size.y - 0.08), Vec3::X)
            } else {
                (Cuboid::new(size.x - 0.08, leg, THICK), Vec3::Z)
            };
            let out = along * (0.5 * size.max_element() - 0.12);
            let foot = Vec3::Y * (0.5 * leg);
            vec![
                (top.into(), Vec3::Y * (height - 0.5 * THICK)),
                (side.into(), foot + out),
                (side.into(), foot - out),
            ]
        }
    }
}
