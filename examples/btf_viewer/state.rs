//! The configuration in force, what is wrong, and what changed on disk.

use std::{
    path::{Path, PathBuf},
    time::SystemTime,
};

use bevy::prelude::*;
use farlight::core::parse_ron;

use super::{actions::Said, args::Args, config::Viewer, program::assets, shown::Shown};

/// The configuration, the command line already in it.
#[derive(Resource, Clone, Debug)]
pub struct Config(pub Viewer);

/// Where the configuration came from, to read it again.
#[derive(Resource, Clone, Debug)]
pub struct Source {
    /// The file.
    pub file: PathBuf,
    /// What goes over it.
    pub args: Args,
}

/// What went wrong, shown until it is right; `None` is fine.
#[derive(Resource, Default, Debug)]
pub struct Problems {
    /// The configuration file; the last good one stays in use.
    pub config: Option<String>,
    /// The object.
    pub object: Option<String>,
    /// The material.
    pub material: Option<String>,
    /// The environment.
    pub environment: Option<String>,
}

impl Problems {
    /// All of them.
    pub fn all(&self) -> impl Iterator<Item = &str> {
        [&self.config, &self.object, &self.material, &self.environment]
            .into_iter()
            .filter_map(Option::as_deref)
    }
}

/// A path of the configuration as the system knows it.
pub fn on_disk(path: &str) -> PathBuf {
    assets().join(path)
}

/// Reads the configuration; the command line goes over it.
pub fn read(source: &Source) -> Result<Viewer, String> {
    let file = source.file.display().to_string();
    let text = std::fs::read_to_string(&source.file).map_err(|e| format!("{file}: {e}"))?;
    let mut config: Viewer = parse_ron(&file, &text).map_err(|e| e.to_string())?;
    source.args.apply(&mut config)?;
    Ok(config)
}

/// When a file was last written.
pub fn written(path: &Path) -> Option<SystemTime> {
    std::fs::metadata(path).and_then(|meta| meta.modified()).ok()
}

/// Reads the configuration again when its file has changed: looks once a second.
pub fn watch(
    time: Res<Time>,
    source: Res<Source>,
    mut config: ResMut<Config>,
    mut shown: ResMut<Shown>,
    mut problems: ResMut<Problems>,
    mut said: Said,
    mut last: Local<Option<(f32, Option<SystemTime>)>>,
) {
    let now = time.elapsed_secs();
    let seen = match *last {
        Some((at, _)) if now - at < 1.0 => return,
        Some((_, seen)) => seen,
        None => written(&source.file),
    };
    let current = written(&source.file);
    *last = Some((now, current));
    if current == seen {
        return;
    }
    match read(&source) {
        Ok(new) => {
            // What changed in the file is shown; what was chosen since and did not change there stays.
            let (before, after) = (Shown::start(&config.0), Shown::start(&new));
            if before != after {
                *shown = after;
            }
            shown.fit(&new);
            config.0 = new;
            problems.config = None;
            said.say("Configuration read again");
        }
        Err(message) => {
            error!("{message}");
            problems.config = Some(message);
        }
    }
}
