//! What changed in the world: pictures that are kept forget what it touches.
//!
//! Values are compared, not only Bevy's change ticks: many games write the same transform or colour
//! in each frame.

mod assets;
mod light;
mod meshes;

use bevy::{camera::primitives::Aabb, ecs::entity::EntityHashMap, prelude::*};

pub use assets::WatchMaterial;
use meshes::Seen;

use crate::{IblSystems, camera::decide};

/// Changes that are told apart; more become one that is everywhere.
pub(crate) const MOST: usize = 16;
/// Frames of a picture that count on when light changes everywhere: few enough to follow, enough not
/// to flicker.
pub(crate) const KEEP_LIGHT: f32 = 8.0;

/// Materials and images are shown a frame or two after they change: by then a still picture would
/// have begun.
const UPLOADING: u32 = 3;

/// Something that isn't noticed by itself has changed what cameras see: a texture that was written on
/// the GPU, a shader's own clock, a material that isn't [watched](WatchMaterial).
#[derive(Message, Clone, Copy, Debug, PartialEq)]
pub struct Disturb {
    /// Where: a sphere in the world (centre, radius in metres); everywhere without.
    pub sphere: Option<(Vec3, f32)>,
    /// How many frames of what is kept still count there; 0 starts anew.
    pub keep: f32,
}

/// What changed in this frame.
#[derive(Resource, Debug, Default)]
pub(crate) struct Changes {
    pub(crate) all: Vec<Disturb>,
    /// Frames in which assets that changed may still be on their way to the GPU.
    uploading: u32,
    known: EntityHashMap<Seen>,
}

impl Changes {
    pub(crate) fn is_empty(&self) -> bool {
        self.all.is_empty()
    }

    fn add(&mut self, sphere: Option<(Vec3, f32)>, keep: f32) {
        if self.all.len() < MOST {
            self.all.push(Disturb { sphere, keep });
        } else {
            let keep = self.all.iter().fold(keep, |least, other| least.min(other.keep));
            self.all.clear();
            self.all.extend([Disturb { sphere: None, keep }; MOST]);
        }
    }

    /// Assets that are seen have changed.
    fn uploads(&mut self) {
        self.uploading = UPLOADING;
        self.everywhere();
    }

    fn everywhere(&mut self) {
        let known = self.all.iter().any(|all| all.sphere.is_none() && all.keep <= KEEP_LIGHT);
        if !known {
            self.add(None, KEEP_LIGHT);
        }
    }
}

/// Changes are noticed: meshes first, then all else.
#[derive(SystemSet, Clone, Copy, Debug, PartialEq, Eq, Hash)]
struct Notice;

pub(crate) fn build(app: &mut App) {
    app.configure_sets(
        PostUpdate,
        Notice.in_set(IblSystems::Decide).after(meshes::notice_meshes).before(decide),
    )
    .add_systems(
        PostUpdate,
        (
            meshes::notice_meshes.in_set(IblSystems::Decide).before(decide),
            assets::notice_assets.in_set(Notice),
        ),
    )
    .watch_material::<StandardMaterial>();
    light::build(app);
}

/// A mesh as its sphere.
fn sphere(transform: &GlobalTransform, aabb: Option<&Aabb>) -> (Vec3, f32) {
    match aabb {
        Some(aabb) => (
            transform.transform_point(aabb.center.into()),
            transform.radius_vec3a(aabb.half_extents).max(1e-3),
        ),
        None => (transform.translation(), 1.0),
    }
}
