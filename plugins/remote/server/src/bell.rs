//! Wakes a thread that sleeps.

use std::{
    sync::{Condvar, Mutex, MutexGuard, PoisonError},
    time::Duration,
};

/// Remembers that it was rung until somebody has waited for it.
#[derive(Debug, Default)]
pub(crate) struct Bell {
    rung: Mutex<bool>,
    changed: Condvar,
}

impl Bell {
    pub(crate) fn ring(&self) {
        *lock(&self.rung) = true;
        self.changed.notify_all();
    }

    /// Returns when it was rung since the last time, or after `timeout`.
    pub(crate) fn wait(&self, timeout: Option<Duration>) {
        let rung = lock(&self.rung);
        let silent = |rung: &mut bool| !*rung;
        let mut rung = match timeout {
            Some(timeout) => {
                let waited = self.changed.wait_timeout_while(rung, timeout, silent);
                waited.unwrap_or_else(PoisonError::into_inner).0
            }
            None => self.changed.wait_while(rung, silent).unwrap_or_else(PoisonError::into_inner),
        };
        *rung = false;
    }
}

/// Locks also after a panic of another holder: sessions are separate, and the one that failed ends.
pub(crate) fn lock<T>(mutex: &Mutex<T>) -> MutexGuard<'_, T> {
    mutex.lock().unwrap_or_else(PoisonError::into_inner)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_ring_before_the_wait_is_not_lost() {
        let bell = Bell::default();
        bell.ring();
        bell.wait(None);
        bell.wait(Some(Duration::from_millis(1)));
        std::thread::scope(|scope| {
            scope.spawn(|| bell.wait(None));
            bell.ring();
        });
    }
}
