//! Lightmap pages, and Bevy's `Lightmap` on the meshes that have a place in them.

use std::collections::BTreeMap;

use bevy::{
    asset::RenderAssetUsages,
    ecs::entity::{EntityHashMap, EntityHashSet},
    image::ImageSampler,
    pbr::Lightmap,
    prelude::*,
    render::render_resource::{Extent3d, TextureDimension, TextureFormat},
};
use farlight_core::{Region, RegionProblem, TextureUploads, Ticket};
use farlight_gi_solver::{
    atlas::{PageId, TexelRect},
    session::Placement,
};

use crate::{EncodedTile, backend::decode_texel};

/// The lightmaps: pages of texels, and who has which rectangle.
///
/// The texels are kept on the CPU too: for switching indirect light off and on, for a GPU that
/// was lost, and for games and tests that want to read the lighting.
#[derive(Resource, Default)]
pub struct GiLightmaps {
    page_size: u32,
    max_pages: u32,
    pages: BTreeMap<PageId, Page>,
    placements: EntityHashMap<Placement>,
    /// Placements whose texels are on their way to the GPU.
    coming: EntityHashMap<Coming>,
    /// Whether the textures hold the texels, or black.
    shown: bool,
}

struct Page {
    image: Handle<Image>,
    texels: Vec<u8>,
}

struct Coming {
    placement: Placement,
    /// Shown when this is written.
    ticket: Ticket,
    /// Frames to wait: Bevy must have seen a frame without a lightmap before it takes a new place.
    frames: u8,
}

/// Bytes of an RGBA half float texel.
const TEXEL: usize = 8;

impl GiLightmaps {
    /// Edge of a page in texels.
    #[must_use]
    pub fn page_size(&self) -> u32 {
        self.page_size
    }

    /// The texture of a page, once something lies on it.
    #[must_use]
    pub fn image(&self, page: PageId) -> Option<&Handle<Image>> {
        self.pages.get(&page).map(|page| &page.image)
    }

    /// Where a mesh's second UV square lies.
    #[must_use]
    pub fn placement(&self, entity: Entity) -> Option<&Placement> {
        self.placements.get(&entity)
    }

    /// All meshes that have a place, in no order.
    pub fn placements(&self) -> impl Iterator<Item = (Entity, &Placement)> {
        self.placements.iter().map(|(&entity, placement)| (entity, placement))
    }

    /// The newest value E / π of a texel, whether or not it is written or shown.
    #[must_use]
    pub fn texel(&self, page: PageId, x: u32, y: u32) -> Option<Vec3> {
        let texels = &self.pages.get(&page)?.texels;
        if x >= self.page_size || y >= self.page_size {
            return None;
        }
        let at = (y as usize * self.page_size as usize + x as usize) * TEXEL;
        Some(decode_texel(&texels[at..at + TEXEL]))
    }

    /// Whether the textures hold the lighting, or black because indirect light is switched off.
    #[must_use]
    pub fn is_shown(&self) -> bool {
        self.shown
    }

    pub(crate) fn configure(&mut self, page_size: u32, max_pages: u32) {
        self.page_size = page_size;
        self.max_pages = max_pages;
    }

    /// Copies tiles into their pages and sends them on their way to the GPU, in few pieces. Tiles
    /// that don't lie on a page are ignored: a backend may be another machine. Answers the first and
    /// the last ticket.
    pub(crate) fn write(
        &mut self,
        tiles: Vec<EncodedTile>,
        images: &mut Assets<Image>,
        uploads: &TextureUploads,
    ) -> Result<Option<(Ticket, Ticket)>, RegionProblem> {
        let mut pages: BTreeMap<PageId, Vec<EncodedTile>> = BTreeMap::new();
        for tile in tiles {
            if self.copy(&tile, images) && self.shown {
                pages.entry(tile.page).or_default().push(tile);
            }
        }
        let mut tickets: Option<(Ticket, Ticket)> = None;
        for (id, tiles) in pages {
            let page = &self.pages[&id];
            for piece in pieces(tiles, page, self.page_size as usize) {
                let ticket = uploads.write(page.image.id(), region(piece.rect), piece.texels)?;
                tickets = Some((tickets.map_or(ticket, |t| t.0), ticket));
            }
        }
        Ok(tickets)
    }

    /// Copies a tile into its page; `false` if it doesn't lie on one.
    fn copy(&mut self, tile: &EncodedTile, images: &mut Assets<Image>) -> bool {
        let rect = tile.rect;
        let size = self.page_size;
        let fits = rect.x.checked_add(rect.width).is_some_and(|end| end <= size)
            && rect.y.checked_add(rect.height).is_some_and(|end| end <= size)
            && tile.texels.len() == rect.width as usize * rect.height as usize * TEXEL
            && !tile.texels.is_empty()
            && tile.page.0 < self.max_pages;
        if !fits {
            warn!("texels that lie outside of the lightmaps are ignored: {:?} {rect:?}", tile.page);
            return false;
        }
        let page = self.page(tile.page, images);
        let row = rect.width as usize * TEXEL;
        for (y, texels) in tile.texels.chunks_exact(row).enumerate() {
            let at = ((rect.y as usize + y) * size as usize + rect.x as usize) * TEXEL;
            page.texels[at..at + row].copy_from_slice(texels);
        }
        true
    }

    fn page(&mut self, id: PageId, images: &mut Assets<Image>) -> &mut Page {
        let size = self.page_size;
        self.pages.entry(id).or_insert_with(|| Page {
            image: images.add(page_image(size)),
            texels: vec![0; size as usize * size as usize * TEXEL],
        })
    }

    /// A place for a mesh, shown when `ticket` is written.
    pub(crate) fn place(
        &mut self,
        entity: Entity,
        placement: Placement,
        ticket: Ticket,
        images: &mut Assets<Image>,
    ) {
        if placement.page.0 >= self.max_pages {
            warn!("a lightmap's place on a page that doesn't exist is ignored");
            return;
        }
        self.page(placement.page, images);
        self.coming.insert(entity, Coming { placement, ticket, frames: 0 });
    }

    /// Switches between the texels and black, at once: the whole pages are written.
    pub(crate) fn show(&mut self, shown: bool, uploads: &TextureUploads) {
        if shown == self.shown {
            return;
        }
        self.shown = shown;
        self.write_all(uploads);
        uploads.write_all_next_frame();
    }

    /// Writes all pages, for example into new textures.
    pub(crate) fn write_all(&self, uploads: &TextureUploads) {
        let size = self.page_size;
        let whole = TexelRect { x: 0, y: 0, width: size, height: size };
        for page in self.pages.values() {
            let texels = if self.shown { page.texels.clone() } else { vec![0; page.texels.len()] };
            if let Err(problem) = uploads.write(page.image.id(), region(whole), texels) {
                warn!("a lightmap page can't be written: {problem}");
            }
        }
    }

    /// Inserts and removes `Lightmap` components. Answers whether any came or went.
    ///
    /// Bevy takes a lightmap's place only once, and chooses the pipeline when the material
    /// changes: so a component that comes or goes marks the material as changed in the same frame,
    /// and one that moves is gone for a frame. This must run before Bevy looks for changed materials,
    /// and before plugins with other materials do as much for theirs (`LightmapSystems`).
    pub(crate) fn apply(
        &mut self,
        commands: &mut Commands,
        materials: &mut Query<Option<&mut MeshMaterial3d<StandardMaterial>>>,
        unlit: &EntityHashSet,
        done: Ticket,
    ) -> bool {
        let mut changed = false;
        for &entity in unlit {
            self.coming.remove(&entity);
            if self.placements.remove(&entity).is_some() {
                changed = true;
                remove_lightmap(commands, materials, entity);
            }
        }
        let size = self.page_size as f32;
        let (placements, pages) = (&mut self.placements, &self.pages);
        self.coming.retain(|&entity, coming| {
            if coming.ticket > done {
                return true;
            }
            if coming.frames > 0 {
                coming.frames -= 1;
                return true;
            }
            if let Some(old) = placements.get(&entity) {
                if *old == coming.placement {
                    return false;
                }
                placements.remove(&entity);
                remove_lightmap(commands, materials, entity);
                changed = true;
                coming.frames = 1;
                return true;
            }
            let (Some(page), Ok(material)) =
                (pages.get(&coming.placement.page), materials.get_mut(entity))
            else {
                return false;
            };
            let rect = coming.placement.rect;
            let (min, max) = (
                Vec2::new(rect.x as f32, rect.y as f32),
                Vec2::new((rect.x + rect.width) as f32, (rect.y + rect.height) as f32),
            );
            commands.entity(entity).try_insert(Lightmap {
                image: page.image.clone(),
                uv_rect: Rect::from_corners(min / size, max / size),
                bicubic_sampling: false,
            });
            if let Some(mut material) = material {
                material.set_changed();
            }
            placements.insert(entity, coming.placement);
            changed = true;
            false
        });
        changed
    }

    /// Forgets all pages and places, for a backend that starts anew.
    pub(crate) fn clear(
        &mut self,
        commands: &mut Commands,
        materials: &mut Query<Option<&mut MeshMaterial3d<StandardMaterial>>>,
        uploads: &TextureUploads,
    ) {
        for (entity, _) in self.placements.drain() {
            remove_lightmap(commands, materials, entity);
        }
        self.coming.clear();
        for page in self.pages.values() {
            uploads.forget(page.image.id());
        }
        self.pages.clear();
    }
}

fn remove_lightmap(
    commands: &mut Commands,
    materials: &mut Query<Option<&mut MeshMaterial3d<StandardMaterial>>>,
    entity: Entity,
) {
    // The entity may be despawned.
    if let Ok(material) = materials.get_mut(entity) {
        if let Some(mut material) = material {
            material.set_changed();
        }
        commands.entity(entity).try_remove::<Lightmap>();
    }
}

/// Tiles of one page as they are, or together as the box around them where they fill it well: a
/// write costs as much as a thousand texels.
fn pieces(tiles: Vec<EncodedTile>, page: &Page, size: usize) -> Vec<EncodedTile> {
    let (mut min, mut max) = ((u32::MAX, u32::MAX), (0, 0));
    let mut area = 0;
    for EncodedTile { rect, .. } in &tiles {
        min = (min.0.min(rect.x), min.1.min(rect.y));
        max = (max.0.max(rect.x + rect.width), max.1.max(rect.y + rect.height));
        area += rect.width as usize * rect.height as usize + 1024;
    }
    let (width, height) = ((max.0 - min.0) as usize, (max.1 - min.1) as usize);
    if tiles.len() == 1 || width * height > area {
        return tiles;
    }
    let mut texels = Vec::with_capacity(width * height * TEXEL);
    for y in min.1 as usize..max.1 as usize {
        let at = (y * size + min.0 as usize) * TEXEL;
        texels.extend_from_slice(&page.texels[at..at + width * TEXEL]);
    }
    let rect = TexelRect { x: min.0, y: min.1, width: max.0 - min.0, height: max.1 - min.1 };
    vec![EncodedTile { page: tiles[0].page, rect, texels }]
}

fn region(rect: TexelRect) -> Region {
    Region { origin: UVec3::new(rect.x, rect.y, 0), size: UVec3::new(rect.width, rect.height, 1) }
}

/// A black page that only the GPU holds and that is never replaced: texels are written into it.
fn page_image(size: u32) -> Image {
    let mut image = Image::new_uninit(
        Extent3d { width: size, height: size, depth_or_array_layers: 1 },
        TextureDimension::D2,
        TextureFormat::Rgba16Float,
        RenderAssetUsages::RENDER_WORLD,
    );
    image.texture_descriptor.label = Some("farlight lightmap page");
    image.sampler = ImageSampler::linear();
    image
}
