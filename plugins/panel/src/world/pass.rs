//! The quad, drawn over finished pictures.

use bevy::{
    asset::AssetServer,
    camera::RenderTarget,
    core_pipeline::{Core3d, Core3dSystems, upscaling::upscaling},
    platform::collections::HashSet,
    prelude::*,
    render::{
        Extract, ExtractSchedule, GpuResourceAppExt, Render, RenderApp, RenderSystems,
        camera::ExtractedCamera,
        render_asset::RenderAssets,
        render_resource::{
            BindGroupEntries, BindGroupLayoutDescriptor, BindGroupLayoutEntries, BlendState,
            BufferInitDescriptor, BufferUsages, CachedRenderPipelineId, ColorTargetState,
            ColorWrites, Face, FilterMode, FragmentState, PipelineCache, PrimitiveState,
            PrimitiveTopology, RenderPassDescriptor, RenderPipelineDescriptor, Sampler,
            SamplerBindingType, SamplerDescriptor, ShaderStages, TextureFormat, TextureSampleType,
            VertexState,
            binding_types::{sampler, texture_2d, uniform_buffer_sized},
        },
        renderer::{RenderContext, RenderDevice, ViewQuery},
        sync_world::MainEntity,
        texture::GpuImage,
        view::{ExtractedView, ViewTarget},
    },
};
use farlight_core::shader_path;

use super::{WorldPanel, is_shown_by};
use crate::{PanelEye, screen::Screen};

pub(super) fn build(app: &mut App) {
    let Some(render_app) = app.get_sub_app_mut(RenderApp) else { return };
    render_app
        .init_resource::<Quad>()
        .init_gpu_resource::<Pipelines>()
        .add_systems(ExtractSchedule, extract)
        .add_systems(Render, prepare.in_set(RenderSystems::Queue))
        .add_systems(Core3d, draw.after(Core3dSystems::PostProcess).before(upscaling));
}

/// The panel, in the render world.
#[derive(Resource, Default)]
struct Quad {
    image: Option<AssetId<Image>>,
    world_from_panel: Mat4,
    texels: Vec2,
    cameras: HashSet<Entity>,
}

fn extract(
    mut quad: ResMut<Quad>,
    panel: Extract<Res<WorldPanel>>,
    screen: Extract<Res<Screen>>,
    cameras: Extract<Query<(Entity, &RenderTarget, Has<PanelEye>), With<Camera3d>>>,
) {
    quad.cameras.clear();
    quad.image = None;
    let Some(pose) = panel.transform() else { return };
    quad.image = Some(panel.image.id());
    quad.world_from_panel = pose.with_scale(panel.size.extend(1.0)).to_matrix();
    quad.texels = panel.texels.as_vec2();
    let shows = cameras
        .iter()
        .filter(|(entity, target, eye)| is_shown_by(*entity, target, *eye, screen.camera));
    quad.cameras.extend(shows.map(|(entity, ..)| entity));
}

/// Pipelines, and how what they read is bound.
#[derive(Resource)]
struct Pipelines {
    layout: BindGroupLayoutDescriptor,
    filter: Sampler,
    made: Vec<(TextureFormat, CachedRenderPipelineId)>,
}

impl FromWorld for Pipelines {
    fn from_world(world: &mut World) -> Self {
        let entries = BindGroupLayoutEntries::sequential(
            ShaderStages::VERTEX_FRAGMENT,
            (
                uniform_buffer_sized(false, None),
                texture_2d(TextureSampleType::Float { filterable: true }),
                sampler(SamplerBindingType::Filtering),
            ),
        );
        let filter = world.resource::<RenderDevice>().create_sampler(&SamplerDescriptor {
            label: Some("farlight_panel"),
            mag_filter: FilterMode::Linear,
            min_filter: FilterMode::Linear,
            ..default()
        });
        let layout = BindGroupLayoutDescriptor::new("farlight_panel", &entries);
        Self { layout, filter, made: Vec::new() }
    }
}

/// Makes pipelines for the formats of pictures that show it.
fn prepare(
    quad: Res<Quad>,
    mut pipelines: ResMut<Pipelines>,
    cache: Res<PipelineCache>,
    server: Res<AssetServer>,
    views: Query<(&MainEntity, &ViewTarget)>,
) {
    for (main, target) in &views {
        let format = target.main_texture_format();
        let known = pipelines.made.iter().any(|(known, _)| *known == format);
        if known || !quad.cameras.contains(&main.id()) {
            continue;
        }
        let shader = server.load(shader_path("panel/quad.wgsl"));
        let id = cache.queue_render_pipeline(RenderPipelineDescriptor {
            label: Some("farlight_panel".into()),
            layout: vec![pipelines.layout.clone()],
            vertex: VertexState { shader: shader.clone(), ..default() },
            fragment: Some(FragmentState {
                shader,
                targets: vec![Some(ColorTargetState {
                    format,
                    blend: Some(BlendState::PREMULTIPLIED_ALPHA_BLENDING),
                    write_mask: ColorWrites::ALL,
                })],
                ..default()
            }),
            primitive: PrimitiveState {
                topology: PrimitiveTopology::TriangleStrip,
                cull_mode: Some(Face::Back),
                ..default()
            },
            ..default()
        });
        pipelines.made.push((format, id));
    }
}

fn draw(
    view: ViewQuery<(&MainEntity, &ExtractedView, &ExtractedCamera, &ViewTarget)>,
    quad: Res<Quad>,
    pipelines: Res<Pipelines>,
    images: Res<RenderAssets<GpuImage>>,
    cache: Res<PipelineCache>,
    mut context: RenderContext,
) {
    let (main, view, camera, target) = view.into_inner();
    if !quad.cameras.contains(&main.id()) {
        return;
    }
    let format = target.main_texture_format();
    let made = pipelines.made.iter().find(|(known, _)| *known == format);
    let (Some(pipeline), Some(image)) = (
        made.and_then(|(_, id)| cache.get_render_pipeline(*id)),
        quad.image.and_then(|image| images.get(image)),
    ) else {
        return;
    };
    let view_from_world = view.world_from_view.affine().inverse();
    let clip_from_panel = view.clip_from_view * Mat4::from(view_from_world) * quad.world_from_panel;
    let numbers = clip_from_panel.to_cols_array();
    let numbers = numbers.into_iter().chain([quad.texels.x, quad.texels.y, 0.0, 0.0]);
    let contents: Vec<u8> = numbers.flat_map(f32::to_ne_bytes).collect();
    let device = context.render_device().clone();
    let uniform = device.create_buffer_with_data(&BufferInitDescriptor {
        label: Some("farlight_panel"),
        contents: &contents,
        usage: BufferUsages::UNIFORM,
    });
    let bound = device.create_bind_group(
        "farlight_panel",
        &cache.get_bind_group_layout(&pipelines.layout),
        &BindGroupEntries::sequential((
            uniform.as_entire_binding(),
            &image.texture_view,
            &pipelines.filter,
        )),
    );
    let mut pass = context.begin_tracked_render_pass(RenderPassDescriptor {
        label: Some("farlight_panel"),
        color_attachments: &[Some(target.get_unsampled_color_attachment())],
        ..default()
    });
    if let Some(viewport) = &camera.viewport {
        pass.set_camera_viewport(viewport);
    }
    pass.set_render_pipeline(pipeline);
    pass.set_bind_group(0, &bound, &[]);
    pass.draw(0..4, 0..1);
}
