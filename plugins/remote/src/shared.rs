//! What the game's thread and the driver's share, behind one short lock.

use std::{
    sync::{Arc, Condvar, Mutex, MutexGuard, PoisonError},
    time::Duration,
};

use farlight_gi::{
    BackendState, LinkStatus,
    solver::session::{SessionChange, SnapshotId},
};
use farlight_wire::{View, Wake};

use crate::mailbox::Waiting;

/// Shared by a backend and its driver.
#[derive(Debug, Default)]
pub(crate) struct Shared {
    mail: Mutex<Mail>,
    changed: Condvar,
}

/// Both directions.
#[derive(Debug, Default)]
pub(crate) struct Mail {
    pub(crate) to_driver: ToDriver,
    pub(crate) updates: Waiting,
    pub(crate) state: BackendState,
    pub(crate) link: LinkStatus,
    /// Something is there for the driver, or came from the network.
    rung: bool,
    /// The driver's thread has ended.
    ended: bool,
}

/// What the game asks for.
#[derive(Debug, Default)]
pub(crate) struct ToDriver {
    pub(crate) submitted: Vec<(SnapshotId, Vec<SessionChange>)>,
    pub(crate) resync: bool,
    pub(crate) view: Option<View>,
    /// The game is done with it.
    pub(crate) stop: bool,
}

impl Shared {
    pub(crate) fn lock(&self) -> MutexGuard<'_, Mail> {
        self.mail.lock().unwrap_or_else(PoisonError::into_inner)
    }

    /// Changes what the driver should do, and wakes it.
    pub(crate) fn tell(&self, change: impl FnOnce(&mut ToDriver)) {
        let mut mail = self.lock();
        change(&mut mail.to_driver);
        mail.rung = true;
        drop(mail);
        self.changed.notify_all();
    }

    /// Returns when the driver was woken since the last time, or after `timeout`.
    pub(crate) fn wait(&self, timeout: Option<Duration>) {
        let mail = self.lock();
        let silent = |mail: &mut Mail| !mail.rung;
        let mut mail = match timeout {
            Some(timeout) => {
                let waited = self.changed.wait_timeout_while(mail, timeout, silent);
                waited.unwrap_or_else(PoisonError::into_inner).0
            }
            None => self.changed.wait_while(mail, silent).unwrap_or_else(PoisonError::into_inner),
        };
        mail.rung = false;
    }

    /// Notes that it is over for good.
    pub(crate) fn fail(&self, why: String) {
        self.lock().state = BackendState::Failed(why.into());
    }

    /// The driver's thread ends.
    pub(crate) fn end(&self) {
        self.lock().ended = true;
        self.changed.notify_all();
    }

    /// Waits for [`end`](Self::end), but not for long.
    pub(crate) fn wait_for_end(&self, timeout: Duration) {
        let running = |mail: &mut Mail| !mail.ended;
        drop(self.changed.wait_timeout_while(self.lock(), timeout, running));
    }

    /// Wakes the driver.
    pub(crate) fn waker(self: &Arc<Self>) -> Wake {
        let shared = self.clone();
        Arc::new(move || shared.tell(|_| {}))
    }
}
