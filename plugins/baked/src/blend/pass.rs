//! The pass that blends, in the render world.

use bevy::{
    asset::AssetServer,
    core_pipeline::schedule::camera_driver,
    prelude::*,
    render::{
        GpuResourceAppExt, Render, RenderApp, RenderSystems,
        render_asset::RenderAssets,
        render_resource::{
            BindGroup, BindGroupEntries, BindGroupLayoutDescriptor, BindGroupLayoutEntries,
            BufferInitDescriptor, BufferUsages, CachedComputePipelineId, ComputePassDescriptor,
            ComputePipelineDescriptor, PipelineCache, ShaderStages, StorageTextureAccess,
            TextureFormat, TextureSampleType,
            binding_types::{
                texture_2d, texture_3d, texture_storage_2d, texture_storage_3d,
                uniform_buffer_sized,
            },
        },
        renderer::{RenderContext, RenderDevice, RenderGraph},
        texture::{FallbackImage, GpuImage},
    },
};
use bytemuck::{Pod, Zeroable};
use farlight_core::shader_path;

use super::{Blends, Order};

/// `Blend` of the shader.
#[repr(C)]
#[derive(Clone, Copy, Debug, Default, Pod, Zeroable)]
struct Uniform {
    weights: [f32; 8],
    count: u32,
    pad: [u32; 3],
}

/// For pages or for volumes.
struct Kind {
    layout: BindGroupLayoutDescriptor,
    pipeline: CachedComputePipelineId,
    workgroup: UVec3,
}

#[derive(Resource)]
struct Kinds {
    page: Kind,
    volume: Kind,
}

impl FromWorld for Kinds {
    fn from_world(world: &mut World) -> Self {
        let cache = world.resource::<PipelineCache>();
        let shader = world.resource::<AssetServer>().load(shader_path("baked/blend.wgsl"));
        let kind = |volume: bool| {
            let format = TextureFormat::Rgba16Float;
            let float = TextureSampleType::Float { filterable: true };
            let access = StorageTextureAccess::WriteOnly;
            let (target, baked) = if volume {
                (texture_storage_3d(format, access), texture_3d(float))
            } else {
                (texture_storage_2d(format, access), texture_2d(float))
            };
            let uniform = uniform_buffer_sized(false, None);
            let layout = BindGroupLayoutDescriptor::new(
                "farlight_baked_blend",
                &BindGroupLayoutEntries::sequential(
                    ShaderStages::COMPUTE,
                    (uniform, target, baked, baked, baked, baked, baked, baked, baked, baked),
                ),
            );
            let pipeline = cache.queue_compute_pipeline(ComputePipelineDescriptor {
                label: Some("farlight_baked_blend".into()),
                layout: vec![layout.clone()],
                shader: shader.clone(),
                shader_defs: if volume { vec!["VOLUME".into()] } else { vec![] },
                ..default()
            });
            let workgroup = if volume { UVec3::splat(4) } else { UVec3::new(8, 8, 1) };
            Kind { layout, pipeline, workgroup }
        };
        Self { page: kind(false), volume: kind(true) }
    }
}

/// What is carried out in this frame.
#[derive(Resource, Default)]
struct Prepared(Vec<(CachedComputePipelineId, BindGroup, UVec3)>);

/// Takes the orders whose textures are there.
fn prepare(
    blends: Res<Blends>,
    kinds: Res<Kinds>,
    mut prepared: ResMut<Prepared>,
    cache: Res<PipelineCache>,
    device: Res<RenderDevice>,
    images: Res<RenderAssets<GpuImage>>,
    fallback: Res<FallbackImage>,
) {
    prepared.0.clear();
    let kind = |order: &Order| if order.size.z > 1 { &kinds.volume } else { &kinds.page };
    let ready = |order: &Order| {
        let pipeline = cache.get_compute_pipeline(kind(order).pipeline).is_some();
        let there = |id| images.get(id).is_some();
        pipeline && there(order.target) && order.inputs.iter().all(|&(id, _)| there(id))
    };
    for order in blends.take(ready) {
        let Some(target) = images.get(order.target) else { continue };
        let mut uniform = Uniform { count: order.inputs.len() as u32, ..default() };
        let nothing = if order.size.z > 1 { &fallback.d3 } else { &fallback.d2 };
        let mut views = [&nothing.texture_view; 8];
        for (slot, &(id, weight)) in order.inputs.iter().enumerate().take(views.len()) {
            let Some(image) = images.get(id) else { continue };
            views[slot] = &image.texture_view;
            uniform.weights[slot] = weight;
        }
        let buffer = device.create_buffer_with_data(&BufferInitDescriptor {
            label: Some("farlight_baked_blend"),
            contents: bytemuck::bytes_of(&uniform),
            usage: BufferUsages::UNIFORM,
        });
        let kind = kind(&order);
        let [a, b, c, d, e, f, g, h] = views;
        let uniform = buffer.as_entire_binding();
        let group = device.create_bind_group(
            "farlight_baked_blend",
            &cache.get_bind_group_layout(&kind.layout),
            &BindGroupEntries::sequential((uniform, &target.texture_view, a, b, c, d, e, f, g, h)),
        );
        let groups = (order.size + kind.workgroup - UVec3::ONE) / kind.workgroup;
        prepared.0.push((kind.pipeline, group, groups));
    }
}

fn blend(prepared: Res<Prepared>, cache: Res<PipelineCache>, mut context: RenderContext) {
    if prepared.0.is_empty() {
        return;
    }
    let mut pass = context.command_encoder().begin_compute_pass(&ComputePassDescriptor {
        label: Some("farlight_baked_blend"),
        timestamp_writes: None,
    });
    for (pipeline, group, size) in &prepared.0 {
        let Some(pipeline) = cache.get_compute_pipeline(*pipeline) else { continue };
        pass.set_pipeline(pipeline);
        pass.set_bind_group(0, group, &[]);
        pass.dispatch_workgroups(size.x, size.y, size.z);
    }
}

/// Adds all of it. Without a renderer nothing happens.
pub(super) fn build(app: &mut App, blends: Blends) {
    let Some(render_app) = app.get_sub_app_mut(RenderApp) else { return };
    render_app
        .insert_resource(blends)
        .init_resource::<Prepared>()
        .add_systems(
            Render,
            prepare.in_set(RenderSystems::PrepareBindGroups).run_if(resource_exists::<Kinds>),
        )
        .add_systems(RenderGraph, blend.before(camera_driver));
}

/// Makes the pipelines, once it is known that the device takes them.
pub(super) fn finish(app: &mut App) {
    if let Some(render_app) = app.get_sub_app_mut(RenderApp) {
        render_app.init_gpu_resource::<Kinds>();
    }
}
