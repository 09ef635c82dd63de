//! What the gallery shows: models in measured cloth and in plaster, and small things to take in hand.
//! All of it is lit by probes, since light on small things is soft anyway, and some of them move.

use bevy::{gltf::GltfMaterialName, prelude::*};
use farlight::prelude::*;

use super::{
    grab::Grabbable,
    plan::{ROUND, STANDS, TABLE},
    settings::Gallery,
};

/// Edge of the cloth's picture as shown, in metres: four times as large as it was measured, so that
/// yarns are seen from where people stand.
const CLOTH: f32 = 0.048;

/// A model that wears the measured cloth on its surfaces called `btf`, if it is not plain.
#[derive(Component)]
pub struct Exhibit {
    scale: f32,
    cloth: bool,
}

/// Turns with [`Gallery::turning`].
#[derive(Component)]
pub struct Turning;

/// Its parts have been looked at.
#[derive(Component)]
struct Dressed;

/// The measured cloth.
#[derive(Resource, Clone)]
pub struct Cloth(Handle<BtfAsset>);

impl Cloth {
    fn material(&self, uv_metres: Vec2) -> BtfMaterial {
        BtfMaterial { repeat: uv_metres / CLOTH, ..BtfMaterial::new(self.0.clone()) }
    }
}

/// Systems of the exhibits.
pub fn plugin(app: &mut App) {
    app.add_systems(Startup, spawn).add_systems(Update, (dress, turn));
}

fn spawn(
    mut commands: Commands,
    server: Res<AssetServer>,
    mut meshes: ResMut<Assets<Mesh>>,
    mut materials: ResMut<Assets<StandardMaterial>>,
    mut cloths: ResMut<Assets<BtfMaterial>>,
) {
    let cloth = Cloth(server.load("materials/cloth.fbtf"));
    let mut model = |file: &'static str, stand: usize, scale: f32, turn: f32, cloth: bool| {
        let scene = server.load(GltfAssetLabel::Scene(0).from_asset(file));
        let place = Transform::from_translation(STANDS[stand].top())
            .with_rotation(Quat::from_rotation_y(turn.to_radians()))
            .with_scale(Vec3::splat(scale));
        let exhibit = Exhibit { scale, cloth };
        commands.spawn((Name::new(file), exhibit, GiDynamic, WorldAssetRoot(scene), place)).id()
    };
    let hippo = model("models/hippo.glb", ROUND, 2.4, 35.0, true);
    model("models/bunny.glb", 1, 1.9, 25.0, true);
    model("models/drape.glb", 7, 1.05, 20.0, true);
    model("models/bunny.glb", 4, 1.7, 20.0, false);
    commands.entity(hippo).insert(Turning);

    let mut sphere = |radius: f32| {
        let mesh = Sphere::new(radius).mesh().uv(96, 48);
        let upright = Quat::from_rotation_x(-std::f32::consts::FRAC_PI_2);
        let mut mesh = mesh.rotated_by(upright);
        let _ = mesh.generate_tangents();
        meshes.add(mesh)
    };
    let radius = 0.24;
    let around = std::f32::consts::TAU * radius;
    let worn = cloths.add(cloth.material(Vec2::new(around, 0.5 * around)));
    for stand in [2, 8] {
        commands.spawn((
            Name::new("sphere"),
            GiDynamic,
            Mesh3d(sphere(radius)),
            MeshMaterial3d(worn.clone()),
            Transform::from_translation(STANDS[stand].top() + Vec3::Y * radius),
        ));
    }
    let mut glaze = |r: f32, g: f32, b: f32, roughness: f32| {
        materials.add(StandardMaterial {
            base_color: Color::linear_rgb(r, g, b),
            perceptual_roughness: roughness,
            ..default()
        })
    };
    let radius = 0.21;
    commands.spawn((
        Name::new("porcelain"),
        GiDynamic,
        Mesh3d(sphere(radius)),
        MeshMaterial3d(glaze(0.78, 0.77, 0.74, 0.28)),
        Transform::from_translation(STANDS[5].top() + Vec3::Y * radius),
    ));
    // Small things on the table, to be taken in hand.
    let table = STANDS[TABLE].top();
    let ball = (sphere(0.06), glaze(0.03, 0.14, 0.16, 0.3), 0.06, Vec2::new(-0.42, 0.05));
    let cube: (Handle<Mesh>, _, _, _) = (
        meshes.add(Cuboid::from_length(0.1)),
        glaze(0.55, 0.38, 0.2, 0.6),
        0.05,
        Vec2::new(-0.12, -0.1),
    );
    let cone = Cone { radius: 0.06, height: 0.14 }.mesh().resolution(48).build();
    let cone = (meshes.add(cone), glaze(0.72, 0.70, 0.66, 0.5), 0.07, Vec2::new(0.12, 0.1));
    let tall = Cylinder::new(0.045, 0.12).mesh().resolution(48).build();
    let tall = (meshes.add(tall), glaze(0.5, 0.1, 0.05, 0.4), 0.06, Vec2::new(0.42, -0.04));
    for (mesh, material, half, at) in [ball, cube, cone, tall] {
        commands.spawn((
            Name::new("small thing"),
            GiDynamic,
            Grabbable { reach: half * 1.5, half, floats: false },
            Mesh3d(mesh),
            MeshMaterial3d(material),
            Transform::from_translation(table + Vec3::new(at.x, half, at.y)),
        ));
    }
    commands.insert_resource(cloth);
}

/// Dresses the parts of models that have arrived.
fn dress(
    mut commands: Commands,
    cloth: Option<Res<Cloth>>,
    exhibits: Query<(Entity, &Exhibit), Without<Dressed>>,
    children: Query<&Children>,
    parts: Query<&GltfMaterialName, With<Mesh3d>>,
    mut cloths: ResMut<Assets<BtfMaterial>>,
    mut materials: ResMut<Assets<StandardMaterial>>,
) {
    let Some(cloth) = cloth else { return };
    for (root, exhibit) in &exhibits {
        let mut found = false;
        for part in children.iter_descendants(root) {
            let Ok(name) = parts.get(part) else { continue };
            found = true;
            if name.0 != "btf" {
                continue;
            }
            if exhibit.cloth {
                let worn = cloths.add(cloth.material(Vec2::splat(exhibit.scale)));
                commands
                    .entity(part)
                    .remove::<MeshMaterial3d<StandardMaterial>>()
                    .insert(MeshMaterial3d(worn));
            } else {
                let plaster = StandardMaterial {
                    base_color: Color::linear_rgb(0.76, 0.74, 0.70),
                    perceptual_roughness: 0.8,
                    ..default()
                };
                commands.entity(part).insert(MeshMaterial3d(materials.add(plaster)));
            }
        }
        if found {
            commands.entity(root).insert(Dressed);
        }
    }
}

/// Whether all models are there and dressed.
pub fn complete(world: &mut World) -> bool {
    let mut waiting = world.query_filtered::<(), (With<Exhibit>, Without<Dressed>)>();
    let cloth = world.get_resource::<Cloth>().map(|cloth| cloth.0.clone());
    let read = cloth.is_some_and(|cloth| world.resource::<Assets<BtfAsset>>().contains(&cloth));
    let status = world.resource::<farlight::btf::BtfStatus>();
    read && status.waiting == 0 && waiting.iter(world).next().is_none()
}

fn turn(time: Res<Time>, gallery: Res<Gallery>, mut turning: Query<&mut Transform, With<Turning>>) {
    if gallery.turning {
        for mut transform in &mut turning {
            transform.rotate_y((12.0 * time.delta_secs()).to_radians());
        }
    }
}
