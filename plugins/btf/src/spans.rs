//! Which words of a buffer are free.

/// A run of words.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) struct Span {
    pub(crate) start: u32,
    pub(crate) length: u32,
}

/// Free runs, by their start; no two of them touch.
#[derive(Clone, Debug, Default)]
pub(crate) struct Spans {
    free: Vec<Span>,
    capacity: u32,
}

/// Spans begin on whole cache lines of the GPU.
const ALIGNMENT: u32 = 16;

impl Spans {
    pub(crate) fn capacity(&self) -> u32 {
        self.capacity
    }

    /// Makes room behind what there is.
    pub(crate) fn grow(&mut self, capacity: u32) {
        let start = self.capacity;
        if capacity > start {
            self.capacity = capacity;
            self.release(Span { start, length: capacity - start });
        }
    }

    /// The first run that is long enough.
    pub(crate) fn take(&mut self, length: u32) -> Option<Span> {
        let length = length.checked_next_multiple_of(ALIGNMENT)?;
        let at = self.free.iter().position(|span| span.length >= length)?;
        let span = &mut self.free[at];
        let taken = Span { start: span.start, length };
        span.start += length;
        span.length -= length;
        if span.length == 0 {
            self.free.remove(at);
        }
        Some(taken)
    }

    pub(crate) fn release(&mut self, span: Span) {
        let at = self.free.partition_point(|free| free.start < span.start);
        self.free.insert(at, span);
        for left in [at, at.wrapping_sub(1)] {
            let Some([a, b]) = self.free.get(left..left.wrapping_add(2)) else { continue };
            if a.start + a.length == b.start {
                self.free[left].length += self.free[left + 1].length;
                self.free.remove(left + 1);
            }
        }
    }

    /// Free words at the end.
    pub(crate) fn tail(&self) -> u32 {
        match self.free.last() {
            Some(span) if span.start + span.length == self.capacity => span.length,
            _ => 0,
        }
    }

    pub(crate) fn is_unused(&self) -> bool {
        self.tail() == self.capacity
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn words_are_taken_once_and_come_back() {
        let mut spans = Spans::default();
        assert_eq!(spans.take(1), None);
        spans.grow(64);
        let spans_taken: Vec<_> = (0..4).map(|_| spans.take(10).unwrap()).collect();
        assert_eq!(spans_taken.iter().map(|s| s.start).collect::<Vec<_>>(), [0, 16, 32, 48]);
        assert_eq!(spans.take(1), None);
        for at in [1, 3, 2] {
            spans.release(spans_taken[at]);
        }
        assert_eq!(spans.tail(), 48);
        assert_eq!(spans.take(48), Some(Span { start: 16, length: 48 }));
        spans.release(Span { start: 16, length: 48 });
        spans.release(spans_taken[0]);
        assert!(spans.is_unused());
        spans.grow(128);
        assert_eq!(spans.take(128), Some(Span { start: 0, length: 128 }));
        assert_eq!(spans.take(u32::MAX), None);
    }
}
