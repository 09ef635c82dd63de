//! Pictures of eyes into other pictures, in the render world.

use bevy::{
    core_pipeline::FullscreenShader,
    prelude::*,
    render::{
        GpuResourceAppExt, RenderApp,
        extract_component::ExtractComponentPlugin,
        render_resource::{
            BindGroupEntries, BindGroupLayoutDescriptor, BindGroupLayoutEntries,
            BufferInitDescriptor, BufferUsages, CachedRenderPipelineId, ColorTargetState,
            ColorWrites, FilterMode, FragmentState, LoadOp, Operations, PipelineCache,
            RenderPassColorAttachment, RenderPassDescriptor, RenderPipelineDescriptor, Sampler,
            SamplerBindingType, SamplerDescriptor, ShaderStages, StoreOp, TextureFormat,
            TextureSampleType, TextureView,
            binding_types::{sampler, texture_2d, uniform_buffer_sized},
        },
        renderer::{RenderContext, RenderDevice},
    },
};
use farlight_core::shader_path;

use crate::XrEye;

pub(crate) fn build(app: &mut App) {
    if app.get_sub_app(RenderApp).is_none() {
        return;
    }
    app.add_plugins(ExtractComponentPlugin::<XrEye>::default());
    if let Some(render_app) = app.get_sub_app_mut(RenderApp) {
        render_app.init_gpu_resource::<Shower>();
    }
}

/// What is needed to draw a picture into another.
#[derive(Resource)]
pub(crate) struct Shower {
    layout: BindGroupLayoutDescriptor,
    filter: Sampler,
    made: Vec<(TextureFormat, CachedRenderPipelineId)>,
}

impl FromWorld for Shower {
    fn from_world(world: &mut World) -> Self {
        let device = world.resource::<RenderDevice>();
        let entries = BindGroupLayoutEntries::sequential(
            ShaderStages::FRAGMENT,
            (
                uniform_buffer_sized(false, None),
                texture_2d(TextureSampleType::Float { filterable: true }),
                sampler(SamplerBindingType::Filtering),
            ),
        );
        Self {
            layout: BindGroupLayoutDescriptor::new("farlight_xr_show", &entries),
            filter: device.create_sampler(&SamplerDescriptor {
                label: Some("farlight_xr_show"),
                mag_filter: FilterMode::Linear,
                min_filter: FilterMode::Linear,
                ..default()
            }),
            made: Vec::new(),
        }
    }
}

impl Shower {
    /// The pipeline that draws into pictures of a format, made if need be.
    pub(crate) fn pipeline(
        &mut self,
        format: TextureFormat,
        cache: &PipelineCache,
        server: &AssetServer,
        fullscreen: &FullscreenShader,
    ) -> CachedRenderPipelineId {
        if let Some((_, id)) = self.made.iter().find(|(known, _)| *known == format) {
            return *id;
        }
        let id = cache.queue_render_pipeline(RenderPipelineDescriptor {
            label: Some("farlight_xr_show".into()),
            layout: vec![self.layout.clone()],
            vertex: fullscreen.to_vertex_state(),
            fragment: Some(FragmentState {
                shader: server.load(shader_path("xr/show.wgsl")),
                targets: vec![Some(ColorTargetState {
                    format,
                    blend: None,
                    write_mask: ColorWrites::ALL,
                })],
                ..default()
            }),
            ..default()
        });
        self.made.push((format, id));
        id
    }

    /// Draws a part of a picture (size and place, from 0 to 1) over all of another. Says whether it could.
    pub(crate) fn show(
        &self,
        context: &mut RenderContext,
        cache: &PipelineCache,
        from: &TextureView,
        part: Vec4,
        into: (&TextureView, TextureFormat),
    ) -> bool {
        let made = self.made.iter().find(|(format, _)| *format == into.1);
        let Some(pipeline) = made.and_then(|(_, id)| cache.get_render_pipeline(*id)) else {
            return false;
        };
        let device = context.render_device().clone();
        let contents: Vec<u8> = part.to_array().iter().flat_map(|x| x.to_ne_bytes()).collect();
        let uniform = device.create_buffer_with_data(&BufferInitDescriptor {
            label: Some("farlight_xr_show"),
            contents: &contents,
            usage: BufferUsages::UNIFORM,
        });
        let bound = device.create_bind_group(
            "farlight_xr_show",
            &cache.get_bind_group_layout(&self.layout),
            &BindGroupEntries::sequential((uniform.as_entire_binding(), from, &self.filter)),
        );
        let mut pass = context.begin_tracked_render_pass(RenderPassDescriptor {
            label: Some("farlight_xr_show"),
            color_attachments: &[Some(RenderPassColorAttachment {
                view: into.0,
                depth_slice: None,
                resolve_target: None,
                ops: Operations { load: LoadOp::Clear(default()), store: StoreOp::Store },
            })],
            ..default()
        });
        pass.set_render_pipeline(pipeline);
        pass.set_bind_group(0, &bound, &[]);
        pass.draw(0..3, 0..1);
        true
    }
}
