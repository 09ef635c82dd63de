//! Everything that a bake reads.

use std::{collections::BTreeMap, fs, path::PathBuf};

use farlight_baked_format::Fingerprint;
use farlight_gi_solver::import::{ImportOptions, ImportedScene};
use serde_json::Value;

use crate::{
    BakeError, BakeOptions, Effort, Emission, Probes, Texels,
    gltf::Source,
    lights::{BakeLights, LightsError, SkySource, read_skies},
    observer::Work,
    store::Key,
};

/// Everything that a bake reads.
pub(super) struct Input {
    pub(super) source: Source,
    pub(super) lights: BakeLights,
    /// The text that the lights come from, for messages.
    pub(super) lights_text: String,
    pub(super) skies: BTreeMap<String, SkySource>,
    /// Of all files and options.
    pub(super) fingerprint: Fingerprint,
    /// Everything that was read.
    pub(super) files: Vec<PathBuf>,
}

impl Input {
    /// Reads and hashes all files.
    pub(super) fn read(options: &BakeOptions) -> Result<Self, BakeError> {
        let source = Source::open(&options.scene, &options.limits)?;
        let mut files = source.files().to_vec();
        let (mut lights, mut skies) = (BakeLights::default(), BTreeMap::new());
        let mut lights_text = String::new();
        if let Some(path) = &options.lights {
            lights_text = fs::read_to_string(path)
                .map_err(|source| LightsError::Io { file: path.clone(), source })?;
            lights = BakeLights::parse(path, &lights_text)?;
            skies = read_skies(path, &lights_text, &lights)?;
            files.push(path.clone());
            files.extend(skies.values().map(|sky| sky.path.clone()));
        }
        let mut key = Key::new("input");
        key.print(source.fingerprint()).text(&lights_text);
        for sky in skies.values() {
            key.print(sky.fingerprint);
        }
        match options.texels {
            Texels::Standard => key.text("standard"),
            Texels::PerMetre(n) => key.text("metre").float(n),
            Texels::Page(n) => key.text("page").number(n),
        };
        match options.effort {
            Effort::Rays(n) => key.text("rays").number(n),
            Effort::Time(t) => key.text("time").number(t.as_millis() as u64),
        };
        match options.probes {
            Probes::None => key.text("none"),
            Probes::Standard => key.text("standard"),
            Probes::Spacing(metres) => key.text("spacing").float(metres),
        };
        match options.emission {
            Emission::Nits => key.text("nits"),
            Emission::Exposure(ev100) => key.text("exposure").float(ev100),
        };
        key.number(options.bounces).vector(options.sky).float(options.scale).number(options.seed);
        key.number(options.exr).number(options.denoise);
        for scenario in &options.scenarios {
            key.text(scenario);
        }
        Ok(Self { source, lights, lights_text, skies, fingerprint: key.finish(), files })
    }

    /// The scene, in metres, with emission in cd/m² and Bevy's ranges of lights.
    pub(super) fn scene(
        &self,
        options: &BakeOptions,
        work: &Work<'_>,
    ) -> Result<ImportedScene, BakeError> {
        let import = ImportOptions {
            scale: options.scale,
            range_window: true,
            limits: options.limits.clone(),
        };
        let mut imported = self.source.scene(&import)?;
        for warning in self.source.warnings().iter().chain(&imported.warnings) {
            work.warn(warning.as_str());
        }
        for feature in self.source.bevy_features() {
            work.warn(format!(
                "images of the scene need Bevy's feature {feature:?}, which is off by default"
            ));
        }
        let factor = options.emission.factor();
        for material in imported.scene.materials.values_mut() {
            material.emissive = (material.emissive * factor).min(glam::Vec3::splat(f32::MAX));
        }
        Ok(imported)
    }

    /// The name of a node; empty if it has none.
    pub(super) fn node_name(&self, node: u32) -> &str {
        name_of(self.source.json(), "nodes", node as usize)
    }

    /// Whether a node has a skin.
    pub(super) fn is_skinned(&self, node: u32) -> bool {
        self.source.json()["nodes"][node as usize].get("skin").is_some()
    }

    /// Indices and names of the materials that have one.
    pub(super) fn material_names(&self) -> impl Iterator<Item = (u64, &str)> {
        let materials = self.source.json()["materials"].as_array();
        let materials = materials.map(Vec::as_slice).unwrap_or_default();
        (0..).zip(materials).filter_map(|(i, m)| Some((i, m.get("name")?.as_str()?)))
    }
}

fn name_of<'a>(json: &'a Value, list: &str, index: usize) -> &'a str {
    json[list][index]["name"].as_str().unwrap_or_default()
}
