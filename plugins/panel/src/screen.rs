//! Panels on the screen: egui's context is on the camera that draws last, and runs only while there
//! is something to show.

use bevy::{
    camera::RenderTarget,
    prelude::*,
    render::{Extract, ExtractSchedule, RenderApp, sync_world::MainEntity},
};
use bevy_egui::{
    EguiContext, EguiContextSettings, EguiFullOutput, EguiInput, EguiRenderOutput, egui,
    render::EguiCameraView,
};

use crate::{
    PanelCamera, PanelEye, PanelSettings, PanelState, WorldPanel,
    help::{self, Hint},
    menu::{self, Room, Steered},
    notify::{self, Lines},
    steer::{self, Steering},
    style,
    world::{Canvas, is_world},
};

/// Which camera shows panels on the screen.
#[derive(Resource, Default)]
pub(crate) struct Screen {
    pub(crate) camera: Option<Entity>,
    ctx: Option<egui::Context>,
    /// Whether the last frame showed anything.
    shown: bool,
    /// Whether the context has had a pass.
    ran: bool,
}

impl Screen {
    pub(crate) fn ctx(&self) -> Option<&egui::Context> {
        self.ctx.as_ref()
    }
}

pub(crate) fn build(app: &mut App) {
    if let Some(render_app) = app.get_sub_app_mut(RenderApp) {
        render_app.add_systems(ExtractSchedule, forget_views);
    }
}

/// Cameras for which egui has nothing to draw have no pass of it: their last view is gone.
fn forget_views(
    mut commands: Commands,
    views: Query<(Entity, &MainEntity), With<EguiCameraView>>,
    drawn: Extract<Query<(), With<EguiRenderOutput>>>,
) {
    for (entity, main) in &views {
        if !drawn.contains(main.id()) {
            commands.entity(entity).remove::<EguiCameraView>();
        }
    }
}

/// Chooses the camera.
pub(crate) fn choose(
    mut commands: Commands,
    mut screen: ResMut<Screen>,
    cameras: Query<
        (Entity, &Camera, &RenderTarget, Has<PanelCamera>),
        (Without<Canvas>, Without<PanelEye>, Or<(With<Camera3d>, With<Camera2d>)>),
    >,
) {
    let best = cameras
        .iter()
        .filter(|(_, camera, target, chosen)| {
            let fits = match target {
                RenderTarget::Window(_) => true,
                RenderTarget::Image(_) => *chosen,
                RenderTarget::TextureView(_) | RenderTarget::None { .. } => false,
            };
            camera.is_active && fits
        })
        .max_by_key(|(entity, camera, _, chosen)| {
            // Of equals the older one, so that the choice is stable.
            (*chosen, camera.order, std::cmp::Reverse(*entity))
        })
        .map(|(entity, ..)| entity);
    if best == screen.camera {
        return;
    }
    if let Some(before) = screen.camera
        && let Ok(mut before) = commands.get_entity(before)
    {
        before.remove_with_requires::<EguiContext>();
    }
    screen.camera = best;
    screen.ctx = None;
    screen.shown = false;
    screen.ran = false;
    if let Some(camera) = best {
        let mut context = EguiContext::default();
        style::apply(context.get_mut());
        screen.ctx = Some(context.get_mut().clone());
        let settings = EguiContextSettings { run_manually: true, ..default() };
        commands.entity(camera).insert((context, settings));
    }
}

/// Draws what is open on the screen.
pub(crate) fn show(world: &mut World) {
    let Some((camera, ctx)) = ({
        let screen = world.resource::<Screen>();
        screen.camera.zip(screen.ctx.clone())
    }) else {
        return;
    };
    let Some(mut input) = world.get_mut::<EguiInput>(camera).map(|mut input| input.take()) else {
        return;
    };
    let settings = world.resource::<PanelSettings>().clone();
    let state = world.resource::<PanelState>().clone();
    let here = !is_world(world);
    let hint = world.resource::<Hint>().opacity(&settings, &state);
    let lines = !world.resource::<Lines>().is_empty();
    if !here {
        // Keys come by the window.
        let panel = world.resource::<WorldPanel>();
        let writing = state.menu && panel.ctx().is_some_and(egui::Context::text_edit_focused);
        steer::keep_text(&mut input.events, writing);
        input.events.retain(is_typed);
        world.resource_mut::<Steering>().typed.append(&mut input.events);
    }
    let visible = here && (state.menu || state.help || lines || hint > 0.0);
    if !visible {
        say_nothing(world, camera, &ctx);
        world.resource_mut::<Screen>().shown = false;
        return;
    }
    let Some((rect, native)) = world.get::<Camera>(camera).and_then(|camera| {
        Some((camera.physical_viewport_rect()?, camera.target_scaling_factor().unwrap_or(1.0)))
    }) else {
        return say_nothing(world, camera, &ctx);
    };
    ctx.set_zoom_factor(settings.scale.clamp(0.5, 4.0));
    let scale = native * settings.scale.clamp(0.5, 4.0);
    let points = |v: UVec2| egui::pos2(v.x as f32 / scale, v.y as f32 / scale);
    input.screen_rect = Some(egui::Rect::from_min_max(points(rect.min), points(rect.max)));
    input.viewports.entry(input.viewport_id).or_default().native_pixels_per_point = Some(native);
    // Gamepads are heard whether or not the window has the focus; keys come only if it has.
    input.focused = true;
    let writing = ctx.text_edit_focused();
    steer::keep_text(&mut input.events, writing && state.menu);
    let pointed = input.events.iter().any(|event| {
        matches!(event, egui::Event::PointerButton { .. } | egui::Event::Touch { .. })
    });
    let steered = world.resource_scope(|_, mut steering: Mut<Steering>| {
        steering.by_focus &= !pointed;
        input.events.append(&mut steering.events);
        Steered { scroll: steering.scroll, by_focus: steering.by_focus }
    });
    let output = ctx.run_ui(input, |ui| {
        content(ui.ctx(), world, Room::Screen, &settings, steered);
        if hint > 0.0 {
            help::hint(ui.ctx(), world, hint);
            ui.ctx().request_repaint();
        }
    });
    world.resource_mut::<Screen>().ran = true;
    if !world.resource::<Screen>().shown {
        world.resource_mut::<Screen>().shown = true;
        world.entity_mut(camera).insert(EguiRenderOutput::default());
    }
    if let Some(mut full) = world.get_mut::<EguiFullOutput>(camera) {
        **full = Some(output);
    }
}

/// An output with nothing in it: bevy_egui 0.42 complains where a context has none, and its renderer
/// panics where the component is gone.
fn say_nothing(world: &mut World, camera: Entity, ctx: &egui::Context) {
    let mut screen = world.resource_mut::<Screen>();
    let output = if std::mem::replace(&mut screen.ran, true) {
        egui::FullOutput { pixels_per_point: 1.0, ..default() }
    } else {
        // Before its first pass egui has no fonts, and makes no triangles without.
        ctx.run_ui(egui::RawInput::default(), |_| {})
    };
    if let Some(mut full) = world.get_mut::<EguiFullOutput>(camera) {
        **full = Some(output);
    }
}

fn is_typed(event: &egui::Event) -> bool {
    use egui::Event;
    matches!(event, Event::Key { .. } | Event::Text(_) | Event::Copy | Event::Cut | Event::Paste(_))
}

/// What is open, on any canvas.
pub(crate) fn content(
    ctx: &egui::Context,
    world: &mut World,
    room: Room,
    settings: &PanelSettings,
    steered: Steered,
) {
    let state = world.resource::<PanelState>().clone();
    if state.menu {
        menu::show(ctx, world, room, settings.opacity, steered);
    }
    if state.help {
        help::overlay(ctx, world, settings.opacity, if state.menu { 0.0 } else { steered.scroll });
    }
    notify::show(ctx, world.resource::<Lines>());
}
