//! Material files as assets.

use std::sync::Arc;

use bevy::{
    asset::{Asset, AssetLoader, LoadContext, io::Reader},
    reflect::TypePath,
};
use farlight_btf_codec::{Btf, BtfError};

/// A material file: `.fbtf`, or a `.btf` binary of the BTFbase format.
#[derive(Asset, TypePath, Clone, Debug)]
pub struct BtfAsset(pub Arc<Btf>);

/// Loads [`BtfAsset`]s; which format a file has is told by its content.
#[derive(Clone, Copy, Debug, Default, TypePath)]
pub struct BtfLoader;

impl AssetLoader for BtfLoader {
    type Asset = BtfAsset;
    type Settings = ();
    type Error = BtfError;

    async fn load(
        &self,
        reader: &mut dyn Reader,
        _settings: &(),
        context: &mut LoadContext<'_>,
    ) -> Result<BtfAsset, BtfError> {
        let mut bytes = Vec::new();
        reader
            .read_to_end(&mut bytes)
            .await
            .map_err(|source| BtfError::Io { path: context.path().path().to_owned(), source })?;
        Ok(BtfAsset(Arc::new(Btf::from_bytes(&bytes)?)))
    }

    fn extensions(&self) -> &[&str] {
        &["fbtf", "btf"]
    }
}
