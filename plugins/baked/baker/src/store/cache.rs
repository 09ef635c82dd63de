//! What is kept from one bake to the next.

use std::{
    collections::BTreeSet,
    fs,
    path::{Path, PathBuf},
    sync::Mutex,
};

use farlight_baked_format::Fingerprint;
use serde::{Deserialize, Serialize};

use super::folder::write_whole;
use crate::{bake::kind, observer::Work, uv::UvCache};

/// What files of the cache begin with.
const MAGIC: &[u8; 8] = b"FLbake1\n";

/// Kept data by keys. Whatever can't be read is as if it weren't there.
pub(crate) struct Cache<'a> {
    folder: PathBuf,
    work: &'a Work<'a>,
    /// Whether there is anything to be read: not where everything is to be made anew.
    read: bool,
    used: Mutex<BTreeSet<String>>,
}

/// Files that were made from certain inputs.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub(crate) struct Record {
    /// Names of pages, each KTX2 and then OpenEXR if there is one.
    pub(crate) pages: Vec<String>,
    /// Names of volumes.
    pub(crate) volumes: Vec<String>,
    /// Rays a texel behind them.
    pub(crate) rays: u32,
    /// Median relative error of the texels before filtering.
    pub(crate) relative_error: f32,
}

impl<'a> Cache<'a> {
    pub(crate) fn new(folder: PathBuf, work: &'a Work<'a>, read: bool) -> Self {
        Self { folder, work, read, used: Mutex::default() }
    }

    /// The name of a file, which is in use from now on.
    fn name(&self, kind: &str, key: Fingerprint) -> String {
        let name = format!("{kind}-{key}");
        self.used.lock().unwrap_or_else(std::sync::PoisonError::into_inner).insert(name.clone());
        name
    }

    /// Says that something is to be kept though nobody asks for it now.
    pub(crate) fn keep(&self, kind: &str, key: Fingerprint) {
        self.name(kind, key);
    }

    /// What was kept.
    pub(crate) fn load(&self, kind: &str, key: Fingerprint) -> Option<Vec<u8>> {
        let name = self.name(kind, key);
        if !self.read {
            return None;
        }
        let mut bytes = fs::read(self.folder.join(&name)).ok()?;
        let damaged = || {
            self.work
                .warn(format!("{}: is damaged and ignored", self.folder.join(&name).display()));
        };
        let start = MAGIC.len() + 16;
        let head = bytes.get(..start).map(<[u8]>::to_vec).unwrap_or_default();
        let good = head.starts_with(MAGIC)
            && head[MAGIC.len()..] == Fingerprint::of(&bytes[start..]).0.to_le_bytes();
        if !good {
            damaged();
            return None;
        }
        bytes.drain(..start);
        Some(bytes)
    }

    /// Keeps something. A full disk is no reason to stop: it only warns.
    pub(crate) fn store(&self, kind: &str, key: Fingerprint, content: &[u8]) {
        let path = self.folder.join(self.name(kind, key));
        let mut bytes = Vec::with_capacity(content.len() + 24);
        bytes.extend_from_slice(MAGIC);
        bytes.extend_from_slice(&Fingerprint::of(content).0.to_le_bytes());
        bytes.extend_from_slice(content);
        if let Err(error) = write_whole(&self.folder, &path, &bytes) {
            self.work.warn(format!("{}: can't be written: {error}", path.display()));
        }
    }

    /// A record.
    pub(crate) fn record(&self, kind: &str, key: Fingerprint) -> Option<Record> {
        let text = String::from_utf8(self.load(kind, key)?).ok()?;
        ron::from_str(&text).ok()
    }

    /// Keeps a record.
    pub(crate) fn set_record(&self, kind: &str, key: Fingerprint, record: &Record) {
        if let Ok(text) = ron::to_string(record) {
            self.store(kind, key, text.as_bytes());
        }
    }

    /// Removes what was not used, and what killed bakes left half written.
    pub(crate) fn prune(&self, kinds: &[&str]) {
        let used = self.used.lock().unwrap_or_else(std::sync::PoisonError::into_inner);
        for (name, path) in names(&self.folder) {
            let ours = match name.split_once('-') {
                Some(("part", _)) => true,
                Some((kind, key)) => kinds.contains(&kind) && key.parse::<Fingerprint>().is_ok(),
                None => false,
            };
            if ours && !used.contains(&name) {
                let _ = fs::remove_file(path);
            }
        }
    }
}

impl UvCache for Cache<'_> {
    fn get(&self, key: Fingerprint) -> Option<Vec<u8>> {
        self.load(kind::UV, key)
    }

    fn put(&self, key: Fingerprint, bytes: &[u8]) {
        self.store(kind::UV, key, bytes);
    }
}

fn names(folder: &Path) -> Vec<(String, PathBuf)> {
    let Ok(entries) = fs::read_dir(folder) else { return Vec::new() };
    entries
        .flatten()
        .filter_map(|entry| Some((entry.file_name().into_string().ok()?, entry.path())))
        .collect()
}
