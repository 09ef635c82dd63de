//! Attempts to connect, and when the next one is due.
//!
//! A new attempt begins before the last one has failed: on a line that loses packets a handshake
//! may hang for seconds while the next one goes through. The first that opens wins.

use std::{collections::VecDeque, time::Duration};

use farlight_gi::solver::sampling::Rng;
use farlight_wire::{CloseCode, Closed, Link, LinkEvent};

/// Attempts at the same time; when one more is due, the oldest is given up.
const MAX_LINKS: usize = 4;
/// An attempt is due after so much of the time that has passed since the connection was lost: each
/// wait is an eighth longer than the one before.
const GROWTH: u32 = 8;

/// Bounds of the time between two attempts.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Retry {
    pub(crate) min: Duration,
    pub(crate) max: Duration,
}

/// Attempts that are under way, if a connection is wanted.
pub(crate) struct Attempts {
    retry: Retry,
    rng: Rng,
    links: VecDeque<Box<dyn Link>>,
    /// A connection is wanted.
    wanted: bool,
    /// Since when there has been none, or none that lasted.
    since: Option<Duration>,
    next: Duration,
    count: u32,
}

/// What became of an attempt.
pub(crate) enum Attempted {
    Opened(Box<dyn Link>),
    Failed(Closed),
}

impl Attempts {
    pub(crate) fn new(retry: Retry, seed: u64) -> Self {
        Self {
            retry,
            rng: Rng::new(seed, 0),
            links: VecDeque::new(),
            wanted: false,
            since: None,
            next: Duration::ZERO,
            count: 0,
        }
    }

    /// A connection is wanted. The first attempt is due at once, unless one that was made before
    /// did not last.
    pub(crate) fn begin(&mut self, now: Duration) {
        if self.wanted {
            return;
        }
        self.wanted = true;
        if self.since.is_none() {
            self.since = Some(now);
            self.next = now;
            self.count = 0;
        }
    }

    /// A connection is there; the others are given up.
    pub(crate) fn end(&mut self) {
        self.wanted = false;
        for mut link in self.links.drain(..) {
            link.close(CloseCode::Done, "");
        }
    }

    /// The connection has lasted: the next loss begins from the start.
    pub(crate) fn forget(&mut self) {
        if !self.wanted {
            self.since = None;
        }
    }

    /// Since when a connection is wanted.
    pub(crate) fn wanted_since(&self) -> Option<Duration> {
        self.since.filter(|_| self.wanted)
    }

    /// When the next attempt is due.
    pub(crate) fn next(&self) -> Option<Duration> {
        self.wanted.then_some(self.next)
    }

    /// Attempts since the connection was lost.
    pub(crate) fn count(&self) -> u32 {
        self.count
    }

    /// Whether one is under way.
    pub(crate) fn is_trying(&self) -> bool {
        !self.links.is_empty()
    }

    /// An attempt begins.
    pub(crate) fn start(&mut self, now: Duration, link: Box<dyn Link>) {
        if self.links.len() == MAX_LINKS
            && let Some(mut oldest) = self.links.pop_front()
        {
            oldest.close(CloseCode::Done, "");
        }
        self.links.push_back(link);
        self.count += 1;
        let gone = now.saturating_sub(self.since.unwrap_or(now));
        let wait = (gone / GROWTH).clamp(self.retry.min, self.retry.max);
        // So that many clients don't come back at the same moment.
        self.next = now + wait.mul_f32(0.8 + 0.4 * self.rng.next_f32());
    }

    /// What became of one, if there is news.
    pub(crate) fn poll(&mut self) -> Option<Attempted> {
        let mut at = 0;
        while let Some(link) = self.links.get_mut(at) {
            match link.poll() {
                Some(LinkEvent::Opened) => return self.links.remove(at).map(Attempted::Opened),
                Some(LinkEvent::Closed(closed)) => {
                    drop(self.links.remove(at));
                    return Some(Attempted::Failed(closed));
                }
                Some(LinkEvent::Received(..) | LinkEvent::Sent(_)) => {}
                None => at += 1,
            }
        }
        None
    }
}

impl std::fmt::Debug for Attempts {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        f.debug_struct("Attempts").field("count", &self.count).finish_non_exhaustive()
    }
}

#[cfg(test)]
mod tests {
    use farlight_wire::{LinkStats, Transmit, TransmitId};

    use super::*;

    const MS: Duration = Duration::from_millis(1);

    /// Never opens.
    struct Dead;

    impl Link for Dead {
        fn send(&mut self, _: Transmit) {}
        fn cancel(&mut self, _: TransmitId) {}
        fn poll(&mut self) -> Option<LinkEvent> {
            None
        }
        fn close(&mut self, _: CloseCode, _: &str) {}
        fn stats(&self) -> LinkStats {
            LinkStats::default()
        }
    }

    fn attempts(seed: u64) -> Attempts {
        Attempts::new(Retry { min: 200 * MS, max: 5000 * MS }, seed)
    }

    fn times(attempts: &mut Attempts, until: Duration) -> Vec<Duration> {
        let mut times = Vec::new();
        while let Some(next) = attempts.next().filter(|next| *next < until) {
            attempts.start(next, Box::new(Dead));
            times.push(next);
        }
        times
    }

    #[test]
    fn waits_grow_to_a_bound_and_few_attempts_are_under_way() {
        let mut attempts = attempts(1);
        assert_eq!(attempts.next(), None);
        attempts.begin(1000 * MS);
        attempts.begin(1500 * MS);
        let times = times(&mut attempts, 300_000 * MS);
        assert_eq!(times[0], 1000 * MS, "at once");
        let waits: Vec<_> = times.windows(2).map(|w| w[1] - w[0]).collect();
        for (wait, at) in waits.iter().zip(&times) {
            let gone = *at - 1000 * MS;
            let expected = (gone / GROWTH).clamp(200 * MS, 5000 * MS);
            assert!(*wait >= expected.mul_f32(0.79) && *wait <= expected.mul_f32(1.21));
        }
        assert!(attempts.links.len() <= MAX_LINKS);
        assert_eq!(attempts.count() as usize, times.len());
        attempts.end();
        assert!(!attempts.is_trying() && attempts.next().is_none());
    }

    #[test]
    fn a_connection_that_did_not_last_does_not_begin_from_the_start() {
        let mut attempts = attempts(1);
        attempts.begin(Duration::ZERO);
        let last = *times(&mut attempts, 60_000 * MS).last().unwrap();
        attempts.end();
        attempts.begin(60_000 * MS);
        assert!(attempts.next().unwrap() > last + 3000 * MS);
        attempts.end();
        attempts.forget();
        attempts.begin(70_000 * MS);
        assert_eq!(attempts.next(), Some(70_000 * MS));
    }

    #[test]
    fn the_seed_decides() {
        let run = |seed| {
            let mut attempts = attempts(seed);
            attempts.begin(Duration::ZERO);
            times(&mut attempts, 10_000 * MS)
        };
        assert_eq!(run(1), run(1));
        assert_ne!(run(1), run(2));
    }
}
