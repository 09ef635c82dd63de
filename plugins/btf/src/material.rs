//! What a mesh with a measured material carries.

use bevy::{asset::Asset, math::Vec2, prelude::*, reflect::TypePath};

use crate::BtfAsset;

/// How texels are joined to a picture.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Hash, Reflect)]
pub enum BtfFilter {
    /// The nearest texel: sharp squares, the least work.
    Nearest,
    /// Four texels, weighted by distance, in linear light.
    #[default]
    Bilinear,
}

/// A measured material on a mesh. The mesh needs normals and a first UV set; tangents are taken
/// from the mesh or derived from the UVs.
#[derive(Asset, TypePath, Clone, Debug)]
pub struct BtfMaterial {
    /// The measured data.
    pub btf: Handle<BtfAsset>,
    /// How often the picture repeats over the UV square.
    pub repeat: Vec2,
    /// Factor on the reflected light, 1 as measured.
    pub gain: f32,
    /// How texels are joined.
    pub filter: BtfFilter,
}

impl BtfMaterial {
    /// As measured, once over the UV square.
    pub fn new(btf: Handle<BtfAsset>) -> Self {
        Self { btf, repeat: Vec2::ONE, gain: 1.0, filter: BtfFilter::default() }
    }
}
