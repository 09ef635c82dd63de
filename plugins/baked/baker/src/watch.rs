//! Baking again whenever the inputs change.

use std::{
    collections::BTreeMap,
    path::PathBuf,
    sync::{Mutex, atomic::Ordering::Relaxed},
    thread,
    time::{Duration, Instant, SystemTime},
};

use crate::{
    Bake, BakeError, Report,
    observer::{Event, Observer},
};

/// Between two looks at the files.
const LOOK: Duration = Duration::from_millis(100);
/// Files are read once they have rested for so long: exporters write them piece by piece.
const REST: Duration = Duration::from_millis(300);

/// What a file looks like from outside; `None` if it isn't there.
type Stamp = Option<(SystemTime, u64)>;

/// The inputs, and what they looked like.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
struct Stamps(BTreeMap<PathBuf, Stamp>);

impl Stamps {
    fn of(files: impl IntoIterator<Item = PathBuf>) -> Self {
        let stamp = |path: &PathBuf| {
            let data = std::fs::metadata(path).ok()?;
            Some((data.modified().ok()?, data.len()))
        };
        Self(files.into_iter().map(|path| (path.clone(), stamp(&path))).collect())
    }

    fn now(&self) -> Self {
        Self::of(self.0.keys().cloned())
    }

    fn changed(&self) -> bool {
        *self != self.now()
    }
}

/// Bakes, and again whenever a file that was read changes and then rests for 300 ms, until the bake's stop
/// flag is set. Each result is told; after an error the last good files stay as they are. A bake whose
/// inputs change under its hands is given up, without a result.
///
/// Files are looked at ten times a second, by their times and sizes.
pub fn watch(
    bake: Bake,
    observer: &mut dyn Observer,
    tell: &mut dyn FnMut(Result<Report, BakeError>),
) {
    let stop = bake.stop_flag();
    let options = bake.options();
    let known = || [Some(options.scene.clone()), options.lights.clone()].into_iter().flatten();
    let mut stamps = Stamps::of(known());
    loop {
        // Not at every tick: asking the file system takes longer than a look at a clock.
        let last = Mutex::new((Instant::now(), false));
        let outdated = || {
            let Ok(mut last) = last.try_lock() else { return false };
            if !last.1 && last.0.elapsed() >= LOOK {
                *last = (Instant::now(), stamps.changed());
            }
            last.1
        };
        let result = bake.run_until(observer, &outdated);
        let stopped = stop.load(Relaxed);
        let before = stamps.clone();
        match result {
            Err(BakeError::Outdated) => {}
            Ok((report, files)) => {
                // Files that belong to the scene are known only now; what the others looked like
                // before they were read still counts.
                stamps = Stamps::of(files);
                for (path, stamp) in before.0 {
                    stamps.0.insert(path, stamp);
                }
                tell(Ok(report));
            }
            Err(error) => tell(Err(error)),
        }
        if stopped {
            return;
        }
        observer.event(Event::Idle);
        while !stamps.changed() {
            if stop.load(Relaxed) {
                return;
            }
            thread::sleep(LOOK);
        }
        let mut seen = stamps.now();
        let mut since = Instant::now();
        while since.elapsed() < REST {
            if stop.load(Relaxed) {
                return;
            }
            thread::sleep(LOOK);
            let now = seen.now();
            if now != seen {
                (seen, since) = (now, Instant::now());
            }
        }
        stamps = seen;
    }
}
