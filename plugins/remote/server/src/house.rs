//! What the parts of a server share: the sessions, and what one session's threads tell each other.

use std::{
    collections::VecDeque,
    sync::{
        Arc, Condvar, Mutex, MutexGuard, PoisonError,
        atomic::{AtomicBool, AtomicU64, AtomicUsize, Ordering},
    },
    time::Duration,
};

use farlight_gi_solver::session::{SessionSettings, SnapshotId};
use farlight_wire::{
    BlobStore, CloseCode, Limits, Link, SceneSize, ServerConfig, ServerSession, SessionKey, Token,
};

use crate::{
    SolverFactory,
    bell::{Bell, lock},
    settings::ServerSettings,
};

/// The whole server, shared by its threads.
pub(crate) struct House {
    pub(crate) settings: ServerSettings,
    pub(crate) limits: Limits,
    pub(crate) token: Token,
    pub(crate) blobs: BlobStore,
    pub(crate) solver: SolverFactory,
    /// Wakes whoever looks after new connections.
    pub(crate) bell: Bell,
    /// The sessions that clients can be in. Never call a link while this is locked: links wake
    /// others, and waking takes this lock.
    rooms: Mutex<Vec<Arc<Room>>>,
    /// Solvers that have not ended yet, those of sessions that are over included.
    pub(crate) solvers: AtomicUsize,
    pub(crate) stopping: AtomicBool,
    pub(crate) counters: Counters,
}

/// Sums over the life of a server.
#[derive(Default)]
pub(crate) struct Counters {
    pub(crate) updates: AtomicU64,
    pub(crate) sent_bytes: AtomicU64,
    pub(crate) received_bytes: AtomicU64,
    pub(crate) admitted: AtomicU64,
    pub(crate) refused: AtomicU64,
    pub(crate) ended: AtomicU64,
}

impl House {
    pub(crate) fn new(settings: ServerSettings, token: Token, solver: SolverFactory) -> Self {
        Self {
            limits: settings.limits(),
            blobs: BlobStore::new(settings.unused_blob_bytes()),
            settings,
            token,
            solver,
            bell: Bell::default(),
            rooms: Mutex::default(),
            solvers: AtomicUsize::new(0),
            stopping: AtomicBool::new(false),
            counters: Counters::default(),
        }
    }

    /// Wakes everyone: something came from the network.
    pub(crate) fn wake(&self) {
        self.bell.ring();
        for room in &*lock(&self.rooms) {
            room.bell.ring();
        }
    }

    pub(crate) fn rooms(&self) -> Vec<Arc<Room>> {
        lock(&self.rooms).clone()
    }

    pub(crate) fn add(&self, room: Arc<Room>) {
        lock(&self.rooms).push(room);
    }

    /// No client finds the session any more.
    pub(crate) fn remove(&self, room: &Arc<Room>) {
        lock(&self.rooms).retain(|other| !Arc::ptr_eq(room, other));
    }

    /// Lets go of meshes and images that were kept for sessions that are over.
    pub(crate) fn trim(&self) {
        self.blobs.trim();
    }

    /// The session with a key.
    pub(crate) fn find(&self, key: SessionKey) -> Option<Arc<Room>> {
        lock(&self.rooms).iter().find(|room| room.key == key).cloned()
    }

    pub(crate) fn is_stopping(&self) -> bool {
        self.stopping.load(Ordering::Relaxed)
    }
}

/// One session.
pub(crate) struct Room {
    /// Counts the sessions of a server, for the log.
    pub(crate) number: u64,
    pub(crate) key: SessionKey,
    pub(crate) name: String,
    pub(crate) settings: SessionSettings,
    /// Never locked while something is solved.
    pub(crate) wire: Mutex<ServerSession>,
    /// Wakes the driver.
    pub(crate) bell: Bell,
    mail: Mutex<Mail>,
    task: Mutex<Task>,
    task_changed: Condvar,
    pub(crate) progress: Mutex<Progress>,
}

/// A client at a session's door: its greeting was accepted.
pub(crate) struct Guest {
    pub(crate) link: Box<dyn Link>,
    pub(crate) address: String,
    pub(crate) resumed: bool,
}

/// For the driver.
#[derive(Default)]
struct Mail {
    guests: VecDeque<Guest>,
    end: Option<(CloseCode, String)>,
    /// The session is over.
    closed: bool,
}

/// For the solver.
#[derive(Debug, Default)]
pub(crate) struct Task {
    /// The scene changed.
    pub(crate) changed: bool,
    /// Somebody waits for light.
    pub(crate) attached: bool,
    /// The session is over.
    pub(crate) stop: bool,
    /// Why the solver has ended by itself.
    pub(crate) failed: Option<String>,
}

/// What can be told about a session.
#[derive(Clone, Debug, Default)]
pub(crate) struct Progress {
    /// Of the client; nothing while it is away.
    pub(crate) address: Option<String>,
    /// Since when it is away.
    pub(crate) away_since: Option<Duration>,
    pub(crate) snapshot: SnapshotId,
    pub(crate) size: SceneSize,
    pub(crate) updates: u64,
    pub(crate) converged: bool,
}

impl Room {
    pub(crate) fn new(
        number: u64,
        key: SessionKey,
        name: String,
        settings: SessionSettings,
        wire: ServerSession,
    ) -> Self {
        Self {
            number,
            key,
            name,
            settings,
            wire: Mutex::new(wire),
            bell: Bell::default(),
            mail: Mutex::default(),
            task: Mutex::default(),
            task_changed: Condvar::new(),
            progress: Mutex::default(),
        }
    }

    /// Frees what the session holds of its scene.
    pub(crate) fn clear(&self) {
        let config = ServerConfig::default();
        let empty = ServerSession::new(self.key, self.settings.clone(), config);
        drop(std::mem::replace(&mut *lock(&self.wire), empty));
    }

    /// Hands a client over to the session; gives it back where the session is over or about to be.
    pub(crate) fn enter(&self, guest: Guest) -> Result<(), Guest> {
        {
            let mut mail = lock(&self.mail);
            if mail.closed || mail.end.is_some() {
                return Err(guest);
            }
            mail.guests.push_back(guest);
        }
        self.bell.ring();
        Ok(())
    }

    /// Tells the session to end.
    pub(crate) fn end(&self, code: CloseCode, why: &str) {
        lock(&self.mail).end.get_or_insert_with(|| (code, why.to_owned()));
        self.bell.ring();
    }

    pub(crate) fn next_guest(&self) -> Option<Guest> {
        lock(&self.mail).guests.pop_front()
    }

    /// What the session was told by [`end`](Self::end).
    pub(crate) fn end_order(&self) -> Option<(CloseCode, String)> {
        lock(&self.mail).end.clone()
    }

    /// Nobody enters any more. Unless `anyway`, only if nobody is about to.
    pub(crate) fn close(&self, anyway: bool) -> bool {
        let mut mail = lock(&self.mail);
        if anyway || mail.guests.is_empty() {
            mail.closed = true;
        }
        mail.closed
    }

    /// Since when no client is there or about to enter.
    pub(crate) fn away_since(&self) -> Option<Duration> {
        let mail = lock(&self.mail);
        if mail.guests.is_empty() { lock(&self.progress).away_since } else { None }
    }

    /// When the client was last heard of over its present connection.
    pub(crate) fn last_heard(&self) -> Option<Duration> {
        lock(&self.wire).last_heard()
    }

    pub(crate) fn task(&self) -> MutexGuard<'_, Task> {
        lock(&self.task)
    }

    /// Changes what the solver has to do, and wakes it.
    pub(crate) fn set_task(&self, change: impl FnOnce(&mut Task)) {
        change(&mut self.task());
        self.task_changed.notify_all();
    }

    /// Waits until the solver's task has changed.
    pub(crate) fn wait_task<'a>(&self, task: MutexGuard<'a, Task>) -> MutexGuard<'a, Task> {
        self.task_changed.wait(task).unwrap_or_else(PoisonError::into_inner)
    }
}

impl std::fmt::Display for Room {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        write!(f, "session {} ({:?})", self.number, self.name)
    }
}
