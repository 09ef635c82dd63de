//! The plugin.

use bevy::{prelude::*, render::RenderApp, shader::Shader};
use bevy_egui::{EguiGlobalSettings, EguiInput, EguiPlugin, EguiPreUpdateSet, egui};
use farlight_controls::{ControlsSystems, InputCapture};

use crate::{
    PanelCamera, PanelEye, PanelPlace, PanelSettings, PanelViewer, WorldPanel,
    help::Hint,
    notify::{self, Lines},
    screen::{self, Screen},
    sections::Sections,
    state::{Notification, PanelState},
    steer::{self, Steering},
    world::{self, Pointed},
};

/// Panels of settings. Needs `ControlsPlugin`.
#[derive(Clone, Debug, Default)]
pub struct PanelPlugin {
    settings: PanelSettings,
}

impl PanelPlugin {
    /// Begins with other settings.
    #[must_use]
    pub fn with_settings(settings: PanelSettings) -> Self {
        Self { settings }
    }
}

/// Systems of `PreUpdate`, in order.
#[derive(SystemSet, Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub enum PanelSystems {
    /// Pointers are looked up, and [`InputCapture`] says what panels take; before
    /// [`ControlsSystems::Sample`].
    Point,
    /// Panels are drawn and change settings; after [`ControlsSystems::Announce`].
    Show,
}

impl Plugin for PanelPlugin {
    fn build(&self, app: &mut App) {
        app.register_type::<PanelSettings>()
            .register_type::<PanelPlace>()
            .register_type::<PanelCamera>()
            .register_type::<PanelEye>()
            .register_type::<PanelViewer>()
            .insert_resource(self.settings.clone())
            .init_resource::<PanelState>()
            .init_resource::<Sections>()
            .init_resource::<Screen>()
            .init_resource::<Steering>()
            .init_resource::<Lines>()
            .init_resource::<Hint>()
            .add_message::<Notification>();
        let draws = app.get_sub_app(RenderApp).is_some()
            && app.world().contains_resource::<Assets<Shader>>();
        if !draws {
            debug!("panels are not shown: the app draws nothing");
            return;
        }
        if !app.is_plugin_added::<EguiPlugin>() {
            app.add_plugins(EguiPlugin::default());
            let mut settings = app.world_mut().resource_mut::<EguiGlobalSettings>();
            settings.auto_create_primary_context = false;
        }
        app.configure_sets(
            PreUpdate,
            (
                PanelSystems::Point
                    .after(EguiPreUpdateSet::ProcessInput)
                    .before(ControlsSystems::Sample),
                PanelSystems::Show
                    .after(ControlsSystems::Announce)
                    .after(EguiPreUpdateSet::BeginPass),
            ),
        )
        .add_systems(
            PreUpdate,
            (
                screen::choose.before(EguiPreUpdateSet::InitContexts),
                capture.in_set(PanelSystems::Point).after(world::point),
                (
                    pass_time,
                    steer::open_and_close,
                    steer::steer,
                    back,
                    notify::collect,
                    screen::show,
                    world::show,
                )
                    .chain()
                    .in_set(PanelSystems::Show),
            ),
        );
        screen::build(app);
        world::build(app);
    }
}

fn pass_time(mut hint: ResMut<Hint>, time: Res<Time<Real>>) {
    hint.pass(time.delta_secs());
}

/// The context that shows panels now.
fn current<'a>(screen: &'a Screen, panel: &'a WorldPanel) -> Option<&'a egui::Context> {
    if panel.transform().is_some() { panel.ctx() } else { screen.ctx() }
}

/// Closes what is on top.
fn back(
    mut state: ResMut<PanelState>,
    steering: Res<Steering>,
    screen: Res<Screen>,
    panel: Res<WorldPanel>,
) {
    if !steering.back {
        return;
    }
    // Of a text field it is the end of writing.
    if current(&screen, &panel).is_some_and(egui::Context::text_edit_focused) {
        return;
    }
    if state.help {
        state.help = false;
    } else {
        state.menu = false;
    }
}

/// Says what panels take.
fn capture(
    state: Res<PanelState>,
    screen: Res<Screen>,
    panel: Res<WorldPanel>,
    pointed: Res<Pointed>,
    inputs: Query<&EguiInput>,
    mut capture: ResMut<InputCapture>,
) {
    let mut taken = InputCapture { panel: state.menu || state.help, ..default() };
    if let (true, Some(ctx)) = (taken.panel, current(&screen, &panel)) {
        taken.keyboard = state.menu && ctx.text_edit_focused();
        if panel.transform().is_some() {
            taken.hands = pointed.hands;
            taken.pointer = pointed.mouse;
        } else {
            let input = screen.camera.and_then(|camera| inputs.get(camera).ok());
            taken.pointer = is_over(ctx, input);
        }
    }
    capture.set_if_neq(taken);
}

/// Whether the pointer is on a panel of the screen, or drags something of it.
fn is_over(ctx: &egui::Context, input: Option<&EguiInput>) -> bool {
    let moved = input.and_then(|input| {
        input.events.iter().rev().find_map(|event| match event {
            egui::Event::PointerMoved(at) => Some(*at),
            egui::Event::PointerButton { pos, .. } => Some(*pos),
            _ => None,
        })
    });
    let over = moved.or_else(|| ctx.pointer_latest_pos()).is_some_and(|at| {
        ctx.layer_id_at(at).is_some_and(|layer| layer.order != egui::Order::Background)
    });
    // A drag that began in the scene stays the scene's.
    let elsewhere = ctx.input(|input| input.pointer.any_down()) && !ctx.egui_is_using_pointer();
    ctx.egui_is_using_pointer() || over && !elsewhere
}
