//! One bind group for all materials of a buffer.
//!
//! Bevy gives a material that is not bindless a group of its own, so that no two materials are
//! drawn in one batch. Storage buffers can't be bindless (`AsBindGroup`), but a material's *slot*
//! reaches the shader whatever it is made of. So once Bevy has prepared a material, its binding is
//! changed to the group of its buffer and to the place of its entry there; before Bevy prepares it
//! again, or lets it go, it gets back the binding that Bevy knows.

use std::{any::TypeId, sync::Arc};

use bevy::{
    pbr::{
        MaterialBindGroupAllocators, MaterialBindGroupIndex, MaterialBindGroupSlot,
        MaterialBindingId, PreparedMaterial, RenderMaterialBindings,
    },
    platform::collections::{HashMap, HashSet},
    prelude::*,
    render::{
        erased_render_asset::{ErasedRenderAssets, ExtractedAssets},
        render_resource::{
            AsBindGroup, BindGroupEntry, BindingResources, PipelineCache, PreparedBindGroup,
        },
        renderer::{RenderDevice, RenderQueue},
    },
};

use crate::{
    BtfMaterial, BtfSettings,
    entry::Entry,
    spans::Span,
    tables::{BtfTables, ENTRIES_BINDING, Place, TABLES_BINDING},
};

/// The materials as they were extracted, and those that share a group.
#[derive(Resource, Default)]
pub(crate) struct SharedGroups {
    wanted: HashMap<AssetId<BtfMaterial>, BtfMaterial>,
    /// Of the wanted, those that share nothing yet.
    waiting: HashSet<AssetId<BtfMaterial>>,
    sharing: HashMap<AssetId<BtfMaterial>, Sharing>,
}

struct Sharing {
    page: usize,
    slot: u32,
    /// Keeps the data in its place while it is read.
    _data: Arc<Span>,
    base: u32,
    /// What Bevy gave.
    own: MaterialBindingId,
}

/// Before Bevy prepares materials: those that it will touch get their own binding back.
pub(crate) fn restore(
    extracted: Res<ExtractedAssets<MeshMaterial3d<BtfMaterial>>>,
    mut groups: ResMut<SharedGroups>,
    mut tables: ResMut<BtfTables>,
    mut bindings: ResMut<RenderMaterialBindings>,
) {
    let groups = &mut *groups;
    let mut restore = |id: AssetId<BtfMaterial>| {
        if let Some(sharing) = groups.sharing.remove(&id) {
            bindings.insert(id.untyped(), sharing.own);
            if let Some(page) = &mut tables.pages[sharing.page] {
                page.release_entry(sharing.slot);
            }
        }
    };
    for (id, material) in &extracted.extracted {
        restore(*id);
        groups.wanted.insert(*id, material.clone());
        groups.waiting.insert(*id);
    }
    for id in &extracted.removed {
        restore(*id);
        groups.wanted.remove(id);
        groups.waiting.remove(id);
    }
}

/// After Bevy has prepared materials: they get the group of their buffer.
pub(crate) fn share(
    mut groups: ResMut<SharedGroups>,
    mut tables: ResMut<BtfTables>,
    mut bindings: ResMut<RenderMaterialBindings>,
    mut materials: ResMut<ErasedRenderAssets<PreparedMaterial>>,
    mut allocators: ResMut<MaterialBindGroupAllocators>,
    settings: Res<BtfSettings>,
    cache: Res<PipelineCache>,
    device: Res<RenderDevice>,
    queue: Res<RenderQueue>,
) {
    let groups = &mut *groups;
    let tables = &mut *tables;
    let directions = settings.directions();
    if settings.is_changed() {
        for (id, sharing) in &groups.sharing {
            let Some(material) = groups.wanted.get(id) else { continue };
            let Some(prepared) = tables.ready(material.btf.id()).map(|data| data.prepared.clone())
            else {
                continue;
            };
            if let Some(page) = &mut tables.pages[sharing.page] {
                let entry = Entry::new(material, &prepared, sharing.base, directions);
                page.write_entry(sharing.slot, entry, &device, &queue);
            }
        }
    }

    let SharedGroups { wanted, waiting, sharing } = groups;
    let mut new = Vec::new();
    waiting.retain(|id| {
        let Some(material) = wanted.get(id) else { return false };
        let (Some(_), Some(own)) = (materials.get(*id), bindings.get(&id.untyped())) else {
            return true;
        };
        let Some(data) = tables.ready(material.btf.id()) else { return true };
        // Without storage buffers, materials keep their own groups.
        let Some(Place { page, span, .. }) = data.place.clone() else { return false };
        let prepared = data.prepared.clone();
        let Some(open) = &mut tables.pages[page] else { return false };
        let Some(slot) = open.take_entry() else {
            error_once!(
                "more than 65536 measured materials share a buffer; the others are not shown"
            );
            return false;
        };
        let base = span.start;
        open.write_entry(slot, Entry::new(material, &prepared, base, directions), &device, &queue);
        sharing.insert(*id, Sharing { page, slot, _data: span, base, own: *own });
        new.push(*id);
        false
    });

    let Some(allocator) = allocators.get_mut(&TypeId::of::<BtfMaterial>()) else { return };
    let binding = |group| MaterialBindingId { group, slot: MaterialBindGroupSlot(0) };
    let mut moved: HashSet<usize> = HashSet::default();
    for (at, place) in tables.pages.iter_mut().enumerate() {
        let Some(page) = place else { continue };
        if page.is_unused() {
            if let Some(group) = page.group {
                allocator.free(binding(group));
            }
            *place = None;
            continue;
        }
        let Some((words, entries)) = page.buffers() else { continue };
        if page.group.is_some() && !page.stale {
            continue;
        }
        let layout =
            cache.get_bind_group_layout(&BtfMaterial::bind_group_layout_descriptor(&device));
        let bind_group = device.create_bind_group(
            "farlight_btf_materials",
            &layout,
            &[
                BindGroupEntry { binding: TABLES_BINDING, resource: words.as_entire_binding() },
                BindGroupEntry { binding: ENTRIES_BINDING, resource: entries.as_entire_binding() },
            ],
        );
        // The place that is freed is the next one that is given.
        let old = page.group;
        if let Some(group) = old {
            allocator.free(binding(group));
        }
        let bindings = BindingResources(Vec::new());
        let group = allocator.allocate_prepared(PreparedBindGroup { bindings, bind_group }).group;
        page.group = Some(group);
        page.stale = false;
        if old.is_some_and(|old| old != group) {
            moved.insert(at);
        }
    }

    let mut bind = |id: AssetId<BtfMaterial>, page: usize, slot: u32| {
        let group = tables.pages[page].as_ref().and_then(|page| page.group);
        let Some(group): Option<MaterialBindGroupIndex> = group else { return };
        let binding = MaterialBindingId { group, slot: MaterialBindGroupSlot(slot) };
        bindings.insert(id.untyped(), binding);
        if let Some(material) = materials.get_mut(id) {
            material.binding = binding;
        }
    };
    for (id, sharing) in sharing.iter() {
        if moved.contains(&sharing.page) || new.contains(id) {
            bind(*id, sharing.page, sharing.slot);
        }
    }
}
