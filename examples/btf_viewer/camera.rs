//! The camera; in a window it draws into an image of its own, whose resolution can be chosen.

use bevy::{
    camera::{ClearColorConfig, Exposure, Hdr, RenderTarget},
    core_pipeline::tonemapping::Tonemapping,
    prelude::*,
    render::{
        render_resource::{Extent3d, TextureFormat},
        renderer::RenderAdapterInfo,
    },
    window::PrimaryWindow,
};

use farlight::{
    panel::{PanelCamera, PanelEye},
    xr::DesktopCamera,
};

use super::{shown::Shown, stage::Stage, state::Config, view, viewpoint::Viewpoint};

/// The picture of the scene that the window shows.
#[derive(Resource)]
pub struct Canvas(pub Handle<Image>);

/// Where the window shows it.
#[derive(Component)]
pub struct CanvasView;

/// The camera of the window: the canvas, the line at the upper edge.
#[derive(Component)]
pub struct WindowCamera;

/// The size of what is drawn where there is no window.
#[derive(Resource, Clone, Copy)]
pub struct WithoutWindow(pub UVec2);

/// Makes the camera.
pub fn spawn(
    mut commands: Commands,
    config: Res<Config>,
    stage: Res<Stage>,
    adapter: Option<Res<RenderAdapterInfo>>,
) {
    let viewpoint = view::start(&config.0, &stage);
    // Multisampling is left to graphics processors when a frame has to be fast.
    let on_cpu = adapter.is_some_and(|info| format!("{:?}", info.device_type) == "Cpu");
    commands.spawn((
        Camera3d::default(),
        Hdr,
        DesktopCamera,
        PanelEye,
        viewpoint.transform(),
        viewpoint,
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
    mut cameras: Query<(&mut Exposure, &mut Projection), With<Camera3d>>,
    added: Query<(), Added<Camera3d>>,
) {
    if !config.is_changed() && !shown.is_changed() && added.is_empty() {
        return;
    }
    let (red, green, blue) = config.0.background;
    clear.0 = Color::srgb_u8(red, green, blue);
    for (mut exposure, mut projection) in &mut cameras {
        exposure.ev100 = shown.picture.exposure;
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
    camera: Single<Entity, With<Viewpoint>>,
) {
    let image = Image::new_target_texture(64, 64, TextureFormat::Rgba8UnormSrgb, None);
    let image = images.add(image);
    commands.entity(*camera).insert(RenderTarget::from(image.clone()));
    commands.spawn((
        WindowCamera,
        Camera2d,
        Camera { order: 1, ..default() },
        IsDefaultUiCamera,
        // Cameras of one window share what they draw into, if they are alike.
        Msaa::Off,
    ));
    // Panels have a camera of their own, so that they are drawn after the canvas.
    commands.spawn((
        PanelCamera,
        Camera2d,
        Camera { order: 2, clear_color: ClearColorConfig::None, ..default() },
        Msaa::Off,
    ));
    let all = Node {
        position_type: PositionType::Absolute,
        width: percent(100),
        height: percent(100),
        ..default()
    };
    commands.spawn((CanvasView, ImageNode::new(image.clone()), all, ZIndex(-1)));
    commands.insert_resource(Canvas(image));
}

/// Makes the image as large as the window times the resolution.
pub fn fit_canvas(
    canvas: Res<Canvas>,
    shown: Res<Shown>,
    windows: Query<&Window, With<PrimaryWindow>>,
    without: Option<Res<WithoutWindow>>,
    mut images: ResMut<Assets<Image>>,
) {
    let window = windows.iter().next().map(Window::physical_size);
    let Some(whole) = window.or(without.map(|size| size.0)) else { return };
    let size = (whole.as_vec2() * shown.picture.resolution).round().as_uvec2();
    let size = size.clamp(UVec2::splat(16), UVec2::splat(8192));
    let fits = images.get(&canvas.0).is_some_and(|image| image.size() == size);
    if !fits && let Some(mut image) = images.get_mut(&canvas.0) {
        image.resize(Extent3d { width: size.x, height: size.y, depth_or_array_layers: 1 });
    }
}
