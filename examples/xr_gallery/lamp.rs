//! The paper lantern: it hangs where it is put, and the light of all rooms follows.

use bevy::{
    light::{NotShadowCaster, PointLightShadowMap},
    prelude::*,
};
use farlight::prelude::*;

use super::{grab::Grabbable, settings::Gallery};

/// Where it is at first: in the red room, before the red wall.
pub const HOME: Vec3 = Vec3::new(7.05, 1.75, -1.5);
/// Radius of the paper in metres.
const RADIUS: f32 = 0.11;

/// The lantern.
#[derive(Component)]
pub struct Lamp;

/// Its paper.
#[derive(Component)]
struct Paper;

/// Systems of the lantern.
pub fn plugin(app: &mut App) {
    app.insert_resource(PointLightShadowMap { size: 1024 })
        .add_systems(Startup, spawn)
        .add_systems(Update, update);
}

fn spawn(
    mut commands: Commands,
    mut meshes: ResMut<Assets<Mesh>>,
    mut materials: ResMut<Assets<StandardMaterial>>,
) {
    let paper = materials.add(StandardMaterial {
        base_color: Color::BLACK,
        reflectance: 0.0,
        perceptual_roughness: 1.0,
        ..default()
    });
    let wood = materials.add(StandardMaterial {
        base_color: Color::linear_rgb(0.12, 0.08, 0.05),
        perceptual_roughness: 0.6,
        ..default()
    });
    let light = PointLight {
        range: 20.0,
        radius: 0.0,
        shadow_maps_enabled: true,
        shadow_depth_bias: 0.03,
        ..default()
    };
    let mesh = meshes.add(Sphere::new(RADIUS).mesh().uv(48, 24));
    let cap = meshes.add(Cylinder::new(0.035, 0.02).mesh().resolution(32));
    commands
        .spawn((
            Lamp,
            Name::new("lantern"),
            GiDynamic,
            light,
            Grabbable { reach: 0.2, half: RADIUS, floats: true },
            Transform::from_translation(HOME),
            Visibility::default(),
        ))
        .with_children(|lamp| {
            lamp.spawn((Paper, Mesh3d(mesh), MeshMaterial3d(paper), NotShadowCaster));
            for y in [-1.0, 1.0] {
                lamp.spawn((
                    Mesh3d(cap.clone()),
                    MeshMaterial3d(wood.clone()),
                    Transform::from_xyz(0.0, y * (RADIUS - 0.005), 0.0),
                    NotShadowCaster,
                ));
            }
        });
}

/// Linear colour of a glowing body of a temperature in kelvin, its largest part 1; between 1500 and
/// 12000 K. After Krystek, "An algorithm to calculate correlated colour temperature", 1985.
pub fn glow(kelvin: f32) -> Vec3 {
    let t = kelvin.clamp(1500.0, 12_000.0);
    let u = (0.860_117_76 + 1.541_182_5e-4 * t + 1.286_412e-7 * t * t)
        / (1.0 + 8.424_202_4e-4 * t + 7.081_451_6e-7 * t * t);
    let v = (0.317_398_72 + 4.228_062_5e-5 * t + 4.204_816_7e-8 * t * t)
        / (1.0 - 2.897_418_2e-5 * t + 1.614_560_5e-7 * t * t);
    let (x, y) = (3.0 * u / (2.0 * u - 8.0 * v + 4.0), 2.0 * v / (2.0 * u - 8.0 * v + 4.0));
    let xyz = Vec3::new(x / y, 1.0, (1.0 - x - y) / y);
    let rgb = Vec3::new(
        xyz.dot(Vec3::new(3.2406, -1.5372, -0.4986)),
        xyz.dot(Vec3::new(-0.9689, 1.8758, 0.0415)),
        xyz.dot(Vec3::new(0.0557, -0.2040, 1.0570)),
    );
    let rgb = rgb.max(Vec3::ZERO);
    rgb / rgb.max_element()
}

/// Light and paper follow the settings.
fn update(
    gallery: Res<Gallery>,
    mut lamps: Query<&mut PointLight, With<Lamp>>,
    papers: Query<&MeshMaterial3d<StandardMaterial>, With<Paper>>,
    mut materials: ResMut<Assets<StandardMaterial>>,
) {
    if !gallery.is_changed() {
        return;
    }
    let power = if gallery.lamp { gallery.lamp_power } else { 0.0 };
    let colour = glow(gallery.lamp_colour);
    let linear = Color::linear_rgb(colour.x, colour.y, colour.z);
    for mut light in &mut lamps {
        if light.intensity != power || light.color != linear {
            (light.intensity, light.color) = (power, linear);
        }
    }
    for paper in &papers {
        if let Some(mut material) = materials.get_mut(&paper.0) {
            // As bright as it would have to be for its light: luminous flux by area and by pi. The paper's
            // emissive value counts in cd/m2 here.
            let area = 4.0 * std::f32::consts::PI * RADIUS * RADIUS;
            let radiance = colour * (power / area / std::f32::consts::PI * 0.25);
            material.emissive = LinearRgba::rgb(radiance.x, radiance.y, radiance.z);
            material.emissive_exposure_weight = 1.0;
        }
    }
}
