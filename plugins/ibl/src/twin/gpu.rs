//! The pass on a device, without an engine.

use bevy::math::{IVec2, Vec4};
use farlight_shaders::{Definition, compose};
use half::f16;
use wgpu::util::DeviceExt;

use super::{Image, Input, Output};
use crate::uniform::Accumulation;

/// A triangle that covers everything.
const COVER: &str = "
@vertex
fn vertex(@builtin(vertex_index) i: u32) -> @builtin(position) vec4<f32> {
    return vec4(f32(i >> 1u) * 4.0 - 1.0, 1.0 - f32(i & 1u) * 4.0, 0.0, 1.0);
}
";

pub(super) struct Gpu {
    device: wgpu::Device,
    queue: wgpu::Queue,
}

/// `None` with a reason where there is no device that can do it.
pub(super) fn open() -> Result<Gpu, String> {
    let instance =
        wgpu::Instance::new(wgpu::InstanceDescriptor::new_without_display_handle_from_env());
    let adapter = instance.request_adapter(&wgpu::RequestAdapterOptions::default());
    let adapter = futures_lite::future::block_on(adapter).map_err(|error| error.to_string())?;
    let descriptor = wgpu::DeviceDescriptor::default();
    let device = futures_lite::future::block_on(adapter.request_device(&descriptor));
    let (device, queue) = device.map_err(|error| error.to_string())?;
    Ok(Gpu { device, queue })
}

impl Gpu {
    fn texture(&self, format: wgpu::TextureFormat, size: IVec2, data: &[u8]) -> wgpu::TextureView {
        let descriptor = texture(format, size, wgpu::TextureUsages::TEXTURE_BINDING);
        self.device
            .create_texture_with_data(
                &self.queue,
                &descriptor,
                wgpu::util::TextureDataOrder::LayerMajor,
                data,
            )
            .create_view(&wgpu::TextureViewDescriptor::default())
    }

    /// Depth can't be uploaded everywhere, so it is drawn.
    fn depth(&self, depth: &Image<f32>) -> wgpu::TextureView {
        let size = size(depth);
        let values =
            self.texture(wgpu::TextureFormat::R32Float, size, bytemuck::cast_slice(&depth.values));
        let source = format!(
            "{COVER}
            @group(0) @binding(0) var values: texture_2d<f32>;
            @fragment
            fn fragment(@builtin(position) p: vec4<f32>) -> @builtin(frag_depth) f32 {{
                return textureLoad(values, vec2<i32>(p.xy), 0).x;
            }}"
        );
        let module = self.device.create_shader_module(wgpu::ShaderModuleDescriptor {
            label: None,
            source: wgpu::ShaderSource::Wgsl(source.into()),
        });
        let format = wgpu::TextureFormat::Depth32Float;
        let usage = wgpu::TextureUsages::TEXTURE_BINDING | wgpu::TextureUsages::RENDER_ATTACHMENT;
        let target = self.device.create_texture(&texture(format, size, usage));
        let view = target.create_view(&wgpu::TextureViewDescriptor::default());
        let state = wgpu::DepthStencilState {
            format,
            depth_write_enabled: Some(true),
            depth_compare: Some(wgpu::CompareFunction::Always),
            stencil: wgpu::StencilState::default(),
            bias: wgpu::DepthBiasState::default(),
        };
        let pipeline = self.pipeline(&module, &module, &[], Some(state));
        let values = wgpu::BindingResource::TextureView(&values);
        self.draw(&pipeline, vec![(0, values)], &[], Some(&view));
        view
    }

    fn pipeline(
        &self,
        vertex: &wgpu::ShaderModule,
        fragment: &wgpu::ShaderModule,
        targets: &[Option<wgpu::ColorTargetState>],
        depth_stencil: Option<wgpu::DepthStencilState>,
    ) -> wgpu::RenderPipeline {
        self.device.create_render_pipeline(&wgpu::RenderPipelineDescriptor {
            label: None,
            layout: None,
            vertex: wgpu::VertexState {
                module: vertex,
                entry_point: Some("vertex"),
                compilation_options: Default::default(),
                buffers: &[],
            },
            fragment: Some(wgpu::FragmentState {
                module: fragment,
                entry_point: Some("fragment"),
                compilation_options: Default::default(),
                targets,
            }),
            primitive: Default::default(),
            depth_stencil,
            multisample: Default::default(),
            multiview_mask: None,
            cache: None,
        })
    }

    /// Draws over all pixels; `resources` by the number of their binding.
    fn draw(
        &self,
        pipeline: &wgpu::RenderPipeline,
        resources: Vec<(u32, wgpu::BindingResource<'_>)>,
        targets: &[wgpu::TextureView],
        depth: Option<&wgpu::TextureView>,
    ) {
        let entries: Vec<_> = resources
            .into_iter()
            .map(|(binding, resource)| wgpu::BindGroupEntry { binding, resource })
            .collect();
        let group = self.device.create_bind_group(&wgpu::BindGroupDescriptor {
            label: None,
            layout: &pipeline.get_bind_group_layout(0),
            entries: &entries,
        });
        let attachment = |view| {
            let ops = wgpu::Operations::default();
            Some(wgpu::RenderPassColorAttachment {
                view,
                depth_slice: None,
                resolve_target: None,
                ops,
            })
        };
        let attachments: Vec<_> = targets.iter().map(attachment).collect();
        let depth_ops =
            Some(wgpu::Operations { load: wgpu::LoadOp::Clear(0.0), store: wgpu::StoreOp::Store });
        let mut encoder = self.device.create_command_encoder(&Default::default());
        {
            let mut pass = encoder.begin_render_pass(&wgpu::RenderPassDescriptor {
                color_attachments: &attachments,
                depth_stencil_attachment: depth.map(|view| {
                    wgpu::RenderPassDepthStencilAttachment { view, depth_ops, stencil_ops: None }
                }),
                ..Default::default()
            });
            pass.set_pipeline(pipeline);
            pass.set_bind_group(0, &group, &[]);
            pass.draw(0..3, 0..1);
        }
        self.queue.submit([encoder.finish()]);
    }

    /// Runs the shader over all pixels.
    pub(super) fn run(&self, a: &Accumulation, input: &Input, still: bool) -> Vec<Output> {
        use wgpu::TextureFormat::{R32Float, Rg32Float, Rgba16Float, Rgba32Float};
        let size = size(&input.depth);
        let definition = match (still, a.still > 0.0) {
            (true, _) => vec![Definition::Flag("STILL")],
            (false, true) => vec![Definition::Flag("RESTED")],
            (false, false) => vec![],
        };
        let module = compose("ibl/accumulate.wgsl", &definition).unwrap();
        let fragment = self.device.create_shader_module(wgpu::ShaderModuleDescriptor {
            label: None,
            source: wgpu::ShaderSource::Naga(std::borrow::Cow::Owned(module)),
        });
        let vertex = self.device.create_shader_module(wgpu::ShaderModuleDescriptor {
            label: None,
            source: wgpu::ShaderSource::Wgsl(COVER.into()),
        });
        let formats = if still {
            vec![Rgba16Float, Rgba32Float]
        } else {
            vec![Rgba16Float, Rgba32Float, R32Float]
        };
        let usage = wgpu::TextureUsages::RENDER_ATTACHMENT | wgpu::TextureUsages::COPY_SRC;
        let targets: Vec<_> = formats
            .iter()
            .map(|format| self.device.create_texture(&texture(*format, size, usage)))
            .collect();
        let states: Vec<_> = formats.iter().map(|format| Some((*format).into())).collect();
        let pipeline = self.pipeline(&vertex, &fragment, &states, None);
        let colours = |image: &Image<Vec4>| {
            self.texture(Rgba32Float, size, bytemuck::cast_slice(&image.values))
        };
        let uniform = self.device.create_buffer_init(&wgpu::util::BufferInitDescriptor {
            label: None,
            contents: bytemuck::bytes_of(a),
            usage: wgpu::BufferUsages::UNIFORM,
        });
        // A layout that is made from the shader has only what the shader reads.
        let mut textures = vec![(1, colours(&input.frame)), (2, colours(&input.moved))];
        if still || a.still > 0.0 {
            textures.push((3, colours(&input.rested)));
        }
        if !still {
            let distance = bytemuck::cast_slice(&input.distance.values);
            textures.push((4, self.texture(R32Float, size, distance)));
            textures.push((5, self.depth(&input.depth)));
            let motion = bytemuck::cast_slice(&input.motion.values);
            textures.push((6, self.texture(Rg32Float, size, motion)));
        }
        let mut resources = vec![(0, uniform.as_entire_binding())];
        resources.extend(
            textures.iter().map(|(at, view)| (*at, wgpu::BindingResource::TextureView(view))),
        );
        let views: Vec<_> = targets
            .iter()
            .map(|target| target.create_view(&wgpu::TextureViewDescriptor::default()))
            .collect();
        self.draw(&pipeline, resources, &views, None);
        let read: Vec<Vec<f32>> = targets.iter().map(|target| self.read(target, size)).collect();
        let four = |values: &[f32], i: usize| Vec4::from_slice(&values[4 * i..]);
        (0..(size.x * size.y) as usize)
            .map(|i| Output {
                colour: four(&read[0], i),
                mean: four(&read[1], i),
                distance: read.get(2).map_or(0.0, |values| values[i]),
            })
            .collect()
    }

    fn read(&self, target: &wgpu::Texture, size: IVec2) -> Vec<f32> {
        let bytes = target.format().block_copy_size(None).unwrap_or(4) * size.x as u32;
        assert_eq!(bytes % 256, 0, "rows without padding");
        let buffer = self.device.create_buffer(&wgpu::BufferDescriptor {
            label: None,
            size: u64::from(bytes) * size.y as u64,
            usage: wgpu::BufferUsages::COPY_DST | wgpu::BufferUsages::MAP_READ,
            mapped_at_creation: false,
        });
        let mut encoder = self.device.create_command_encoder(&Default::default());
        encoder.copy_texture_to_buffer(
            target.as_image_copy(),
            wgpu::TexelCopyBufferInfo {
                buffer: &buffer,
                layout: wgpu::TexelCopyBufferLayout {
                    offset: 0,
                    bytes_per_row: Some(bytes),
                    rows_per_image: None,
                },
            },
            target.size(),
        );
        self.queue.submit([encoder.finish()]);
        buffer.slice(..).map_async(wgpu::MapMode::Read, |outcome| outcome.unwrap());
        self.device.poll(wgpu::PollType::wait_indefinitely()).unwrap();
        let bytes = buffer.slice(..).get_mapped_range();
        if target.format() == wgpu::TextureFormat::Rgba16Float {
            let halves: &[[u8; 2]] = bytemuck::cast_slice(&bytes);
            return halves.iter().map(|half| f16::from_le_bytes(*half).to_f32()).collect();
        }
        bytemuck::cast_slice(&bytes).to_vec()
    }
}

fn size<T>(image: &Image<T>) -> IVec2 {
    IVec2::new(image.width, image.values.len() as i32 / image.width)
}

fn texture(
    format: wgpu::TextureFormat,
    size: IVec2,
    usage: wgpu::TextureUsages,
) -> wgpu::TextureDescriptor<'static> {
    wgpu::TextureDescriptor {
        label: None,
        size: wgpu::Extent3d {
            width: size.x as u32,
            height: size.y as u32,
            depth_or_array_layers: 1,
        },
        mip_level_count: 1,
        sample_count: 1,
        dimension: wgpu::TextureDimension::D2,
        format,
        usage,
        view_formats: &[],
    }
}
