//! Light on its way to the client: the newest of everything, and what of it is not there yet.
//!
//! Tiles, placements and probes are items. An item that changes is due; due items go out in the
//! order in which they became so, as many as the network takes without queueing. Newer light
//! replaces older light that waits, so a slow line shows fewer states, never older ones.

use std::{
    collections::{BTreeMap, VecDeque},
    sync::Arc,
    time::Duration,
};

use farlight_gi_solver::{
    scene::InstanceId,
    session::{GridId, LightingUpdate, Placement, Quality, SnapshotId},
};

use super::{bases::Bases, tiles::Tiles, window::Window};
use crate::{HalfGrid, HalfTile, LightingMessage, Piece, TransmitId};

/// Probes of a run that is sent and resent as one.
const RUN: usize = 512;
/// Bytes of texels and probes (before compression) of one message at most.
const MESSAGE_BYTES: usize = 192 << 10;
/// Bytes that a placement or a refusal counts.
const SMALL: usize = 64;

/// Something that is sent as a whole.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord, Hash)]
pub(super) enum ItemKey {
    /// Snapshot and quality.
    Head,
    /// Where a receiver lies, or why it has no place.
    Receiver(InstanceId),
    /// A tile, by its number in [`Tiles`].
    Tile(u32),
    /// Probes, from an index on.
    Probes(GridId, u32),
}

/// Where an item stands.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum State {
    /// To be sent; the first snapshot that the client lacks of it.
    Due(SnapshotId),
    /// In a message.
    Sent {
        /// Its number.
        sequence: u64,
        /// The first snapshot that the client lacks of the item if the message is lost.
        since: SnapshotId,
    },
    /// There.
    Shown,
}

impl State {
    fn is_in(self, message: u64) -> bool {
        matches!(self, Self::Sent { sequence, .. } if sequence == message)
    }
}

#[derive(Clone, Debug)]
enum Receiver {
    Placed(Placement),
    Refused(Arc<str>),
}

/// A message on its way.
#[derive(Debug)]
struct UnderWay {
    sequence: u64,
    transmit: TransmitId,
    sent: Duration,
    bytes: usize,
    items: Vec<ItemKey>,
    /// Its texels and probes as they will arrive.
    pieces: Vec<(Piece, Vec<[u16; 3]>)>,
}

#[derive(Debug, Default)]
pub(super) struct Outbox {
    states: BTreeMap<ItemKey, State>,
    due: VecDeque<ItemKey>,
    tiles: Tiles,
    bases: Bases,
    receivers: BTreeMap<InstanceId, Receiver>,
    probes: BTreeMap<(GridId, u32), HalfGrid>,
    quality: Quality,
    /// The newest snapshot that was published.
    published: SnapshotId,
    under_way: VecDeque<UnderWay>,
    window: Window,
    sequence: u64,
    cancelled: VecDeque<TransmitId>,
}

impl Outbox {
    /// Takes light over; `whole`: of the whole scene, nothing of which is still on its way here.
    pub(super) fn publish(&mut self, update: &LightingUpdate, whole: bool) {
        let snapshot = update.snapshot;
        for placement in &update.placements {
            self.receivers.insert(placement.instance, Receiver::Placed(*placement));
            self.make_due(ItemKey::Receiver(placement.instance), snapshot);
        }
        for (instance, why) in &update.refused {
            self.receivers.insert(*instance, Receiver::Refused(why.clone()));
            self.make_due(ItemKey::Receiver(*instance), snapshot);
        }
        for tile in &update.tiles {
            let (changed, replaced) = self.tiles.insert(HalfTile::new(tile));
            for (index, piece) in replaced {
                self.states.remove(&ItemKey::Tile(index));
                self.bases.forget(piece);
            }
            if let Some(index) = changed {
                self.make_due(ItemKey::Tile(index), snapshot);
            }
        }
        for grid in &update.grids {
            self.publish_probes(HalfGrid::new(grid), snapshot);
        }
        let mut quality = update.quality;
        quality.converged &= whole;
        if snapshot != self.published || quality != self.quality {
            self.published = self.published.max(snapshot);
            self.quality = quality;
            self.make_due(ItemKey::Head, snapshot);
        }
    }

    fn publish_probes(&mut self, grid: HalfGrid, snapshot: SnapshotId) {
        // Runs of a grid that had another resolution.
        let gone: Vec<(GridId, u32)> = self
            .probes
            .range((grid.grid, 0)..=(grid.grid, u32::MAX))
            .filter(|(_, run)| run.resolution != grid.resolution)
            .map(|(key, _)| *key)
            .collect();
        for (id, first) in gone {
            self.probes.remove(&(id, first));
            self.states.remove(&ItemKey::Probes(id, first));
            self.bases.forget(Piece::Probes(id, first));
        }
        for (i, probes) in grid.probes.chunks(RUN).enumerate() {
            let first = (i * RUN) as u32;
            let run = HalfGrid { first, probes: probes.to_vec(), ..grid.clone_empty() };
            let key = (grid.grid, first);
            if self.probes.get(&key) != Some(&run) {
                self.probes.insert(key, run);
                self.make_due(ItemKey::Probes(grid.grid, first), snapshot);
            }
        }
    }

    /// Forgets a receiver; its tiles are replaced when others need their place.
    pub(super) fn remove_receiver(&mut self, instance: InstanceId) {
        self.receivers.remove(&instance);
        self.states.remove(&ItemKey::Receiver(instance));
    }

    /// Forgets a grid.
    pub(super) fn remove_grid(&mut self, grid: GridId) {
        self.probes.retain(|(id, _), _| *id != grid);
        self.bases.forget_grid(grid);
        self.states.retain(|key, _| !matches!(key, ItemKey::Probes(id, _) if *id == grid));
    }

    fn make_due(&mut self, key: ItemKey, since: SnapshotId) {
        let state = self.states.entry(key).or_insert(State::Shown);
        if !matches!(state, State::Due(_)) {
            *state = State::Due(since);
            self.due.push_back(key);
        }
    }

    /// Everything is due again.
    pub(super) fn resync(&mut self) {
        let keys: Vec<ItemKey> = self.states.keys().copied().collect();
        keys.into_iter().for_each(|key| self.make_due(key, self.published));
    }

    /// What is on its way is lost.
    pub(super) fn detach(&mut self) {
        while let Some(message) = self.under_way.pop_front() {
            self.lose(&message);
        }
        self.cancelled.clear();
        self.bases = Bases::default();
        self.window = Window::default();
    }

    fn lose(&mut self, message: &UnderWay) {
        for key in &message.items {
            if let Some(&State::Sent { sequence, since }) = self.states.get(key)
                && sequence == message.sequence
            {
                self.make_due(*key, since);
            }
        }
    }

    /// A message arrived.
    pub(super) fn acknowledge(&mut self, now: Duration, sequence: u64) {
        let Some(at) = self.under_way.iter().position(|m| m.sequence == sequence) else { return };
        let Some(message) = self.under_way.remove(at) else { return };
        for key in &message.items {
            if let Some(state) = self.states.get_mut(key)
                && state.is_in(sequence)
            {
                *state = State::Shown;
            }
        }
        for (piece, values) in message.pieces {
            self.bases.arrived(piece, sequence, values);
        }
        self.window.arrived(now.saturating_sub(message.sent), message.bytes);
    }

    /// Gives up messages that are late and mostly replaced.
    fn cancel_late(&mut self, now: Duration) {
        let patience = self.window.patience();
        let mut at = 0;
        while let Some(message) = self.under_way.get(at) {
            let is_late = now.saturating_sub(message.sent) > patience;
            let current =
                |key: &&ItemKey| self.states.get(key).is_some_and(|s| s.is_in(message.sequence));
            let replaced = 2 * message.items.iter().filter(current).count() <= message.items.len();
            if is_late
                && replaced
                && let Some(message) = self.under_way.remove(at)
            {
                self.cancelled.push_back(message.transmit);
                for (piece, _) in &message.pieces {
                    self.bases.cancelled(*piece, message.sequence);
                }
                self.lose(&message);
            } else {
                at += 1;
            }
        }
    }

    /// A message that need not arrive any more.
    pub(super) fn poll_cancel(&mut self) -> Option<TransmitId> {
        self.cancelled.pop_front()
    }

    /// The next message, to be sent as `transmit`, if something is due and the network takes it.
    /// `stamp` may complete it.
    pub(super) fn next(
        &mut self,
        now: Duration,
        transmit: TransmitId,
        stamp: impl FnOnce(&mut LightingMessage),
    ) -> Option<Vec<u8>> {
        self.cancel_late(now);
        if self.due.is_empty() || self.waits_for_the_rest() {
            return None;
        }
        let flying: usize = self.under_way.iter().map(|m| m.bytes).sum();
        let room = self.window.room(flying)?.min(MESSAGE_BYTES);
        self.sequence += 1;
        let sequence = self.sequence;
        let mut message = LightingMessage { sequence, ..Default::default() };
        let (mut items, mut bytes) = (Vec::new(), 0);
        while bytes < room
            && let Some(key) = self.due.pop_front()
        {
            let Some(state) = self.states.get_mut(&key) else { continue };
            let State::Due(since) = *state else { continue };
            *state = State::Sent { sequence, since };
            bytes += self.add(key, &mut message);
            items.push(key);
        }
        if items.is_empty() {
            return None;
        }
        // Snapshot and quality go with every message, so a lost head needs no message of its own.
        if !items.contains(&ItemKey::Head) && self.states.contains_key(&ItemKey::Head) {
            let since = self.published;
            self.states.insert(ItemKey::Head, State::Sent { sequence, since });
            items.push(ItemKey::Head);
        }
        message.snapshot = self.complete();
        message.quality = self.quality;
        message.quality.converged &= message.snapshot == self.published
            && self.due_count() == 0
            && self.under_way.is_empty();
        if message.quality != self.quality || message.snapshot != self.published {
            // This was not the last word.
            self.make_due(ItemKey::Head, self.published);
        }
        stamp(&mut message);
        let (encoding, rounded) = message.encode_beside(|piece| self.bases.of(piece));
        let tiles = rounded.tiles.into_iter().map(|tile| (tile.piece(), tile.texels));
        let probes =
            rounded.grids.into_iter().map(|run| (run.piece(), run.probes.into_flattened()));
        let pieces: Vec<(Piece, Vec<[u16; 3]>)> = tiles.chain(probes).collect();
        for (piece, _) in &pieces {
            self.bases.sent(*piece, sequence);
        }
        self.under_way.push_back(UnderWay { sequence, transmit, sent: now, bytes, items, pieces });
        Some(encoding)
    }

    /// Adds an item; the bytes that it counts.
    fn add(&self, key: ItemKey, message: &mut LightingMessage) -> usize {
        match key {
            ItemKey::Head => SMALL,
            ItemKey::Receiver(id) => {
                match self.receivers.get(&id) {
                    Some(Receiver::Placed(placement)) => message.placements.push(*placement),
                    Some(Receiver::Refused(why)) => message.refused.push((id, why.clone())),
                    None => {}
                }
                SMALL
            }
            ItemKey::Tile(index) => {
                let Some(tile) = self.tiles.get(index) else { return 0 };
                message.tiles.push(tile.clone());
                tile.texels.len() * 6 + SMALL
            }
            ItemKey::Probes(grid, first) => {
                let Some(run) = self.probes.get(&(grid, first)) else { return 0 };
                message.grids.push(run.clone());
                run.probes.len() * 54 + SMALL
            }
        }
    }

    /// Only the last word is left to say, that nothing better will come; it must not overtake light
    /// that is still on its way.
    fn waits_for_the_rest(&self) -> bool {
        self.quality.converged && !self.under_way.is_empty() && self.due_count() == 0
    }

    /// Items that are due, the head aside.
    fn due_count(&self) -> usize {
        let is_due = |key: &&ItemKey| {
            **key != ItemKey::Head && matches!(self.states.get(key), Some(State::Due(_)))
        };
        self.due.iter().filter(is_due).count()
    }

    /// The newest snapshot of which nothing is due.
    fn complete(&self) -> SnapshotId {
        let due = self.due.iter().filter(|key| **key != ItemKey::Head);
        let oldest = due
            .filter_map(|key| match self.states.get(key) {
                Some(State::Due(since)) => Some(*since),
                _ => None,
            })
            .min();
        match oldest {
            Some(oldest) => self.published.min(SnapshotId(oldest.0.saturating_sub(1))),
            None => self.published,
        }
    }

    /// Whether light is on its way or due.
    pub(super) fn is_busy(&self) -> bool {
        !self.under_way.is_empty() || !self.due.is_empty()
    }
}
