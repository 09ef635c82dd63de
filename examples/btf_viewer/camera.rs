//! The camera; in a window it draws into an image of its own, whose resolution can be chosen.

use std::path::PathBuf;

use bevy::{
    camera::{Exposure, Hdr, RenderTarget},
    core_pipeline::tonemapping::Tonemapping,
    prelude::*,
    render::{
        render_resource::{Extent3d, TextureFormat},
        renderer::RenderAdapterInfo,
        view::screenshot::{Screenshot, save_to_disk},
    },
    window::PrimaryWindow,
};

use farlight::prelude::*;

use super::{
    config::Viewer,
    orbit::Orbit,
    state::{Config, Problems, Shown},
};

/// The picture of the scene that the window shows.
#[derive(Resource)]
pub struct Canvas(Handle<Image>);

/// Where the configuration wants the camera.
pub fn orbit(config: &Viewer) -> Orbit {
    let place = Vec3::from(config.camera.position);
    let distance = place.length().max(0.2);
    let pitch = (place.y / distance).clamp(-1.0, 1.0).asin();
    Orbit { target: Vec3::ZERO, distance, yaw: place.x.atan2(place.z), pitch }
}

/// Makes the camera.
pub fn spawn(mut commands: Commands, config: Res<Config>, adapter: Option<Res<RenderAdapterInfo>>) {
    let orbit = orbit(&config.0);
    // Multisampling is left to graphics processors when a frame has to be fast.
    let on_cpu = adapter.is_some_and(|info| format!("{:?}", info.device_type) == "Cpu");
    commands.spawn((
        Camera3d::default(),
        Hdr,
        orbit.transform(),
        orbit,
        Exposure { ev100: config.0.exposure },
        Tonemapping::TonyMcMapface,
        if on_cpu { Msaa::Off } else { Msaa::Sample4 },
    ));
}

/// Keeps exposure, field of view and background as they should be.
pub fn tune(
    config: Res<Config>,
    shown: Res<Shown>,
    mut clear: ResMut<ClearColor>,
    mut cameras: Query<(&mut Exposure, &mut Projection)>,
) {
    if !config.is_changed() && !shown.is_changed() {
        return;
    }
    let (red, green, blue) = config.0.background;
    clear.0 = Color::srgb_u8(red, green, blue);
    for (mut exposure, mut projection) in &mut cameras {
        exposure.ev100 = shown.exposure;
        if let Projection::Perspective(perspective) = &mut *projection {
            perspective.fov = config.0.camera.field_of_view.to_radians();
            perspective.near = 0.02;
        }
    }
}

/// Gives the camera an image to draw into, and the window a view of it.
pub fn hang_canvas(
    mut commands: Commands,
    mut images: ResMut<Assets<Image>>,
    camera: Single<Entity, With<Camera3d>>,
) {
    let image = Image::new_target_texture(64, 64, TextureFormat::Rgba8UnormSrgb, None);
    let image = images.add(image);
    commands.entity(*camera).insert(RenderTarget::from(image.clone()));
    commands.spawn((Camera2d, Camera { order: 1, ..default() }, IsDefaultUiCamera));
    let all = Node {
        position_type: PositionType::Absolute,
        width: percent(100),
        height: percent(100),
        ..default()
    };
    commands.spawn((ImageNode::new(image.clone()), all, ZIndex(-1)));
    commands.insert_resource(Canvas(image));
}

/// Makes the image as large as the window times the resolution.
pub fn fit_canvas(
    canvas: Res<Canvas>,
    shown: Res<Shown>,
    window: Single<&Window, With<PrimaryWindow>>,
    mut images: ResMut<Assets<Image>>,
) {
    let size = (window.physical_size().as_vec2() * shown.resolution).round().as_uvec2();
    let size = size.clamp(UVec2::splat(16), UVec2::splat(8192));
    let fits = images.get(&canvas.0).is_some_and(|image| image.size() == size);
    if !fits && let Some(mut image) = images.get_mut(&canvas.0) {
        image.resize(Extent3d { width: size.x, height: size.y, depth_or_array_layers: 1 });
    }
}

/// Writes what the canvas shows to the configured folder: `object-material-lamps-1.png`, ...
pub fn screenshot(
    mut commands: Commands,
    keys: Res<ButtonInput<KeyCode>>,
    canvas: Res<Canvas>,
    config: Res<Config>,
    shown: Res<Shown>,
    refining: Query<Entity, With<ProgressiveCamera>>,
    mut problems: ResMut<Problems>,
) {
    if !keys.any_just_pressed([KeyCode::KeyP, KeyCode::F12]) {
        return;
    }
    let config = &config.0;
    let folder = PathBuf::from(&config.screenshots);
    if let Err(error) = std::fs::create_dir_all(&folder) {
        problems.config = Some(format!("screenshots: {}: {error}", folder.display()));
        return;
    }
    let plain = |name: &str| -> String {
        name.chars().map(|c| if c.is_alphanumeric() { c } else { '_' }).collect()
    };
    let object = config.models.get(shown.object).map_or(String::new(), |m| plain(&m.name));
    let material = config.materials.get(shown.material).map_or(String::new(), |m| plain(&m.name));
    let stem = format!("{object}-{material}-{}", shown.light.name());
    let path = (1..=9999)
        .map(|n| folder.join(format!("{stem}-{n}.png")))
        .find(|path| !path.exists())
        .unwrap_or_else(|| folder.join(format!("{stem}.png")));
    // As soon as the picture is refined.
    if let Ok(camera) = refining.single() {
        commands.spawn(RefinedScreenshot(camera)).observe(save_to_disk(path));
    } else {
        commands.spawn(Screenshot::image(canvas.0.clone())).observe(save_to_disk(path));
    }
}
