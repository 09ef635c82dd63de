//! The environment's lights as dots on the sky, for people who choose how many they need.
//!
//! They are drawn over the picture after it was kept: they disturb nothing, and a refined picture
//! stays refined.

use std::{ops::Range, sync::Arc};

use bevy::{
    asset::AssetServer,
    core_pipeline::{Core3d, Core3dSystems, prepass::ViewPrepassTextures},
    ecs::{entity::EntityHashMap, system::SystemParam},
    prelude::*,
    render::{
        Extract, ExtractSchedule, GpuResourceAppExt, Render, RenderApp, RenderSystems,
        camera::ExtractedCamera,
        extract_component::{ExtractComponent, ExtractComponentPlugin},
        render_resource::{
            BindGroupEntries, BindGroupLayoutDescriptor, BindGroupLayoutEntries, BlendState,
            Buffer, BufferInitDescriptor, BufferUsages, CachedRenderPipelineId, ColorTargetState,
            ColorWrites, FragmentState, PipelineCache, PrimitiveState, PrimitiveTopology,
            RenderPassDescriptor, RenderPipelineDescriptor, ShaderStages, TextureFormat,
            TextureSampleType, VertexFormat, VertexState, VertexStepMode,
            binding_types::{texture_2d, texture_depth_2d, uniform_buffer_sized},
        },
        renderer::{RenderContext, RenderDevice, RenderQueue, ViewQuery},
        sync_world::MainEntity,
        view::{ExtractedView, ViewTarget},
    },
};
use bevy::{mesh::VertexBufferLayout, render::sync_component::SyncComponent};
use bytemuck::{Pod, Zeroable};
use farlight_core::shader_path;
use farlight_environment::EnvironmentLight;

use crate::{
    ProgressiveLighting,
    camera::{Action, Step},
    groups::Arranged,
    lights::Group,
    render::{Histories, refine},
};

/// Draws the environment's lights over what a [`ProgressiveCamera`](crate::ProgressiveCamera) shows of
/// the sky: small dots, those of this frame large and orange.
#[derive(Component, Clone, Copy, Debug, PartialEq, Reflect)]
#[reflect(Component, Default, Debug, Clone)]
pub struct EnvironmentDots {
    /// Radius of a dot in pixels of the camera's target.
    pub radius: f32,
}

impl Default for EnvironmentDots {
    fn default() -> Self {
        Self { radius: 3.0 }
    }
}

impl SyncComponent for EnvironmentDots {
    type Target = Self;
}

impl ExtractComponent for EnvironmentDots {
    type QueryData = &'static Self;
    type QueryFilter = ();
    type Out = Self;

    fn extract_component(dots: &Self) -> Option<Self> {
        Some(*dots)
    }
}

/// The lights that stand for the environment, for those who draw or count them.
#[derive(SystemParam)]
pub struct EnvironmentLights<'w> {
    arranged: Res<'w, Arranged>,
    group: Res<'w, Group>,
}

impl EnvironmentLights<'_> {
    /// All of them: directions in the map's frame, irradiance in the map's unit.
    #[must_use]
    pub fn all(&self) -> &[EnvironmentLight] {
        self.arranged.lights()
    }

    /// Whether others were chosen since this system ran last.
    #[must_use]
    pub fn are_others(&self) -> bool {
        self.arranged.is_changed()
    }

    /// Which of them shine in the frame that was drawn last.
    #[must_use]
    pub fn shining(&self) -> Range<usize> {
        if self.group.cycle > 0 { self.group.range(self.arranged.lights().len()) } else { 0..0 }
    }
}

/// The lights in the render world.
#[derive(Resource, Default)]
struct Shown {
    lights: Arc<[EnvironmentLight]>,
    shining: Range<usize>,
    rotation: Quat,
}

fn extract(
    lights: Extract<EnvironmentLights>,
    settings: Extract<Res<ProgressiveLighting>>,
    mut shown: ResMut<Shown>,
) {
    if !Arc::ptr_eq(&shown.lights, lights.arranged.lights()) {
        shown.lights = lights.arranged.lights().clone();
    }
    shown.shining = lights.shining();
    shown.rotation = settings.rotation;
}

/// `Dots` of the shader.
#[repr(C)]
#[derive(Clone, Copy, Debug, Pod, Zeroable)]
struct DotsUniform {
    clip_from_map: [f32; 16],
    viewport: [f32; 2],
    radius: f32,
    pad: f32,
    shining: [u32; 2],
    end: [u32; 2],
}

/// Pipelines and buffers.
#[derive(Resource)]
struct DotPipelines {
    kept: BindGroupLayoutDescriptor,
    drawn: BindGroupLayoutDescriptor,
    made: Vec<(bool, TextureFormat, CachedRenderPipelineId)>,
    uniforms: EntityHashMap<Buffer>,
    directions: Option<(Arc<[EnvironmentLight]>, Buffer)>,
}

impl FromWorld for DotPipelines {
    fn from_world(_: &mut World) -> Self {
        let uniform = || uniform_buffer_sized(false, None);
        let stages = ShaderStages::VERTEX_FRAGMENT;
        let distance = texture_2d(TextureSampleType::Float { filterable: false });
        Self {
            kept: BindGroupLayoutDescriptor::new(
                "farlight_ibl_dots_kept",
                &BindGroupLayoutEntries::sequential(stages, (uniform(), distance)),
            ),
            drawn: BindGroupLayoutDescriptor::new(
                "farlight_ibl_dots_drawn",
                &BindGroupLayoutEntries::sequential(stages, (uniform(), texture_depth_2d())),
            ),
            made: Vec::new(),
            uniforms: EntityHashMap::default(),
            directions: None,
        }
    }
}

impl DotPipelines {
    fn get(
        &mut self,
        depth: bool,
        format: TextureFormat,
        cache: &PipelineCache,
        server: &AssetServer,
    ) -> CachedRenderPipelineId {
        if let Some((.., id)) = self.made.iter().find(|(d, f, _)| (*d, *f) == (depth, format)) {
            return *id;
        }
        let shader = server.load(shader_path("ibl/dots.wgsl"));
        let shader_defs = if depth { vec!["DEPTH".into()] } else { vec![] };
        let direction = [VertexFormat::Float32x4];
        let id = cache.queue_render_pipeline(RenderPipelineDescriptor {
            label: Some("farlight_ibl_dots".into()),
            layout: vec![if depth { self.drawn.clone() } else { self.kept.clone() }],
            vertex: VertexState {
                shader: shader.clone(),
                shader_defs: shader_defs.clone(),
                buffers: vec![VertexBufferLayout::from_vertex_formats(
                    VertexStepMode::Instance,
                    direction,
                )],
                ..default()
            },
            primitive: PrimitiveState { topology: PrimitiveTopology::TriangleStrip, ..default() },
            fragment: Some(FragmentState {
                shader,
                shader_defs,
                targets: vec![Some(ColorTargetState {
                    format,
                    blend: Some(BlendState::ALPHA_BLENDING),
                    write_mask: ColorWrites::COLOR,
                })],
                ..default()
            }),
            ..default()
        });
        self.made.push((depth, format, id));
        id
    }
}

/// The pipeline of a camera's dots.
#[derive(Component)]
struct DotPipeline(CachedRenderPipelineId);

fn prepare(
    mut commands: Commands,
    mut pipelines: ResMut<DotPipelines>,
    cache: Res<PipelineCache>,
    server: Res<AssetServer>,
    device: Res<RenderDevice>,
    queue: Res<RenderQueue>,
    shown: Res<Shown>,
    cameras: Query<(Entity, &MainEntity, &Step, &ExtractedView, &EnvironmentDots)>,
) {
    let is_there = |entity: &Entity| cameras.iter().any(|(_, main, ..)| main.id() == *entity);
    pipelines.uniforms.retain(|entity, _| is_there(entity));
    if cameras.is_empty() || shown.lights.is_empty() {
        return;
    }
    let known = pipelines.directions.as_ref();
    if !known.is_some_and(|(lights, _)| Arc::ptr_eq(lights, &shown.lights)) {
        let lights = shown.lights.iter().enumerate();
        let directions: Vec<Vec4> =
            lights.map(|(index, light)| light.direction.extend(index as f32)).collect();
        let buffer = device.create_buffer_with_data(&BufferInitDescriptor {
            label: Some("farlight_ibl_directions"),
            contents: bytemuck::cast_slice(&directions),
            usage: BufferUsages::VERTEX,
        });
        pipelines.directions = Some((shown.lights.clone(), buffer));
    }
    for (entity, main, step, view, dots) in &cameras {
        let depth = step.action == Action::Show;
        let id = pipelines.get(depth, view.target_format, &cache, &server);
        commands.entity(entity).insert(DotPipeline(id));
        let viewport = step.pose.viewport.size().as_vec2();
        let clip_from_map = step.pose.clip_from_world * Mat4::from_quat(shown.rotation);
        let uniform = DotsUniform {
            clip_from_map: clip_from_map.to_cols_array(),
            viewport: viewport.to_array(),
            radius: dots.radius.clamp(0.5, 100.0),
            pad: 0.0,
            shining: [shown.shining.start as u32, shown.shining.end as u32],
            end: [0; 2],
        };
        let contents = bytemuck::bytes_of(&uniform);
        match pipelines.uniforms.get(&main.id()) {
            Some(buffer) => queue.write_buffer(buffer, 0, contents),
            None => {
                let buffer = device.create_buffer_with_data(&BufferInitDescriptor {
                    label: Some("farlight_ibl_dots"),
                    contents,
                    usage: BufferUsages::UNIFORM | BufferUsages::COPY_DST,
                });
                pipelines.uniforms.insert(main.id(), buffer);
            }
        }
    }
}

fn draw(
    view: ViewQuery<(
        &MainEntity,
        &Step,
        &DotPipeline,
        &EnvironmentDots,
        &ViewTarget,
        &ExtractedCamera,
        Option<&ViewPrepassTextures>,
    )>,
    pipelines: Res<DotPipelines>,
    histories: Res<Histories>,
    cache: Res<PipelineCache>,
    mut context: RenderContext,
) {
    let (main, step, pipeline, _, target, camera, prepass) = view.into_inner();
    let Some(pipeline) = cache.get_render_pipeline(pipeline.0) else { return };
    let Some((lights, directions)) = &pipelines.directions else { return };
    let Some(uniform) = pipelines.uniforms.get(&main.id()) else { return };
    let device = context.render_device().clone();
    let uniform = uniform.as_entire_binding();
    let group = if step.action == Action::Show {
        let depth = prepass.and_then(ViewPrepassTextures::depth_view);
        let Some(depth) = depth else { return };
        device.create_bind_group(
            "farlight_ibl_dots",
            &cache.get_bind_group_layout(&pipelines.drawn),
            &BindGroupEntries::sequential((uniform, depth)),
        )
    } else {
        let Some(history) = histories.0.get(&main.id()) else { return };
        device.create_bind_group(
            "farlight_ibl_dots",
            &cache.get_bind_group_layout(&pipelines.kept),
            &BindGroupEntries::sequential((uniform, history.moved_distance())),
        )
    };
    let attachment = target.get_unsampled_color_attachment();
    let mut pass = context.command_encoder().begin_render_pass(&RenderPassDescriptor {
        label: Some("farlight_ibl_dots"),
        color_attachments: &[Some(attachment)],
        depth_stencil_attachment: None,
        timestamp_writes: None,
        occlusion_query_set: None,
        multiview_mask: None,
    });
    if let Some(viewport) = &camera.viewport {
        let (at, size) = (viewport.physical_position.as_vec2(), viewport.physical_size.as_vec2());
        pass.set_viewport(at.x, at.y, size.x, size.y, 0.0, 1.0);
    }
    pass.set_pipeline(pipeline);
    pass.set_bind_group(0, &group, &[]);
    pass.set_vertex_buffer(0, *directions.slice(..));
    pass.draw(0..4, 0..lights.len() as u32);
}

/// Adds all of it. Without a renderer nothing happens.
pub(crate) fn build(app: &mut App) {
    app.register_type::<EnvironmentDots>();
    if app.get_sub_app(RenderApp).is_none() {
        return;
    }
    app.add_plugins(ExtractComponentPlugin::<EnvironmentDots>::default());
    let Some(render_app) = app.get_sub_app_mut(RenderApp) else { return };
    render_app
        .init_resource::<Shown>()
        .init_gpu_resource::<DotPipelines>()
        .add_systems(ExtractSchedule, extract)
        .add_systems(Render, prepare.in_set(RenderSystems::PrepareBindGroups))
        .add_systems(Core3d, draw.after(refine).before(Core3dSystems::EarlyPostProcess));
}
