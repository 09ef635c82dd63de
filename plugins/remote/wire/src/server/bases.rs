//! What the client is known to have of each tile, so that only differences need to be sent.

use std::collections::{HashMap, VecDeque};

use crate::client::VERSIONS;

/// The newest texels of tiles that the client has acknowledged.
#[derive(Debug, Default)]
pub(super) struct Bases(HashMap<u32, Base>);

#[derive(Debug, Default)]
struct Base {
    /// The number of a message that arrived, and what it brought.
    shown: Option<(u64, Vec<[u16; 3]>)>,
    /// Messages with the tile that were sent since. The client keeps so many versions.
    sent: VecDeque<u64>,
    /// Messages below it are no bases.
    floor: u64,
}

impl Bases {
    /// What a tile can be coded beside.
    pub(super) fn of(&self, tile: u32) -> Option<(u64, &[[u16; 3]])> {
        let base = self.0.get(&tile)?;
        let (number, texels) = base.shown.as_ref()?;
        (base.sent.len() < VERSIONS - 1).then_some((*number, &texels[..]))
    }

    /// A message with the tile goes out.
    pub(super) fn sent(&mut self, tile: u32, sequence: u64) {
        let base = self.0.entry(tile).or_default();
        if base.sent.len() >= VERSIONS - 1 {
            // The client may have forgotten what is older.
            base.shown = None;
            base.sent.clear();
            base.floor = sequence;
        }
        base.sent.push_back(sequence);
    }

    /// A message with the tile arrived.
    pub(super) fn arrived(&mut self, tile: u32, sequence: u64, texels: Vec<[u16; 3]>) {
        let Some(base) = self.0.get_mut(&tile) else { return };
        let newer = base.shown.as_ref().is_none_or(|(shown, _)| *shown < sequence);
        if newer && sequence >= base.floor {
            base.shown = Some((sequence, texels));
            base.sent.retain(|sent| *sent > sequence);
        }
    }

    /// A message with the tile was given up. It may have arrived for all that, and the client have
    /// dropped older ones that came after it: these are no bases.
    pub(super) fn cancelled(&mut self, tile: u32, sequence: u64) {
        if let Some(base) = self.0.get_mut(&tile) {
            base.floor = base.floor.max(sequence + 1);
        }
    }

    /// There is no such tile any more.
    pub(super) fn forget(&mut self, tile: u32) {
        self.0.remove(&tile);
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_newest_that_arrived_is_the_base() {
        let mut bases = Bases::default();
        let number = |bases: &Bases| bases.of(7).map(|(number, _)| number);
        bases.sent(7, 1);
        bases.sent(7, 2);
        assert_eq!(number(&bases), None);
        bases.arrived(7, 2, vec![[2; 3]]);
        bases.arrived(7, 1, vec![[1; 3]]);
        assert_eq!(bases.of(7), Some((2, &[[2; 3]][..])));
        bases.sent(7, 3);
        bases.sent(7, 4);
        bases.cancelled(7, 4);
        bases.arrived(7, 3, vec![[3; 3]]);
        assert_eq!(number(&bases), Some(2), "the client may have dropped 3 because of 4");
        bases.forget(7);
        assert_eq!(number(&bases), None);
    }

    #[test]
    fn what_the_client_may_have_forgotten_is_no_base() {
        let mut bases = Bases::default();
        bases.sent(0, 1);
        bases.arrived(0, 1, Vec::new());
        let mut sequence = 1;
        while bases.of(0).is_some() {
            sequence += 1;
            bases.sent(0, sequence);
        }
        assert_eq!(sequence as usize, VERSIONS);
        bases.sent(0, sequence + 1);
        bases.arrived(0, 2, Vec::new());
        assert!(bases.of(0).is_none());
        bases.arrived(0, sequence + 1, Vec::new());
        assert!(bases.of(0).is_some());
    }
}
