//! What happens in the render world: histories, the pass that accumulates, and drawing nothing.

mod history;
mod pass;
mod rest;

use std::sync::{
    Arc,
    atomic::{AtomicBool, AtomicU32, Ordering},
};

use bevy::{
    core_pipeline::{Core3d, Core3dSystems},
    pbr::prepare_lights,
    prelude::*,
    render::{
        Extract, ExtractSchedule, GpuResourceAppExt, Render, RenderApp, RenderSystems,
        extract_component::ExtractComponentPlugin,
        render_resource::{PipelineCache, PipelineDescriptor},
        view::prepare_view_targets,
    },
};

pub(crate) use history::Histories;
pub(crate) use pass::refine;

use crate::{camera::Progress, changes::Changes, uniform::Changed};

/// What the render world tells the main world.
#[derive(Resource, Clone, Debug, Default)]
pub(crate) struct Pending {
    /// Pipelines that are still being compiled: what they draw is missing from what is refined.
    pipelines: Arc<AtomicU32>,
    /// Whether what was kept is gone, with its device.
    lost: Arc<AtomicBool>,
}

impl Pending {
    pub(crate) fn is_waiting(&self) -> bool {
        self.pipelines.load(Ordering::Relaxed) > 0
    }

    pub(crate) fn take_lost(&self) -> bool {
        self.lost.swap(false, Ordering::Relaxed)
    }
}

/// Pipelines that draw over finished pictures, copy them, or draw in two dimensions, by their labels:
/// Bevy's (0.19), bevy_egui's (0.42) and ours. What is refined has nothing of theirs, so that the first
/// menu and the first screenshot don't disturb it.
const AFTERWARDS: [&str; 6] = [
    "blit pipeline",
    "egui_pipeline",
    "farlight_panel",
    "screenshot-to-screen",
    "sprite_pipeline",
    "tonemapping pipeline",
];

fn watch_pipelines(pending: Res<Pending>, cache: Res<PipelineCache>) {
    let is_of_picture = |id: &usize| {
        let pipeline = cache.pipelines().nth(*id).map(|pipeline| &pipeline.descriptor);
        let Some(PipelineDescriptor::RenderPipelineDescriptor(descriptor)) = pipeline else {
            return true;
        };
        descriptor.label.as_ref().is_none_or(|label| !AFTERWARDS.contains(&label.as_ref()))
    };
    let count = cache.waiting_pipelines().filter(is_of_picture).count();
    pending.pipelines.store(count as u32, Ordering::Relaxed);
}

fn extract_changes(changes: Extract<Res<Changes>>, mut extracted: ResMut<pass::ExtractedChanges>) {
    extracted.0.clear();
    extracted.0.extend(changes.all.iter().map(Changed::from));
}

/// Adds all of it. Without a renderer nothing happens.
pub(crate) fn build(app: &mut App) {
    let pending = Pending::default();
    app.insert_resource(pending.clone());
    if app.get_sub_app(RenderApp).is_none() {
        return;
    }
    app.add_plugins(ExtractComponentPlugin::<Progress>::default());
    let Some(render_app) = app.get_sub_app_mut(RenderApp) else { return };
    crate::layers::build(render_app);
    render_app
        .insert_resource(pending)
        .init_resource::<pass::ExtractedChanges>()
        .init_gpu_resource::<pass::Pipelines>()
        .init_gpu_resource::<Histories>()
        .add_systems(ExtractSchedule, extract_changes)
        .add_systems(
            Render,
            (
                history::prepare
                    .in_set(RenderSystems::PrepareResources)
                    .after(prepare_view_targets),
                pass::prepare.in_set(RenderSystems::PrepareBindGroups),
                rest::skip_shadows.in_set(RenderSystems::PrepareBindGroups).after(prepare_lights),
                watch_pipelines.in_set(RenderSystems::Cleanup),
            ),
        )
        .configure_sets(
            Core3d,
            (Core3dSystems::Prepass, Core3dSystems::MainPass).run_if(rest::is_drawn),
        )
        .add_systems(
            Core3d,
            refine.after(Core3dSystems::MainPass).before(Core3dSystems::EarlyPostProcess),
        );
}
