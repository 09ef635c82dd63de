//! What was shown of each piece of light before, since the server sends differences to that.

use std::collections::{HashMap, VecDeque};

use crate::Piece;

/// Versions of a piece that are kept. The server builds on none that is older.
pub(crate) const VERSIONS: usize = 9;

/// As how many texels a version counts beside its own, so that many tiny pieces are bounded too.
const OVERHEAD: usize = 32;

/// The last versions of every piece.
#[derive(Debug, Default)]
pub(super) struct History {
    pieces: HashMap<Piece, VecDeque<Version>>,
    /// Sizes of all versions.
    size: usize,
}

/// What a message brought.
#[derive(Debug)]
struct Version {
    sequence: u64,
    values: Vec<[u16; 3]>,
}

impl Version {
    fn size(&self) -> usize {
        self.values.len() + OVERHEAD
    }
}

impl History {
    /// What a message brought of a piece: texels, or nine coefficients a probe.
    pub(super) fn get(&self, piece: Piece, sequence: u64) -> Option<&[[u16; 3]]> {
        let versions = self.pieces.get(&piece)?;
        Some(&versions.iter().find(|version| version.sequence == sequence)?.values)
    }

    /// Keeps what is shown of a piece now. `all` is how many values everything that can be shown has.
    pub(super) fn keep(
        &mut self,
        sequence: u64,
        piece: Piece,
        values: &[[u16; 3]],
        all: usize,
        is_shown: impl Fn(Piece, u64) -> bool,
    ) {
        if self.size > 4 * VERSIONS * (all + OVERHEAD) {
            // Pieces whose place others have taken.
            self.pieces.retain(|piece, versions| {
                versions.back().is_some_and(|newest| is_shown(*piece, newest.sequence))
            });
            self.size = self.pieces.values().flatten().map(Version::size).sum();
        }
        let versions = self.pieces.entry(piece).or_default();
        if versions.len() == VERSIONS
            && let Some(oldest) = versions.pop_front()
        {
            self.size -= oldest.size();
        }
        let version = Version { sequence, values: values.to_vec() };
        self.size += version.size();
        versions.push_back(version);
    }

    /// The server has built on a version, so it builds on no older one any more.
    pub(super) fn forget_before(&mut self, piece: Piece, sequence: u64) {
        let Some(versions) = self.pieces.get_mut(&piece) else { return };
        while versions.front().is_some_and(|oldest| oldest.sequence < sequence)
            && let Some(oldest) = versions.pop_front()
        {
            self.size -= oldest.size();
        }
    }
}

#[cfg(test)]
mod tests {
    use farlight_gi_solver::session::GridId;

    use super::*;

    const VALUES: [[u16; 3]; 4] = [[1; 3]; 4];

    fn piece(first: u32) -> Piece {
        Piece::Probes(GridId(0), first)
    }

    #[test]
    fn versions_are_found_until_the_server_has_gone_on() {
        let mut history = History::default();
        for sequence in 1..=VERSIONS as u64 + 2 {
            history.keep(sequence, piece(0), &VALUES, 100, |_, _| true);
        }
        let found = |history: &History, sequence| history.get(piece(0), sequence).is_some();
        assert!(!found(&history, 2) && found(&history, 3));
        history.forget_before(piece(0), 5);
        assert!(!found(&history, 4) && found(&history, 5) && found(&history, 11));
        assert_eq!(history.size, (4 + OVERHEAD) * 7);
        assert!(history.get(piece(4), 5).is_none());
    }

    #[test]
    fn what_is_no_longer_shown_goes() {
        let mut history = History::default();
        for x in 0..1000_u64 {
            history.keep(x, piece(x as u32), &VALUES, 16, |_, sequence| sequence + 5 > x);
        }
        assert!(history.size <= (4 * VERSIONS + 1) * (16 + OVERHEAD), "{}", history.size);
        assert!(history.pieces.len() < 60);
        assert!(history.get(piece(999), 999).is_some());
    }
}
