//! How long kernels take.

use std::time::{Duration, Instant};

use super::{GpuError, GpuEvaluator};
use crate::Query;

/// What tells the time.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Clock {
    /// The device, before and after a kernel.
    Device,
    /// The computer: the difference to a submission in which nothing is computed.
    Computer,
}

/// The time of one kernel.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Timing {
    /// Median over the rounds.
    pub median: Duration,
    /// Shortest of the rounds.
    pub shortest: Duration,
    /// Queries that the kernel answered.
    pub queries: usize,
    /// What told the time.
    pub clock: Clock,
}

impl Timing {
    fn new(mut times: Vec<Duration>, queries: usize, clock: Clock) -> Self {
        times.sort();
        Self { median: times[times.len() / 2], shortest: times[0], queries, clock }
    }
}

impl GpuEvaluator {
    /// How long the device takes for `queries` (the first 2^18 of them at most), measured `rounds`
    /// times, at least once; transfers do not count.
    ///
    /// # Errors
    ///
    /// As [`GpuEvaluator::evaluate`].
    pub fn time(&self, queries: &[Query], rounds: usize) -> Result<Timing, GpuError> {
        self.gpu.check()?;
        let queries = &queries[..queries.len().min(self.chunk)];
        if queries.is_empty() {
            return Ok(Timing::new(vec![Duration::ZERO], 0, Clock::Computer));
        }
        let bindings = self.upload(queries);
        let count = queries.len() as u32;
        // The first run waits for the upload, and for the driver to compile.
        self.submit(&bindings, count)?;
        let rounds = 0..rounds.max(1);
        if self.gpu.device.features().contains(wgpu::Features::TIMESTAMP_QUERY) {
            let times: Result<_, _> = rounds.map(|_| self.device_time(&bindings, count)).collect();
            return Ok(Timing::new(times?, queries.len(), Clock::Device));
        }
        let times: Result<_, _> = rounds
            .map(|_| {
                let nothing = self.submit(&bindings, 0)?;
                Ok::<_, GpuError>(self.submit(&bindings, count)?.saturating_sub(nothing))
            })
            .collect();
        Ok(Timing::new(times?, queries.len(), Clock::Computer))
    }

    /// Runs the kernel; the time on the computer's clock.
    fn submit(&self, bindings: &wgpu::BindGroup, count: u32) -> Result<Duration, GpuError> {
        let start = Instant::now();
        let mut encoder = self.gpu.device.create_command_encoder(&Default::default());
        self.kernel.dispatch(&mut encoder, bindings, count, None);
        self.gpu.queue.submit([encoder.finish()]);
        self.gpu.wait()?;
        Ok(start.elapsed())
    }

    /// Runs the kernel; the time on the device's clock.
    fn device_time(&self, bindings: &wgpu::BindGroup, count: u32) -> Result<Duration, GpuError> {
        let device = &self.gpu.device;
        let stamps = device.create_query_set(&wgpu::QuerySetDescriptor {
            label: None,
            ty: wgpu::QueryType::Timestamp,
            count: 2,
        });
        let buffer = |usage| {
            device.create_buffer(&wgpu::BufferDescriptor {
                label: Some("timestamps"),
                size: 16,
                usage,
                mapped_at_creation: false,
            })
        };
        use wgpu::BufferUsages as Usage;
        let resolved = buffer(Usage::QUERY_RESOLVE | Usage::COPY_SRC);
        let read = buffer(Usage::COPY_DST | Usage::MAP_READ);
        let mut encoder = device.create_command_encoder(&Default::default());
        let writes = wgpu::ComputePassTimestampWrites {
            query_set: &stamps,
            beginning_of_pass_write_index: Some(0),
            end_of_pass_write_index: Some(1),
        };
        self.kernel.dispatch(&mut encoder, bindings, count, Some(writes));
        encoder.resolve_query_set(&stamps, 0..2, &resolved, 0);
        encoder.copy_buffer_to_buffer(&resolved, 0, &read, 0, 16);
        self.gpu.queue.submit([encoder.finish()]);
        let [start, end] = *self.gpu.read::<u64>(&read, 16)? else {
            return Err(self.gpu.failed("gave no timestamps"));
        };
        let period = f64::from(self.gpu.queue.get_timestamp_period());
        Ok(Duration::from_secs_f64(end.saturating_sub(start) as f64 * period * 1e-9))
    }
}
