//! One buffer of materials' data with the entries of those that are drawn from it.

use bevy::{
    pbr::MaterialBindGroupIndex,
    render::{
        render_resource::{Buffer, BufferDescriptor, BufferUsages},
        renderer::{RenderDevice, RenderQueue},
    },
};

use crate::{
    entry::Entry,
    spans::{Span, Spans},
};

/// Words of a new buffer: 1 MiB.
const FIRST_WORDS: u32 = 1 << 18;
/// Entries of a new page.
const FIRST_ENTRIES: usize = 64;
/// A mesh instance has 16 bits for its material.
const MOST_ENTRIES: usize = 1 << 16;

#[derive(Default)]
pub(crate) struct Page {
    tables: Option<Buffer>,
    pub(crate) spans: Spans,
    entries: Option<Buffer>,
    values: Vec<Entry>,
    free: Vec<u32>,
    /// The bind group that all materials of the page are drawn with.
    pub(crate) group: Option<MaterialBindGroupIndex>,
    /// Whether the group refers to buffers that are no longer those of the page.
    pub(crate) stale: bool,
}

impl Page {
    /// A span of `words` words; the buffer grows up to `most` words if it must.
    pub(crate) fn take(
        &mut self,
        words: u32,
        most: u32,
        device: &RenderDevice,
        queue: &RenderQueue,
    ) -> Option<Span> {
        if let Some(span) = self.spans.take(words) {
            return Some(span);
        }
        let capacity = self.spans.capacity();
        let needed = (capacity - self.spans.tail()).checked_add(words.checked_add(16)?)?;
        if needed > most {
            return None;
        }
        let grown = needed.max(capacity.saturating_mul(2)).max(FIRST_WORDS).min(most);
        let buffer = device.create_buffer(&BufferDescriptor {
            label: Some("farlight_btf_tables"),
            size: u64::from(grown) * 4,
            usage: BufferUsages::STORAGE | BufferUsages::COPY_DST | BufferUsages::COPY_SRC,
            mapped_at_creation: false,
        });
        if let Some(old) = self.tables.replace(buffer.clone()) {
            // On the GPU: nobody waits for it.
            let mut encoder = device.create_command_encoder(&Default::default());
            encoder.copy_buffer_to_buffer(&old, 0, &buffer, 0, u64::from(capacity) * 4);
            queue.submit([encoder.finish()]);
        }
        self.stale = true;
        self.spans.grow(grown);
        self.spans.take(words)
    }

    pub(crate) fn write(&self, word: usize, words: &[u32], queue: &RenderQueue) {
        if let Some(tables) = &self.tables {
            queue.write_buffer(tables, 4 * word as u64, bytemuck::cast_slice(words));
        }
    }

    /// A free entry, if there is one.
    pub(crate) fn take_entry(&mut self) -> Option<u32> {
        if let Some(slot) = self.free.pop() {
            return Some(slot);
        }
        if self.values.len() == MOST_ENTRIES {
            return None;
        }
        self.values.push(Entry::default());
        Some(self.values.len() as u32 - 1)
    }

    pub(crate) fn release_entry(&mut self, slot: u32) {
        self.free.push(slot);
    }

    pub(crate) fn write_entry(
        &mut self,
        slot: u32,
        entry: Entry,
        device: &RenderDevice,
        queue: &RenderQueue,
    ) {
        let slot = slot as usize;
        self.values[slot] = entry;
        let size = size_of::<Entry>();
        let room = self.entries.as_ref().map_or(0, |buffer| buffer.size() as usize / size);
        if slot < room {
            if let Some(entries) = &self.entries {
                let at = (slot * size) as u64;
                queue.write_buffer(entries, at, bytemuck::bytes_of(&entry));
            }
            return;
        }
        let buffer = device.create_buffer(&BufferDescriptor {
            label: Some("farlight_btf_entries"),
            size: ((slot + 1).next_power_of_two().max(FIRST_ENTRIES) * size) as u64,
            usage: BufferUsages::STORAGE | BufferUsages::COPY_DST,
            mapped_at_creation: false,
        });
        queue.write_buffer(&buffer, 0, bytemuck::cast_slice(&self.values));
        self.entries = Some(buffer);
        self.stale = true;
    }

    /// Both buffers, once something is in them.
    pub(crate) fn buffers(&self) -> Option<(&Buffer, &Buffer)> {
        Some((self.tables.as_ref()?, self.entries.as_ref()?))
    }

    /// Whether nobody's data and nobody's entry is left.
    pub(crate) fn is_unused(&self) -> bool {
        self.spans.is_unused() && self.free.len() == self.values.len()
    }
}
