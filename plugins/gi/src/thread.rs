//! The solver in a background thread of the game.

use std::{
    collections::VecDeque,
    panic::{AssertUnwindSafe, catch_unwind},
    sync::{
        Arc, Condvar, Mutex, MutexGuard, PoisonError,
        atomic::{AtomicBool, Ordering},
    },
    thread::JoinHandle,
    time::{Duration, Instant},
};

use bevy::log::error;
use farlight_gi_solver::session::{
    Session, SessionChange, SessionSettings, SnapshotId, Solve, panic_message,
};

use crate::{BackendState, GiUpdate, LightingBackend};

/// Updates that may wait to be polled before the solver pauses: a game that doesn't draw doesn't
/// pile up lighting.
const MAX_WAITING: usize = 4;

/// Solves on this machine's processor: one thread that drives a [`Session`], whose parallel work
/// runs on threads of its own. Dropping it stops the solver after the piece of work at hand.
pub struct ThreadBackend {
    shared: Arc<Shared>,
    thread: Option<JoinHandle<()>>,
}

struct Shared {
    mail: Mutex<Mail>,
    changed: Condvar,
    stop: AtomicBool,
}

#[derive(Default)]
struct Mail {
    submitted: Vec<(SnapshotId, Vec<SessionChange>)>,
    updates: VecDeque<GiUpdate>,
    state: BackendState,
}

impl Shared {
    fn lock(&self) -> MutexGuard<'_, Mail> {
        self.mail.lock().unwrap_or_else(PoisonError::into_inner)
    }
}

impl ThreadBackend {
    /// Starts a solver with these settings. It works on as many threads as they say: by default one
    /// fewer than there are cores, so that the game keeps one.
    #[must_use]
    pub fn new(settings: SessionSettings) -> Self {
        Self::run(move || Session::new(settings))
    }

    /// Runs something else that solves; `make` is called on the new thread.
    #[must_use]
    pub fn run<S: Solve>(make: impl FnOnce() -> S + Send + 'static) -> Self {
        let shared = Arc::new(Shared {
            mail: Mutex::default(),
            changed: Condvar::new(),
            stop: AtomicBool::new(false),
        });
        let for_thread = shared.clone();
        let thread = std::thread::Builder::new()
            .name("farlight solver".into())
            .spawn(move || work(&for_thread, make));
        let thread = match thread {
            Ok(thread) => Some(thread),
            Err(problem) => {
                let reason = format!("the solver's thread can't be started: {problem}");
                error!("global illumination is off: {reason}");
                shared.lock().state = BackendState::Failed(reason.into());
                None
            }
        };
        Self { shared, thread }
    }
}

impl LightingBackend for ThreadBackend {
    fn submit(&mut self, snapshot: SnapshotId, changes: Vec<SessionChange>) {
        let mut mail = self.shared.lock();
        if matches!(mail.state, BackendState::Failed(_)) {
            return;
        }
        mail.submitted.push((snapshot, changes));
        mail.state = BackendState::Solving;
        drop(mail);
        self.shared.changed.notify_all();
    }

    fn poll(&mut self) -> Option<GiUpdate> {
        let update = self.shared.lock().updates.pop_front();
        if update.is_some() {
            self.shared.changed.notify_all();
        }
        update
    }

    fn state(&self) -> BackendState {
        self.shared.lock().state.clone()
    }
}

impl Drop for ThreadBackend {
    fn drop(&mut self) {
        self.shared.stop.store(true, Ordering::Relaxed);
        // The lock makes sure that the thread is either waiting or will see the flag.
        drop(self.shared.lock());
        self.shared.changed.notify_all();
        if let Some(thread) = self.thread.take()
            && thread.join().is_err()
        {
            error!("the solver's thread ended with a panic");
        }
    }
}

/// The thread: panics of the solver end it, not the game.
fn work<S: Solve>(shared: &Shared, make: impl FnOnce() -> S) {
    let outcome = catch_unwind(AssertUnwindSafe(|| run(shared, make())));
    if let Err(panic) = outcome {
        let reason = format!("the solver failed: {}", panic_message(&*panic));
        error!("global illumination has stopped: {reason}");
        shared.lock().state = BackendState::Failed(reason.into());
    }
}

fn run(shared: &Shared, mut solver: impl Solve) {
    let mut solving = Duration::ZERO;
    loop {
        let mut mail = shared.lock();
        let submitted = loop {
            if shared.stop.load(Ordering::Relaxed) {
                return;
            }
            let full = mail.updates.len() >= MAX_WAITING;
            if !full && (!solver.is_idle() || !mail.submitted.is_empty()) {
                break std::mem::take(&mut mail.submitted);
            }
            if solver.is_idle() && mail.submitted.is_empty() {
                mail.state = match mail.state {
                    BackendState::Solving | BackendState::Converged => BackendState::Converged,
                    _ => BackendState::Idle,
                };
            }
            mail = shared.changed.wait(mail).unwrap_or_else(PoisonError::into_inner);
        };
        mail.state = BackendState::Solving;
        drop(mail);

        let start = Instant::now();
        for (snapshot, changes) in submitted {
            solver.apply(snapshot, changes);
        }
        let update = solver.step();
        solving += start.elapsed();
        if let Some(update) = update {
            let encoding = Instant::now();
            let mut update = GiUpdate::encode(&update);
            update.times.solve = Some(std::mem::take(&mut solving));
            update.times.encode = Some(encoding.elapsed());
            shared.lock().updates.push_back(update);
        }
    }
}

#[cfg(test)]
mod tests {
    use farlight_gi_solver::session::LightingUpdate;

    use super::*;

    /// Answers each snapshot once; panics when told so.
    struct Echo {
        pending: Option<SnapshotId>,
        panic_at: u64,
    }

    impl Solve for Echo {
        fn apply(&mut self, snapshot: SnapshotId, _: Vec<SessionChange>) {
            assert!(snapshot.0 != self.panic_at, "told to");
            self.pending = Some(snapshot);
        }

        fn step(&mut self) -> Option<LightingUpdate> {
            let snapshot = self.pending.take()?;
            Some(LightingUpdate { snapshot, ..LightingUpdate::default() })
        }

        fn is_idle(&self) -> bool {
            self.pending.is_none()
        }
    }

    fn wait<T>(mut look: impl FnMut() -> Option<T>) -> T {
        let patience = Instant::now() + Duration::from_secs(20);
        loop {
            if let Some(found) = look() {
                return found;
            }
            assert!(Instant::now() < patience, "the thread doesn't answer");
            std::thread::yield_now();
        }
    }

    #[test]
    fn snapshots_are_answered_and_a_still_scene_is_converged() {
        let mut backend = ThreadBackend::run(|| Echo { pending: None, panic_at: u64::MAX });
        for snapshot in 1..=3 {
            backend.submit(SnapshotId(snapshot), Vec::new());
        }
        wait(|| backend.poll().filter(|update| update.snapshot == SnapshotId(3)));
        wait(|| (backend.state() == BackendState::Converged).then_some(()));
        drop(backend);
    }

    #[test]
    fn a_panic_of_the_solver_becomes_a_state() {
        let mut backend = ThreadBackend::run(|| Echo { pending: None, panic_at: 2 });
        backend.submit(SnapshotId(2), Vec::new());
        let reason = wait(|| match backend.state() {
            BackendState::Failed(reason) => Some(reason),
            _ => None,
        });
        assert!(reason.contains("told to"), "{reason}");
        backend.submit(SnapshotId(3), Vec::new());
        assert!(backend.poll().is_none());
    }

    #[test]
    fn updates_that_nobody_takes_do_not_pile_up() {
        /// Never idle, always something new.
        struct Busy;
        impl Solve for Busy {
            fn apply(&mut self, _: SnapshotId, _: Vec<SessionChange>) {}
            fn step(&mut self) -> Option<LightingUpdate> {
                let mut echo = Echo { pending: Some(SnapshotId(1)), panic_at: 0 };
                echo.step()
            }
            fn is_idle(&self) -> bool {
                false
            }
        }
        let mut backend = ThreadBackend::run(|| Busy);
        wait(|| (backend.shared.lock().updates.len() == MAX_WAITING).then_some(()));
        assert!(backend.poll().is_some());
        wait(|| (backend.shared.lock().updates.len() == MAX_WAITING).then_some(()));
        drop(backend);
    }
}
