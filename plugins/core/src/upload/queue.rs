//! What is still to be written, in order, within bounded memory.

use std::collections::VecDeque;

use bevy::{asset::AssetId, image::Image, math::UVec3};
use thiserror::Error;

/// A box of texels of one image; `z` counts slices of a 3D texture or array layers.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub struct Region {
    /// First texel.
    pub origin: UVec3,
    /// Texels along x, y and z, each at least 1.
    pub size: UVec3,
}

/// Names data that was handed over; growing. Data is done when the [`Ticket`] that
/// [progress](super::UploadProgress) reports is not smaller.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, PartialOrd, Ord, Hash)]
pub struct Ticket(pub u64);

/// Why data was not accepted.
#[derive(Clone, Copy, Debug, Error, PartialEq, Eq)]
pub enum RegionProblem {
    /// A region without texels.
    #[error("the region has no texels")]
    Empty,
    /// The bytes aren't a whole number for each texel.
    #[error("{bytes} bytes don't fit {texels} texels")]
    Length {
        /// How many bytes came.
        bytes: usize,
        /// How many texels the region has.
        texels: u64,
    },
    /// Too much is waiting. Nothing was queued; send everything again when there is room.
    #[error("more than {limit} bytes are waiting to be uploaded")]
    Full {
        /// The limit.
        limit: usize,
    },
}

impl Region {
    fn texels(&self) -> u64 {
        u64::from(self.size.x) * u64::from(self.size.y) * u64::from(self.size.z)
    }

    fn end(&self) -> UVec3 {
        self.origin.saturating_add(self.size)
    }

    fn overlaps(&self, other: &Self) -> bool {
        self.origin.cmplt(other.end()).all() && other.origin.cmplt(self.end()).all()
    }

    fn contains(&self, other: &Self) -> bool {
        self.origin.cmple(other.origin).all() && other.end().cmple(self.end()).all()
    }
}

/// Most tickets that one entry remembers; older ones are merged into later ones.
const MAX_MARKS: usize = 8;

/// Data of one region. Rows are written round and round from `next_row`, so that data which is
/// replaced before it was written completely still reaches every row.
pub(super) struct Entry {
    pub(super) image: AssetId<Image>,
    pub(super) region: Region,
    pub(super) bytes: Vec<u8>,
    next_row: u32,
    newest: Ticket,
    /// Tickets with the rows that they still miss, oldest first.
    marks: VecDeque<(Ticket, u32)>,
}

/// Some rows of an entry, counted through all its slices: row `y` of slice `z` is `z * height + y`.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) struct Rows {
    pub(super) first: u32,
    pub(super) count: u32,
}

impl Entry {
    fn rows(&self) -> u32 {
        self.region.size.y * self.region.size.z
    }

    fn rows_left(&self) -> u32 {
        self.marks.back().map_or(0, |&(_, rows)| rows)
    }

    pub(super) fn row_bytes(&self) -> usize {
        self.bytes.len() / self.rows() as usize
    }

    /// The newest ticket whose data this is.
    pub(super) fn newest(&self) -> Ticket {
        self.newest
    }

    fn mark(&mut self, ticket: Ticket) {
        let rows = self.rows();
        self.marks.push_back((ticket, rows));
        if self.marks.len() > MAX_MARKS {
            // The older ticket counts as done with the later one's rows: late, never early.
            let last = self.marks.len() - 2;
            if let Some((_, later)) = self.marks.remove(last) {
                self.marks[last - 1].1 = later;
            }
        }
    }

    /// The next rows to write, at most `most`, so that they form a box: whole slices, or a part of
    /// one.
    fn next(&self, most: u32) -> Rows {
        let height = self.region.size.y;
        let first = self.next_row;
        let most = most.min(self.rows_left()).min(self.rows() - first);
        let in_slice = height - first % height;
        let count = if in_slice == height && most >= height {
            most / height * height
        } else {
            most.min(in_slice)
        };
        Rows { first, count }
    }

    fn advance(&mut self, count: u32) {
        self.next_row = (self.next_row + count) % self.rows();
        for (_, rows) in &mut self.marks {
            *rows = rows.saturating_sub(count);
        }
        while self.marks.front().is_some_and(|&(_, rows)| rows == 0) {
            self.marks.pop_front();
        }
    }
}

#[derive(Default)]
pub(super) struct Queue {
    entries: VecDeque<Entry>,
    bytes: usize,
    last: u64,
}

impl Queue {
    pub(super) fn bytes(&self) -> usize {
        self.bytes
    }

    /// Everything up to this ticket is written or replaced by something that is.
    pub(super) fn done(&self) -> Ticket {
        let waiting =
            self.entries.iter().filter_map(|e| e.marks.front()).map(|&(ticket, _)| ticket.0).min();
        Ticket(waiting.map_or(self.last, |ticket| ticket - 1))
    }

    /// Takes data over. Waiting data of the same region is replaced.
    pub(super) fn push(
        &mut self,
        image: AssetId<Image>,
        region: Region,
        bytes: Vec<u8>,
        limit: usize,
    ) -> Result<Ticket, RegionProblem> {
        let texels = region.texels();
        if texels == 0 {
            return Err(RegionProblem::Empty);
        }
        if bytes.is_empty() || !(bytes.len() as u64).is_multiple_of(texels) {
            return Err(RegionProblem::Length { bytes: bytes.len(), texels });
        }
        let covered = |e: &Entry| e.image == image && region.contains(&e.region);
        let freed: usize = self.entries.iter().filter(|e| covered(e)).map(|e| e.bytes.len()).sum();
        if self.bytes - freed + bytes.len() > limit {
            return Err(RegionProblem::Full { limit });
        }
        self.last += 1;
        let ticket = Ticket(self.last);
        self.bytes = self.bytes - freed + bytes.len();

        let same = self.entries.iter().position(|e| e.image == image && e.region == region);
        if let Some(at) = same {
            let overwritten_later = self
                .entries
                .iter()
                .skip(at + 1)
                .any(|e| e.image == image && e.region.overlaps(&region) && !covered(e));
            if !overwritten_later && self.entries[at].bytes.len() == bytes.len() {
                let inherited = self.remove_covered(|e| covered(e) && e.region != region);
                if let Some(entry) =
                    self.entries.iter_mut().find(|e| e.image == image && e.region == region)
                {
                    entry.bytes = bytes;
                    entry.newest = ticket;
                    // Tickets of smaller regions inside need all rows from now on, like this one.
                    let oldest = inherited.into_iter().min().map_or(ticket, |t| t.min(ticket));
                    entry.mark(oldest);
                    return Ok(ticket);
                }
            }
        }
        let inherited = self.remove_covered(covered);
        let mut entry =
            Entry { image, region, bytes, next_row: 0, newest: ticket, marks: VecDeque::new() };
        entry.mark(inherited.into_iter().min().unwrap_or(ticket));
        self.entries.push_back(entry);
        Ok(ticket)
    }

    fn remove_covered(&mut self, covered: impl Fn(&Entry) -> bool) -> Vec<Ticket> {
        let mut tickets = Vec::new();
        self.entries.retain(|e| {
            let remove = covered(e);
            if remove {
                tickets.extend(e.marks.iter().map(|&(ticket, _)| ticket));
            }
            !remove
        });
        tickets
    }

    /// Forgets everything that waits for an image.
    pub(super) fn forget(&mut self, image: AssetId<Image>) {
        self.entries.retain(|e| e.image != image);
        self.bytes = self.entries.iter().map(|e| e.bytes.len()).sum();
    }

    /// Hands rows to `write` in order until `budget` bytes are used, of which each write takes
    /// `overhead` besides its own; at least one row is written, so that any budget gets through.
    /// `write` answers whether it could: entries that it refuses
    /// stay (`Later`) or leave (`Never`). Returns the bytes written.
    pub(super) fn drain(
        &mut self,
        budget: usize,
        overhead: usize,
        mut write: impl FnMut(&Entry, Rows) -> Written,
    ) -> usize {
        let (mut used, mut written) = (0_usize, 0);
        let mut at = 0;
        while at < self.entries.len() {
            let entry = &mut self.entries[at];
            let row_bytes = entry.row_bytes();
            let mut remove = false;
            let mut blocked = false;
            while entry.rows_left() > 0 {
                let room = budget.saturating_sub(used + overhead) / row_bytes.max(1);
                let most = if used == 0 { room.max(1) } else { room };
                if most == 0 {
                    break;
                }
                let rows = entry.next(u32::try_from(most).unwrap_or(u32::MAX));
                match write(entry, rows) {
                    Written::Yes => {
                        let bytes = rows.count as usize * row_bytes;
                        used += bytes + overhead;
                        written += bytes;
                        entry.advance(rows.count);
                    }
                    Written::Later => {
                        blocked = true;
                        break;
                    }
                    Written::Never => {
                        remove = true;
                        break;
                    }
                }
            }
            if remove || entry.rows_left() == 0 {
                self.bytes -= entry.bytes.len();
                self.entries.remove(at);
            } else if blocked {
                at += 1;
            } else {
                break;
            }
        }
        written
    }
}

/// What became of some rows.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Written {
    Yes,
    /// The texture isn't there yet.
    Later,
    /// The data doesn't fit the texture.
    Never,
}

#[cfg(test)]
mod tests {
    use bevy::asset::uuid::Uuid;

    use super::*;

    fn image(n: u128) -> AssetId<Image> {
        AssetId::Uuid { uuid: Uuid::from_u128(n) }
    }

    fn region(x: u32, y: u32, width: u32, height: u32) -> Region {
        Region { origin: UVec3::new(x, y, 0), size: UVec3::new(width, height, 1) }
    }

    /// Drains into a picture of `8 x 8` one-byte texels.
    fn drain(queue: &mut Queue, picture: &mut [u8; 64], budget: usize) -> usize {
        queue.drain(budget, 0, |entry, rows| {
            let width = entry.region.size.x as usize;
            for row in rows.first..rows.first + rows.count {
                let y = (entry.region.origin.y + row) as usize;
                let x = entry.region.origin.x as usize;
                let from = row as usize * width;
                picture[y * 8 + x..][..width].copy_from_slice(&entry.bytes[from..][..width]);
            }
            Written::Yes
        })
    }

    #[test]
    fn a_budget_splits_a_region_into_rows_and_order_is_kept() {
        let (mut queue, mut picture) = (Queue::default(), [0; 64]);
        let a = queue.push(image(1), region(0, 0, 8, 8), vec![1; 64], 1 << 20).unwrap();
        let b = queue.push(image(1), region(2, 2, 4, 4), vec![2; 16], 1 << 20).unwrap();
        assert_eq!(drain(&mut queue, &mut picture, 20), 16);
        assert_eq!((queue.done(), queue.bytes()), (Ticket(0), 80));
        assert_eq!(drain(&mut queue, &mut picture, 48), 48);
        assert_eq!(queue.done(), a);
        drain(&mut queue, &mut picture, 100);
        assert_eq!((queue.done(), queue.bytes()), (b, 0));
        assert_eq!(picture[2 * 8 + 2], 2);
        assert_eq!(picture[8], 1);
    }

    #[test]
    fn any_budget_makes_progress() {
        let (mut queue, mut picture) = (Queue::default(), [0; 64]);
        queue.push(image(1), region(0, 0, 8, 2), vec![1; 16], 1 << 20).unwrap();
        assert_eq!(drain(&mut queue, &mut picture, 0), 8);
        assert_eq!(drain(&mut queue, &mut picture, 0), 8);
        assert_eq!(drain(&mut queue, &mut picture, 0), 0);
    }

    #[test]
    fn newer_data_replaces_older_and_still_reaches_every_row() {
        let (mut queue, mut picture) = (Queue::default(), [0; 64]);
        let mut last = Ticket(0);
        // Two rows fit a frame, new data comes every frame: without going round, the lower rows
        // would never be written.
        for frame in 1..=8_u8 {
            last = queue.push(image(1), region(0, 0, 8, 8), vec![frame; 64], 1 << 20).unwrap();
            drain(&mut queue, &mut picture, 16);
            assert_eq!(queue.bytes(), 64);
        }
        assert!(picture.iter().all(|&v| v >= 5), "{picture:?}");
        assert!(queue.done() >= Ticket(5) && queue.done() < last, "{:?}", queue.done());
        while drain(&mut queue, &mut picture, 16) > 0 {}
        assert_eq!(queue.done(), last);
        assert!(picture.iter().all(|&v| v == 8), "{picture:?}");
    }

    #[test]
    fn replaced_data_does_not_jump_before_what_it_overwrites() {
        let (mut queue, mut picture) = (Queue::default(), [0; 64]);
        queue.push(image(1), region(0, 0, 4, 4), vec![1; 16], 1 << 20).unwrap();
        queue.push(image(1), region(2, 2, 4, 4), vec![2; 16], 1 << 20).unwrap();
        queue.push(image(1), region(0, 0, 4, 4), vec![3; 16], 1 << 20).unwrap();
        drain(&mut queue, &mut picture, 1 << 20);
        assert_eq!(picture[2 * 8 + 2], 3);
        assert_eq!(picture[5 * 8 + 5], 2);
        assert_eq!(queue.done(), Ticket(3));
    }

    #[test]
    fn a_region_swallows_smaller_ones_inside() {
        let (mut queue, mut picture) = (Queue::default(), [0; 64]);
        queue.push(image(1), region(1, 1, 2, 2), vec![1; 4], 1 << 20).unwrap();
        queue.push(image(1), region(0, 0, 8, 8), vec![2; 64], 1 << 20).unwrap();
        assert_eq!(queue.bytes(), 64);
        drain(&mut queue, &mut picture, 32);
        assert_eq!(queue.done(), Ticket(0), "the first ticket's area isn't all written");
        drain(&mut queue, &mut picture, 32);
        assert_eq!(queue.done(), Ticket(2));
    }

    #[test]
    fn memory_is_bounded_and_bad_regions_are_refused() {
        let mut queue = Queue::default();
        queue.push(image(1), region(0, 0, 8, 8), vec![1; 64], 100).unwrap();
        let full = queue.push(image(2), region(0, 0, 8, 8), vec![1; 64], 100);
        assert_eq!(full, Err(RegionProblem::Full { limit: 100 }));
        queue.push(image(1), region(0, 0, 8, 8), vec![2; 64], 100).unwrap();
        let length = queue.push(image(1), region(0, 0, 8, 8), vec![2; 63], 100);
        assert_eq!(length, Err(RegionProblem::Length { bytes: 63, texels: 64 }));
        assert_eq!(
            queue.push(image(1), region(0, 0, 0, 8), vec![2; 8], 100),
            Err(RegionProblem::Empty)
        );
        queue.forget(image(1));
        assert_eq!((queue.bytes(), queue.done()), (0, Ticket(2)));
    }

    #[test]
    fn a_texture_that_is_not_ready_does_not_hold_up_others() {
        let mut queue = Queue::default();
        queue.push(image(1), region(0, 0, 8, 8), vec![1; 64], 1 << 20).unwrap();
        let b = queue.push(image(2), region(0, 0, 8, 8), vec![1; 64], 1 << 20).unwrap();
        let ready = |e: &Entry, _| if e.image == image(2) { Written::Yes } else { Written::Later };
        assert_eq!(queue.drain(1 << 20, 0, ready), 64);
        assert_eq!(queue.done(), Ticket(0));
        assert_eq!(queue.drain(1 << 20, 0, |_, _| Written::Never), 0);
        assert_eq!((queue.done(), queue.bytes()), (b, 0));
    }

    #[test]
    fn many_small_writes_cost_more_than_their_bytes() {
        let mut queue = Queue::default();
        for x in 0..8 {
            queue.push(image(1), region(x, 0, 1, 1), vec![1], 1 << 20).unwrap();
        }
        assert_eq!(queue.drain(100, 24, |_, _| Written::Yes), 4);
    }

    #[test]
    fn slices_of_a_volume_are_written_as_boxes() {
        let mut queue = Queue::default();
        let volume = Region { origin: UVec3::ZERO, size: UVec3::new(2, 3, 4) };
        queue.push(image(1), volume, vec![0; 24], 1 << 20).unwrap();
        let mut seen = Vec::new();
        queue.drain(8, 0, |_, rows| {
            seen.push((rows.first, rows.count));
            Written::Yes
        });
        queue.drain(1 << 20, 0, |_, rows| {
            seen.push((rows.first, rows.count));
            Written::Yes
        });
        // Part of the budget ends within a slice; whole slices go together.
        assert_eq!(seen, [(0, 3), (3, 1), (4, 2), (6, 6)]);
    }
}
