//! A bake, from files to files.
//!
//! 1. Everything is read and hashed; if the last manifest was made from the same, nothing is done.
//! 2. [`geometry`]: second UV sets, and where every texel lies. Shared by all scenarios.
//! 3. [`scenario`]: direct light, gather passes, filtering, pages and probes of each scenario, or what
//!    an earlier bake left of it.
//! 4. [`publish`]: the manifest, and the end of what it no longer names.

mod geometry;
mod input;
mod plan;
mod probes;
mod publish;
mod scenario;

use std::sync::{Arc, atomic::AtomicBool};

use crate::{
    BakeError, BakeOptions, Report,
    observer::{Observer, Stage, Step, Work},
    report::Outcome,
    store::{Cache, Folder, Lock},
};
use geometry::Geometry;
use input::Input;
use plan::Plan;
use scenario::{Baked, Deadline};

/// A bake that is about to run.
pub struct Bake {
    options: BakeOptions,
    stop: Arc<AtomicBool>,
}

/// Kinds of kept data.
pub(crate) mod kind {
    /// Second UV sets, by mesh.
    pub(crate) const UV: &str = "uv";
    /// Sums of gather rays.
    pub(crate) const GATHER: &str = "gather";
    /// Direct light of texels.
    pub(crate) const DIRECT: &str = "direct";
    /// Which files hold a scenario at a certain effort.
    pub(crate) const DONE: &str = "done";
    /// Which files hold a scenario at whatever effort was spent on it last.
    pub(crate) const LAST: &str = "last";
    /// Which files hold the probes.
    pub(crate) const PROBES: &str = "probes";
    /// All of them.
    pub(crate) const ALL: [&str; 6] = [UV, GATHER, DIRECT, DONE, LAST, PROBES];
}

impl Bake {
    /// A bake with these options.
    #[must_use]
    pub fn new(options: BakeOptions) -> Self {
        Self { options, stop: Arc::default() }
    }

    /// Set this to stop the bake: what is done by then is written, and the next run goes on from there.
    #[must_use]
    pub fn stop_flag(&self) -> Arc<AtomicBool> {
        self.stop.clone()
    }

    /// The options.
    #[must_use]
    pub fn options(&self) -> &BakeOptions {
        &self.options
    }

    /// Bakes, on all threads of the current rayon pool. Equal inputs give equal files on any number of
    /// threads, and however often the work was interrupted; except with [`Effort::Time`](crate::Effort).
    ///
    /// # Errors
    /// [`BakeError`]. The last result stays as it was.
    pub fn run(&self, observer: &mut dyn Observer) -> Result<Report, BakeError> {
        self.run_until(observer, &|| false).map(|(report, _)| report)
    }

    /// [`run`](Self::run), given up with [`BakeError::Outdated`] once `outdated` says yes (it is asked ten
    /// times a second). Returns the files that were read as well.
    pub(crate) fn run_until(
        &self,
        observer: &mut dyn Observer,
        outdated: &(dyn Fn() -> bool + Sync),
    ) -> Result<(Report, Vec<std::path::PathBuf>), BakeError> {
        let options = &self.options;
        options.validate()?;
        let work = Work::new(observer, self.stop.clone(), outdated);
        let reading = work.begin(Stage::Read, "", 1);
        let input = Input::read(options)?;
        let folder = Folder::new(&options.out, &options.scene);
        let old = match folder.manifest() {
            None => None,
            Some(Ok(manifest)) => Some(manifest),
            Some(Err(error)) => {
                let path = folder.at(&folder.manifest_name());
                work.warn(format!("{}: {error}; it will be replaced", path.display()));
                None
            }
        };
        if let Some(old) = &old
            && !options.force
            && publish::is_current(&folder, &input, old)
        {
            drop(reading);
            return Ok((Report::of(old, &folder, Outcome::Unchanged, &work), input.files));
        }
        folder.prepare(&options.scene)?;
        let _lock = Lock::take(folder.path(), &folder.cache())?;
        let cache = Cache::new(folder.cache(), &work, !options.force);

        let mut scene = input.scene(options, &work)?;
        let plans = Plan::all(options, &input, &scene)?;
        drop(reading);
        work.plan(guess(&plans));
        let geometry = Geometry::new(options, &input, &mut scene, &cache, &work)?;
        work.plan(geometry.steps(options, &plans));

        let deadline = Deadline::new(options, &work, geometry.layout.len());
        let mut baked: Vec<(bool, Baked)> = Vec::new();
        let mut world = geometry.world;
        let geometry = geometry.rest;
        let wanted = |plan: &Plan| options.wants(&plan.name);
        let mut left = plans.iter().filter(|plan| wanted(plan)).count() as u32;
        for plan in &plans {
            let one = scenario::Scenario {
                options,
                plan,
                geometry: &geometry,
                folder: &folder,
                cache: &cache,
                work: &work,
            };
            let result = if wanted(plan) && !work.stopped() {
                let share = deadline.share(left);
                left -= 1;
                one.bake(&mut world, &scene.scene, share)?
            } else {
                one.recall()
            };
            if work.outdated() {
                return Err(BakeError::Outdated);
            }
            // Less than what was asked for is better than nothing.
            baked.extend(result.or_else(|| one.last()).map(|baked| (wanted(plan), baked)));
        }
        if baked.is_empty() {
            return Err(BakeError::Stopped);
        }
        let report = publish::publish(
            options,
            &input,
            &geometry,
            &plans,
            baked,
            &folder,
            old.as_ref(),
            &work,
        )?;
        cache.prune(&kind::ALL);
        Ok((report, input.files))
    }
}

/// What is to be done, before more than the scenarios' names is known.
fn guess(plans: &[Plan]) -> Vec<Step> {
    let mut steps = vec![Step::new(Stage::Unwrap, "", 3.0), Step::new(Stage::Layout, "", 2.0)];
    steps.extend(plans.iter().map(|plan| Step::new(Stage::Gather, &plan.name, 60.0)));
    steps
}
