//! What a bake made.

use std::{path::PathBuf, time::Duration};

use farlight_baked_format::Manifest;

use crate::{
    observer::{Stage, Work},
    store::Folder,
};

/// What a bake made.
#[derive(Clone, Debug)]
pub struct Report {
    /// How it ended.
    pub outcome: Outcome,
    /// Where the manifest is.
    pub manifest_path: PathBuf,
    /// What it says.
    pub manifest: Manifest,
    /// Scenarios that earlier bakes had made from the same inputs.
    pub unchanged: Vec<String>,
    /// How much of the pages charts cover, 0 to 1; 0 where nothing was laid out.
    pub coverage: f32,
    /// All warnings.
    pub warnings: Vec<String>,
    /// How long it took.
    pub time: Duration,
    /// How long the stages took.
    pub stages: Vec<(Stage, Duration)>,
}

/// How a bake ended.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Outcome {
    /// All was baked as asked.
    Complete,
    /// It was stopped: what is there is right but noisier, or lacks scenarios. The next run goes on.
    Partial,
    /// There was nothing to do.
    Unchanged,
}

impl Report {
    pub(crate) fn of(
        manifest: &Manifest,
        folder: &Folder,
        outcome: Outcome,
        work: &Work<'_>,
    ) -> Self {
        Self {
            outcome,
            manifest_path: folder.at(&folder.manifest_name()),
            manifest: manifest.clone(),
            unchanged: Vec::new(),
            coverage: 0.0,
            warnings: work.warnings(),
            time: work.start.elapsed(),
            stages: work.seconds(),
        }
    }
}
