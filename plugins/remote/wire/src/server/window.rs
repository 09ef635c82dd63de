//! How much light may be on its way: as much as the network takes without queueing.

use std::time::Duration;

/// Bytes at the start, at least, at most. They are counted before compression.
const START: usize = 256 << 10;
const LEAST: usize = 32 << 10;
const MOST: usize = 8 << 20;
/// Time that a message may wait in queues on its way.
const QUEUEING: Duration = Duration::from_millis(60);
/// By how much the shortest time is raised an arrival, so that it follows a route that got longer.
const AGEING: Duration = Duration::from_micros(200);
/// A message is not late before this.
const LEAST_PATIENCE: Duration = Duration::from_millis(200);

/// Bounds what is on its way by how long it takes to arrive, in the manner of delay-based congestion
/// control (TCP Vegas, Brakmo and Peterson 1995): the shortest time seen is the way itself, what is
/// longer is a queue.
#[derive(Debug)]
pub(super) struct Window {
    bytes: usize,
    shortest: Option<Duration>,
    usual: Duration,
}

impl Default for Window {
    fn default() -> Self {
        Self { bytes: START, shortest: None, usual: Duration::ZERO }
    }
}

impl Window {
    /// A message of so many bytes was acknowledged after a time.
    pub(super) fn arrived(&mut self, after: Duration, bytes: usize) {
        let shortest = self.shortest.map_or(after, |s| (s + AGEING).min(after));
        self.shortest = Some(shortest);
        self.usual = if self.usual.is_zero() { after } else { (self.usual * 7 + after) / 8 };
        self.bytes = if after > shortest * 2 + QUEUEING {
            (self.bytes * 3 / 4).max(LEAST)
        } else {
            (self.bytes + bytes / 4).min(MOST)
        };
    }

    /// Bytes that may be sent while so many are on their way; `None`: wait. One message may always
    /// be on its way.
    pub(super) fn room(&self, flying: usize) -> Option<usize> {
        match self.bytes.saturating_sub(flying) {
            0 => None,
            room => Some(room.max(LEAST / 4)),
        }
    }

    /// After which time a message is late.
    pub(super) fn patience(&self) -> Duration {
        (self.usual * 3).max(LEAST_PATIENCE)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn queues_make_it_small_and_a_free_way_large() {
        let ms = Duration::from_millis;
        let mut window = Window::default();
        for _ in 0..50 {
            window.arrived(ms(20), 64 << 10);
        }
        assert!(window.bytes > 2 * START);
        for _ in 0..50 {
            window.arrived(ms(500), 64 << 10);
        }
        assert_eq!(window.bytes, LEAST);
        assert_eq!(window.room(LEAST), None);
        assert!(window.room(0).is_some());
        assert!(window.patience() > ms(500));
    }

    #[test]
    fn a_longer_way_is_learned() {
        let ms = Duration::from_millis;
        let mut window = Window::default();
        window.arrived(ms(10), 1000);
        for _ in 0..1000 {
            window.arrived(ms(150), 1000);
        }
        assert!(window.bytes > LEAST, "{window:?}");
    }
}
