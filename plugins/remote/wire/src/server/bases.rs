//! What the client is known to have of each piece of light, so that only differences need to be sent.

use std::collections::{HashMap, VecDeque};

use farlight_gi_solver::session::GridId;

use crate::{Piece, client::VERSIONS};

/// The newest of each piece that the client has acknowledged.
#[derive(Debug, Default)]
pub(super) struct Bases(HashMap<Piece, Base>);

#[derive(Debug, Default)]
struct Base {
    /// The number of a message that arrived, and what it brought.
    shown: Option<(u64, Vec<[u16; 3]>)>,
    /// Messages with the piece that were sent since. The client keeps so many versions.
    sent: VecDeque<u64>,
    /// Messages below it are no bases.
    floor: u64,
}

impl Bases {
    /// What a piece can be coded beside.
    pub(super) fn of(&self, piece: Piece) -> Option<(u64, &[[u16; 3]])> {
        let base = self.0.get(&piece)?;
        let (number, values) = base.shown.as_ref()?;
        (base.sent.len() < VERSIONS - 1).then_some((*number, &values[..]))
    }

    /// A message with the piece goes out.
    pub(super) fn sent(&mut self, piece: Piece, sequence: u64) {
        let base = self.0.entry(piece).or_default();
        if base.sent.len() >= VERSIONS - 1 {
            // The client may have forgotten what is older.
            base.shown = None;
            base.sent.clear();
            base.floor = sequence;
        }
        base.sent.push_back(sequence);
    }

    /// A message with the piece arrived.
    pub(super) fn arrived(&mut self, piece: Piece, sequence: u64, values: Vec<[u16; 3]>) {
        let Some(base) = self.0.get_mut(&piece) else { return };
        // Messages about another piece of the same name, that has gone, are not in the list.
        if sequence >= base.floor && base.sent.contains(&sequence) {
            base.shown = Some((sequence, values));
            base.sent.retain(|sent| *sent > sequence);
        }
    }

    /// A message with the piece was given up. It may have arrived for all that, and the client have
    /// dropped older ones that came after it: these are no bases.
    pub(super) fn cancelled(&mut self, piece: Piece, sequence: u64) {
        if let Some(base) = self.0.get_mut(&piece) {
            base.floor = base.floor.max(sequence + 1);
        }
    }

    /// There is no such piece any more.
    pub(super) fn forget(&mut self, piece: Piece) {
        self.0.remove(&piece);
    }

    /// No piece of the grid is left.
    pub(super) fn forget_grid(&mut self, grid: GridId) {
        self.0.retain(|piece, _| !matches!(piece, Piece::Probes(id, _) if *id == grid));
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    const SEVEN: Piece = Piece::Probes(GridId(7), 0);

    #[test]
    fn the_newest_that_arrived_is_the_base() {
        let mut bases = Bases::default();
        let number = |bases: &Bases| bases.of(SEVEN).map(|(number, _)| number);
        bases.sent(SEVEN, 1);
        bases.sent(SEVEN, 2);
        assert_eq!(number(&bases), None);
        bases.arrived(SEVEN, 2, vec![[2; 3]]);
        bases.arrived(SEVEN, 1, vec![[1; 3]]);
        assert_eq!(bases.of(SEVEN), Some((2, &[[2; 3]][..])));
        bases.sent(SEVEN, 3);
        bases.sent(SEVEN, 4);
        bases.cancelled(SEVEN, 4);
        bases.arrived(SEVEN, 3, vec![[3; 3]]);
        assert_eq!(number(&bases), Some(2), "the client may have dropped 3 because of 4");
        bases.forget(SEVEN);
        assert_eq!(number(&bases), None);
    }

    #[test]
    fn what_the_client_may_have_forgotten_is_no_base() {
        let mut bases = Bases::default();
        bases.sent(SEVEN, 1);
        bases.arrived(SEVEN, 1, Vec::new());
        let mut sequence = 1;
        while bases.of(SEVEN).is_some() {
            sequence += 1;
            bases.sent(SEVEN, sequence);
        }
        assert_eq!(sequence as usize, VERSIONS);
        bases.sent(SEVEN, sequence + 1);
        bases.arrived(SEVEN, 2, Vec::new());
        assert!(bases.of(SEVEN).is_none());
        bases.arrived(SEVEN, sequence + 1, Vec::new());
        assert!(bases.of(SEVEN).is_some());
    }
}
