//! Evaluation in a compute shader, without an engine: `shaders/btf/evaluate_points.wgsl`.

mod device;
mod error;
mod kernel;
#[cfg(test)]
mod tests;

use glam::Vec3;

use crate::{Angles, Btf, Rules};

pub use device::Gpu;
pub use error::GpuError;
use kernel::{Kernel, Resident};

/// One value to find: a texel and two directions.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Query {
    /// Column of the texel; wraps round.
    pub x: i32,
    /// Row of the texel; wraps round.
    pub y: i32,
    /// Directions of light and view.
    pub angles: Angles,
}

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
        let points: Vec<Point> = queries.iter().map(|query| self.point(query)).collect();
        let bytes = (queries.len() * size_of::<[f32; 4]>()) as u64;
        let device = &self.gpu.device;
        self.gpu.queue.write_buffer(&self.points, 0, bytemuck::cast_slice(&points));
        let bindings = self.kernel.bind(
            &self.gpu,
            &self.material,
            self.points.slice(..(points.len() * size_of::<Point>()) as u64),
            self.values.slice(..bytes),
        );
        let mut encoder = device.create_command_encoder(&Default::default());
        self.kernel.dispatch(&mut encoder, &bindings, queries.len() as u32, None);
        encoder.copy_buffer_to_buffer(&self.values, 0, &self.answers, 0, bytes);
        self.gpu.queue.submit([encoder.finish()]);

        let answers = self.answers.slice(..bytes);
        let (sender, receiver) = std::sync::mpsc::channel();
        answers.map_async(wgpu::MapMode::Read, move |result| {
            // Nobody listens any more if waiting failed.
            let _ = sender.send(result);
        });
        self.gpu.wait()?;
        match receiver.try_recv() {
            Ok(Ok(())) => {}
            Ok(Err(error)) => return Err(self.gpu.failed(error.to_string())),
            Err(_) => return Err(self.gpu.failed("gave no answer")),
        }
        let view = answers.get_mapped_range();
        values.extend(view.chunks_exact(size_of::<[f32; 4]>()).map(|value| {
            let [x, y, z, _]: [f32; 4] = bytemuck::pod_read_unaligned(value);
            Vec3::new(x, y, z)
        }));
        drop(view);
        self.answers.unmap();
        Ok(())
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
