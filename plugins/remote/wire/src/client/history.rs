//! What was shown of each tile before, since the server sends differences to that.

use std::collections::{HashMap, VecDeque};

use farlight_gi_solver::atlas::{PageId, TexelRect};

use crate::HalfTile;

/// Versions of a tile that are kept. The server builds on none that is older.
pub(crate) const VERSIONS: usize = 9;

/// As how many texels a version counts beside its own, so that many tiny tiles are bounded too.
const OVERHEAD: usize = 32;

/// The last versions of every tile.
#[derive(Debug, Default)]
pub(super) struct History {
    tiles: HashMap<(PageId, TexelRect), VecDeque<Version>>,
    /// Sizes of all versions.
    size: usize,
}

/// What a message brought.
#[derive(Debug)]
struct Version {
    sequence: u64,
    texels: Vec<[u16; 3]>,
}

impl Version {
    fn size(&self) -> usize {
        self.texels.len() + OVERHEAD
    }
}

impl History {
    /// What a message brought of a tile.
    pub(super) fn get(&self, page: PageId, rect: TexelRect, sequence: u64) -> Option<&[[u16; 3]]> {
        let versions = self.tiles.get(&(page, rect))?;
        Some(&versions.iter().find(|version| version.sequence == sequence)?.texels)
    }

    /// Keeps a tile that is shown now. `texels` are those of all pages.
    pub(super) fn keep(
        &mut self,
        sequence: u64,
        tile: &HalfTile,
        texels: usize,
        is_shown: impl Fn(PageId, TexelRect, u64) -> bool,
    ) {
        if self.size > 4 * VERSIONS * texels {
            // Tiles whose place others have taken.
            self.tiles.retain(|(page, rect), versions| {
                versions.back().is_some_and(|newest| is_shown(*page, *rect, newest.sequence))
            });
            self.size = self.tiles.values().flatten().map(Version::size).sum();
        }
        let versions = self.tiles.entry((tile.page, tile.rect)).or_default();
        if versions.len() == VERSIONS
            && let Some(oldest) = versions.pop_front()
        {
            self.size -= oldest.size();
        }
        let version = Version { sequence, texels: tile.texels.clone() };
        self.size += version.size();
        versions.push_back(version);
    }

    /// The server has built on a version, so it builds on no older one any more.
    pub(super) fn forget_before(&mut self, page: PageId, rect: TexelRect, sequence: u64) {
        let Some(versions) = self.tiles.get_mut(&(page, rect)) else { return };
        while versions.front().is_some_and(|oldest| oldest.sequence < sequence)
            && let Some(oldest) = versions.pop_front()
        {
            self.size -= oldest.size();
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn tile(x: u32) -> HalfTile {
        let rect = TexelRect { x, y: 0, width: 4, height: 1 };
        HalfTile { page: PageId(0), rect, texels: vec![[x as u16; 3]; 4] }
    }

    #[test]
    fn versions_are_found_until_the_server_has_gone_on() {
        let mut history = History::default();
        let rect = tile(0).rect;
        for sequence in 1..=VERSIONS as u64 + 2 {
            history.keep(sequence, &tile(0), 100, |_, _, _| true);
        }
        let found = |history: &History, sequence| history.get(PageId(0), rect, sequence).is_some();
        assert!(!found(&history, 2) && found(&history, 3));
        history.forget_before(PageId(0), rect, 5);
        assert!(!found(&history, 4) && found(&history, 5) && found(&history, 11));
        assert_eq!(history.size, (4 + OVERHEAD) * 7);
        assert!(history.get(PageId(0), tile(4).rect, 5).is_none());
    }

    #[test]
    fn what_is_no_longer_shown_goes() {
        let mut history = History::default();
        for x in 0..1000 {
            history.keep(u64::from(x), &tile(x), 16, |_, rect, _| rect.x + 5 > x);
        }
        assert!(history.size <= 4 * VERSIONS * 16 + 4 + OVERHEAD, "{}", history.size);
        assert!(history.tiles.len() < 20);
        assert!(history.get(PageId(0), tile(999).rect, 999).is_some());
    }
}
