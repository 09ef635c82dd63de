//! Which of the suite's settings the panel shows, under which titles.

#[cfg(feature = "gi")]
use std::collections::VecDeque;
use std::time::Duration;

use bevy::{prelude::*, render::renderer::RenderAdapterInfo};
use farlight_controls::{RebindState, Rebinding, Resolve};
use farlight_core::TimeWindow;
use farlight_panel::{
    AddPanel, Notification, PanelSettings, button_row, egui::Ui, plot, slider_row, switch_row,
    text_row,
};

/// Adds the suite's sections below those of the game.
pub(crate) struct SuiteSections;

impl Plugin for SuiteSections {
    fn build(&self, app: &mut App) {
        // The panel may have been left out.
        app.add_message::<Notification>();
        app.init_resource::<Frames>().add_systems(Last, measure);
        #[cfg(feature = "gi")]
        app.init_resource::<LinkHistory>().add_systems(Last, sample_link);
        app.add_systems(
            Update,
            (
                tell_devices.run_if(resource_exists::<farlight_controls::ActiveDevice>),
                save_rebound.run_if(resource_exists::<Rebinding>),
            ),
        );
    }

    fn finish(&self, app: &mut App) {
        #[cfg(feature = "ibl")]
        {
            use farlight_ibl::{
                EnvironmentStatus, ProgressiveCamera, ProgressiveLighting, Refinement,
            };
            app.add_panel_resource::<ProgressiveLighting>("Environment light")
                .add_panel_status::<EnvironmentStatus>("Environment light")
                .add_panel_component::<ProgressiveCamera, ()>("Progressive picture", true)
                .add_panel_component::<Refinement, ()>("Progressive picture", false);
        }
        #[cfg(feature = "gi")]
        {
            use farlight_gi::{GiControl, GiSettings, GiStatus, GiView};
            app.add_panel_resource::<GiControl>("Global illumination")
                .add_panel_resource::<GiView>("Global illumination")
                .add_panel_status::<GiStatus>("Global illumination")
                .add_panel_section("Global illumination", |ui, world| {
                    let Some(status) = world.get_resource::<GiStatus>() else { return };
                    let quality = status.quality;
                    let error = format!("{:.1} %", quality.relative_error * 100.0);
                    text_row(ui, "Estimated error", error);
                    text_row(ui, "Rays a texel", quality.rays_per_texel.to_string());
                    ui.add_space(4.0);
                    ui.weak("Solver: changes start it anew");
                })
                .add_panel_resource::<GiSettings>("Global illumination")
                .add_panel_section("Network", network);
        }
        #[cfg(feature = "btf")]
        if app.world().contains_resource::<farlight_btf::BtfSettings>() {
            app.add_panel_section("Measured materials", measured)
                .add_panel_resource::<farlight_btf::BtfSettings>("Measured materials");
        }
        app.add_panel_section("Performance", performance)
            .add_panel_section("Controls", controls)
            .add_panel_resource::<PanelSettings>("Panel");
    }
}

/// What frames took.
#[derive(Resource)]
struct Frames(TimeWindow);

impl Default for Frames {
    fn default() -> Self {
        Self(TimeWindow::new(160))
    }
}

fn measure(mut frames: ResMut<Frames>, time: Res<Time<Real>>) {
    frames.0.push(time.delta());
}

fn milliseconds(window: &TimeWindow) -> Vec<f64> {
    window.iter().map(|time| time.as_secs_f64() * 1e3).collect()
}

fn performance(ui: &mut Ui, world: &mut World) {
    let frames = &world.resource::<Frames>().0;
    let stats = frames.stats();
    let median = stats.median.as_secs_f64();
    let ms = |time: Duration| format!("{:.1} ms", time.as_secs_f64() * 1e3);
    let rate = if median > 0.0 { format!(" ({:.0} /s)", 1.0 / median) } else { String::new() };
    text_row(ui, "Frame, median", ms(stats.median) + &rate);
    text_row(ui, "Frame, p99", ms(stats.p99));
    plot(ui, &milliseconds(frames), "ms");
    #[cfg(feature = "gi")]
    if let Some(status) = world.get_resource::<farlight_gi::GiStatus>() {
        let own = status.timings.frame.cpu_stats();
        let text = format!(
            "{:.2} ms, p99 {:.2} ms",
            own.median.as_secs_f64() * 1e3,
            own.p99.as_secs_f64() * 1e3
        );
        text_row(ui, "Global illumination", text);
    }
    if let Some(adapter) = world.get_resource::<RenderAdapterInfo>() {
        text_row(ui, "GPU", adapter.name.clone());
        text_row(ui, "Interface", format!("{:?}, {}", adapter.backend, adapter.driver_info));
    }
}

/// How many materials are there, and what is wrong with others.
#[cfg(feature = "btf")]
fn measured(ui: &mut Ui, world: &mut World) {
    let Some(status) = world.get_resource::<farlight_btf::BtfStatus>() else { return };
    let megabytes = status.resident_bytes as f64 / 1e6;
    text_row(ui, "On the GPU", format!("{}, {megabytes:.1} MB", status.resident));
    if status.waiting > 0 {
        text_row(ui, "On their way", status.waiting.to_string());
    }
    for problem in status.limited.iter().chain(status.failed.last().map(|failed| &failed.error)) {
        ui.colored_label(ui.visuals().error_fg_color, problem);
    }
}

/// What the connection to a lighting server did of late, ten times a second, oldest first; at most 160
/// values each. The panel's section "Network" plots it.
#[cfg(feature = "gi")]
#[derive(Resource, Debug, Default)]
pub struct LinkHistory {
    since: f32,
    latency: VecDeque<f64>,
    bandwidth: VecDeque<f64>,
    error: VecDeque<f64>,
    received: u64,
}

#[cfg(feature = "gi")]
impl LinkHistory {
    /// Milliseconds there and back; NaN while nobody knows.
    pub fn latency(&self) -> impl Iterator<Item = f64> {
        self.latency.iter().copied()
    }

    /// Received, in kB a second.
    pub fn bandwidth(&self) -> impl Iterator<Item = f64> {
        self.bandwidth.iter().copied()
    }

    /// Estimated error of the light that is shown, in percent; also of what is solved here.
    pub fn error(&self) -> impl Iterator<Item = f64> {
        self.error.iter().copied()
    }
}

#[cfg(feature = "gi")]
fn sample_link(
    mut link: ResMut<LinkHistory>,
    status: Option<Res<farlight_gi::GiStatus>>,
    time: Res<Time<Real>>,
) {
    const EVERY: f32 = 0.1;
    const KEPT: usize = 160;
    link.since += time.delta_secs();
    let (true, Some(status)) = (link.since >= EVERY, status) else { return };
    let seconds = f64::from(std::mem::take(&mut link.since));
    let keep = |history: &mut VecDeque<f64>, value: f64| {
        if history.len() == KEPT {
            history.pop_front();
        }
        history.push_back(value);
    };
    keep(&mut link.error, f64::from(status.quality.relative_error) * 100.0);
    if let Some(now) = &status.link {
        keep(&mut link.latency, now.rtt.map_or(f64::NAN, |rtt| rtt.as_secs_f64() * 1e3));
        let new = now.received_bytes.saturating_sub(link.received);
        link.received = now.received_bytes;
        keep(&mut link.bandwidth, new as f64 / 1e3 / seconds);
    }
}

#[cfg(feature = "gi")]
fn network(ui: &mut Ui, world: &mut World) {
    use farlight_gi::{GiStatus, LinkState};
    let (Some(link), Some(status)) =
        (world.get_resource::<LinkHistory>(), world.get_resource::<GiStatus>())
    else {
        return;
    };
    let mut lines = |title: &str, history: &VecDeque<f64>, unit: &'static str| {
        if !history.is_empty() {
            ui.weak(title);
            plot(ui, &history.iter().copied().collect::<Vec<_>>(), unit);
        }
    };
    if let Some(now) = &status.link {
        lines("Latency, there and back", &link.latency, "ms");
        lines("Bandwidth, received", &link.bandwidth, "kB/s");
        lines("Estimated error of the light", &link.error, " %");
        let state = match &now.state {
            LinkState::Connecting => "connecting".into(),
            LinkState::Connected => "connected".into(),
            LinkState::Reconnecting { attempt, why, .. } => format!("attempt {attempt}: {why}"),
            LinkState::GivenUp => "given up".into(),
        };
        text_row(ui, "Server", now.peer.to_string());
        text_row(ui, "State", state);
        text_row(ui, "Received", format!("{:.1} MB", now.received_bytes as f64 / 1e6));
        text_row(ui, "Sent", format!("{:.1} MB", now.sent_bytes as f64 / 1e6));
        text_row(ui, "Snapshots behind", now.snapshot_lag.to_string());
    } else {
        lines("Estimated error of the light", &link.error, " %");
        text_row(ui, "Server", "none: solved here");
    }
}

/// What does what on the device in hand.
fn controls(ui: &mut Ui, world: &mut World) {
    use farlight_controls::{ActiveDevice, ControlsInForce, bindings::ACTIONS};
    let Some(device) = world.get_resource::<ActiveDevice>() else { return };
    let device = device.device;
    text_row(ui, "Device in hand", device.label());
    let Some(in_force) = world.get_resource::<ControlsInForce>() else { return };
    let mut bindings = in_force.bindings.clone();
    let sensitivity = &mut bindings.sensitivity.0;
    let mut changed = slider_row(ui, "Sensitivity", sensitivity, 0.05..=20.0, "×");
    changed |= switch_row(ui, "Invert the zoom", &mut bindings.invert_zoom);
    changed |= switch_row(ui, "Invert looking up and down", &mut bindings.invert_look);
    if changed {
        world.resource_mut::<ControlsInForce>().bindings = bindings;
    }
    rebind(ui, world);
    let Some(in_force) = world.get_resource::<ControlsInForce>() else { return };
    let mut chosen = None;
    for info in ACTIONS.iter().filter(|info| !in_force.bindings.is_unused(info.name)) {
        let bound = in_force.bindings.of(info.name, device);
        let inputs: Vec<_> = bound.iter().map(|binding| binding.label_on(device)).collect();
        let inputs = if inputs.is_empty() { "none".into() } else { inputs.join(", ") };
        if ui.push_id(info.name, |ui| button_row(ui, info.label, inputs)).inner {
            chosen = Some(info.name);
        }
    }
    let Some(mut rebinding) = world.get_resource_mut::<Rebinding>() else { return };
    if let Some(action) = chosen {
        rebinding.start(action, device, 0);
    }
    if button_row(ui, "All inputs", "As the game has them") {
        rebinding.reset_all();
        rebinding.save();
    }
}

/// What people read of an action.
fn label(action: &str) -> &str {
    farlight_controls::bindings::action(action).map_or(action, |info| info.label)
}

/// What is asked while an action is given another input.
fn rebind(ui: &mut Ui, world: &mut World) {
    let Some(mut rebinding) = world.get_resource_mut::<Rebinding>() else { return };
    match rebinding.state().clone() {
        RebindState::Waiting { target, prompt, refused } => {
            ui.strong(format!("{}: {prompt}", label(&target.action)));
            if let Some(refused) = refused {
                ui.colored_label(ui.visuals().error_fg_color, refused);
            }
        }
        RebindState::Conflict { target, binding, with } => {
            ui.strong(format!(
                "{} already does: {}",
                binding.label_on(target.device),
                with.iter().map(|name| label(name)).collect::<Vec<_>>().join("; ")
            ));
            ui.horizontal(|ui| {
                for (text, resolve) in [
                    ("Replace", Resolve::Replace),
                    ("Keep both", Resolve::KeepBoth),
                    ("Cancel", Resolve::Cancel),
                ] {
                    if ui.button(text).clicked() {
                        rebinding.resolve(resolve);
                    }
                }
            });
        }
        _ => {
            ui.weak("Press a row to give an action another input:");
        }
    }
}

/// Saves another input as soon as it is there, and says so.
fn save_rebound(
    mut rebinding: ResMut<Rebinding>,
    mut was_done: Local<bool>,
    mut says: MessageWriter<Notification>,
) {
    let done = match rebinding.state() {
        RebindState::Done { target, binding } => {
            Some((label(&target.action).to_owned(), binding.label_on(target.device)))
        }
        _ => None,
    };
    let is_done = done.is_some();
    if let Some((action, input)) = done.filter(|_| !*was_done) {
        rebinding.save();
        says.write(Notification::new(format!("{action}: {input}")));
    }
    *was_done = is_done;
}

/// Says which device is in hand when it becomes another.
fn tell_devices(
    device: Res<farlight_controls::ActiveDevice>,
    mut before: Local<Option<farlight_controls::bindings::Device>>,
    mut says: MessageWriter<Notification>,
) {
    let was = before.replace(device.device);
    if was.is_some_and(|was| was != device.device) {
        says.write(Notification::new(
            device.name.clone().unwrap_or_else(|| device.device.label().into()),
        ));
    }
}
