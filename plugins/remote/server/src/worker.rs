//! Solves the light of one session.

use std::{
    panic::{AssertUnwindSafe, catch_unwind},
    sync::{Arc, atomic::Ordering},
    time::{Duration, Instant},
};

use farlight_gi_solver::session::{
    LightingUpdate, Quality, SessionSettings, SnapshotId, Solve, panic_message,
};

use crate::{
    bell::lock,
    house::{House, Room, Task},
};

/// Makes what solves a session; called on the thread that will run it.
pub type SolverFactory = Box<dyn Fn(SessionSettings) -> Box<dyn Solve> + Send + Sync>;

/// Drives the solver of a session. A panic of the solver ends the session, not the server.
pub(crate) struct Worker {
    house: Arc<House>,
    room: Arc<Room>,
    /// Made at the first piece of work.
    solver: Option<Box<dyn Solve>>,
    /// Time of solving since the last update.
    solving: Duration,
    /// The newest snapshot that the solver has, and the newest that it has answered.
    newest: SnapshotId,
    answered: SnapshotId,
    /// How good the light was that was published last.
    quality: Quality,
}

impl Drop for Worker {
    fn drop(&mut self) {
        self.solver = None;
        self.house.trim();
        self.house.counters.ended.fetch_add(1, Ordering::Relaxed);
        self.house.solvers.fetch_sub(1, Ordering::Relaxed);
    }
}

impl Worker {
    pub(crate) fn new(house: Arc<House>, room: Arc<Room>) -> Self {
        house.solvers.fetch_add(1, Ordering::Relaxed);
        Self {
            house,
            room,
            solver: None,
            solving: Duration::ZERO,
            newest: SnapshotId::default(),
            answered: SnapshotId::default(),
            quality: Quality::default(),
        }
    }

    /// Works until the session is over, sleeping while there is nothing to do.
    pub(crate) fn run(mut self, clock: impl Fn() -> Duration) {
        let room = self.room.clone();
        loop {
            let mut task = room.task();
            loop {
                if task.stop || task.failed.is_some() {
                    return;
                }
                if self.wants_to_work(&task) {
                    break;
                }
                task = room.wait_task(task);
            }
            drop(task);
            self.work(&clock);
        }
    }

    /// Does a piece of work if there is one, and says whether there was.
    pub(crate) fn tick(&mut self, clock: impl Fn() -> Duration) -> bool {
        let room = self.room.clone();
        let task = room.task();
        if task.stop || task.failed.is_some() || !self.wants_to_work(&task) {
            return false;
        }
        drop(task);
        self.work(&clock);
        true
    }

    /// While the client is away its last snapshot is still answered, then the solver rests.
    fn wants_to_work(&self, task: &Task) -> bool {
        let idle = self.solver.as_ref().is_none_or(|solver| solver.is_idle());
        task.changed || (!idle && (task.attached || self.answered < self.newest))
    }

    fn work(&mut self, clock: &impl Fn() -> Duration) {
        let outcome = catch_unwind(AssertUnwindSafe(|| self.work_here(clock)));
        if let Err(panic) = outcome {
            let why = panic_message(&*panic).to_owned();
            self.room.set_task(|task| task.failed = Some(why));
            self.room.bell.ring();
        }
    }

    fn work_here(&mut self, clock: &impl Fn() -> Duration) {
        self.room.task().changed = false;
        let start = Instant::now();
        let make = || (self.house.solver)(self.room.settings.clone());
        let solver = self.solver.get_or_insert_with(make);
        let mut applied = false;
        loop {
            let next = lock(&self.room.wire).take_changes();
            let Some((snapshot, changes)) = next else { break };
            self.newest = self.newest.max(snapshot);
            solver.apply(snapshot, changes);
            applied = true;
        }
        if applied {
            let size = lock(&self.room.wire).scene_size();
            let mut progress = lock(&self.room.progress);
            progress.size = size;
            progress.converged = false;
            // Also if it is what came late of a snapshot that was answered without it.
            self.answered = self.answered.min(SnapshotId(self.newest.0.saturating_sub(1)));
        }
        let update = solver.step();
        self.solving += start.elapsed();
        let idle = solver.is_idle();
        if let Some(update) = update {
            self.publish(clock, &update);
        }
        if idle && self.answered < self.newest {
            // There is no light to solve, or the last changes make no difference to it. Whoever
            // waits for the snapshot should know.
            let quality = Quality { converged: true, ..self.quality };
            let snapshot = self.newest;
            let update = LightingUpdate { snapshot, quality, ..LightingUpdate::default() };
            self.publish(clock, &update);
        }
    }

    fn publish(&mut self, clock: &impl Fn() -> Duration, update: &LightingUpdate) {
        self.answered = update.snapshot;
        self.quality = update.quality;
        let solve = std::mem::take(&mut self.solving);
        lock(&self.room.wire).publish(clock(), update, solve);
        {
            let mut progress = lock(&self.room.progress);
            progress.snapshot = update.snapshot;
            progress.updates += 1;
            progress.converged = update.quality.converged;
        }
        self.house.counters.updates.fetch_add(1, Ordering::Relaxed);
        self.room.bell.ring();
    }
}
