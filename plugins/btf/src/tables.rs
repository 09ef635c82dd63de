//! The data of all materials on the GPU: in few buffers, so that many materials are drawn with few
//! bind groups.

use std::sync::Arc;

use bevy::{
    platform::collections::HashMap,
    prelude::*,
    render::{
        MainWorld,
        render_resource::OwnedData,
        render_resource::{Buffer, BufferDescriptor, BufferUsages, OwnedBindingResource},
        renderer::{RenderDevice, RenderQueue},
    },
};
use farlight_btf_codec::Btf;

use crate::{
    BtfAsset, BtfMaterial, BtfSettings,
    loading::{Prepared, PreparedBtfs},
    page::Page,
    spans::Span,
    status::SharedReport,
};

/// Words of all materials of a buffer.
pub(crate) const TABLES_BINDING: u32 = 0;
/// What `entry.rs` says of each.
pub(crate) const ENTRIES_BINDING: u32 = 1;

/// Storage buffers in a fragment shader: six of Bevy's and two of ours. The shader asks the same.
const STORAGE_BUFFERS: u32 = 8;

/// Whether materials can be decoded in the fragment shader.
pub(crate) fn storage_is_usable(device: &RenderDevice) -> bool {
    device.limits().max_storage_buffers_per_shader_stage >= STORAGE_BUFFERS
}

/// Where a material's data lies.
#[derive(Clone, Debug)]
pub(crate) struct Place {
    pub(crate) page: usize,
    /// Held by all who read it.
    pub(crate) span: Arc<Span>,
    /// Words that are written.
    sent: usize,
}

pub(crate) struct Resident {
    pub(crate) prepared: Arc<Prepared>,
    /// `None` where the device has no storage buffers.
    pub(crate) place: Option<Place>,
}

impl Resident {
    fn length(&self) -> usize {
        self.prepared.btf.words().len() + self.prepared.coarse.words.len()
    }

    fn is_sent(&self) -> bool {
        self.place.as_ref().is_none_or(|place| place.sent == self.length())
    }
}

/// All buffers, and what is in them.
#[derive(Resource)]
pub struct BtfTables {
    usable: bool,
    pub(crate) pages: Vec<Option<Page>>,
    resident: HashMap<AssetId<BtfAsset>, Resident>,
    /// No longer anybody's data, once the last reader is gone.
    retired: Vec<(usize, Arc<Span>)>,
    /// What groups refer to that nothing is drawn with.
    placeholder: Buffer,
    incoming: Vec<(AssetId<BtfAsset>, Option<Arc<Prepared>>)>,
    /// The device is new and knows nothing.
    ask_for_all: bool,
}

impl FromWorld for BtfTables {
    fn from_world(world: &mut World) -> Self {
        let device = world.resource::<RenderDevice>();
        let usable = storage_is_usable(device);
        let placeholder = device.create_buffer(&BufferDescriptor {
            label: Some("farlight_btf_placeholder"),
            size: 256,
            usage: BufferUsages::STORAGE | BufferUsages::UNIFORM,
            mapped_at_creation: false,
        });
        if !usable {
            let found = device.limits().max_storage_buffers_per_shader_stage;
            let reason = format!(
                "this device has {found} storage buffers for a fragment shader, measured materials \
                 need {STORAGE_BUFFERS}: they are shown as diffuse surfaces of their mean colour"
            );
            let report = world.resource::<SharedReport>();
            let new = report.with(|report| report.limited.replace(reason.clone()).is_none());
            if new {
                warn!("{reason}");
            }
        }
        Self {
            usable,
            pages: Vec::new(),
            resident: HashMap::default(),
            retired: Vec::new(),
            placeholder,
            incoming: Vec::new(),
            ask_for_all: true,
        }
    }
}

impl BtfTables {
    /// Where the data of a material lies, once all of it is there.
    pub(crate) fn ready(&self, id: AssetId<BtfAsset>) -> Option<&Resident> {
        self.resident.get(&id).filter(|resident| resident.is_sent())
    }

    /// Bindings of the right kind; nothing before the material's data is there.
    pub(crate) fn placeholder(
        &self,
        material: &BtfMaterial,
    ) -> Option<Vec<(u32, OwnedBindingResource)>> {
        let resident = self.ready(material.btf.id())?;
        if !self.usable {
            let mean = (material.gain * resident.prepared.coarse.mean).extend(0.0).to_array();
            let bytes = bytemuck::bytes_of(&mean).to_vec();
            return Some(vec![(0, OwnedBindingResource::Data(OwnedData(bytes)))]);
        }
        let buffer = || OwnedBindingResource::Buffer(self.placeholder.clone());
        Some(vec![(TABLES_BINDING, buffer()), (ENTRIES_BINDING, buffer())])
    }

    fn remove(&mut self, id: AssetId<BtfAsset>) -> Option<Resident> {
        let resident = self.resident.remove(&id)?;
        if let Some(place) = &resident.place {
            self.retired.push((place.page, place.span.clone()));
        }
        Some(resident)
    }

    /// Finds room for `words` words: in a buffer that is there, in one made longer, in a new one.
    fn make_room(
        &mut self,
        words: u32,
        most: u32,
        device: &RenderDevice,
        queue: &RenderQueue,
    ) -> Option<Place> {
        for page in 0..self.pages.len() {
            let Some(open) = &mut self.pages[page] else { continue };
            if let Some(span) = open.take(words, most, device, queue) {
                return Some(Place { page, span: Arc::new(span), sent: 0 });
            }
        }
        let mut new = Page::default();
        let span = new.take(words, most, device, queue)?;
        let page = self.pages.iter().position(Option::is_none).unwrap_or(self.pages.len());
        if page == self.pages.len() {
            self.pages.push(None);
        }
        self.pages[page] = Some(new);
        Some(Place { page, span: Arc::new(span), sent: 0 })
    }

    /// Writes at most `budget` bytes of a material, at least something.
    fn send(&mut self, id: AssetId<BtfAsset>, budget: &mut u64, queue: &RenderQueue) {
        let Some(resident) = self.resident.get_mut(&id) else { return };
        let Some(place) = &mut resident.place else { return };
        let Some(page) = &self.pages[place.page] else { return };
        let base = resident.prepared.btf.words().len();
        for (start, words) in
            [(0, resident.prepared.btf.words()), (base, &resident.prepared.coarse.words[..])]
        {
            let from = place.sent.saturating_sub(start).min(words.len());
            let count = (words.len() - from).min((*budget / 4) as usize);
            if place.sent < start || count == 0 {
                continue;
            }
            let chunk = &words[from..from + count];
            page.write(place.span.start as usize + start + from, chunk, queue);
            place.sent += count;
            *budget -= 4 * count as u64;
        }
    }

    fn free_retired(&mut self) {
        let pages = &mut self.pages;
        self.retired.retain(|(page, span)| {
            if Arc::strong_count(span) > 1 {
                return true;
            }
            if let Some(page) = &mut pages[*page] {
                page.spans.release(**span);
            }
            false
        });
    }
}

/// Takes what is new in the main world.
pub(crate) fn extract(mut main: ResMut<MainWorld>, tables: Option<ResMut<BtfTables>>) {
    let Some(mut tables) = tables else { return };
    let Some(mut prepared) = main.get_resource_mut::<PreparedBtfs>() else { return };
    if tables.ask_for_all {
        tables.ask_for_all = false;
        prepared.changed = prepared.ready.keys().copied().collect();
    }
    if prepared.changed.is_empty() {
        return;
    }
    let changed = std::mem::take(&mut prepared.changed);
    let now = changed.into_iter().map(|id| (id, prepared.ready.get(&id).cloned()));
    tables.incoming.extend(now);
}

/// Sends materials to the GPU, a bounded number of bytes a frame.
pub(crate) fn upload(
    mut tables: ResMut<BtfTables>,
    settings: Res<BtfSettings>,
    report: Res<SharedReport>,
    device: Res<RenderDevice>,
    queue: Res<RenderQueue>,
) {
    let tables = &mut *tables;
    let limits = device.limits();
    let most = limits
        .max_storage_buffer_binding_size
        .min(limits.max_buffer_size)
        .min(settings.max_buffer_bytes);
    let most = u32::try_from(most / 4).unwrap_or(u32::MAX);
    for (id, prepared) in std::mem::take(&mut tables.incoming) {
        let replaced = tables.remove(id).is_some();
        let Some(prepared) = prepared else { continue };
        let mut resident = Resident { prepared, place: None };
        if tables.usable {
            let words = u32::try_from(resident.length()).unwrap_or(u32::MAX);
            resident.place = tables.make_room(words, most, &device, &queue);
            if resident.place.is_none() {
                let name = name_of(&resident.prepared.btf);
                let reason = format!(
                    "its {} bytes do not fit into a buffer of this device ({} bytes)",
                    resident.length() * 4,
                    u64::from(most) * 4
                );
                report.with(|report| report.refused.push((name, reason)));
                continue;
            }
        }
        tables.resident.insert(id, resident);
        if replaced {
            tables.send(id, &mut u64::MAX.clone(), &queue);
        }
    }
    let mut budget = settings.upload_bytes_per_frame.max(4096);
    let unsent: Vec<_> = tables
        .resident
        .iter()
        .filter(|(_, resident)| !resident.is_sent())
        .map(|(id, _)| *id)
        .collect();
    for id in unsent {
        tables.send(id, &mut budget, &queue);
    }
    tables.free_retired();
    report.with(|report| {
        report.uploading = tables.resident.values().filter(|resident| !resident.is_sent()).count();
        report.resident = tables.resident.len() - report.uploading;
        report.buffers = tables.pages.iter().flatten().count();
        report.resident_bytes = tables
            .resident
            .values()
            .filter_map(|resident| resident.place.as_ref())
            .map(|place| u64::from(place.span.length) * 4)
            .sum();
    });
}

fn name_of(btf: &Btf) -> String {
    let name = &btf.info().name;
    if name.is_empty() { "a measured material".to_owned() } else { name.clone() }
}
