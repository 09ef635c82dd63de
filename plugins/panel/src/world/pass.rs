//! The quad, drawn over finished pictures, with what is nearer before it.

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
            TextureUsages, VertexState,
            binding_types::{
                sampler, texture_2d, texture_depth_2d, texture_depth_2d_multisampled,
                uniform_buffer_sized,
            },
        },
        renderer::{RenderContext, RenderDevice, ViewQuery},
        sync_world::MainEntity,
        texture::GpuImage,
        view::{ExtractedView, ViewDepthTexture, ViewTarget},
    },
    shader::ShaderDefVal,
};
use farlight_core::shader_path;

use super::{WorldPanel, is_shown_by};
use crate::{PanelEye, PanelSettings, PanelViewer, screen::Screen};

pub(super) fn build(app: &mut App) {
    let Some(render_app) = app.get_sub_app_mut(RenderApp) else { return };
    render_app
        .init_resource::<Quad>()
        .init_gpu_resource::<Pipelines>()
        .add_systems(ExtractSchedule, extract)
        .add_systems(Render, prepare.in_set(RenderSystems::PrepareBindGroups))
        .add_systems(Core3d, draw.after(Core3dSystems::PostProcess).before(upscaling));
}

/// The panel, in the render world.
#[derive(Resource, Default)]
struct Quad {
    image: Option<AssetId<Image>>,
    world_from_panel: Mat4,
    texels: Vec2,
    through: f32,
    cameras: HashSet<Entity>,
}

/// What is known of how near things are in a picture.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum Depth {
    None,
    /// One sample a pixel.
    Single,
    /// Several.
    Multiple,
}

impl Depth {
    /// Of a view: only what may be bound can be read.
    fn of(texture: Option<&ViewDepthTexture>) -> Self {
        let bound = |depth: &&ViewDepthTexture| {
            depth.texture.usage().contains(TextureUsages::TEXTURE_BINDING)
        };
        match texture.filter(bound) {
            None => Self::None,
            Some(depth) if depth.texture.sample_count() > 1 => Self::Multiple,
            Some(_) => Self::Single,
        }
    }

    fn definitions(self) -> Vec<ShaderDefVal> {
        match self {
            Self::None => vec![],
            Self::Single => vec!["DEPTH".into()],
            Self::Multiple => vec!["DEPTH".into(), "SAMPLES".into()],
        }
    }
}

/// Pictures that will show the panel keep their depth where it can be read: also before it opens, since
/// a picture that is refined already isn't drawn again for it.
pub(super) fn keep_depth(
    settings: Res<PanelSettings>,
    screen: Res<Screen>,
    viewers: Query<(), With<PanelViewer>>,
    mut cameras: Query<(Entity, &RenderTarget, Has<PanelEye>, &mut Camera3d)>,
) {
    if settings.through >= 1.0 || !settings.place.is_world(!viewers.is_empty()) {
        return;
    }
    for (entity, target, eye, mut camera) in &mut cameras {
        let usages = TextureUsages::from(camera.depth_texture_usages);
        let kept = usages.contains(TextureUsages::TEXTURE_BINDING);
        if !kept && is_shown_by(entity, target, eye, screen.camera) {
            camera.depth_texture_usages = (usages | TextureUsages::TEXTURE_BINDING).into();
        }
    }
}

fn extract(
    mut quad: ResMut<Quad>,
    panel: Extract<Res<WorldPanel>>,
    screen: Extract<Res<Screen>>,
    settings: Extract<Res<PanelSettings>>,
    cameras: Extract<Query<(Entity, &RenderTarget, Has<PanelEye>), With<Camera3d>>>,
) {
    quad.cameras.clear();
    quad.image = None;
    let Some(pose) = panel.transform() else { return };
    quad.image = Some(panel.image.id());
    quad.world_from_panel = pose.with_scale(panel.size.extend(1.0)).to_matrix();
    quad.texels = panel.texels.as_vec2();
    quad.through = settings.through.clamp(0.0, 1.0);
    let shows = cameras
        .iter()
        .filter(|(entity, target, eye)| is_shown_by(*entity, target, *eye, screen.camera));
    quad.cameras.extend(shows.map(|(entity, ..)| entity));
}

/// Pipelines, and how what they read is bound.
#[derive(Resource)]
struct Pipelines {
    /// Without depth, with one sample of it a pixel, with several.
    layouts: [BindGroupLayoutDescriptor; 3],
    filter: Sampler,
    made: Vec<((TextureFormat, Depth), CachedRenderPipelineId)>,
}

impl Pipelines {
    fn layout(&self, depth: Depth) -> &BindGroupLayoutDescriptor {
        &self.layouts[depth as usize]
    }
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
        let layouts = [None, Some(texture_depth_2d()), Some(texture_depth_2d_multisampled())];
        let layouts = layouts.map(|depth| {
            let mut entries = entries.to_vec();
            entries.extend(depth.map(|depth| depth.build(3, ShaderStages::FRAGMENT)));
            BindGroupLayoutDescriptor::new("farlight_panel", &entries)
        });
        let filter = world.resource::<RenderDevice>().create_sampler(&SamplerDescriptor {
            label: Some("farlight_panel"),
            mag_filter: FilterMode::Linear,
            min_filter: FilterMode::Linear,
            ..default()
        });
        Self { layouts, filter, made: Vec::new() }
    }
}

/// Makes pipelines for the formats of pictures that show it.
fn prepare(
    quad: Res<Quad>,
    mut pipelines: ResMut<Pipelines>,
    cache: Res<PipelineCache>,
    server: Res<AssetServer>,
    views: Query<(&MainEntity, &ViewTarget, Option<&ViewDepthTexture>)>,
) {
    for (main, target, depth) in &views {
        let format = target.main_texture_format();
        let kind = (format, Depth::of(depth));
        let known = pipelines.made.iter().any(|(known, _)| *known == kind);
        if known || !quad.cameras.contains(&main.id()) {
            continue;
        }
        let shader = server.load(shader_path("panel/quad.wgsl"));
        let id = cache.queue_render_pipeline(RenderPipelineDescriptor {
            label: Some("farlight_panel".into()),
            layout: vec![pipelines.layout(kind.1).clone()],
            vertex: VertexState { shader: shader.clone(), ..default() },
            fragment: Some(FragmentState {
                shader,
                shader_defs: kind.1.definitions(),
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
        pipelines.made.push((kind, id));
    }
}

fn draw(
    view: ViewQuery<(
        &MainEntity,
        &ExtractedView,
        &ExtractedCamera,
        &ViewTarget,
        Option<&ViewDepthTexture>,
    )>,
    quad: Res<Quad>,
    pipelines: Res<Pipelines>,
    images: Res<RenderAssets<GpuImage>>,
    cache: Res<PipelineCache>,
    mut context: RenderContext,
) {
    let (main, view, camera, target, depth) = view.into_inner();
    if !quad.cameras.contains(&main.id()) {
        return;
    }
    let kind = (target.main_texture_format(), Depth::of(depth));
    let made = pipelines.made.iter().find(|(known, _)| *known == kind);
    let (Some(pipeline), Some(image)) = (
        made.and_then(|(_, id)| cache.get_render_pipeline(*id)),
        quad.image.and_then(|image| images.get(image)),
    ) else {
        return;
    };
    let view_from_world = view.world_from_view.affine().inverse();
    let clip_from_panel = view.clip_from_view * Mat4::from(view_from_world) * quad.world_from_panel;
    let numbers = clip_from_panel.to_cols_array();
    let pixels = target.main_texture().size();
    let [across, down] = [pixels.width as f32, pixels.height as f32];
    let rest = [quad.texels.x, quad.texels.y, across, down, quad.through, 0.0, 0.0, 0.0];
    let numbers = numbers.into_iter().chain(rest);
    let contents: Vec<u8> = numbers.flat_map(f32::to_ne_bytes).collect();
    let device = context.render_device().clone();
    let uniform = device.create_buffer_with_data(&BufferInitDescriptor {
        label: Some("farlight_panel"),
        contents: &contents,
        usage: BufferUsages::UNIFORM,
    });
    let layout = cache.get_bind_group_layout(pipelines.layout(kind.1));
    let (uniform, picture) = (uniform.as_entire_binding(), &image.texture_view);
    let filter = &pipelines.filter;
    let bound = match depth.filter(|_| kind.1 != Depth::None) {
        None => {
            let entries = BindGroupEntries::sequential((uniform, picture, filter));
            device.create_bind_group("farlight_panel", &layout, &entries)
        }
        Some(depth) => {
            let entries = BindGroupEntries::sequential((uniform, picture, filter, depth.view()));
            device.create_bind_group("farlight_panel", &layout, &entries)
        }
    };
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
