//! The library as an editor uses it: events, stopping anywhere, inputs of several files.

mod input;
mod stop;

use std::{collections::BTreeMap, fs, path::Path, sync::Arc, sync::atomic::AtomicBool};

use farlight_baker::{Bake, BakeOptions, Effort, Event, Observer, Probes, Stage, Texels};

/// Two rooms and a lamp.
const SCENE: &str = concat!(env!("CARGO_MANIFEST_DIR"), "/../../../tests/data/TwoRooms.glb");

/// A bake that takes a second or so.
fn quick(scene: &Path, out: &Path) -> BakeOptions {
    let mut options = BakeOptions::new(scene, out);
    options.texels = Texels::Page(64);
    options.effort = Effort::Rays(64);
    options.probes = Probes::Spacing(2.0);
    options
}

/// Files of a folder, without the cache.
fn contents(out: &Path) -> BTreeMap<String, Vec<u8>> {
    let entries = fs::read_dir(out).unwrap().map(Result::unwrap);
    entries
        .filter(|entry| entry.path().is_file())
        .map(|entry| (entry.file_name().into_string().unwrap(), fs::read(entry.path()).unwrap()))
        .collect()
}

/// Notes what it hears, and may stop the bake at the beginning of a stage.
#[derive(Default)]
struct Ear {
    stages: Vec<Stage>,
    warnings: Vec<String>,
    stop: Option<(Stage, Arc<AtomicBool>)>,
}

impl Observer for Ear {
    fn event(&mut self, event: Event<'_>) {
        match event {
            Event::Progress(progress) => {
                assert!((0.0..=1.0).contains(&progress.done), "{}", progress.done);
                if self.stages.last() != Some(&progress.stage) {
                    self.stages.push(progress.stage);
                }
                if let Some((stage, flag)) = &self.stop
                    && *stage == progress.stage
                {
                    flag.store(true, std::sync::atomic::Ordering::Relaxed);
                }
            }
            Event::Warning(text) => self.warnings.push(text.to_owned()),
            Event::Idle => {}
        }
    }
}

fn run(
    options: BakeOptions,
    ear: &mut Ear,
) -> Result<farlight_baker::Report, farlight_baker::BakeError> {
    Bake::new(options).run(ear)
}
