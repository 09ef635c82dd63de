//! Cameras whose pictures refine themselves, and how far they are.

use bevy::{
    camera::{Exposure, Hdr},
    core_pipeline::prepass::{DepthPrepass, MotionVectorPrepass},
    prelude::*,
    render::{
        camera::TemporalJitter, extract_component::ExtractComponent, sync_component::SyncComponent,
    },
};

use crate::{changes::Changes, lights::Group, render::Pending};

/// Frames that a still picture has at least, so that edges are smooth.
const MIN_FRAMES: u32 = 32;
/// Frames that count while the camera moves, at most: what is older was moved by parts of pixels
/// too often.
const LONGEST_MOVING: f32 = 512.0;

/// Gives a camera the environment's light, refined from frame to frame.
///
/// The camera draws linear HDR (`Hdr`) with motion vectors and without multisampling; edges become
/// smooth by moving each frame by a part of a pixel (not with a parallel projection). Temporal
/// antialiasing beside it is of no use.
#[derive(Component, Clone, Copy, Debug, PartialEq, Reflect)]
#[reflect(Component, Default, Debug, Clone)]
#[require(Camera3d, Hdr, DepthPrepass, MotionVectorPrepass, Refinement, TemporalJitter)]
pub struct ProgressiveCamera {
    /// Whether pictures are accumulated. Off, every frame is shown as it is: lit by a few lights.
    pub accumulate: bool,
    /// Whether a refined picture is kept and nothing is drawn until something changes. What moves
    /// only in shaders (water, particles on the GPU) is not noticed: switch it off for such scenes,
    /// or send [`Disturb`](crate::Disturb).
    pub rest: bool,
    /// How many times all lights are gone through until a still picture counts as refined; more make
    /// edges smoother where lights are few. At least 32 frames are drawn anyway.
    #[reflect(@1..=64_u32)]
    pub cycles: u32,
}

impl ProgressiveCamera {
    /// How many times a still picture goes through `cycle` groups until it is refined.
    pub(crate) fn rounds(&self, cycle: u32) -> u32 {
        self.cycles.max(1).max(MIN_FRAMES.div_ceil(cycle.max(1)))
    }
}

impl Default for ProgressiveCamera {
    fn default() -> Self {
        Self { accumulate: true, rest: true, cycles: 1 }
    }
}

/// How far the picture of a [`ProgressiveCamera`] is.
#[derive(Component, Clone, Copy, Debug, Default, PartialEq, Reflect)]
#[reflect(Component, Default, Debug, Clone)]
pub struct Refinement {
    /// Frames since everything is still.
    pub frames: u32,
    /// Frames that a refined picture has.
    pub of: u32,
}

impl Refinement {
    /// Whether the picture is as good as it becomes.
    #[must_use]
    pub fn is_refined(&self) -> bool {
        self.of > 0 && self.frames >= self.of
    }

    /// From 0 to 1.
    #[must_use]
    pub fn progress(&self) -> f32 {
        if self.of == 0 { 0.0 } else { (self.frames as f32 / self.of as f32).min(1.0) }
    }
}

/// How a camera looks at the world.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct Pose {
    pub(crate) clip_from_world: Mat4,
    pub(crate) eye: Vec3,
    pub(crate) forward: Vec3,
    pub(crate) viewport: URect,
    pub(crate) exposure: f32,
}

/// What a frame of a camera is to do, for the render world.
#[derive(Component, Clone, Copy, Debug)]
pub(crate) struct Step {
    pub(crate) action: Action,
    pub(crate) pose: Pose,
    pub(crate) previous: Pose,
    /// Frames of the still mean before this one.
    pub(crate) still: u32,
    /// Frames of a refined picture: a whole number of cycles.
    pub(crate) cycle: u32,
    pub(crate) longest: f32,
    pub(crate) jitter: Vec2,
    /// Nothing is kept.
    pub(crate) fresh: bool,
}

/// What happens to a frame.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Action {
    /// It is shown as it is drawn.
    Show,
    /// What is kept moves along.
    Move,
    /// It is added to the mean of a still picture.
    Rest,
    /// Nothing is drawn; what is kept is shown.
    Present,
}

/// The state of a camera between frames.
#[derive(Component, Clone, Copy, Debug, Default)]
pub(crate) struct Progress {
    previous: Option<Pose>,
    /// Frames of the still mean.
    still: u32,
    frame: u32,
    /// Whether the last frame was shown as it was drawn, and nothing is kept of it.
    shown: bool,
    pub(crate) step: Option<Step>,
}

impl SyncComponent for Progress {
    type Target = Step;
}

impl ExtractComponent for Progress {
    type QueryData = &'static Self;
    type QueryFilter = ();
    type Out = Step;

    fn extract_component(progress: &Self) -> Option<Step> {
        progress.step
    }
}

/// A camera that no longer refines its picture is an ordinary one again.
pub(crate) fn forget(
    mut commands: Commands,
    mut removed: RemovedComponents<ProgressiveCamera>,
    mut cameras: Query<Option<&mut TemporalJitter>, (With<Progress>, Without<ProgressiveCamera>)>,
) {
    for entity in removed.read() {
        let Ok(jitter) = cameras.get_mut(entity) else { continue };
        if let Some(mut jitter) = jitter {
            jitter.offset = Vec2::ZERO;
        }
        commands.entity(entity).remove::<Progress>();
    }
}

/// Decides what each camera does in this frame.
pub(crate) fn decide(
    mut commands: Commands,
    mut group: ResMut<Group>,
    changes: Res<Changes>,
    pending: Res<Pending>,
    mut cameras: Query<(
        Entity,
        &ProgressiveCamera,
        &Camera,
        &GlobalTransform,
        Option<&Exposure>,
        &mut TemporalJitter,
        &mut Refinement,
        Option<&mut Progress>,
    )>,
) {
    let mut draws = false;
    let lost = pending.take_lost();
    for (entity, settings, camera, transform, exposure, mut jitter, mut refinement, progress) in
        &mut cameras
    {
        let Some(mut progress) = progress else {
            commands.entity(entity).insert((Progress::default(), Msaa::Off));
            draws = true;
            continue;
        };
        let viewport = camera.physical_viewport_rect().unwrap_or_default();
        if !camera.is_active || viewport.is_empty() {
            progress.step = None;
            continue;
        }
        let view_from_world = transform.affine().inverse();
        let pose = Pose {
            clip_from_world: camera.clip_from_view() * Mat4::from(view_from_world),
            eye: transform.translation(),
            forward: transform.forward().into(),
            viewport,
            exposure: exposure.copied().unwrap_or_default().exposure(),
        };
        let previous = progress.previous.replace(pose);
        let cycle = group.cycle.max(1);
        let of = cycle * settings.rounds(cycle);
        let fresh = lost
            || progress.shown
            || previous.is_none_or(|previous| previous.viewport != pose.viewport);
        let still = !fresh && previous == Some(pose) && changes.is_empty() && !pending.is_waiting();
        let done = progress.still >= of;
        let action = match settings {
            ProgressiveCamera { accumulate: false, .. } => Action::Show,
            _ if !still => Action::Move,
            ProgressiveCamera { rest: true, .. } if done => Action::Present,
            _ => Action::Rest,
        };
        progress.frame = progress.frame.wrapping_add(1);
        progress.shown = action == Action::Show;
        // Bevy 0.19 moves parallel projections by a distance that grows with depth.
        let is_parallel = camera.clip_from_view().w_axis.w == 1.0;
        let offset = match action {
            Action::Show | Action::Present => Vec2::ZERO,
            _ if is_parallel => Vec2::ZERO,
            Action::Move => halton(progress.frame % 64) - 0.5,
            // Each group has its place in a pixel, so that equal scenes give equal pictures, whenever
            // they come to rest. A group that comes again comes at another place, whatever the number
            // of groups has in common with the sequence's bases.
            Action::Rest => {
                let at = (group.turn % u64::from(of)) as u32;
                let [round, place] = [at / cycle, at % cycle].map(halton);
                (round + place).fract() - 0.5
            }
        };
        if jitter.offset != offset {
            jitter.offset = offset;
        }
        progress.step = Some(Step {
            action,
            pose,
            previous: previous.unwrap_or(pose),
            still: progress.still,
            cycle: of,
            longest: LONGEST_MOVING.min(of as f32),
            jitter: offset,
            fresh,
        });
        progress.still = match action {
            Action::Rest => progress.still.saturating_add(1),
            Action::Present => progress.still,
            Action::Show | Action::Move => 0,
        };
        refinement.set_if_neq(Refinement { frames: progress.still.min(of), of });
        draws |= action != Action::Present;
    }
    group.advance = draws;
}

/// The Halton sequence in bases 2 and 3, from its second point on.
fn halton(index: u32) -> Vec2 {
    let radical_inverse = |base: u32| {
        let (mut index, mut scale, mut value) = (index + 1, 1.0_f32, 0.0);
        while index > 0 {
            scale /= base as f32;
            value += scale * (index % base) as f32;
            index /= base;
        }
        value
    };
    Vec2::new(radical_inverse(2), radical_inverse(3))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn halton_points_are_known() {
        assert_eq!(halton(0), Vec2::new(1.0 / 2.0, 1.0 / 3.0));
        assert!(halton(4).abs_diff_eq(Vec2::new(5.0 / 8.0, 7.0 / 9.0), 1e-6));
        let mean = (0..36).map(halton).sum::<Vec2>() / 36.0;
        assert!((mean - 0.5).abs().max_element() < 0.03, "{mean}");
    }
}
