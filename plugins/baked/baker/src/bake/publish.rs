//! The manifest, and the end of what it no longer names.

use std::collections::BTreeSet;

use farlight_baked_format::{
    Manifest,
    manifest::{Settings, VERSION, Volume},
};

use super::{geometry::Rest, input::Input, plan::Plan, scenario::Baked};
use crate::{
    BakeError, BakeOptions, Report,
    observer::Work,
    report::Outcome,
    store::{Folder, files},
};

/// Whether the last bake was made from the same, came to its end, and is whole.
pub(super) fn is_current(folder: &Folder, input: &Input, old: &Manifest) -> bool {
    old.complete
        && old.input == input.fingerprint
        && folder.at(&old.scene).is_file()
        && files(old).iter().all(|file| folder.is_intact(file))
}

/// Writes lit scene and manifest, and removes what nobody needs any more.
pub(super) fn publish(
    options: &BakeOptions,
    input: &Input,
    geometry: &Rest,
    plans: &[Plan],
    baked: Vec<(bool, Baked)>,
    folder: &Folder,
    old: Option<&Manifest>,
    work: &Work<'_>,
) -> Result<Report, BakeError> {
    let recalled: Vec<String> = baked
        .iter()
        .filter(|(_, baked)| baked.recalled)
        .map(|(_, baked)| baked.scenario.name.clone())
        .collect();
    let done = baked.iter().filter(|(wanted, baked)| *wanted && baked.complete).count();
    let complete = done == plans.iter().filter(|plan| options.wants(&plan.name)).count();
    let manifest = Manifest {
        version: VERSION,
        scene: folder.scene(),
        input: input.fingerprint,
        complete,
        settings: Settings {
            scale: options.scale,
            texels_per_metre: geometry.layout.texels_per_metre,
            samples: match options.effort {
                crate::Effort::Rays(rays) => rays,
                crate::Effort::Time(_) => 0,
            },
            bounces: options.bounces,
            denoise: options.denoise,
            seed: options.seed,
        },
        page_size: geometry.layout.page_size,
        pages: geometry.layout.page_count,
        receivers: geometry.receivers.clone(),
        left_out: geometry.left_out.clone(),
        volumes: geometry
            .volumes
            .iter()
            .map(|grid| Volume::new(&grid.transform, grid.resolution))
            .collect(),
        scenarios: baked.into_iter().map(|(_, baked)| baked.scenario).collect(),
    };
    manifest
        .validate()
        .map_err(|error| BakeError::Option { option: "manifest", problem: error.to_string() })?;
    let same = std::fs::read(folder.at(&folder.scene())).is_ok_and(|bytes| bytes == geometry.glb);
    if !same {
        folder.replace(&folder.scene(), &geometry.glb)?;
    }
    folder.replace(&folder.manifest_name(), manifest.to_text().as_bytes())?;
    let mut needed: BTreeSet<String> = files(&manifest).into_iter().collect();
    needed.extend([folder.scene(), folder.manifest_name()]);
    folder.clean(&needed, old);
    let outcome = if complete { Outcome::Complete } else { Outcome::Partial };
    let mut report = Report::of(&manifest, folder, outcome, work);
    report.unchanged = recalled;
    report.coverage = geometry.coverage();
    Ok(report)
}
