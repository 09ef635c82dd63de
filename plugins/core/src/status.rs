//! What status resources are made of.

use std::{borrow::Cow, collections::VecDeque, time::Duration};

use bevy::{ecs::entity::Entity, prelude::ReflectDefault, reflect::Reflect};

/// An entity that a plugin can't treat as asked, and why, in words for the game's author.
#[derive(Clone, Debug, PartialEq, Eq, Reflect)]
#[reflect(Clone)]
pub struct LeftOut {
    /// The entity.
    pub entity: Entity,
    /// Why, and what to do about it.
    pub reason: Cow<'static, str>,
}

/// Order statistics of durations.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct TimeStats {
    /// Shortest.
    pub min: Duration,
    /// Half are shorter.
    pub median: Duration,
    /// 95 % are shorter.
    pub p95: Duration,
    /// 99 % are shorter.
    pub p99: Duration,
    /// Longest.
    pub max: Duration,
    /// How many there are.
    pub samples: usize,
}

/// The last durations of something, in bounded memory.
#[derive(Clone, Debug, Reflect)]
#[reflect(opaque, Default, Clone)]
pub struct TimeWindow {
    ring: VecDeque<Duration>,
    capacity: usize,
}

impl Default for TimeWindow {
    /// A window of 1024.
    fn default() -> Self {
        Self::new(1024)
    }
}

impl TimeWindow {
    /// A window of the last `capacity` durations (at least one).
    #[must_use]
    pub fn new(capacity: usize) -> Self {
        let capacity = capacity.max(1);
        Self { ring: VecDeque::with_capacity(capacity), capacity }
    }

    /// Adds one; the oldest leaves when the window is full.
    pub fn push(&mut self, duration: Duration) {
        if self.ring.len() == self.capacity {
            self.ring.pop_front();
        }
        self.ring.push_back(duration);
    }

    /// The newest.
    #[must_use]
    pub fn last(&self) -> Option<Duration> {
        self.ring.back().copied()
    }

    /// All of them, oldest first.
    pub fn iter(&self) -> impl DoubleEndedIterator<Item = Duration> {
        self.ring.iter().copied()
    }

    /// Forgets everything, for example after loading.
    pub fn clear(&mut self) {
        self.ring.clear();
    }

    /// How many there are.
    #[must_use]
    pub fn len(&self) -> usize {
        self.ring.len()
    }

    /// Whether there is none.
    #[must_use]
    pub fn is_empty(&self) -> bool {
        self.ring.is_empty()
    }

    /// Sorts a copy: call it when somebody looks, not every frame. All zero while empty.
    #[must_use]
    pub fn stats(&self) -> TimeStats {
        let mut sorted: Vec<_> = self.ring.iter().copied().collect();
        sorted.sort_unstable();
        let Some(&max) = sorted.last() else { return TimeStats::default() };
        // Nearest rank: the smallest value that at least the fraction `q` does not exceed.
        let rank = |q: f64| {
            let rank = (q * sorted.len() as f64).ceil() as usize;
            sorted[rank.clamp(1, sorted.len()) - 1]
        };
        TimeStats {
            min: sorted[0],
            median: rank(0.5),
            p95: rank(0.95),
            p99: rank(0.99),
            max,
            samples: sorted.len(),
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn order_statistics_are_nearest_ranks() {
        let mut window = TimeWindow::new(100);
        assert_eq!(window.stats(), TimeStats::default());
        for ms in (1..=200).rev() {
            window.push(Duration::from_millis(ms));
        }
        assert_eq!(window.iter().next(), Some(Duration::from_millis(100)));
        let stats = window.stats();
        assert_eq!(stats.samples, 100);
        assert_eq!(stats.min, Duration::from_millis(1));
        assert_eq!(stats.median, Duration::from_millis(50));
        assert_eq!(stats.p95, Duration::from_millis(95));
        assert_eq!(stats.p99, Duration::from_millis(99));
        assert_eq!(stats.max, Duration::from_millis(100));
    }
}
