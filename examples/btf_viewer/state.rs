//! What is shown now, what is wrong, and what changed on disk.

use std::{
    path::{Path, PathBuf},
    time::SystemTime,
};

use bevy::prelude::*;
use farlight::core::parse_ron;

use super::{
    args::Args,
    config::{Rig, Viewer},
};

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

/// What is shown.
#[derive(Resource, Clone, Debug, PartialEq)]
pub struct Shown {
    /// Index of the object.
    pub object: usize,
    /// Index of the material; without materials nothing is there.
    pub material: usize,
    /// Lamps.
    pub light: Rig,
    /// Index of the environment.
    pub environment: Option<usize>,
    /// Whether it is seen behind the object.
    pub backdrop: bool,
    /// Whether its light is refined from frame to frame; else it is image-based light.
    pub progressive: bool,
    /// Whether the object stands on something.
    pub floor: bool,
    /// Exposure value at ISO 100.
    pub exposure: f32,
    /// Pixels drawn for a pixel of the window, along each edge.
    pub resolution: f32,
    /// Factor on the size of the material's picture.
    pub pattern: f32,
    /// Where the key light comes from: degrees round the vertical axis and above the horizon.
    pub light_direction: Vec2,
    /// Turn of the object in degrees.
    pub turn: f32,
    /// Whether it goes on turning.
    pub turning: bool,
}

impl Shown {
    /// What the configuration begins with.
    pub fn start(config: &Viewer) -> Self {
        let start = &config.start;
        let object = config.models.iter().position(|m| m.name == start.object);
        let material = config.materials.iter().position(|m| m.name == start.material);
        Self {
            object: object.unwrap_or(0),
            material: material.unwrap_or(0),
            light: start.light,
            environment: config.environments.iter().position(|e| e.name == start.environment),
            backdrop: start.backdrop,
            progressive: config.progressive.on,
            floor: start.floor,
            exposure: config.exposure,
            resolution: config.resolution.scale,
            pattern: 1.0,
            light_direction: config.light.direction.into(),
            turn: 0.0,
            turning: false,
        }
    }
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

/// The folder that relative paths start from.
pub fn assets() -> PathBuf {
    Path::new(env!("CARGO_MANIFEST_DIR")).join("assets")
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
            // What changed in the file is shown; what was chosen by keys and did not change stays.
            let (before, after) = (Shown::start(&config.0), Shown::start(&new));
            if before != after {
                *shown = after;
            }
            shown.object = shown.object.min(new.models.len() - 1);
            shown.material = shown.material.min(new.materials.len().saturating_sub(1));
            shown.environment = shown.environment.filter(|&e| e < new.environments.len());
            config.0 = new;
            problems.config = None;
        }
        Err(message) => {
            error!("{message}");
            problems.config = Some(message);
        }
    }
}
