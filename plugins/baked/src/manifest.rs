//! The manifest as an asset, with its textures.

use std::ops::Deref;

use bevy::{
    asset::{AssetLoader, AssetPath, LoadContext, RenderAssetUsages, io::Reader},
    image::{ImageLoaderSettings, ImageSampler},
    prelude::*,
};
use farlight_baked_format::{Manifest, manifest::ManifestError};
use thiserror::Error;

/// What a bake made, a file `NAME.baked.ron`, and the textures that it names.
///
/// Derefs to what the file says.
#[derive(Asset, TypePath, Clone, Debug)]
pub struct BakedManifest {
    manifest: Manifest,
    /// The lit scene, a glTF file.
    pub scene: AssetPath<'static>,
    /// Scenario after scenario.
    #[dependency]
    pages: Vec<Handle<Image>>,
    #[dependency]
    volumes: Vec<Handle<Image>>,
}

impl Deref for BakedManifest {
    type Target = Manifest;

    fn deref(&self) -> &Manifest {
        &self.manifest
    }
}

impl BakedManifest {
    /// The lightmap page of a scenario.
    #[must_use]
    pub fn page(&self, scenario: usize, page: usize) -> Option<&Handle<Image>> {
        let pages = self.manifest.pages as usize;
        (page < pages).then(|| self.pages.get(scenario * pages + page)).flatten()
    }

    /// The probes of a scenario.
    #[must_use]
    pub fn volume(&self, scenario: usize, volume: usize) -> Option<&Handle<Image>> {
        let volumes = self.manifest.volumes.len();
        (volume < volumes).then(|| self.volumes.get(scenario * volumes + volume)).flatten()
    }

    /// All textures.
    pub fn images(&self) -> impl Iterator<Item = &Handle<Image>> {
        self.pages.iter().chain(&self.volumes)
    }

    /// The scenarios' names in their order.
    pub fn scenario_names(&self) -> impl ExactSizeIterator<Item = &str> + Clone {
        self.scenarios.iter().map(|scenario| scenario.name.as_str())
    }
}

/// Why a manifest was not loaded.
#[derive(Debug, Error)]
pub enum BakedManifestError {
    /// The file can't be read.
    #[error("{file}: {source}")]
    Io {
        /// Which file.
        file: String,
        /// Why.
        source: std::io::Error,
    },
    /// It isn't UTF-8.
    #[error("{file}: not UTF-8 text")]
    NotText {
        /// Which file.
        file: String,
    },
    /// It isn't a manifest, or one that contradicts itself.
    #[error("{file}: {source}")]
    Manifest {
        /// Which file.
        file: String,
        /// Place or field, and what is wrong.
        source: ManifestError,
    },
}

/// Loads [`BakedManifest`]s and the textures that they name.
#[derive(TypePath)]
pub(crate) struct BakedManifestLoader {
    /// Whether scenarios are blended here and not by the GPU, so that texels stay.
    pub(crate) keep_texels: bool,
}

impl BakedManifestLoader {
    pub(crate) const EXTENSIONS: &'static [&'static str] = &["baked.ron"];
}

impl AssetLoader for BakedManifestLoader {
    type Asset = BakedManifest;
    type Settings = ();
    type Error = BakedManifestError;

    async fn load(
        &self,
        reader: &mut dyn Reader,
        _settings: &(),
        context: &mut LoadContext<'_>,
    ) -> Result<BakedManifest, BakedManifestError> {
        let file = context.path().to_string();
        let mut bytes = Vec::new();
        let read = reader.read_to_end(&mut bytes).await;
        read.map_err(|source| BakedManifestError::Io { file: file.clone(), source })?;
        let text = String::from_utf8(bytes)
            .map_err(|_| BakedManifestError::NotText { file: file.clone() })?;
        let refused = |source| BakedManifestError::Manifest { file: file.clone(), source };
        let manifest = Manifest::parse(&text).map_err(refused)?;

        // Files stand beside the manifest, whatever source it comes from.
        let folder = context.path().parent().unwrap_or_default();
        let beside = |name: &str| {
            let path = AssetPath::from(folder.path().join(name));
            path.with_source(folder.source().clone()).into_owned()
        };
        let texels = if self.keep_texels {
            RenderAssetUsages::MAIN_WORLD | RenderAssetUsages::RENDER_WORLD
        } else {
            RenderAssetUsages::RENDER_WORLD
        };
        let mut load = |name: &str| {
            let settings = move |settings: &mut ImageLoaderSettings| {
                settings.is_srgb = false;
                // Clamped at the edges.
                settings.sampler = ImageSampler::linear();
                settings.asset_usage = texels;
            };
            context.load_builder().with_settings(settings).load(beside(name))
        };
        let (mut pages, mut volumes) = (Vec::new(), Vec::new());
        for scenario in &manifest.scenarios {
            pages.extend(scenario.pages.iter().map(|page| load(&page.ktx2)));
            volumes.extend(scenario.volumes.iter().map(|name| load(name)));
        }
        Ok(BakedManifest { scene: beside(&manifest.scene), manifest, pages, volumes })
    }

    fn extensions(&self) -> &[&str] {
        Self::EXTENSIONS
    }
}
