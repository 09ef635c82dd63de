//! What the shader knows of a material: the twin of `shaders/btf/bindings.wgsl`.

use bytemuck::{Pod, Zeroable};
use farlight_btf_codec::{Layout, fade_slope};

use crate::{BtfMaterial, loading::Prepared, settings::Directions};

/// One element of the buffer of entries.
#[repr(C)]
#[derive(Clone, Copy, Debug, Default, PartialEq, Pod, Zeroable)]
pub(crate) struct Entry {
    pub(crate) btf: Layout,
    pub(crate) repeat: [f32; 2],
    pub(crate) gain: f32,
    pub(crate) environment_directions: u32,
    pub(crate) coarse_offset: u32,
    pub(crate) coarse_count: u32,
    pub(crate) coarse_tints: u32,
    pub(crate) coarse_most: f32,
    pub(crate) albedo_directions: u32,
    pub(crate) mean: [f32; 3],
    pub(crate) fade: f32,
    pub(crate) coarseness: f32,
}

impl Entry {
    /// Of a material whose data begins at word `base` of its buffer.
    pub(crate) fn new(
        material: &BtfMaterial,
        prepared: &Prepared,
        base: u32,
        directions: Directions,
    ) -> Self {
        let layout = *prepared.btf.layout();
        let coarse = &prepared.coarse;
        let coarse_offset = base + prepared.btf.words().len() as u32;
        let limit =
            if material.fade_beyond_measured { prepared.btf.info().light_limit } else { None };
        Self {
            btf: layout.moved(base),
            repeat: finite(material.repeat).to_array(),
            gain: if material.gain.is_finite() { material.gain } else { 1.0 },
            environment_directions: directions.environment,
            coarse_offset,
            coarse_count: coarse.count,
            coarse_tints: coarse_offset + coarse.texels,
            coarse_most: coarse.most,
            albedo_directions: directions.albedo,
            mean: coarse.mean.to_array(),
            fade: fade_slope(limit),
            coarseness: if material.coarseness.is_finite() { material.coarseness } else { 0.0 },
        }
    }
}

/// Without numbers that the shader can't reduce to a texel.
fn finite(repeat: bevy::math::Vec2) -> bevy::math::Vec2 {
    let sound = |value: f32| if value.is_finite() { value.clamp(-1e6, 1e6) } else { 1.0 };
    bevy::math::Vec2::new(sound(repeat.x), sound(repeat.y))
}
