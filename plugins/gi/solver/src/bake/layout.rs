//! Where receivers lie on lightmap pages, and which points of their surfaces texels stand for.

use std::{
    collections::{BTreeSet, HashMap},
    sync::Arc,
};

use glam::Vec3;

use super::{
    normals::shading_normals,
    open::{not_enclosed, part_sides},
};
use crate::{
    Scene, World,
    atlas::PageId,
    lightmap::{FillPlan, MeshTexels, Patches, Receiver, unbury},
    scene::{InstanceId, Mesh},
    session::{Placement, Places},
};

/// How many texels a metre of surface gets.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Density {
    /// So many; fewer where not all would fit on the pages.
    TexelsPerMetre(f32),
    /// As many as fit on the pages.
    Fit,
}

/// How to lay receivers out.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct LayoutSettings {
    /// Edge of a square page in texels (power of two, 16 to 4096).
    pub page_size: u32,
    /// Most pages.
    pub max_pages: u32,
    /// Texels a metre.
    pub density: Density,
}

/// The texels of all receivers.
pub struct Layout {
    /// Edge of a page in texels.
    pub page_size: u32,
    /// How many pages are in use.
    pub page_count: u32,
    /// Texels a metre that came out.
    pub texels_per_metre: f32,
    /// Where the receivers are.
    pub placements: Vec<Placement>,
    /// Receivers that get no lightmap, and why.
    pub refused: Vec<(InstanceId, Arc<str>)>,
    pub(super) patches: Patches,
    /// Whether a texel has a point in the open.
    pub(super) open: Vec<bool>,
    /// Whether something stands between the points of a texel.
    pub(super) split: Vec<bool>,
    /// Unit normal that a texel's light is for.
    pub(super) shading: Vec<Vec3>,
    /// One a receiver of `patches`.
    pub(super) plans: Vec<FillPlan>,
}

/// A texel, and the point that it is solved at.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct LayoutTexel {
    /// The receiver.
    pub instance: InstanceId,
    /// The page.
    pub page: PageId,
    /// Column in the page.
    pub x: u32,
    /// Row in the page.
    pub y: u32,
    /// The chart; charts of other receivers may have the same number.
    pub chart: u32,
    /// World position.
    pub position: Vec3,
    /// Unit normal that its light is for: that of the vertices, interpolated, where the mesh has any.
    pub normal: Vec3,
    /// Unit normal of the triangle.
    pub geometric: Vec3,
    /// Whether the point is in the open. If not, the texel takes its neighbours' light.
    pub open: bool,
}

impl Layout {
    /// Lays the receivers out and finds the points of their texels. `world` is that of the scene.
    #[must_use]
    pub fn new(
        scene: &Scene,
        world: &World,
        receivers: impl IntoIterator<Item = InstanceId>,
        settings: &LayoutSettings,
    ) -> Self {
        let wanted: BTreeSet<InstanceId> = receivers.into_iter().collect();
        let places = |density| Places::new(settings.page_size, settings.max_pages, density);
        let (places, refused) = match settings.density {
            Density::TexelsPerMetre(density) => {
                let mut places = places(density);
                let refused = places.arrange(scene, &wanted);
                (places, refused)
            }
            Density::Fit => {
                let mut places = places(1.0);
                let refused = places.fit(scene, &wanted);
                (places, refused)
            }
        };
        let refused = refused.into_iter().collect();

        let mut rasters: HashMap<(*const Mesh, u32, u32), Arc<MeshTexels>> = HashMap::new();
        let (mut texels, mut placements) = (Vec::new(), Vec::new());
        for (index, instance) in world.instances().iter().enumerate() {
            let Some(place) = places.places.get(&instance.id) else { continue };
            let rect = place.rect();
            let raster = rasters
                .entry((Arc::as_ptr(&instance.mesh), rect.width, rect.height))
                .or_insert_with(|| {
                    Arc::new(MeshTexels::new(&instance.mesh, rect.width, rect.height))
                });
            texels.push((index as u32, raster.clone()));
            placements.push(Placement { instance: instance.id, page: place.page, rect });
        }
        let texel = places.texel();
        let mut patches = Patches::new(world, texels, texel * 2.0);
        let open = unbury(world, &mut patches, texel);
        let split = part_sides(world, &mut patches, texel);
        let open = not_enclosed(world, &patches, &open, texel);
        let shading = shading_normals(world, &patches);
        let plans = patches
            .receivers
            .iter()
            .map(|receiver| {
                let first = receiver.first as usize;
                FillPlan::new(&receiver.texels, &open[first..first + receiver.texels.len()])
            })
            .collect();
        Self {
            page_size: settings.page_size,
            page_count: places.atlas.page_count(),
            texels_per_metre: 1.0 / texel,
            placements,
            refused,
            patches,
            open,
            split,
            shading,
            plans,
        }
    }

    /// How many texels are covered by surfaces.
    #[must_use]
    pub fn len(&self) -> usize {
        self.patches.fronts
    }

    /// Whether there are none.
    #[must_use]
    pub fn is_empty(&self) -> bool {
        self.len() == 0
    }

    /// Whether what is known about a texel answers for rays that meet it: its point is in the open, and
    /// nothing cuts it in two.
    pub(super) fn answers(&self, texel: usize) -> bool {
        self.open[texel] && !self.split[texel]
    }

    /// The receiver that a texel belongs to.
    pub(super) fn receiver_of(&self, texel: u32) -> &Receiver {
        &self.patches.receivers[self.receiver_index(texel)]
    }

    pub(super) fn receiver_index(&self, texel: u32) -> usize {
        self.patches.receivers.partition_point(|r| r.first <= texel).saturating_sub(1)
    }

    /// All covered texels, in the order of everything that is computed for them.
    pub fn texels(&self) -> impl Iterator<Item = LayoutTexel> + '_ {
        self.patches.receivers.iter().zip(&self.placements).flat_map(move |(receiver, place)| {
            (0..receiver.texels.len()).map(move |i| {
                let [x, y] = receiver.texels.coords[i].map(u32::from);
                let texel = receiver.first as usize + i;
                LayoutTexel {
                    instance: place.instance,
                    page: place.page,
                    x: place.rect.x + x,
                    y: place.rect.y + y,
                    chart: receiver.texels.chart[i],
                    position: self.patches.position[texel],
                    normal: self.shading[texel],
                    geometric: self.patches.normal[texel],
                    open: self.open[texel],
                }
            })
        })
    }
}
