//! Material files as assets.

use std::sync::Arc;

use bevy::{asset::Asset, reflect::TypePath};
use farlight_btf_codec::Btf;

/// A material file: `.fbtf`, or a `.btf` binary of the BTFbase format.
#[derive(Asset, TypePath, Clone, Debug)]
pub struct BtfAsset(pub Arc<Btf>);
