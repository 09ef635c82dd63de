//! Textures to be blended: orders of the main world that the render world carries out.

mod pass;
pub mod twin;

use std::sync::{Arc, Mutex, MutexGuard, PoisonError};

use bevy::{
    asset::AssetId,
    prelude::*,
    render::{
        RenderApp,
        render_resource::{DownlevelFlags, TextureFormat, TextureUsages},
        renderer::{RenderAdapter, RenderDevice},
    },
};
use farlight_core::{Region, TextureUploads};

use crate::{Blending, MOST_SCENARIOS};

/// Orders on their way. Cloning shares them.
#[derive(Resource, Clone, Default)]
pub(crate) struct Blends(Arc<Mutex<Queue>>);

#[derive(Default)]
struct Queue {
    waiting: Vec<Order>,
    /// Carried out since the start.
    done: u64,
}

/// A texture to be blended.
#[derive(Clone, Debug)]
pub(crate) struct Order {
    target: AssetId<Image>,
    size: UVec3,
    /// With weights above 0, at most [`MOST_SCENARIOS`].
    inputs: Vec<(AssetId<Image>, f32)>,
}

impl Blends {
    fn lock(&self) -> MutexGuard<'_, Queue> {
        // The queue stays consistent at every point where a panic is possible.
        self.0.lock().unwrap_or_else(PoisonError::into_inner)
    }

    /// Orders a texture to be blended; an older order for it is replaced.
    pub(crate) fn order(
        &self,
        target: AssetId<Image>,
        size: UVec3,
        inputs: impl Iterator<Item = (AssetId<Image>, f32)>,
    ) {
        let inputs = inputs.take(MOST_SCENARIOS).collect();
        let mut queue = self.lock();
        queue.waiting.retain(|order| order.target != target);
        queue.waiting.push(Order { target, size, inputs });
    }

    pub(crate) fn forget(&self, target: AssetId<Image>) {
        self.lock().waiting.retain(|order| order.target != target);
    }

    pub(crate) fn is_waiting(&self, target: AssetId<Image>) -> bool {
        self.lock().waiting.iter().any(|order| order.target == target)
    }

    /// How many are waiting, and how many were carried out.
    pub(crate) fn progress(&self) -> (usize, u64) {
        let queue = self.lock();
        (queue.waiting.len(), queue.done)
    }

    /// Takes the orders that `ready` says yes to.
    fn take(&self, mut ready: impl FnMut(&Order) -> bool) -> Vec<Order> {
        let mut queue = self.lock();
        let (taken, waiting) = queue.waiting.drain(..).partition(|order| ready(order));
        queue.waiting = waiting;
        queue.done += taken.len() as u64;
        taken
    }
}

/// Carries orders out where the GPU can't.
pub(crate) fn blend_here(
    blends: &Blends,
    blending: Blending,
    images: &Assets<Image>,
    uploads: &TextureUploads,
) {
    match blending {
        Blending::Gpu => {}
        // Nobody sees it.
        Blending::Nobody => drop(blends.take(|_| true)),
        Blending::Cpu => {
            for order in blends.take(|_| true) {
                if let Err(problem) = blend_on_cpu(&order, images, uploads) {
                    error!("baked light is not blended: {problem}");
                }
            }
            uploads.write_all_next_frame();
        }
    }
}

fn blend_on_cpu(
    order: &Order,
    images: &Assets<Image>,
    uploads: &TextureUploads,
) -> Result<(), String> {
    let inputs = order.inputs.iter().map(|&(id, weight)| {
        images.get(id).map(|image| (image, weight)).ok_or("a texture is gone".to_owned())
    });
    let inputs = inputs.collect::<Result<Vec<_>, _>>()?;
    let mut texels = twin::blend_images(&inputs)?;
    if inputs.is_empty() {
        texels.resize(order.size.element_product() as usize * 8, 0);
    }
    let region = Region { origin: UVec3::ZERO, size: order.size };
    uploads.write(order.target, region, texels).map(drop).map_err(|problem| problem.to_string())
}

/// Who blends, by what the GPU can. Ask when plugins are finished.
pub(crate) fn who(app: &App) -> Blending {
    let Some(render_app) = app.get_sub_app(RenderApp) else { return Blending::Nobody };
    let world = render_app.world();
    let (Some(device), Some(adapter)) =
        (world.get_resource::<RenderDevice>(), world.get_resource::<RenderAdapter>())
    else {
        return Blending::Nobody;
    };
    let limits = device.limits();
    let compute = adapter.get_downlevel_capabilities().flags;
    let usages = adapter.get_texture_format_features(TextureFormat::Rgba16Float).allowed_usages;
    let able = compute.contains(DownlevelFlags::COMPUTE_SHADERS)
        && usages.contains(TextureUsages::STORAGE_BINDING)
        && limits.max_storage_textures_per_shader_stage >= 1
        && limits.max_sampled_textures_per_shader_stage >= MOST_SCENARIOS as u32
        && limits.max_compute_invocations_per_workgroup >= 64;
    if able { Blending::Gpu } else { Blending::Cpu }
}

/// Adds what the render world does.
pub(crate) fn build(app: &mut App) {
    let blends = Blends::default();
    app.insert_resource(blends.clone());
    pass::build(app, blends);
}

/// Makes pipelines where the GPU blends.
pub(crate) fn finish(app: &mut App, blending: Blending) {
    if blending == Blending::Gpu {
        pass::finish(app);
    }
}
