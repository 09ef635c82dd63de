//! Evaluation in a compute shader, without an engine: `shaders/btf/evaluate_points.wgsl`, and
//! `shaders/btf/evaluate_lights.wgsl` for many lights.

mod device;
mod error;
mod kernel;
#[cfg(test)]
mod tests;
mod timing;

use glam::Vec3;
use wgpu::util::DeviceExt;

use crate::{Angles, Btf, Query, Rules};

pub use device::Gpu;
pub use error::GpuError;
use kernel::{Kernel, Resident};
pub use timing::{Clock, Timing};

/// [`Query`] as the shader reads it.
#[repr(C)]
#[derive(Clone, Copy, Debug, bytemuck::Pod, bytemuck::Zeroable)]
struct Point {
    texel: [u32; 2],
    pad: [u32; 2],
    angles: [f32; 4],
}

/// Queries that go to the device at once: 8 MiB of them.
const CHUNK: usize = 1 << 18;

/// Values of one material on a GPU, the same as those of [`Btf::evaluate`] but for rounding.
#[derive(Debug)]
pub struct GpuEvaluator {
    gpu: Gpu,
    kernel: Kernel,
    material: Resident,
    size: [u32; 2],
    lights: Option<wgpu::Buffer>,
    points: wgpu::Buffer,
    values: wgpu::Buffer,
    answers: wgpu::Buffer,
    chunk: usize,
}

impl GpuEvaluator {
    /// Uploads a material and builds the shader for `rules`.
    ///
    /// # Errors
    ///
    /// Tables that are larger than the device's buffers; trouble of the device.
    pub fn new(gpu: &Gpu, btf: &Btf, rules: Rules) -> Result<Self, GpuError> {
        let kernel = Kernel::new(gpu, "btf/evaluate_points.wgsl", rules)?;
        Self::build(gpu, btf, kernel, None)
    }

    /// The same for sums over `lights`, unit vectors in the frame of the surface: of a query, only
    /// texel and view count. Lights below the surface give nothing.
    ///
    /// # Errors
    ///
    /// As [`GpuEvaluator::new`].
    pub fn with_lights(
        gpu: &Gpu,
        btf: &Btf,
        rules: Rules,
        lights: &[Vec3],
    ) -> Result<Self, GpuError> {
        let kernel = Kernel::new(gpu, "btf/evaluate_lights.wgsl", rules)?;
        let mut lights: Vec<[f32; 4]> = lights.iter().map(|l| l.extend(0.0).to_array()).collect();
        if lights.is_empty() {
            // A buffer can't be empty; this one is below the surface.
            lights.push([0.0, 0.0, -1.0, 0.0]);
        }
        let buffer = gpu.device.create_buffer_init(&wgpu::util::BufferInitDescriptor {
            label: Some("lights"),
            contents: bytemuck::cast_slice(&lights),
            usage: wgpu::BufferUsages::STORAGE,
        });
        Self::build(gpu, btf, kernel, Some(buffer))
    }

    fn build(
        gpu: &Gpu,
        btf: &Btf,
        kernel: Kernel,
        lights: Option<wgpu::Buffer>,
    ) -> Result<Self, GpuError> {
        let material = Resident::new(gpu, btf)?;
        let limits = gpu.device.limits();
        let largest = gpu.largest_tables() / size_of::<Point>() as u64;
        let chunk = CHUNK
            .min(usize::try_from(largest).unwrap_or(CHUNK))
            .min(limits.max_compute_workgroups_per_dimension as usize * kernel::GROUP as usize)
            .max(1);
        let buffer = |label, stride: usize, usage| {
            gpu.device.create_buffer(&wgpu::BufferDescriptor {
                label: Some(label),
                size: (chunk * stride) as u64,
                usage,
                mapped_at_creation: false,
            })
        };
        use wgpu::BufferUsages as Usage;
        let evaluator = Self {
            points: buffer("queries", size_of::<Point>(), Usage::STORAGE | Usage::COPY_DST),
            values: buffer("values", size_of::<[f32; 4]>(), Usage::STORAGE | Usage::COPY_SRC),
            answers: buffer("answers", size_of::<[f32; 4]>(), Usage::MAP_READ | Usage::COPY_DST),
            gpu: gpu.clone(),
            kernel,
            material,
            size: btf.size(),
            lights,
            chunk,
        };
        gpu.check()?;
        Ok(evaluator)
    }

    /// The values of any number of queries, in their order.
    ///
    /// # Errors
    ///
    /// Trouble of the device; it does not go away by asking again.
    pub fn evaluate(&self, queries: &[Query]) -> Result<Vec<Vec3>, GpuError> {
        self.gpu.check()?;
        let mut values = Vec::with_capacity(queries.len());
        for queries in queries.chunks(self.chunk) {
            self.chunk(queries, &mut values)?;
        }
        Ok(values)
    }

    fn chunk(&self, queries: &[Query], values: &mut Vec<Vec3>) -> Result<(), GpuError> {
        let bytes = (queries.len() * size_of::<[f32; 4]>()) as u64;
        let device = &self.gpu.device;
        let bindings = self.upload(queries);
        let mut encoder = device.create_command_encoder(&Default::default());
        self.kernel.dispatch(&mut encoder, &bindings, queries.len() as u32, None);
        encoder.copy_buffer_to_buffer(&self.values, 0, &self.answers, 0, bytes);
        self.gpu.queue.submit([encoder.finish()]);

        let answers = self.gpu.read::<[f32; 4]>(&self.answers, bytes)?;
        values.extend(answers.iter().map(|[x, y, z, _]| Vec3::new(*x, *y, *z)));
        Ok(())
    }

    /// Sends queries, no more than a chunk, and binds them.
    fn upload(&self, queries: &[Query]) -> wgpu::BindGroup {
        let points: Vec<Point> = queries.iter().map(|query| self.point(query)).collect();
        self.gpu.queue.write_buffer(&self.points, 0, bytemuck::cast_slice(&points));
        self.kernel.bind(
            &self.gpu,
            &self.material,
            self.points.slice(..(points.len() * size_of::<Point>()) as u64),
            self.values.slice(..(points.len() * size_of::<[f32; 4]>()) as u64),
            self.lights.as_ref(),
        )
    }

    fn point(&self, query: &Query) -> Point {
        let wrap = |at: i32, count: u32| i64::from(at).rem_euclid(i64::from(count)) as u32;
        let Angles { theta_i, phi_i, theta_v, phi_v } = query.angles;
        Point {
            texel: [wrap(query.x, self.size[0]), wrap(query.y, self.size[1])],
            pad: [0; 2],
            angles: [theta_i, phi_i, theta_v, phi_v],
        }
    }
}
