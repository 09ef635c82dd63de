//! Panels in the world: egui draws into a texture, whose density is that of the viewer's pixels; a
//! pass after tone mapping shows it on a quad, behind what is nearer as far as settings say. So no light, exposure, tone mapping, shadow map or
//! accumulation touches it, nor does any plugin take it for a mesh of the scene.

mod follow;
mod pass;
mod place;
mod point;

use bevy::{
    camera::{ClearColorConfig, RenderTarget, visibility::RenderLayers},
    core_pipeline::tonemapping::Tonemapping,
    prelude::*,
    render::render_resource::TextureFormat,
};
use bevy_egui::{
    EguiContext, EguiContextSettings, EguiFullOutput, EguiRenderOutput,
    egui::{self, Pos2},
};

use crate::{
    PanelEye, PanelSettings, PanelState, PanelSystems, PanelViewer,
    help::{self, Hint},
    menu::{Room, Steered},
    notify::Lines,
    screen::{self, Screen},
    steer::Steering,
    style,
};

pub(crate) use place::{Canvas, is_world};
pub(crate) use point::{Pointed, point};

/// Height of the quad for a width of 1.
const ASPECT: f32 = 1.2;
/// Points across the quad, where pixels are many: text of 14 points is then about a degree high.
const POINTS: f32 = 560.0;
/// And at least, where they are few.
const FEWEST_POINTS: f32 = 380.0;
/// Texels a pixel of the viewer. The pass takes the mean of what lies under a pixel, so that more are
/// sharper and don't shimmer.
const TEXELS_A_PIXEL: f32 = 1.5;
/// Seconds after which what is shown is drawn anew, for values that plugins change.
const REFRESH: f32 = 0.1;

/// The panel in the world: where it is, for whoever wants to point at it.
#[derive(Resource, Default)]
pub struct WorldPanel {
    canvas: Option<Entity>,
    ctx: Option<egui::Context>,
    image: Handle<Image>,
    texels: UVec2,
    points: Vec2,
    size: Vec2,
    shown: bool,
    idle: f32,
    followed: follow::Followed,
}

impl WorldPanel {
    /// Where its centre is; its front looks along +z. `None` while nothing is shown.
    pub fn transform(&self) -> Option<Transform> {
        self.shown.then(|| self.followed.pose())
    }

    /// Width and height in metres.
    pub fn size(&self) -> Vec2 {
        self.size
    }

    /// Texels of its picture.
    pub fn texels(&self) -> UVec2 {
        self.texels
    }

    /// Width and height in egui's points, whose origin is the upper left corner.
    pub fn points(&self) -> Vec2 {
        self.points
    }

    /// Where a point of egui's is in the world.
    pub fn world_from_point(&self, point: Vec2) -> Vec3 {
        let part = point / self.points - 0.5;
        self.followed.pose().transform_point((part * self.size * Vec2::new(1.0, -1.0)).extend(0.0))
    }

    pub(crate) fn ctx(&self) -> Option<&egui::Context> {
        self.ctx.as_ref()
    }
}

pub(crate) fn build(app: &mut App) {
    app.init_resource::<WorldPanel>()
        .init_resource::<Pointed>()
        .add_systems(PreUpdate, point.in_set(PanelSystems::Point))
        .add_systems(
            PostUpdate,
            (follow::follow.after(TransformSystems::Propagate), pass::keep_depth),
        );
    pass::build(app);
}

/// Pixels a metre at a distance, of the picture that has the most.
fn density(world: &mut World, distance: f32) -> Option<f32> {
    let main = world.resource::<Screen>().camera;
    let mut cameras = world.query::<(Entity, &Camera, &RenderTarget, Has<PanelEye>)>();
    cameras
        .iter(world)
        .filter(|(entity, _, target, eye)| is_shown_by(*entity, target, *eye, main))
        .filter_map(|(_, camera, ..)| {
            let height = camera.physical_viewport_size()?.y as f32;
            Some(height * 0.5 * camera.clip_from_view().y_axis.y / distance.max(0.1))
        })
        .filter(|density| density.is_finite() && *density > 0.0)
        .max_by(f32::total_cmp)
}

/// Whether a camera sees the panel: eyes, and the camera of the screen.
fn is_shown_by(camera: Entity, target: &RenderTarget, eye: bool, main: Option<Entity>) -> bool {
    eye || main == Some(camera) || matches!(target, RenderTarget::TextureView(_))
}

/// Draws what is open into the texture, if it changes.
pub(crate) fn show(world: &mut World) {
    let settings = world.resource::<PanelSettings>().clone();
    let state = world.resource::<PanelState>().clone();
    let hint = world.resource::<Hint>().opacity(&settings, &state);
    let moving = !world.resource::<Lines>().is_empty() || hint > 0.0;
    let visible = is_world(world) && (state.menu || state.help || moving);
    let density = if visible { density(world, settings.distance) } else { None };
    let Some(density) = density else {
        sleep(world, true);
        return;
    };
    let ctx = prepare(world, &settings, density);
    let delta = world.resource::<Time<Real>>().delta_secs();
    let seconds = world.resource::<Time<Real>>().elapsed_secs_f64();
    let events = std::mem::take(&mut world.resource_mut::<Pointed>().events);
    let mut input = world.resource_scope(|_, mut steering: Mut<Steering>| {
        let clicked = events.iter().any(|event| matches!(event, egui::Event::PointerButton { .. }));
        steering.by_focus &= !clicked;
        let mut input = egui::RawInput { time: Some(seconds), events, ..default() };
        input.events.append(&mut steering.typed);
        input.events.append(&mut steering.events);
        input
    });
    let steered = {
        let steering = world.resource::<Steering>();
        Steered { scroll: steering.scroll, by_focus: steering.by_focus }
    };
    let panel = world.resource::<WorldPanel>();
    let points = panel.points;
    let wakes = !panel.shown
        || !input.events.is_empty()
        || steered.scroll != 0.0
        || moving
        || world.resource::<Pointed>().at.is_some()
        || world.is_resource_changed::<PanelState>()
        || ctx.has_requested_repaint()
        || panel.idle >= REFRESH;
    if !wakes {
        world.resource_mut::<WorldPanel>().idle += delta;
        sleep(world, false);
        return;
    }
    let scale = panel.texels.x as f32 / points.x;
    input.screen_rect = Some(egui::Rect::from_min_size(Pos2::ZERO, egui::vec2(points.x, points.y)));
    input.viewports.entry(input.viewport_id).or_default().native_pixels_per_point = Some(scale);
    let output = ctx.run_ui(input, |ui| {
        screen::content(ui.ctx(), world, Room::World, &settings, steered);
        if hint > 0.0 {
            help::hint(ui.ctx(), world, hint);
        }
        world.resource::<Pointed>().mark(ui.ctx());
    });
    let mut panel = world.resource_mut::<WorldPanel>();
    panel.idle = 0.0;
    panel.shown = true;
    let Some(canvas) = panel.canvas else { return };
    let mut canvas = world.entity_mut(canvas);
    canvas.insert(EguiRenderOutput::default());
    if let Some(mut camera) = canvas.get_mut::<Camera>() {
        camera.is_active = true;
    }
    if let Some(mut full) = canvas.get_mut::<EguiFullOutput>() {
        **full = Some(output);
    }
}

/// Nothing is drawn into the texture; hidden, the quad goes too.
fn sleep(world: &mut World, hide: bool) {
    let mut panel = world.resource_mut::<WorldPanel>();
    if hide && panel.shown {
        panel.shown = false;
        panel.followed.forget();
        panel.idle = 0.0;
    }
    let Some(canvas) = panel.canvas else { return };
    let mut canvas = world.entity_mut(canvas);
    if canvas.get::<Camera>().is_some_and(|camera| camera.is_active) {
        canvas.remove::<EguiRenderOutput>();
        if let Some(mut camera) = canvas.get_mut::<Camera>() {
            camera.is_active = false;
        }
    }
}

/// The texture, its camera and egui's context, as large as they should be.
fn prepare(world: &mut World, settings: &PanelSettings, density: f32) -> egui::Context {
    let width = settings.width.clamp(0.05, 20.0);
    let pixels = width * density;
    // Where pixels are few, letters are larger and the panel holds less.
    let across = (pixels / 0.8).clamp(FEWEST_POINTS, POINTS) / settings.scale.clamp(0.5, 4.0);
    let points = Vec2::new(across, across * ASPECT).round();
    // In steps, so that a viewer who moves does not make new textures.
    let texels = (pixels * TEXELS_A_PIXEL).max(across) / 64.0;
    let texels = (texels.ceil() * 64.0).min(3072.0);
    let texels = UVec2::new(texels as u32, (texels * points.y / points.x) as u32);
    let mut panel = world.resource_mut::<WorldPanel>();
    panel.size = Vec2::new(width, width * points.y / points.x);
    panel.points = points;
    if let Some(ctx) = panel.ctx.clone()
        && panel.texels == texels
    {
        return ctx;
    }
    panel.texels = texels;
    panel.idle = f32::INFINITY;
    let format = TextureFormat::Rgba8UnormSrgb;
    let image = Image::new_target_texture(texels.x, texels.y, format, None);
    let image = world.resource_mut::<Assets<Image>>().add(image);
    let target = RenderTarget::from(image.clone());
    let mut panel = world.resource_mut::<WorldPanel>();
    panel.image = image;
    if let (Some(canvas), Some(ctx)) = (panel.canvas, panel.ctx.clone()) {
        world.entity_mut(canvas).insert(target);
        return ctx;
    }
    let mut context = EguiContext::default();
    style::apply(context.get_mut());
    let ctx = context.get_mut().clone();
    let canvas = world.spawn((
        Canvas,
        Name::new("panel"),
        Camera2d,
        Camera {
            order: -1000,
            clear_color: ClearColorConfig::Custom(Color::NONE),
            is_active: false,
            ..default()
        },
        target,
        Msaa::Off,
        Tonemapping::None,
        RenderLayers::none(),
        context,
        EguiContextSettings { run_manually: true, ..default() },
    ));
    let canvas = canvas.id();
    world.entity_mut(canvas).remove::<EguiRenderOutput>();
    let mut panel = world.resource_mut::<WorldPanel>();
    panel.canvas = Some(canvas);
    panel.ctx = Some(ctx.clone());
    ctx
}

/// Where the viewer is.
fn viewer(
    screen: &Screen,
    heads: &Query<&GlobalTransform, With<PanelViewer>>,
    all: &Query<&GlobalTransform>,
) -> Option<GlobalTransform> {
    let head = heads.iter().next().copied();
    head.or_else(|| all.get(screen.camera?).ok().copied())
}
