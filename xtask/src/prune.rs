//! `cargo xtask prune`: a build folder that several checkouts share stays below a size.
//!
//! Dependencies are compiled once for all checkouts, but cargo names what it builds from a
//! workspace after the workspace's path as well, so every fresh clone leaves its test programs
//! behind, each with an engine linked in.

use std::collections::HashMap;
use std::fs::{File, OpenOptions, TryLockError};
use std::path::{Path, PathBuf};
use std::time::{Duration, SystemTime};

use crate::args::Args;
use crate::{Failure, environment};

pub(crate) const HELP: &str = "\
cargo xtask prune [--limit GB] [--dry-run]

If the build folder is larger than the limit, removes what this workspace's own crates left there
from other checkouts and older builds, oldest first and nothing younger than six hours, until it is
not. If that does not do, dependencies have piled up: it removes those that are older than two weeks.

  --limit GB   the size to stay below (default 30)
  --dry-run    only say what would go

The folder is the one that CARGO_TARGET_DIR names, else target/.
";

/// What may belong to a build that runs now is left alone.
const KEEP_OURS: Duration = Duration::from_secs(6 * 3600);
/// Dependencies are worth more: they cost minutes.
const KEEP_OTHERS: Duration = Duration::from_secs(14 * 24 * 3600);

pub(crate) fn run(mut args: Args) -> Result<(), Failure> {
    let limit = args.parsed::<f64>("--limit", "a size in gigabytes")?.unwrap_or(30.0);
    let dry_run = args.flag("--dry-run");
    args.finish()?;
    if limit.is_nan() || limit < 0.0 {
        return Err("--limit must not be negative.".to_owned());
    }
    let folder = environment::target_dir();
    let size = size_of(&folder);
    println!("{}: {:.1} GB, limit {limit:.1} GB", folder.display(), gigabytes(size));
    let excess = size.saturating_sub((limit * 1e9) as u64);
    if excess == 0 {
        return Ok(());
    }
    let mut freed = 0;
    for profile in profiles(&folder) {
        let Some(_lock) = lock(&profile)? else {
            println!("{} is in use by another build and stays.", profile.display());
            continue;
        };
        let units = units(&profile);
        for unit in chosen(&units, excess.saturating_sub(freed), SystemTime::now()) {
            if dry_run {
                println!("would remove {} ({:.1} MB)", unit.name, unit.size as f64 / 1e6);
            } else {
                unit.files.iter().for_each(|path| remove(path));
            }
            freed += unit.size;
        }
    }
    println!("{:.1} GB {}", gigabytes(freed), if dry_run { "would go" } else { "removed" });
    Ok(())
}

/// What cargo made of one crate in one configuration: everything that carries one hash.
#[derive(Debug, Default, PartialEq, Eq)]
struct Unit {
    /// Package and hash, as cargo names it.
    name: String,
    files: Vec<PathBuf>,
    size: u64,
    /// When it was built, at the latest.
    built: Option<SystemTime>,
}

impl Unit {
    /// Whether it is of this workspace.
    fn is_ours(&self) -> bool {
        let (package, _) = split(&self.name);
        package == "xtask" || package == "farlight" || package.starts_with("farlight_")
    }
}

/// The units to remove so that `excess` bytes go: ours first, then the oldest, none that is young.
fn chosen(units: &[Unit], excess: u64, now: SystemTime) -> Vec<&Unit> {
    let age = |unit: &Unit| {
        unit.built.and_then(|built| now.duration_since(built).ok()).unwrap_or_default()
    };
    let mut old: Vec<&Unit> = units
        .iter()
        .filter(|unit| age(unit) > if unit.is_ours() { KEEP_OURS } else { KEEP_OTHERS })
        .collect();
    old.sort_by_key(|unit| (!unit.is_ours(), std::cmp::Reverse(age(unit))));
    let mut freed = 0;
    old.into_iter()
        .take_while(|unit| {
            let wanted = freed < excess;
            freed += unit.size;
            wanted
        })
        .collect()
}

/// Groups the files of a profile's folder by hash. `.fingerprint` names the package of each hash.
fn units(profile: &Path) -> Vec<Unit> {
    let mut units: HashMap<String, Unit> = HashMap::new();
    for folder in [".fingerprint", "deps", "build", "examples", "incremental"] {
        for path in entries(&profile.join(folder)) {
            let name = path.file_name().unwrap_or_default().to_string_lossy().into_owned();
            let (package, hash) = split(name.split('.').next().unwrap_or_default());
            if hash.is_empty() {
                continue;
            }
            let unit = units.entry(hash.to_owned()).or_default();
            if folder == ".fingerprint" || unit.name.is_empty() {
                unit.name = format!("{}-{hash}", package.trim_start_matches("lib"));
            }
            unit.size += size_of(&path);
            let built = path.metadata().and_then(|metadata| metadata.modified()).ok();
            unit.built = unit.built.max(built);
            unit.files.push(path);
        }
    }
    units.into_values().collect()
}

/// Splits `name-hash`; the hash is empty where there is none.
fn split(name: &str) -> (&str, &str) {
    match name.rsplit_once('-') {
        Some((package, hash))
            if hash.len() >= 12 && hash.bytes().all(|b| b.is_ascii_alphanumeric()) =>
        {
            (package, hash)
        }
        _ => (name, ""),
    }
}

/// Folders in which cargo keeps a profile's artefacts: `debug`, `release`, those of other targets.
fn profiles(folder: &Path) -> Vec<PathBuf> {
    let is_profile = |path: &PathBuf| path.join(".fingerprint").is_dir();
    let below = entries(folder);
    let of_targets = below.iter().flat_map(|path| entries(path));
    below.iter().cloned().chain(of_targets).filter(is_profile).collect()
}

/// Cargo's own lock on the profile, so that nothing vanishes under a running build; nothing if a
/// build holds it.
fn lock(profile: &Path) -> Result<Option<File>, Failure> {
    let path = profile.join(".cargo-lock");
    let failed = |error: std::io::Error| format!("{}: {error}.", path.display());
    let file =
        OpenOptions::new().write(true).create(true).truncate(false).open(&path).map_err(failed)?;
    match file.try_lock() {
        Ok(()) => Ok(Some(file)),
        Err(TryLockError::WouldBlock) => Ok(None),
        Err(TryLockError::Error(error)) => Err(failed(error)),
    }
}

fn entries(folder: &Path) -> Vec<PathBuf> {
    let entries = std::fs::read_dir(folder).into_iter().flatten();
    entries.filter_map(|entry| Some(entry.ok()?.path())).collect()
}

/// Bytes of a file or of a folder with all below it; links are not followed.
fn size_of(path: &Path) -> u64 {
    match path.symlink_metadata() {
        Ok(metadata) if metadata.is_dir() => entries(path).iter().map(|path| size_of(path)).sum(),
        Ok(metadata) => metadata.len() / links(&metadata),
        Err(_) => 0,
    }
}

/// How many names a file has: cargo links what it builds under two or three.
#[cfg(unix)]
fn links(metadata: &std::fs::Metadata) -> u64 {
    std::os::unix::fs::MetadataExt::nlink(metadata).max(1)
}

#[cfg(not(unix))]
fn links(_: &std::fs::Metadata) -> u64 {
    1
}

fn remove(path: &Path) {
    let removed = match path.symlink_metadata() {
        Ok(metadata) if metadata.is_dir() => std::fs::remove_dir_all(path),
        _ => std::fs::remove_file(path),
    };
    if let Err(error) = removed {
        println!("{}: {error}", path.display());
    }
}

fn gigabytes(bytes: u64) -> f64 {
    bytes as f64 / 1e9
}

#[cfg(test)]
mod tests {
    use super::*;

    const HOUR: Duration = Duration::from_secs(3600);

    fn unit(name: &str, size: u64, age: Duration, now: SystemTime) -> Unit {
        Unit { name: name.to_owned(), files: Vec::new(), size, built: Some(now - age) }
    }

    #[test]
    fn ours_go_first_oldest_first_and_only_as_many_as_needed() {
        let now = SystemTime::now();
        let units = [
            unit("bevy-0123456789abcdef", 100, HOUR * 24 * 30, now),
            unit("farlight_gi-0123456789abcde0", 10, HOUR * 24, now),
            unit("farlight-0123456789abcde1", 10, HOUR * 48, now),
            unit("xtask-0123456789abcde2", 10, HOUR, now),
        ];
        let names = |excess| {
            let names = chosen(&units, excess, now).into_iter().map(|unit| split(&unit.name).0);
            names.collect::<Vec<_>>()
        };
        assert_eq!(names(0), [""; 0]);
        assert_eq!(names(5), ["farlight"]);
        assert_eq!(names(15), ["farlight", "farlight_gi"]);
        assert_eq!(names(1000), ["farlight", "farlight_gi", "bevy"], "xtask is too young");
    }

    #[test]
    fn names_and_hashes() {
        assert_eq!(split("bevy_pbr-0123456789abcdef"), ("bevy_pbr", "0123456789abcdef"));
        assert_eq!(split("some-crate-name"), ("some-crate-name", ""));
        assert_eq!(split("xtask"), ("xtask", ""));
    }

    #[test]
    fn the_files_of_a_unit_go_together() {
        let folder = std::env::temp_dir().join(format!("xtask-prune-{}", std::process::id()));
        let profile = folder.join("debug");
        let hash = "0123456789abcdef";
        for file in [
            format!(".fingerprint/farlight-{hash}/invoked.timestamp"),
            format!("deps/demo-{hash}"),
            format!("deps/demo-{hash}.d"),
            format!("deps/libfarlight-{hash}.rlib"),
            "deps/libbevy-fedcba9876543210.rlib".to_owned(),
            "demo".to_owned(),
        ] {
            let path = profile.join(file);
            std::fs::create_dir_all(path.parent().unwrap()).unwrap();
            std::fs::write(path, "four").unwrap();
        }
        assert_eq!(profiles(&folder), std::slice::from_ref(&profile));
        let units = units(&profile);
        let ours: Vec<_> = units.iter().filter(|unit| unit.is_ours()).collect();
        assert_eq!((units.len(), ours.len()), (2, 1));
        assert_eq!((ours[0].files.len(), ours[0].size), (4, 16));
        ours[0].files.iter().for_each(|path| remove(path));
        assert_eq!(entries(&profile.join("deps")).len(), 1);
        assert!(profile.join("demo").exists());

        let held = lock(&profile).unwrap();
        assert!(held.is_some());
        assert!(lock(&profile).unwrap().is_none(), "held by the first");
        std::fs::remove_dir_all(&folder).unwrap();
    }
}
