//! The sky behind skylight and window: what is seen of it, and what it lights.

use bevy::{
    asset::RenderAssetUsages,
    light::{CascadeShadowConfigBuilder, DirectionalLightShadowMap, Skybox},
    prelude::*,
    render::render_resource::{
        Extent3d, TextureDimension, TextureFormat, TextureViewDescriptor, TextureViewDimension,
    },
};
use farlight::prelude::*;

use super::settings::Gallery;

/// Lux of the sun, facing it: through thin haze.
const SUN: f32 = 14_000.0;
/// Edge of a face of the cube that is seen, in pixels.
const CUBE: u32 = 192;
/// Rows of the picture that lights; it is twice as wide.
const ROWS: u32 = 32;

/// The sun.
#[derive(Component)]
pub struct Sun;

/// The picture of the sky that cameras show.
#[derive(Resource, Clone)]
pub struct SkyPicture(pub Handle<Image>);

/// What cameras have for the sky.
pub fn skybox(picture: &SkyPicture) -> Skybox {
    Skybox { image: Some(picture.0.clone()), brightness: 1.0, ..default() }
}

/// Radiance of the sky in cd/m2 towards a direction, without the sun: deeper blue above, a pale band at
/// the horizon, brighter round the sun; below it hills in the haze, and a lawn.
pub fn radiance(towards: Vec3, to_sun: Vec3, sunlit: bool) -> Vec3 {
    let sun = if sunlit { to_sun.y.max(0.0) } else { 0.0 };
    let day = 0.35 + 0.65 * sun;
    let horizon = Vec3::new(0.90, 0.95, 1.0) * 3100.0;
    let turn = towards.x.atan2(-towards.z);
    let hill = |height: f32, waves: f32, phase: f32| {
        height * (1.0 + 0.45 * (waves * turn + phase).sin() + 0.25 * (2.7 * waves * turn).sin())
    };
    if towards.y < hill(0.035, 5.0, 0.7) {
        // Grass is darker close by, and hidden by the haze far away.
        let lawn = Vec3::new(0.16, 0.20, 0.085) * 3600.0;
        let trees = Vec3::new(0.105, 0.14, 0.10) * 3600.0;
        let near =
            if towards.y < 0.0 { trees.lerp(lawn, (-towards.y * 14.0).min(1.0)) } else { trees };
        let haze = (1.0 - towards.y.min(0.0).abs() * 6.0).clamp(0.0, 1.0);
        return near.lerp(horizon, 0.22 * haze) * day;
    }
    if towards.y < hill(0.075, 3.0, 2.1) {
        return Vec3::new(0.22, 0.29, 0.33).lerp(Vec3::ONE, 0.3) * 2600.0 * day;
    }
    let zenith = Vec3::new(0.34, 0.56, 1.0) * 1700.0;
    let height = towards.y.max(0.0).sqrt();
    let near_sun = towards.dot(to_sun).max(0.0).powf(6.0) * sun;
    let glow = Vec3::new(1.0, 0.86, 0.66) * 2200.0 * near_sun;
    (horizon.lerp(zenith, height) + glow) * day
}

/// Makes the sun and the pictures' places.
pub fn spawn(mut commands: Commands, mut images: ResMut<Assets<Image>>) {
    let picture = images.add(cube(&Gallery::default()));
    commands.insert_resource(SkyPicture(picture));
    commands.insert_resource(DirectionalLightShadowMap { size: 2048 });
    commands.spawn((
        Sun,
        DirectionalLight { shadow_maps_enabled: true, illuminance: SUN, ..default() },
        CascadeShadowConfigBuilder {
            num_cascades: 2,
            minimum_distance: 0.1,
            first_cascade_far_bound: 5.0,
            maximum_distance: 24.0,
            overlap_proportion: 0.2,
        }
        .build(),
        Transform::default(),
    ));
}

/// Sun and sky follow the settings.
pub fn update(
    gallery: Res<Gallery>,
    mut suns: Query<(&mut Transform, &mut DirectionalLight), With<Sun>>,
    picture: Option<Res<SkyPicture>>,
    mut images: ResMut<Assets<Image>>,
    mut sky: ResMut<SkySource>,
    mut shown: Local<Option<[f32; 3]>>,
) {
    let Some(picture) = picture else { return };
    let wanted = [gallery.sun_height, gallery.sun_direction, f32::from(u8::from(gallery.sun))];
    if *shown == Some(wanted) {
        return;
    }
    *shown = Some(wanted);
    let to_sun = gallery.to_sun();
    for (mut transform, mut light) in &mut suns {
        *transform = Transform::default().looking_to(-to_sun, Vec3::Y);
        let low = (to_sun.y * 3.0).clamp(0.0, 1.0);
        light.color = Color::linear_rgb(1.0, 0.74 + 0.20 * low, 0.48 + 0.38 * low);
        light.illuminance = if gallery.sun { SUN * low } else { 0.0 };
    }
    if let Some(mut image) = images.get_mut(&picture.0) {
        *image = cube(&gallery);
    }
    let image = images.add(equirect(&gallery));
    *sky = SkySource::equirect(image, Quat::IDENTITY, 1.0);
}

fn half(value: f32) -> [u8; 2] {
    half::f16::from_f32(value).to_le_bytes()
}

/// Six faces, as cube maps have them.
fn cube(gallery: &Gallery) -> Image {
    let to_sun = gallery.to_sun();
    let mut data = Vec::with_capacity((6 * CUBE * CUBE * 8) as usize);
    // Right, up and forward of each face; cube maps are left-handed, Bevy mirrors z.
    let faces = [
        (Vec3::NEG_Z, Vec3::Y, Vec3::X),
        (Vec3::Z, Vec3::Y, Vec3::NEG_X),
        (Vec3::X, Vec3::NEG_Z, Vec3::Y),
        (Vec3::X, Vec3::Z, Vec3::NEG_Y),
        (Vec3::X, Vec3::Y, Vec3::Z),
        (Vec3::NEG_X, Vec3::Y, Vec3::NEG_Z),
    ];
    for (right, up, forward) in faces {
        for y in 0..CUBE {
            for x in 0..CUBE {
                let part = |i: u32| (i as f32 + 0.5) / CUBE as f32 * 2.0 - 1.0;
                let towards = (forward + right * part(x) - up * part(y)).normalize();
                let towards = towards * Vec3::new(1.0, 1.0, -1.0);
                let light = radiance(towards, to_sun, gallery.sun);
                for value in light.to_array().into_iter().chain([1.0]) {
                    data.extend(half(value));
                }
            }
        }
    }
    let size = Extent3d { width: CUBE, height: CUBE, depth_or_array_layers: 6 };
    let mut image = Image::new(
        size,
        TextureDimension::D2,
        data,
        TextureFormat::Rgba16Float,
        RenderAssetUsages::RENDER_WORLD,
    );
    image.texture_view_descriptor =
        Some(TextureViewDescriptor { dimension: Some(TextureViewDimension::Cube), ..default() });
    image
}

/// The same for solvers: `u = 0.5 + atan2(x, -z) / 2 pi`, `v = acos(y) / pi`.
fn equirect(gallery: &Gallery) -> Image {
    use std::f32::consts::{PI, TAU};
    let to_sun = gallery.to_sun();
    let mut data = Vec::new();
    for row in 0..ROWS {
        for column in 0..2 * ROWS {
            let azimuth = ((column as f32 + 0.5) / (2 * ROWS) as f32 - 0.5) * TAU;
            let polar = (row as f32 + 0.5) / ROWS as f32 * PI;
            let flat = Vec3::new(azimuth.sin(), 0.0, -azimuth.cos());
            let towards = flat * polar.sin() + Vec3::Y * polar.cos();
            for value in radiance(towards, to_sun, gallery.sun).to_array().into_iter().chain([1.0])
            {
                data.extend(value.to_le_bytes());
            }
        }
    }
    let size = Extent3d { width: 2 * ROWS, height: ROWS, depth_or_array_layers: 1 };
    Image::new(
        size,
        TextureDimension::D2,
        data,
        TextureFormat::Rgba32Float,
        RenderAssetUsages::MAIN_WORLD | RenderAssetUsages::RENDER_WORLD,
    )
}
