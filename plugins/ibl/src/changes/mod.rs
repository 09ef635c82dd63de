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

/// Changes that are told apart; more are joined with their neighbours.
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
        let Some((centre, radius)) = sphere else {
            match self.all.iter_mut().find(|other| other.sphere.is_none()) {
                Some(other) => other.keep = other.keep.min(keep),
                None => self.all.push(Disturb { sphere: None, keep }),
            }
            return;
        };
        if !centre.is_finite() || !radius.is_finite() {
            self.everywhere();
            return;
        }
        // One place is left for what is everywhere.
        let spheres = || self.all.iter().filter_map(|other| other.sphere);
        if spheres().count() + 1 < MOST {
            self.all.push(Disturb { sphere, keep });
            return;
        }
        // Joined with the one beside it: where few things move, the rest of a picture is kept.
        let joined = self.all.iter_mut().filter_map(|other| {
            let sphere = joined((centre, radius), other.sphere?);
            Some((sphere, other))
        });
        if let Some((sphere, other)) = joined.min_by(|(a, _), (b, _)| a.1.total_cmp(&b.1)) {
            *other = Disturb { sphere: Some(sphere), keep: keep.min(other.keep) };
        }
    }

    /// Assets that are seen have changed.
    fn uploads(&mut self) {
        self.uploading = UPLOADING;
        self.everywhere();
    }

    fn everywhere(&mut self) {
        self.add(None, KEEP_LIGHT);
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

/// A sphere around two.
fn joined(a: (Vec3, f32), b: (Vec3, f32)) -> (Vec3, f32) {
    let ((from, small), (to, large)) = if a.1 <= b.1 { (a, b) } else { (b, a) };
    let apart = from.distance(to);
    if apart + small <= large {
        return (to, large);
    }
    let radius = 0.5 * (apart + small + large);
    (to + (from - to) * ((radius - large) / apart), radius)
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

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn many_changes_are_joined_where_they_are() {
        let mut changes = Changes::default();
        for i in 0..1000 {
            let side = if i % 2 == 0 { -50.0 } else { 50.0 };
            let centre = Vec3::new(side, (i % 7) as f32, (i % 5) as f32);
            changes.add(Some((centre, 0.5)), if i % 3 == 0 { 0.0 } else { KEEP_LIGHT });
            assert!(changes.all.len() <= MOST);
            let lies = |change: &Disturb| {
                change.sphere.is_some_and(|(c, radius)| c.distance(centre) + 0.5 <= radius + 1e-4)
            };
            assert!(changes.all.iter().any(lies), "change {i} is in one of them");
        }
        let middle =
            |change: &Disturb| change.sphere.is_some_and(|(c, radius)| c.length() < radius);
        assert!(!changes.all.iter().any(middle), "nothing changed in the middle");
        changes.everywhere();
        assert!(changes.all.iter().any(|change| change.sphere.is_none()));
    }

    #[test]
    fn a_place_that_is_no_number_is_everywhere() {
        let mut changes = Changes::default();
        changes.add(Some((Vec3::NAN, 1.0)), 0.0);
        changes.add(Some((Vec3::ZERO, f32::INFINITY)), 0.0);
        assert!(changes.all.iter().all(|change| change.sphere.is_none()));
    }
}
