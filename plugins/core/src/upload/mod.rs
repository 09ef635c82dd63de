//! Texels into existing textures, a bounded number of bytes a frame.
//!
//! Anyone hands over boxes of texels with [`TextureUploads::write`]; a system of the render world
//! writes them into the textures of [`Image`] assets by `RenderQueue::write_texture`. No asset is
//! touched, so nothing is prepared again and nothing waits for the GPU.

mod queue;

use std::{
    collections::VecDeque,
    sync::{Arc, Mutex, MutexGuard, PoisonError},
};

use bevy::{
    asset::AssetId,
    image::Image,
    log::error,
    platform::time::Instant,
    prelude::*,
    render::{
        Render, RenderApp, RenderStartup, RenderSystems,
        render_asset::{RenderAssets, prepare_assets},
        render_resource::{
            Extent3d, Origin3d, TexelCopyBufferLayout, TexelCopyTextureInfo, TextureAspect,
        },
        renderer::RenderQueue,
        texture::GpuImage,
    },
};

pub use queue::{Region, RegionProblem, Ticket};

use crate::{CostMeter, Measured};
use queue::{Entry, Queue, Rows, Written};

/// Data on its way into textures. Cloning shares it.
#[derive(Resource, Clone)]
pub struct TextureUploads {
    shared: Arc<Mutex<Shared>>,
    meter: CostMeter,
}

struct Shared {
    queue: Queue,
    bytes_per_frame: usize,
    all_next_frame: bool,
    most_waiting: usize,
    written_bytes: u64,
    renderer: bool,
    device: u64,
    started: VecDeque<(Ticket, Instant)>,
    finished: VecDeque<(Ticket, Instant)>,
    last_started: Ticket,
}

/// How far the uploads are.
#[derive(Clone, Debug, Default)]
pub struct UploadProgress {
    /// All data up to this ticket is written, or replaced by newer data that is.
    pub done: Ticket,
    /// Bytes that wait.
    pub waiting_bytes: usize,
    /// Bytes written since the start.
    pub written_bytes: u64,
    /// Counts the GPU devices so far. When it grows past 1, the old device was lost and textures
    /// are empty: send everything again.
    pub device: u64,
    /// When the first texels of a ticket (or of an older one that it replaced) were written, for
    /// the tickets since [`TextureUploads::progress`] was last called, oldest first.
    pub started: Vec<(Ticket, Instant)>,
    /// When everything up to a ticket was written, likewise.
    pub finished: Vec<(Ticket, Instant)>,
}

/// What a write costs besides its bytes, in bytes: a staging buffer and some driver calls take about
/// as long as copying this much.
const WRITE_OVERHEAD: usize = 8 << 10;

/// Most entries of the lists of times between two looks at the progress.
const MAX_TIMES: usize = 256;

impl Default for TextureUploads {
    fn default() -> Self {
        Self {
            shared: Arc::new(Mutex::new(Shared {
                queue: Queue::default(),
                bytes_per_frame: 1 << 20,
                all_next_frame: false,
                most_waiting: 128 << 20,
                written_bytes: 0,
                renderer: false,
                device: 0,
                started: VecDeque::new(),
                finished: VecDeque::new(),
                last_started: Ticket(0),
            })),
            meter: CostMeter::new(1),
        }
    }
}

impl TextureUploads {
    fn lock(&self) -> MutexGuard<'_, Shared> {
        // The queue stays consistent at every point where a panic is possible.
        self.shared.lock().unwrap_or_else(PoisonError::into_inner)
    }

    /// Hands texels of `image` over: rows from the top, slice after slice, in the image's format.
    /// Data that still waits for the same region is replaced.
    ///
    /// Without a renderer the data counts as written at once.
    ///
    /// # Errors
    /// [`RegionProblem`]; nothing is queued then.
    pub fn write(
        &self,
        image: AssetId<Image>,
        region: Region,
        bytes: Vec<u8>,
    ) -> Result<Ticket, RegionProblem> {
        let mut shared = self.lock();
        let limit = shared.most_waiting;
        let ticket = shared.queue.push(image, region, bytes, limit);
        if !shared.renderer {
            shared.queue.forget(image);
        }
        ticket
    }

    /// Forgets what waits for `image`. Call it when the image is dropped.
    pub fn forget(&self, image: AssetId<Image>) {
        self.lock().queue.forget(image);
    }

    /// Most bytes that are written a frame (a single row of texels is always written). At 1 MiB,
    /// the default, a 1024² page of half floats takes 8 frames.
    pub fn set_bytes_per_frame(&self, bytes: usize) {
        self.lock().bytes_per_frame = bytes;
    }

    /// Writes everything that waits in the next frame, whatever it costs: for switches that must
    /// not be seen halfway.
    pub fn write_all_next_frame(&self) {
        self.lock().all_next_frame = true;
    }

    /// Most bytes that may wait; 128 MiB by default.
    pub fn set_most_waiting(&self, bytes: usize) {
        self.lock().most_waiting = bytes;
    }

    /// Whether there is a renderer that writes.
    #[must_use]
    pub fn has_renderer(&self) -> bool {
        self.lock().renderer
    }

    /// How far the uploads are. The lists of times start anew with each call.
    #[must_use]
    pub fn progress(&self) -> UploadProgress {
        let mut shared = self.lock();
        UploadProgress {
            done: shared.queue.done(),
            waiting_bytes: shared.queue.bytes(),
            written_bytes: shared.written_bytes,
            device: shared.device,
            started: shared.started.drain(..).collect(),
            finished: shared.finished.drain(..).collect(),
        }
    }

    /// Bytes that wait.
    #[must_use]
    pub fn waiting_bytes(&self) -> usize {
        self.lock().queue.bytes()
    }

    /// What writing cost since it was last asked.
    #[must_use]
    pub fn take_cost(&self) -> Measured {
        self.meter.take(0)
    }
}

/// Adds the resource to both worlds and the system that writes to the render world.
pub(crate) fn build(app: &mut App) {
    app.init_resource::<TextureUploads>();
    let uploads = app.world().resource::<TextureUploads>().clone();
    let Some(render_app) = app.get_sub_app_mut(RenderApp) else { return };
    uploads.lock().renderer = true;
    render_app
        .insert_resource(uploads)
        .add_systems(RenderStartup, |uploads: Res<TextureUploads>| uploads.lock().device += 1)
        .add_systems(
            Render,
            write_textures
                .in_set(RenderSystems::PrepareResources)
                .after(prepare_assets::<GpuImage>),
        );
}

fn write_textures(
    uploads: Res<TextureUploads>,
    queue: Res<RenderQueue>,
    images: Res<RenderAssets<GpuImage>>,
) {
    let mut shared = uploads.lock();
    let all = std::mem::take(&mut shared.all_next_frame);
    if shared.queue.bytes() == 0 {
        return;
    }
    let _measure = uploads.meter.measure(0);
    let budget = if all { usize::MAX } else { shared.bytes_per_frame };
    let before = shared.queue.done();
    let mut newest = Ticket(0);
    let written = shared.queue.drain(budget, WRITE_OVERHEAD, |entry, rows| {
        let Some(image) = images.get(entry.image) else { return Written::Later };
        if let Err(problem) = fits(entry, image) {
            error!("texels for an image are dropped: {problem}");
            return Written::Never;
        }
        newest = newest.max(entry.newest());
        write_rows(&queue, image, entry, rows);
        Written::Yes
    });
    let now = Instant::now();
    shared.written_bytes += written as u64;
    if newest > shared.last_started {
        shared.last_started = newest;
        shared.started.push_back((newest, now));
    }
    let done = shared.queue.done();
    if done > before {
        shared.finished.push_back((done, now));
    }
    while shared.started.len() > MAX_TIMES {
        shared.started.pop_front();
    }
    while shared.finished.len() > MAX_TIMES {
        shared.finished.pop_front();
    }
}

/// wgpu treats a write that doesn't fit as an error of the whole renderer, so it is checked here.
fn fits(entry: &Entry, image: &GpuImage) -> Result<(), String> {
    let texture = &image.texture_descriptor;
    let size = texture.size;
    let end = entry.region.origin.saturating_add(entry.region.size);
    if end.x > size.width || end.y > size.height || end.z > size.depth_or_array_layers {
        return Err(format!("{:?} is outside of {size:?}", entry.region));
    }
    let texel = entry.row_bytes() / entry.region.size.x as usize;
    if texture.format.block_dimensions() != (1, 1)
        || texture.format.block_copy_size(None) != u32::try_from(texel).ok()
    {
        return Err(format!("{texel} bytes a texel for {:?}", texture.format));
    }
    Ok(())
}

fn write_rows(queue: &RenderQueue, image: &GpuImage, entry: &Entry, rows: Rows) {
    let Region { origin, size } = entry.region;
    let row_bytes = entry.row_bytes();
    let height = rows.count.min(size.y);
    let bytes = &entry.bytes[rows.first as usize * row_bytes..][..rows.count as usize * row_bytes];
    queue.write_texture(
        TexelCopyTextureInfo {
            texture: &image.texture,
            mip_level: 0,
            origin: Origin3d {
                x: origin.x,
                y: origin.y + rows.first % size.y,
                z: origin.z + rows.first / size.y,
            },
            aspect: TextureAspect::All,
        },
        bytes,
        TexelCopyBufferLayout {
            offset: 0,
            bytes_per_row: u32::try_from(row_bytes).ok(),
            rows_per_image: Some(height),
        },
        Extent3d { width: size.x, height, depth_or_array_layers: rows.count / height },
    );
}
