//! How it is going, for a game to show.

use std::sync::{Arc, Mutex};

use bevy::{asset::AssetLoadFailedEvent, prelude::*};

use crate::BtfAsset;

/// A material file that could not be used.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct BtfFailure {
    /// The file.
    pub path: String,
    /// What is wrong with it.
    pub error: String,
}

/// How the plugin is doing.
#[derive(Resource, Clone, Debug, Default, PartialEq)]
pub struct BtfStatus {
    /// Why materials are shown in their mean colour only; `None` while all is well.
    pub limited: Option<String>,
    /// Files that could not be used, the newest last; a file that is read well later leaves the
    /// list. At most 64 are kept.
    pub failed: Vec<BtfFailure>,
    /// Materials' data that is on its way: being prepared or sent to the GPU.
    pub waiting: usize,
    /// Materials' data on the GPU.
    pub resident: usize,
    /// Bytes that they take there.
    pub resident_bytes: u64,
    /// Buffers that hold them.
    pub buffers: usize,
}

/// Failures that are kept.
const MOST_FAILURES: usize = 64;

impl BtfStatus {
    pub(crate) fn fail(&mut self, path: String, error: String) {
        error!("{path}: {error}");
        self.recover(&path);
        if self.failed.len() == MOST_FAILURES {
            self.failed.remove(0);
        }
        self.failed.push(BtfFailure { path, error });
    }

    pub(crate) fn recover(&mut self, path: &str) {
        self.failed.retain(|failure| failure.path != path);
    }
}

/// What the render world has to say.
#[derive(Clone, Debug, Default)]
pub(crate) struct Report {
    pub(crate) limited: Option<String>,
    pub(crate) uploading: usize,
    pub(crate) resident: usize,
    pub(crate) resident_bytes: u64,
    pub(crate) buffers: usize,
    /// Materials that no buffer of this device can hold: name and reason.
    pub(crate) refused: Vec<(String, String)>,
}

/// Both worlds hold it.
#[derive(Resource, Clone, Default)]
pub(crate) struct SharedReport(pub(crate) Arc<Mutex<Report>>);

impl SharedReport {
    pub(crate) fn with<R>(&self, change: impl FnOnce(&mut Report) -> R) -> R {
        change(&mut self.0.lock().unwrap_or_else(|poisoned| poisoned.into_inner()))
    }
}

pub(crate) fn note_failures(
    mut failures: MessageReader<AssetLoadFailedEvent<BtfAsset>>,
    mut status: ResMut<BtfStatus>,
) {
    for failure in failures.read() {
        status.fail(failure.path.to_string(), failure.error.to_string());
    }
}

pub(crate) fn take_report(report: Res<SharedReport>, mut status: ResMut<BtfStatus>) {
    let Report { limited, resident, resident_bytes, buffers, refused, .. } =
        report.with(|report| {
            let refused = std::mem::take(&mut report.refused);
            Report { refused, ..report.clone() }
        });
    for (name, reason) in refused {
        status.fail(name, reason);
    }
    let now = BtfStatus { limited, resident, resident_bytes, buffers, ..status.clone() };
    status.set_if_neq(now);
}
