//! Lightmap pages with free rectangles, so that objects can come and go.
//!
//! [`Atlas`] keeps, for every page, the list of maximal free rectangles (Jylänki 2010, "A Thousand
//! Ways to Pack the Bin", section 2.5, MAXRECTS with best short side fit). A freed rectangle is given
//! back exactly: the list is made anew from what is still used, so nothing fragments for good.

/// Index of a square page.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, PartialOrd, Ord, Hash)]
pub struct PageId(pub u32);

/// A rectangle of texels, half open.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, PartialOrd, Ord, Hash)]
pub struct TexelRect {
    /// First column.
    pub x: u32,
    /// First row (0 = top).
    pub y: u32,
    /// Columns.
    pub width: u32,
    /// Rows.
    pub height: u32,
}

impl TexelRect {
    /// How many texels it has.
    #[must_use]
    pub fn area(&self) -> usize {
        self.width as usize * self.height as usize
    }

    /// Whether the two share a texel.
    #[must_use]
    pub fn overlaps(&self, other: &Self) -> bool {
        self.x < other.x + other.width
            && other.x < self.x + self.width
            && self.y < other.y + other.height
            && other.y < self.y + self.height
    }

    /// Whether `other` lies inside.
    #[must_use]
    pub fn contains(&self, other: &Self) -> bool {
        self.x <= other.x
            && self.y <= other.y
            && self.x + self.width >= other.x + other.width
            && self.y + self.height >= other.y + other.height
    }
}

/// Hands out rectangles of square pages. Equal requests in equal order give equal places.
#[derive(Clone, Debug)]
pub struct Atlas {
    page_size: u32,
    max_pages: u32,
    pages: Vec<Page>,
}

#[derive(Clone, Debug)]
struct Page {
    used: Vec<TexelRect>,
    free: Vec<TexelRect>,
    /// Something was given back since `free` was made.
    stale: bool,
}

impl Atlas {
    /// An atlas of at most `max_pages` pages with edges of `page_size` texels. Pages are opened when
    /// they are needed.
    #[must_use]
    pub fn new(page_size: u32, max_pages: u32) -> Self {
        Self { page_size, max_pages, pages: Vec::new() }
    }

    /// Edge of a page in texels.
    #[must_use]
    pub fn page_size(&self) -> u32 {
        self.page_size
    }

    /// Pages opened so far.
    #[must_use]
    pub fn page_count(&self) -> u32 {
        self.pages.len() as u32
    }

    /// Texels of all pages that there may be.
    #[must_use]
    pub fn capacity(&self) -> usize {
        self.page_size as usize * self.page_size as usize * self.max_pages as usize
    }

    /// Texels in use.
    #[must_use]
    pub fn used_area(&self) -> usize {
        self.pages.iter().flat_map(|p| &p.used).map(TexelRect::area).sum()
    }

    /// Takes a rectangle of the given size (at least 1x1); `None` where there is no room for it.
    pub fn allocate(&mut self, width: u32, height: u32) -> Option<(PageId, TexelRect)> {
        if width == 0 || height == 0 || width.max(height) > self.page_size {
            return None;
        }
        for index in 0.. {
            if index == self.pages.len() {
                if index as u32 >= self.max_pages {
                    return None;
                }
                self.pages.push(Page::new(self.page_size));
            }
            if let Some(rect) = self.pages[index].allocate(width, height, self.page_size) {
                return Some((PageId(index as u32), rect));
            }
        }
        None
    }

    /// Gives a rectangle back that [`allocate`](Self::allocate) handed out; others are ignored.
    pub fn free(&mut self, page: PageId, rect: TexelRect) {
        if let Some(page) = self.pages.get_mut(page.0 as usize)
            && let Some(index) = page.used.iter().position(|used| *used == rect)
        {
            page.used.swap_remove(index);
            page.stale = true;
        }
    }

    /// Gives everything back.
    pub fn clear(&mut self) {
        self.pages.clear();
    }
}

impl Page {
    fn new(size: u32) -> Self {
        let whole = TexelRect { x: 0, y: 0, width: size, height: size };
        Self { used: Vec::new(), free: vec![whole], stale: false }
    }

    fn allocate(&mut self, width: u32, height: u32, size: u32) -> Option<TexelRect> {
        if self.stale {
            let used = std::mem::take(&mut self.used);
            *self = Self::new(size);
            for rect in &used {
                self.cut(rect);
            }
            self.used = used;
        }
        let best = self
            .free
            .iter()
            .filter(|free| free.width >= width && free.height >= height)
            .min_by_key(|free| {
                let (dx, dy) = (free.width - width, free.height - height);
                (dx.min(dy), dx.max(dy), free.y, free.x)
            })?;
        let rect = TexelRect { x: best.x, y: best.y, width, height };
        self.cut(&rect);
        self.used.push(rect);
        Some(rect)
    }

    /// Takes `rect` out of the free rectangles and keeps these maximal.
    fn cut(&mut self, rect: &TexelRect) {
        let mut parts = Vec::new();
        self.free.retain(|free| {
            if !free.overlaps(rect) {
                return true;
            }
            let (right, bottom) = (free.x + free.width, free.y + free.height);
            let (cut_right, cut_bottom) = (rect.x + rect.width, rect.y + rect.height);
            if rect.x > free.x {
                parts.push(TexelRect { width: rect.x - free.x, ..*free });
            }
            if cut_right < right {
                parts.push(TexelRect { x: cut_right, width: right - cut_right, ..*free });
            }
            if rect.y > free.y {
                parts.push(TexelRect { height: rect.y - free.y, ..*free });
            }
            if cut_bottom < bottom {
                parts.push(TexelRect { y: cut_bottom, height: bottom - cut_bottom, ..*free });
            }
            false
        });
        for (i, part) in parts.iter().enumerate() {
            let covered = self.free.iter().any(|free| free.contains(part))
                || parts
                    .iter()
                    .enumerate()
                    .any(|(j, other)| j != i && other.contains(part) && (other != part || j < i));
            if !covered {
                self.free.push(*part);
            }
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// A small generator, so that the test needs nothing else.
    fn next(state: &mut u32) -> u32 {
        *state = state.wrapping_mul(1_664_525).wrapping_add(1_013_904_223);
        *state >> 16
    }

    fn check(live: &[(PageId, TexelRect)], size: u32) {
        for (i, (page, rect)) in live.iter().enumerate() {
            assert!(rect.x + rect.width <= size && rect.y + rect.height <= size);
            for (other_page, other) in &live[..i] {
                assert!(page != other_page || !rect.overlaps(other), "{rect:?} {other:?}");
            }
        }
    }

    #[test]
    fn rectangles_never_overlap_while_objects_come_and_go() {
        let mut atlas = Atlas::new(128, 2);
        let mut live = Vec::new();
        let mut state = 7;
        for round in 0..2000 {
            if next(&mut state) % 5 < 3 {
                let (w, h) = (1 + next(&mut state) % 40, 1 + next(&mut state) % 40);
                if let Some(place) = atlas.allocate(w, h) {
                    assert_eq!((place.1.width, place.1.height), (w, h));
                    live.push(place);
                }
            } else if !live.is_empty() {
                let (page, rect) = live.swap_remove(next(&mut state) as usize % live.len());
                atlas.free(page, rect);
            }
            if round % 50 == 0 {
                check(&live, 128);
            }
        }
        assert_eq!(atlas.used_area(), live.iter().map(|(_, r)| r.area()).sum::<usize>());
    }

    #[test]
    fn freed_space_is_whole_again() {
        let mut atlas = Atlas::new(64, 1);
        let mut live: Vec<_> = (0..16).map(|_| atlas.allocate(16, 16).unwrap()).collect();
        assert!(atlas.allocate(1, 1).is_none());
        // Free in an order that leaves holes: every second one first.
        for parity in [0, 1] {
            for (i, (page, rect)) in live.iter().enumerate() {
                if i % 2 == parity {
                    atlas.free(*page, *rect);
                }
            }
        }
        live.clear();
        assert_eq!(atlas.used_area(), 0);
        assert!(atlas.allocate(64, 64).is_some(), "nothing may stay fragmented");
    }

    #[test]
    fn what_cannot_fit_is_refused() {
        let mut atlas = Atlas::new(64, 1);
        assert!(atlas.allocate(65, 1).is_none());
        assert!(atlas.allocate(0, 4).is_none());
        assert!(Atlas::new(64, 0).allocate(1, 1).is_none());
    }
}
