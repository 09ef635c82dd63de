//! Gives receivers their rectangles.

use std::{
    cmp::Reverse,
    collections::{BTreeMap, BTreeSet},
    sync::Arc,
};

use glam::{Affine3A, Vec2, Vec3};

use crate::{
    Scene,
    atlas::{Atlas, PageId, TexelRect},
    scene::{AlphaMode, InstanceId, Mesh},
};

/// Rectangles, padding included, have edges of a multiple of this, which also puts them at such
/// places: block codecs like that.
const ALIGN: u32 = 4;
/// Texels around a rectangle that repeat its edge, so that bilinear lookups never leave it.
pub(super) const PADDING: u32 = 1;
/// Steps by which the density is lowered until everything fits.
const LOWER: f32 = 0.96;
/// Orders of packing that are tried at each density.
const ORDERS: u32 = 4;
/// Densities that are tried in search for the densest.
const FIT_STEPS: u32 = 6;
/// A receiver keeps its rectangle while its ideal edges change by less than this factor.
const KEEP: f32 = 1.3;

/// A receiver's place.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct Place {
    pub page: PageId,
    /// With padding.
    pub padded: TexelRect,
    /// Texels a metre that it was made for, along both axes of its UV square.
    ideal: Vec2,
}

impl Place {
    /// Without padding: what the UV square covers.
    pub(crate) fn rect(&self) -> TexelRect {
        let p = self.padded;
        TexelRect {
            x: p.x + PADDING,
            y: p.y + PADDING,
            width: p.width - 2 * PADDING,
            height: p.height - 2 * PADDING,
        }
    }
}

/// All receivers' places.
pub(crate) struct Places {
    pub atlas: Atlas,
    pub places: BTreeMap<InstanceId, Place>,
    /// Texels a metre; lowered until everything fits.
    density: f32,
}

impl Places {
    pub(crate) fn new(page_size: u32, max_pages: u32, texels_per_metre: f32) -> Self {
        Self {
            atlas: Atlas::new(page_size, max_pages),
            places: BTreeMap::new(),
            density: texels_per_metre,
        }
    }

    /// Edge of a texel in metres.
    pub(crate) fn texel(&self) -> f32 {
        1.0 / self.density
    }

    /// Gives every wanted receiver a place. Returns those that get none, and why.
    pub(crate) fn arrange(
        &mut self,
        scene: &Scene,
        wanted: &BTreeSet<InstanceId>,
    ) -> BTreeMap<InstanceId, Arc<str>> {
        let (sizes, refused) = measure(scene, wanted);
        let gone: Vec<InstanceId> = self
            .places
            .iter()
            .filter(|(id, place)| !sizes.get(id).is_some_and(|size| place.still_fits(*size)))
            .map(|(id, _)| *id)
            .collect();
        for id in gone {
            if let Some(place) = self.places.remove(&id) {
                self.atlas.free(place.page, place.padded);
            }
        }
        if sizes.keys().all(|id| self.places.contains_key(id)) || self.add_missing(&sizes, 0) {
            return refused;
        }
        // Something has no room: everything is packed anew, coarser and coarser.
        self.lower_until_it_fits(&sizes, refused)
    }

    /// Packs every wanted receiver anew, as densely as fits. Returns those that get no place, and why.
    ///
    /// Packing is not quite monotonic in the density: what is found is the densest of those that a
    /// search by halves tries.
    pub(crate) fn fit(
        &mut self,
        scene: &Scene,
        wanted: &BTreeSet<InstanceId>,
    ) -> BTreeMap<InstanceId, Arc<str>> {
        let (sizes, refused) = measure(scene, wanted);
        // More never fits: the longest receiver takes a page's edge, or all together take all texels.
        let longest = sizes.values().map(|s| s.max_element()).fold(f32::MIN_POSITIVE, f32::max);
        let area: f32 = sizes.values().map(|s| s.x * s.y).sum();
        let edge = (self.atlas.page_size() - 2 * PADDING) as f32 / longest;
        let all = (self.atlas.capacity() as f32 / area.max(f32::MIN_POSITIVE)).sqrt();
        self.density = edge.min(all).clamp(1e-6, 1e6);
        let refused = self.lower_until_it_fits(&sizes, refused);
        let (mut low, mut high) = (self.density, self.density / LOWER);
        let mut best = (self.atlas.clone(), self.places.clone());
        for _ in 0..FIT_STEPS {
            self.density = (low * high).sqrt();
            if self.density <= edge && self.pack(&sizes) {
                low = self.density;
                best = (self.atlas.clone(), self.places.clone());
            } else {
                high = self.density;
            }
        }
        self.density = low;
        (self.atlas, self.places) = best;
        refused
    }

    fn lower_until_it_fits(
        &mut self,
        sizes: &BTreeMap<InstanceId, Vec2>,
        mut refused: BTreeMap<InstanceId, Arc<str>>,
    ) -> BTreeMap<InstanceId, Arc<str>> {
        while !self.pack(sizes) {
            let smallest = |s: &Vec2| (*s * self.density).max_element() <= (ALIGN - 2) as f32;
            if sizes.values().all(smallest) {
                self.atlas.clear();
                self.places.clear();
                self.add_missing(sizes, 0);
                for id in sizes.keys().filter(|id| !self.places.contains_key(id)) {
                    refused.insert(*id, Arc::from("all lightmap pages are full"));
                }
                break;
            }
            self.density *= LOWER;
        }
        refused
    }

    /// Packs everything anew at the present density. Returns whether it fits.
    fn pack(&mut self, sizes: &BTreeMap<InstanceId, Vec2>) -> bool {
        let orders = match sizes.len() {
            _ if self.area(sizes) > self.atlas.capacity() => 0,
            0..1000 => ORDERS,
            _ => 1,
        };
        (0..orders).any(|order| {
            self.atlas.clear();
            self.places.clear();
            self.add_missing(sizes, order)
        })
    }

    /// Texels that all receivers take at the present density.
    fn area(&self, sizes: &BTreeMap<InstanceId, Vec2>) -> usize {
        let page = self.atlas.page_size();
        let area = |size: &Vec2| {
            let [w, h] = (*size * self.density).to_array().map(|v| edge(v, page) as usize);
            w * h
        };
        sizes.values().map(area).sum()
    }

    /// Places what has no place, large ones first in one of several senses. Returns whether all found
    /// room.
    fn add_missing(&mut self, sizes: &BTreeMap<InstanceId, Vec2>, order: u32) -> bool {
        let page = self.atlas.page_size();
        let mut missing: Vec<(u32, u32, InstanceId, Vec2)> = sizes
            .iter()
            .filter(|(id, _)| !self.places.contains_key(id))
            .map(|(id, size)| {
                let [w, h] = (*size * self.density).to_array().map(|v| edge(v, page));
                (w, h, *id, *size)
            })
            .collect();
        missing.sort_unstable_by_key(|(w, h, id, _)| {
            let large = match order {
                0 => *w.max(h),
                1 => w * h,
                2 => *h,
                _ => *w,
            };
            (Reverse(large), Reverse(w * h), *w, *id)
        });
        let mut all = true;
        for (width, height, id, ideal) in missing {
            match self.atlas.allocate(width, height) {
                Some((page, padded)) => {
                    self.places.insert(id, Place { page, padded, ideal });
                }
                None => all = false,
            }
        }
        all
    }
}

impl Place {
    fn still_fits(&self, ideal: Vec2) -> bool {
        let ratio = ideal / self.ideal;
        ratio.max_element() < KEEP && ratio.min_element() > 1.0 / KEEP
    }
}

/// Sizes in metres of those that can be receivers, and why the others can't.
type Measured = (BTreeMap<InstanceId, Vec2>, BTreeMap<InstanceId, Arc<str>>);

fn measure(scene: &Scene, wanted: &BTreeSet<InstanceId>) -> Measured {
    let (mut sizes, mut refused) = (BTreeMap::new(), BTreeMap::new());
    for id in wanted {
        match size_in_metres(scene, *id) {
            Ok(size) => drop(sizes.insert(*id, size)),
            Err(why) => drop(refused.insert(*id, Arc::from(why))),
        }
    }
    (sizes, refused)
}

/// Padded edge for so many texels.
fn edge(texels: f32, page: u32) -> u32 {
    let texels = (texels.ceil().max(1.0) as u32).min(page) + 2 * PADDING;
    texels.next_multiple_of(ALIGN).min(page)
}

/// How many metres the whole UV square of an instance measures along its two axes.
fn size_in_metres(scene: &Scene, id: InstanceId) -> Result<Vec2, &'static str> {
    let instance = scene.instances.get(&id).ok_or("there is no such instance")?;
    let mesh = scene.meshes.get(&instance.mesh).ok_or("its mesh is missing")?;
    if mesh.validate().is_err() {
        return Err("its mesh is not valid");
    }
    if !instance.transform.is_finite() {
        return Err("its transform is not finite");
    }
    if mesh.uv1.is_empty() {
        return Err("its mesh has no second UV set");
    }
    let material = scene.materials.get(&instance.material);
    if material.is_some_and(|m| m.alpha_mode == AlphaMode::Blend) {
        return Err("its material is blended");
    }
    stretch(mesh, &instance.transform).ok_or("its second UV set has no area")
}

/// Root mean square of the length that one unit of u and of v has on the surface, over its area.
fn stretch(mesh: &Mesh, transform: &Affine3A) -> Option<Vec2> {
    let (mut sum, mut area) = (Vec2::ZERO, 0.0_f32);
    for corners in &mesh.triangles {
        let [a, b, c] = corners.map(|i| transform.transform_point3(mesh.positions[i as usize]));
        let [ua, ub, uc] = corners.map(|i| mesh.uv1[i as usize]);
        let (p1, p2): (Vec3, Vec3) = (b - a, c - a);
        let (d1, d2) = (ub - ua, uc - ua);
        let det = d1.perp_dot(d2);
        let world = p1.cross(p2).length() * 0.5;
        let du = (p1 * d2.y - p2 * d1.y) / det;
        let dv = (p2 * d1.x - p1 * d2.x) / det;
        let squares = Vec2::new(du.length_squared(), dv.length_squared()) * world;
        if squares.is_finite() && world > 0.0 {
            sum += squares;
            area += world;
        }
    }
    let size = Vec2::new((sum.x / area).sqrt(), (sum.y / area).sqrt());
    (size.is_finite() && size.min_element() > 0.0).then_some(size)
}
