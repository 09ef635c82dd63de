//! The kept pictures of each camera.

use std::sync::atomic::Ordering;

use bevy::{
    ecs::entity::EntityHashMap,
    prelude::*,
    render::{
        camera::ExtractedCamera,
        render_resource::{
            Buffer, BufferDescriptor, BufferUsages, Extent3d, TextureDescriptor, TextureDimension,
            TextureFormat, TextureUsages, TextureView, TextureViewDescriptor,
        },
        renderer::RenderDevice,
        sync_world::MainEntity,
    },
};

use super::Pending;
use crate::{
    camera::{Action, Step},
    uniform::Accumulation,
};

/// Means of colour, in full precision: the mean of thousands of half floats stands still.
pub(crate) const MEAN_FORMAT: TextureFormat = TextureFormat::Rgba32Float;
/// Metres.
pub(crate) const DISTANCE_FORMAT: TextureFormat = TextureFormat::R32Float;

/// What is kept of a camera's frames: 3 x 16 + 2 x 4 bytes a pixel of its target.
pub(crate) struct History {
    size: UVec2,
    means: [TextureView; 3],
    distances: [TextureView; 2],
    /// Which mean moves along, which is the still one, and which is free.
    pub(crate) roles: [usize; 3],
    pub(crate) distance: usize,
    /// What the pass is told about a frame.
    pub(crate) uniform: Buffer,
}

impl History {
    fn new(device: &RenderDevice, size: UVec2) -> Self {
        let texture = |label, format| {
            device
                .create_texture(&TextureDescriptor {
                    label: Some(label),
                    size: Extent3d { width: size.x, height: size.y, depth_or_array_layers: 1 },
                    mip_level_count: 1,
                    sample_count: 1,
                    dimension: TextureDimension::D2,
                    format,
                    usage: TextureUsages::RENDER_ATTACHMENT | TextureUsages::TEXTURE_BINDING,
                    view_formats: &[],
                })
                .create_view(&TextureViewDescriptor::default())
        };
        Self {
            size,
            means: std::array::from_fn(|_| texture("farlight_ibl_mean", MEAN_FORMAT)),
            distances: std::array::from_fn(|_| texture("farlight_ibl_distance", DISTANCE_FORMAT)),
            roles: [0, 1, 2],
            distance: 0,
            uniform: device.create_buffer(&BufferDescriptor {
                label: Some("farlight_ibl_accumulation"),
                size: size_of::<Accumulation>() as u64,
                usage: BufferUsages::UNIFORM | BufferUsages::COPY_DST,
                mapped_at_creation: false,
            }),
        }
    }

    /// The mean of what moved along.
    pub(crate) fn moved(&self) -> &TextureView {
        &self.means[self.roles[0]]
    }

    /// The mean since everything is still.
    pub(crate) fn rested(&self) -> &TextureView {
        &self.means[self.roles[1]]
    }

    /// Where the next mean goes.
    pub(crate) fn next(&self) -> &TextureView {
        &self.means[self.roles[2]]
    }

    pub(crate) fn moved_distance(&self) -> &TextureView {
        &self.distances[self.distance]
    }

    pub(crate) fn next_distance(&self) -> &TextureView {
        &self.distances[1 - self.distance]
    }

    /// What was next is what is kept.
    pub(crate) fn turn(&mut self, action: Action) {
        match action {
            Action::Move => {
                self.roles.swap(0, 2);
                self.distance = 1 - self.distance;
            }
            Action::Rest => self.roles.swap(1, 2),
            Action::Show | Action::Present => {}
        }
    }
}

/// The histories of all cameras, by the camera's entity in the main world.
#[derive(Resource, Default)]
pub(crate) struct Histories(pub(crate) EntityHashMap<History>);

/// Makes and forgets histories. A step whose history is new keeps nothing.
pub(crate) fn prepare(
    mut histories: ResMut<Histories>,
    device: Res<RenderDevice>,
    pending: Res<Pending>,
    mut cameras: Query<(&MainEntity, &ExtractedCamera, &mut Step)>,
) {
    histories.0.retain(|entity, _| cameras.iter().any(|(main, ..)| main.id() == *entity));
    for (main, camera, mut step) in &mut cameras {
        let Some(size) = camera.physical_target_size else { continue };
        let known = histories.0.get(&main.id()).is_some_and(|history| history.size == size);
        if !known {
            histories.0.insert(main.id(), History::new(&device, size));
            if !step.fresh {
                pending.lost.store(true, Ordering::Relaxed);
            }
            step.fresh = true;
            if step.action != Action::Show {
                step.action = Action::Move;
            }
        }
    }
}
