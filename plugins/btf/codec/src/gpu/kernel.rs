//! A compute kernel over the tables of a material.

use farlight_shaders::Definition;
use wgpu::util::DeviceExt;

use super::{Gpu, GpuError};
use crate::{Btf, Rules};

/// Invocations of a workgroup, as the kernels declare it.
pub(super) const GROUP: u32 = 64;

/// The definitions of [`Rules`], and where kernels bind the tables.
pub(super) fn definitions(rules: Rules) -> Vec<Definition<'static>> {
    let mut definitions =
        vec![Definition::Number("BTF_GROUP", 0), Definition::Number("BTF_TABLES", 1)];
    let flags = [
        (rules.half_end_slope, "BTF_HALF_END_SLOPE"),
        (rules.guard_beta_pole, "BTF_GUARD_BETA_POLE"),
        (rules.linear, "BTF_LINEAR"),
    ];
    definitions.extend(flags.iter().filter(|flag| flag.0).map(|flag| Definition::Flag(flag.1)));
    definitions
}

/// A material on the device.
#[derive(Debug)]
pub(super) struct Resident {
    layout: wgpu::Buffer,
    words: wgpu::Buffer,
}

impl Resident {
    pub(super) fn new(gpu: &Gpu, btf: &Btf) -> Result<Self, GpuError> {
        let words: &[u8] = bytemuck::cast_slice(btf.words());
        let (bytes, limit) = (words.len() as u64, gpu.largest_tables());
        if bytes > limit {
            return Err(GpuError::TooLarge { bytes, limit, adapter: gpu.adapter().to_owned() });
        }
        let buffer = |label, contents, usage| {
            let descriptor =
                wgpu::util::BufferInitDescriptor { label: Some(label), contents, usage };
            gpu.device.create_buffer_init(&descriptor)
        };
        let layout = bytemuck::bytes_of(btf.layout());
        let resident = Self {
            layout: buffer("layout", layout, wgpu::BufferUsages::UNIFORM),
            words: buffer("tables", words, wgpu::BufferUsages::STORAGE),
        };
        gpu.check()?;
        Ok(resident)
    }
}

/// A kernel with the bindings layout, tables, input, output and perhaps one more.
#[derive(Debug)]
pub(super) struct Kernel {
    pipeline: wgpu::ComputePipeline,
}

impl Kernel {
    pub(super) fn new(gpu: &Gpu, path: &str, rules: Rules) -> Result<Self, GpuError> {
        let module = farlight_shaders::compose(path, &definitions(rules))?;
        let module = gpu.device.create_shader_module(wgpu::ShaderModuleDescriptor {
            label: Some(path),
            source: wgpu::ShaderSource::Naga(std::borrow::Cow::Owned(module)),
        });
        let pipeline = gpu.device.create_compute_pipeline(&wgpu::ComputePipelineDescriptor {
            label: Some(path),
            layout: None,
            module: &module,
            entry_point: None,
            compilation_options: wgpu::PipelineCompilationOptions::default(),
            cache: None,
        });
        gpu.check()?;
        Ok(Self { pipeline })
    }

    pub(super) fn bind(
        &self,
        gpu: &Gpu,
        material: &Resident,
        input: wgpu::BufferSlice,
        output: wgpu::BufferSlice,
        more: Option<&wgpu::Buffer>,
    ) -> wgpu::BindGroup {
        let entry = |binding, resource| wgpu::BindGroupEntry { binding, resource };
        let mut entries = vec![
            entry(0, material.layout.as_entire_binding()),
            entry(1, material.words.as_entire_binding()),
            entry(2, input.into()),
            entry(3, output.into()),
        ];
        entries.extend(more.map(|buffer| entry(4, buffer.as_entire_binding())));
        gpu.device.create_bind_group(&wgpu::BindGroupDescriptor {
            label: None,
            layout: &self.pipeline.get_bind_group_layout(0),
            entries: &entries,
        })
    }

    /// One invocation for each of `count` inputs.
    pub(super) fn dispatch(
        &self,
        encoder: &mut wgpu::CommandEncoder,
        bindings: &wgpu::BindGroup,
        count: u32,
        timestamp_writes: Option<wgpu::ComputePassTimestampWrites>,
    ) {
        let descriptor = wgpu::ComputePassDescriptor { label: None, timestamp_writes };
        let mut pass = encoder.begin_compute_pass(&descriptor);
        pass.set_pipeline(&self.pipeline);
        pass.set_bind_group(0, bindings, &[]);
        pass.dispatch_workgroups(count.div_ceil(GROUP), 1, 1);
    }
}
