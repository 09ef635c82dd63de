//! The pass over all pixels that accumulates, moves along, or presents.

use bevy::{
    asset::AssetServer,
    core_pipeline::{FullscreenShader, prepass::ViewPrepassTextures},
    prelude::*,
    render::{
        diagnostic::RecordDiagnostics,
        render_resource::{
            BindGroupEntries, BindGroupLayoutDescriptor, BindGroupLayoutEntries,
            CachedRenderPipelineId, ColorTargetState, ColorWrites, FragmentState, Operations,
            PipelineCache, RenderPassColorAttachment, RenderPassDescriptor,
            RenderPipelineDescriptor, ShaderStages, TextureFormat, TextureSampleType, TextureView,
            binding_types::{texture_2d, texture_depth_2d, uniform_buffer_sized},
        },
        renderer::{RenderContext, RenderQueue, ViewQuery},
        sync_world::MainEntity,
        view::{ExtractedView, ViewTarget},
    },
};
use farlight_core::shader_path;

use super::history::{DISTANCE_FORMAT, Histories, MEAN_FORMAT};
use crate::{
    camera::{Action, Step},
    uniform::{Accumulation, Changed},
};

/// Pipelines, and how what they read is bound.
#[derive(Resource)]
pub(crate) struct Pipelines {
    moving: BindGroupLayoutDescriptor,
    resting: BindGroupLayoutDescriptor,
    presenting: BindGroupLayoutDescriptor,
    made: Vec<(Kind, TextureFormat, CachedRenderPipelineId)>,
}

impl FromWorld for Pipelines {
    fn from_world(_: &mut World) -> Self {
        let exact = || texture_2d(TextureSampleType::Float { filterable: false });
        let uniform = || uniform_buffer_sized(false, None);
        let stages = ShaderStages::FRAGMENT;
        Self {
            moving: BindGroupLayoutDescriptor::new(
                "farlight_ibl_moving",
                &BindGroupLayoutEntries::sequential(
                    stages,
                    (uniform(), exact(), exact(), exact(), exact(), texture_depth_2d(), exact()),
                ),
            ),
            resting: BindGroupLayoutDescriptor::new(
                "farlight_ibl_resting",
                &BindGroupLayoutEntries::sequential(stages, (uniform(), exact(), exact(), exact())),
            ),
            presenting: BindGroupLayoutDescriptor::new(
                "farlight_ibl_presenting",
                &BindGroupLayoutEntries::sequential(stages, (exact(), exact(), uniform())),
            ),
            made: Vec::new(),
        }
    }
}

/// Which pipeline.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum Kind {
    /// What is kept moves along.
    Move,
    /// The same in the first frame after a rest: two means become one.
    Leave,
    Rest,
    Present,
}

impl Kind {
    const ALL: [Self; 4] = [Self::Move, Self::Leave, Self::Rest, Self::Present];

    fn of(step: &Step) -> Option<Self> {
        match step.action {
            Action::Show => None,
            Action::Move if step.still > 0 => Some(Self::Leave),
            Action::Move => Some(Self::Move),
            Action::Rest => Some(Self::Rest),
            Action::Present => Some(Self::Present),
        }
    }

    fn definitions(self) -> &'static [&'static str] {
        match self {
            Self::Move | Self::Present => &[],
            Self::Leave => &["RESTED"],
            Self::Rest => &["STILL"],
        }
    }
}

/// The pipeline of a camera's frame.
#[derive(Component)]
pub(crate) struct StepPipeline(CachedRenderPipelineId);

/// Writes uniforms, and makes pipelines where new ones are needed.
pub(crate) fn prepare(
    mut commands: Commands,
    mut pipelines: ResMut<Pipelines>,
    cache: Res<PipelineCache>,
    server: Res<AssetServer>,
    fullscreen: Res<FullscreenShader>,
    histories: Res<Histories>,
    queue: Res<RenderQueue>,
    changes: Res<ExtractedChanges>,
    cameras: Query<(Entity, &MainEntity, &Step, &ExtractedView, Option<&ViewPrepassTextures>)>,
) {
    for (entity, main, step, view, prepass) in &cameras {
        // All at once: a pipeline that is asked for only when a picture rests would disturb it.
        let all = Kind::ALL
            .map(|kind| pipelines.get(kind, view.target_format, &cache, &server, &fullscreen));
        let (Some(kind), Some(history)) = (Kind::of(step), histories.0.get(&main.id())) else {
            commands.entity(entity).remove::<StepPipeline>();
            continue;
        };
        commands.entity(entity).insert(StepPipeline(all[kind as usize]));
        let moves = prepass.is_some_and(|prepass| prepass.motion_vectors_view().is_some());
        let accumulation = Accumulation::new(step, moves, &changes.0);
        queue.write_buffer(&history.uniform, 0, bytemuck::bytes_of(&accumulation));
    }
}

/// What changed, for the shader.
#[derive(Resource, Default)]
pub(crate) struct ExtractedChanges(pub(crate) Vec<Changed>);

impl Pipelines {
    fn get(
        &mut self,
        kind: Kind,
        format: TextureFormat,
        cache: &PipelineCache,
        server: &AssetServer,
        fullscreen: &FullscreenShader,
    ) -> CachedRenderPipelineId {
        let known = self.made.iter().find(|(k, f, _)| (*k, *f) == (kind, format));
        if let Some((.., id)) = known {
            return *id;
        }
        let (layout, module, targets): (_, _, &[TextureFormat]) = match kind {
            Kind::Rest => (&self.resting, "accumulate", &[format, MEAN_FORMAT]),
            Kind::Present => (&self.presenting, "present", &[format]),
            Kind::Move | Kind::Leave => {
                (&self.moving, "accumulate", &[format, MEAN_FORMAT, DISTANCE_FORMAT])
            }
        };
        let target = |format: &TextureFormat| {
            Some(ColorTargetState { format: *format, blend: None, write_mask: ColorWrites::ALL })
        };
        let id = cache.queue_render_pipeline(RenderPipelineDescriptor {
            label: Some(format!("farlight_ibl_{kind:?}").into()),
            layout: vec![layout.clone()],
            vertex: fullscreen.to_vertex_state(),
            fragment: Some(FragmentState {
                shader: server.load(shader_path(&format!("ibl/{module}.wgsl"))),
                shader_defs: kind.definitions().iter().map(|name| (*name).into()).collect(),
                targets: targets.iter().map(target).collect(),
                ..default()
            }),
            ..default()
        });
        self.made.push((kind, format, id));
        id
    }
}

fn attachment(view: &TextureView) -> Option<RenderPassColorAttachment<'_>> {
    let ops = Operations::default();
    Some(RenderPassColorAttachment { view, depth_slice: None, resolve_target: None, ops })
}

/// Accumulates the frame that was drawn, or presents what is kept.
pub(crate) fn refine(
    view: ViewQuery<(&MainEntity, &Step, &StepPipeline, &ViewTarget, Option<&ViewPrepassTextures>)>,
    pipelines: Res<Pipelines>,
    mut histories: ResMut<Histories>,
    cache: Res<PipelineCache>,
    mut context: RenderContext,
) {
    let (main, step, pipeline, target, prepass) = view.into_inner();
    if step.action == Action::Show {
        return;
    }
    let Some(history) = histories.0.get_mut(&main.id()) else { return };
    let Some(pipeline) = cache.get_render_pipeline(pipeline.0) else { return };
    let device = context.render_device().clone();
    let layout = |descriptor| cache.get_bind_group_layout(descriptor);
    let (depth, motion) = (
        prepass.and_then(ViewPrepassTextures::depth_view),
        prepass.and_then(ViewPrepassTextures::motion_vectors_view),
    );
    if step.action == Action::Move && (depth.is_none() || motion.is_none()) {
        return;
    }

    let post = target.post_process_write();
    let uniform = history.uniform.as_entire_binding();
    let (bind_group, written): (_, Vec<&TextureView>) = match (step.action, depth, motion) {
        (Action::Present, ..) => (
            device.create_bind_group(
                "farlight_ibl_present",
                &layout(&pipelines.presenting),
                &BindGroupEntries::sequential((history.rested(), post.source, uniform)),
            ),
            vec![],
        ),
        (Action::Move, Some(depth), Some(motion)) => (
            device.create_bind_group(
                "farlight_ibl_move",
                &layout(&pipelines.moving),
                &BindGroupEntries::sequential((
                    uniform,
                    post.source,
                    history.moved(),
                    history.rested(),
                    history.moved_distance(),
                    depth,
                    motion,
                )),
            ),
            vec![history.next(), history.next_distance()],
        ),
        _ => (
            device.create_bind_group(
                "farlight_ibl_rest",
                &layout(&pipelines.resting),
                &BindGroupEntries::sequential((
                    uniform,
                    post.source,
                    history.moved(),
                    history.rested(),
                )),
            ),
            vec![history.next()],
        ),
    };
    let mut attachments = vec![attachment(post.destination)];
    attachments.extend(written.into_iter().map(attachment));
    let diagnostics = context.diagnostic_recorder();
    let diagnostics = diagnostics.as_deref();
    let span = diagnostics.time_span(context.command_encoder(), "farlight_ibl");
    {
        let mut pass = context.command_encoder().begin_render_pass(&RenderPassDescriptor {
            label: Some("farlight_ibl"),
            color_attachments: &attachments,
            depth_stencil_attachment: None,
            timestamp_writes: None,
            occlusion_query_set: None,
            multiview_mask: None,
        });
        pass.set_pipeline(pipeline);
        pass.set_bind_group(0, &bind_group, &[]);
        pass.draw(0..3, 0..1);
    }
    span.end(context.command_encoder());
    history.turn(step.action);
}
