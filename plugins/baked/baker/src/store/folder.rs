//! Result files: written whole or not at all, removed only if they are ours.

use std::{
    collections::BTreeSet,
    fs::{self, File, OpenOptions},
    io::{self, Write},
    path::{Path, PathBuf},
    sync::atomic::{AtomicU32, Ordering::Relaxed},
};

use farlight_baked_format::{
    Fingerprint, Manifest,
    manifest::{EXTENSION, ManifestError},
    name,
};

use crate::BakeError;

/// The name of the cache's folder.
const CACHE: &str = ".bake";
/// In it: the names of all files that were written into the folder, a line each.
const WRITTEN: &str = "written";

/// The folder of the results of one scene.
pub(crate) struct Folder {
    dir: PathBuf,
    name: String,
}

/// Tells temporary files of one process apart.
static COUNTER: AtomicU32 = AtomicU32::new(0);

impl Folder {
    /// The folder for a scene, which need not be there yet.
    pub(crate) fn new(dir: &Path, scene: &Path) -> Self {
        let stem = scene.file_stem().unwrap_or_default().to_string_lossy();
        Self { dir: dir.to_owned(), name: name::part(&stem) }
    }

    /// Makes it. Fails where nothing can be written, or something of that name is not ours.
    pub(crate) fn prepare(&self, scene: &Path) -> Result<(), BakeError> {
        let cache = self.cache();
        let io = |path: &Path, doing| {
            let path = path.to_owned();
            move |source| BakeError::Io { path, doing, source }
        };
        fs::create_dir_all(&cache).map_err(io(&cache, "made"))?;
        let lit = self.at(&self.scene());
        let same = |a: &Path, b: &Path| match (a.canonicalize(), b.canonicalize()) {
            (Ok(a), Ok(b)) => a == b,
            _ => false,
        };
        if same(&lit, scene) {
            let what = "is the scene itself, and the lit scene would replace it: choose another \
                        folder for the results";
            return Err(BakeError::Foreign { path: lit, what: what.to_owned() });
        }
        let manifest = self.manifest_name();
        let ours = self.written();
        let known = self.at(&manifest).exists() || ours.contains(&self.scene());
        if lit.exists() && !known {
            let what = "is there and was not made by a bake: choose another folder, or remove it";
            return Err(BakeError::Foreign { path: lit, what: what.to_owned() });
        }
        Ok(())
    }

    /// Where a file of it is.
    pub(crate) fn at(&self, name: &str) -> PathBuf {
        self.dir.join(name)
    }

    pub(crate) fn path(&self) -> &Path {
        &self.dir
    }

    pub(crate) fn cache(&self) -> PathBuf {
        self.dir.join(CACHE)
    }

    /// The name of the manifest.
    pub(crate) fn manifest_name(&self) -> String {
        format!("{}.{EXTENSION}", self.name)
    }

    /// The name of the lit scene.
    pub(crate) fn scene(&self) -> String {
        format!("{}.glb", self.name)
    }

    /// The manifest of the last bake; `None` if there is none. The inner error: it can't be used.
    pub(crate) fn manifest(&self) -> Option<Result<Manifest, ManifestError>> {
        let text = fs::read_to_string(self.at(&self.manifest_name())).ok()?;
        Some(Manifest::parse(&text))
    }

    /// Writes a file whose name, `NAME.{part}.HASH.{extension}`, says what it holds. Returns the name.
    pub(crate) fn add(
        &self,
        part: &str,
        extension: &str,
        bytes: &[u8],
    ) -> Result<String, BakeError> {
        let hash = Fingerprint::of(bytes).short();
        let file = format!("{}.{part}.{hash}.{extension}", self.name);
        if !self.is_intact(&file) {
            self.replace(&file, bytes)?;
        }
        Ok(file)
    }

    /// Whether a file that [`add`](Self::add) wrote is there and holds what it held.
    pub(crate) fn is_intact(&self, file: &str) -> bool {
        let hash = file.rsplit('.').nth(1);
        let bytes = fs::read(self.at(file));
        matches!((hash, bytes), (Some(hash), Ok(bytes)) if Fingerprint::of(&bytes).short() == hash)
    }

    /// Writes a file, or replaces it by a new one: whoever opens it sees one or the other.
    pub(crate) fn replace(&self, file: &str, bytes: &[u8]) -> Result<(), BakeError> {
        let path = self.at(file);
        let io = |source| BakeError::Io { path: path.clone(), doing: "written", source };
        self.remember(file).map_err(io)?;
        write_whole(&self.cache(), &path, bytes).map_err(io)
    }

    /// Removes what earlier bakes wrote and nobody needs any more: only files that are known to have been
    /// written by one, and are named like it.
    pub(crate) fn clean(&self, needed: &BTreeSet<String>, old: Option<&Manifest>) {
        let mut ours = self.written();
        ours.extend(old.into_iter().flat_map(files));
        let mut kept = String::new();
        for file in &ours {
            if needed.contains(file) {
                kept += &format!("{file}\n");
            } else if self.is_named_like_ours(file) {
                // What can't be removed is merely left over.
                let _ = fs::remove_file(self.at(file));
            }
        }
        let _ = write_whole(&self.cache(), &self.cache().join(WRITTEN), kept.as_bytes());
    }

    fn is_named_like_ours(&self, file: &str) -> bool {
        let Some(rest) = file.strip_prefix(&self.name).and_then(|rest| rest.strip_prefix('.'))
        else {
            return false;
        };
        let parts: Vec<&str> = rest.split('.').collect();
        let [_, _, hash, "ktx2" | "exr"] = parts[..] else { return false };
        name::is_plain(file) && hash.len() == 8 && hash.bytes().all(|b| b.is_ascii_hexdigit())
    }

    /// Names of files of which it is known that bakes wrote them.
    fn written(&self) -> BTreeSet<String> {
        let text = fs::read_to_string(self.cache().join(WRITTEN)).unwrap_or_default();
        text.lines().filter(|line| name::is_plain(line)).map(str::to_owned).collect()
    }

    /// Notes a name before the file is there, so that it is never taken for somebody else's.
    fn remember(&self, file: &str) -> io::Result<()> {
        let mut options = OpenOptions::new();
        let mut notes = options.create(true).append(true).open(self.cache().join(WRITTEN))?;
        // A line that a killed process left unfinished is ended by the line break in front.
        notes.write_all(format!("\n{file}\n").as_bytes())
    }
}

/// All files that a manifest names, beside the lit scene.
pub(crate) fn files(manifest: &Manifest) -> Vec<String> {
    let mut names = Vec::new();
    for scenario in &manifest.scenarios {
        for page in &scenario.pages {
            names.push(page.ktx2.clone());
            names.extend(Some(page.exr.clone()).filter(|name| !name.is_empty()));
        }
        names.extend(scenario.volumes.iter().cloned());
    }
    names
}

/// Writes a file under another name in `beside`, on the same disk, and then renames it.
pub(super) fn write_whole(beside: &Path, path: &Path, bytes: &[u8]) -> io::Result<()> {
    let number = COUNTER.fetch_add(1, Relaxed);
    let part = beside.join(format!("part-{}-{number}", std::process::id()));
    let write = || {
        let mut file = File::create(&part)?;
        file.write_all(bytes)?;
        file.sync_all()?;
        fs::rename(&part, path)
    };
    write().inspect_err(|_| {
        let _ = fs::remove_file(&part);
    })
}
