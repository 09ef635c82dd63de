//! `Accumulation` of `shaders/ibl/accumulate.wgsl`, laid out as WGSL lays it out.

use bevy::math::{Mat4, Vec3};
use bytemuck::{Pod, Zeroable};

use crate::{
    camera::Step,
    changes::{Disturb, MOST},
};

/// `Change` of the shader.
#[repr(C)]
#[derive(Clone, Copy, Debug, Default, Pod, Zeroable)]
pub(crate) struct Changed {
    pub(crate) sphere: [f32; 4],
    pub(crate) keep: f32,
    pad: [f32; 3],
}

impl From<&Disturb> for Changed {
    fn from(disturb: &Disturb) -> Self {
        let sphere = match disturb.sphere {
            Some((centre, radius)) => centre.extend(radius.max(0.0)).to_array(),
            None => [0.0, 0.0, 0.0, -1.0],
        };
        Self { sphere, keep: disturb.keep.max(0.0), pad: [0.0; 3] }
    }
}

/// The uniform of the pass.
#[repr(C)]
#[derive(Clone, Copy, Debug, Pod, Zeroable)]
pub(crate) struct Accumulation {
    pub(crate) viewport: [f32; 4],
    pub(crate) world_from_clip: [f32; 16],
    pub(crate) previous_clip_from_world: [f32; 16],
    pub(crate) eye: [f32; 4],
    pub(crate) forward: [f32; 4],
    pub(crate) previous_eye: [f32; 4],
    pub(crate) previous_forward: [f32; 4],
    pub(crate) jitter: [f32; 2],
    pub(crate) still: f32,
    pub(crate) cycle: f32,
    pub(crate) longest: f32,
    pub(crate) scale: f32,
    pub(crate) flags: u32,
    pub(crate) change_count: u32,
    pub(crate) changes: [Changed; MOST],
}

impl Accumulation {
    pub(crate) fn new(step: &Step, has_motion: bool, changes: &[Changed]) -> Self {
        let point = |v: Vec3| v.extend(0.0).to_array();
        let world_from_clip = |m: Mat4| m.as_dmat4().inverse().as_mat4().to_cols_array();
        let viewport = step.pose.viewport;
        let mut all = [Changed::default(); MOST];
        let count = changes.len().min(MOST);
        all[..count].copy_from_slice(&changes[..count]);
        Self {
            world_from_clip: world_from_clip(step.pose.clip_from_world),
            previous_clip_from_world: step.previous.clip_from_world.to_cols_array(),
            eye: point(step.pose.eye),
            forward: point(step.pose.forward),
            previous_eye: point(step.previous.eye),
            previous_forward: point(step.previous.forward),
            viewport: [
                viewport.min.x as f32,
                viewport.min.y as f32,
                viewport.width() as f32,
                viewport.height() as f32,
            ],
            jitter: step.jitter.to_array(),
            still: step.still as f32,
            cycle: step.cycle.max(1) as f32,
            longest: step.longest,
            scale: step.pose.exposure / step.previous.exposure.max(1e-20),
            flags: u32::from(step.fresh) | u32::from(has_motion) << 1,
            change_count: count as u32,
            changes: all,
        }
    }
}
