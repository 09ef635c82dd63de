//! A device without an engine.

use std::sync::{Arc, Mutex, PoisonError, mpsc};
use std::time::Duration;

use wgpu::util::initialize_adapter_from_env;

use super::GpuError;

/// The device has hung if it does not answer for so long.
const PATIENCE: Duration = Duration::from_secs(120);

/// A GPU (or a driver that computes on the CPU), opened for compute shaders.
#[derive(Clone, Debug)]
pub struct Gpu {
    pub(super) device: wgpu::Device,
    pub(super) queue: wgpu::Queue,
    adapter: String,
    largest_tables: u64,
    trouble: Arc<Mutex<Option<Trouble>>>,
}

#[derive(Clone, Debug)]
enum Trouble {
    Failed(String),
    Lost(String),
}

impl Gpu {
    /// Opens the fastest adapter, or the one that the variables `WGPU_BACKEND` and
    /// `WGPU_ADAPTER_NAME` name.
    ///
    /// # Errors
    ///
    /// There is no adapter, or it gives no device.
    pub fn new() -> Result<Self, GpuError> {
        let instance =
            wgpu::Instance::new(wgpu::InstanceDescriptor::new_without_display_handle_from_env());
        let adapter = futures_lite::future::block_on(async {
            match initialize_adapter_from_env(&instance, None).await {
                Err(wgpu::RequestAdapterError::EnvNotSet) => {
                    let options = wgpu::RequestAdapterOptions {
                        power_preference: wgpu::PowerPreference::HighPerformance,
                        ..wgpu::RequestAdapterOptions::default()
                    };
                    instance.request_adapter(&options).await
                }
                other => other,
            }
        })
        .map_err(|error| GpuError::NoAdapter(error.to_string()))?;
        let info = adapter.get_info();
        let name = format!("{} ({})", info.name, info.backend);
        let descriptor = wgpu::DeviceDescriptor {
            label: Some("measured materials"),
            required_features: adapter.features() & wgpu::Features::TIMESTAMP_QUERY,
            required_limits: adapter.limits(),
            ..wgpu::DeviceDescriptor::default()
        };
        let (device, queue) =
            futures_lite::future::block_on(adapter.request_device(&descriptor)).map_err(
                |error| GpuError::NoDevice { adapter: name.clone(), what: error.to_string() },
            )?;

        // The default handlers panic.
        let trouble = Arc::new(Mutex::new(None));
        let found = trouble.clone();
        device.on_uncaptured_error(Arc::new(move |error: wgpu::Error| {
            note(&found, Trouble::Failed(error.to_string()));
        }));
        let found = trouble.clone();
        device.set_device_lost_callback(move |reason, text| {
            note(&found, Trouble::Lost(format!("{reason:?}. {text}")));
        });
        let limits = device.limits();
        let largest_tables = limits.max_storage_buffer_binding_size.min(limits.max_buffer_size);
        Ok(Self { device, queue, adapter: name, largest_tables, trouble })
    }

    /// Name and interface of the adapter.
    pub fn adapter(&self) -> &str {
        &self.adapter
    }

    /// The most bytes of tables that a material may have.
    pub fn largest_tables(&self) -> u64 {
        self.largest_tables
    }

    /// The first `bytes` of a buffer that the computer may map, once all that was submitted is done.
    pub(super) fn read<T: bytemuck::AnyBitPattern>(
        &self,
        buffer: &wgpu::Buffer,
        bytes: u64,
    ) -> Result<Box<[T]>, GpuError> {
        let slice = buffer.slice(..bytes);
        let (sender, receiver) = mpsc::channel();
        slice.map_async(wgpu::MapMode::Read, move |result| {
            // Nobody listens any more if waiting failed.
            let _ = sender.send(result);
        });
        self.wait()?;
        match receiver.try_recv() {
            Ok(Ok(())) => {}
            Ok(Err(error)) => return Err(self.failed(error.to_string())),
            Err(_) => return Err(self.failed("gave no answer")),
        }
        let view = slice.get_mapped_range();
        let values =
            (view.chunks_exact(size_of::<T>())).map(bytemuck::pod_read_unaligned).collect();
        drop(view);
        buffer.unmap();
        Ok(values)
    }

    /// Waits until all that was submitted is done.
    pub(super) fn wait(&self) -> Result<(), GpuError> {
        let poll = wgpu::PollType::Wait { submission_index: None, timeout: Some(PATIENCE) };
        let polled = self.device.poll(poll);
        self.check()?;
        polled.map(|_| ()).map_err(|error| self.failed(error.to_string()))
    }

    /// What went wrong since the device was opened, if something did.
    pub(super) fn check(&self) -> Result<(), GpuError> {
        let trouble = self.trouble.lock().unwrap_or_else(PoisonError::into_inner).clone();
        match trouble {
            None => Ok(()),
            Some(Trouble::Failed(what)) => Err(self.failed(what)),
            Some(Trouble::Lost(what)) => {
                Err(GpuError::Lost { adapter: self.adapter.clone(), what })
            }
        }
    }

    pub(super) fn failed(&self, what: impl Into<String>) -> GpuError {
        GpuError::Failed { adapter: self.adapter.clone(), what: what.into() }
    }
}

#[cfg(test)]
impl Gpu {
    /// A device whose buffers are small.
    pub(super) fn limited(self, largest_tables: u64) -> Self {
        Self { largest_tables, ..self }
    }
}

/// Keeps the first trouble: what follows follows from it. Loss explains everything.
fn note(found: &Mutex<Option<Trouble>>, new: Trouble) {
    let mut found = found.lock().unwrap_or_else(PoisonError::into_inner);
    if found.is_none() || matches!(new, Trouble::Lost(_)) {
        *found = Some(new);
    }
}
