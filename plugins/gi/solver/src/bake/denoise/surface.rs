//! What texels help each other: neighbours on one smooth piece of surface.

use std::collections::HashMap;

use glam::{Vec3, Vec3A};
use rayon::prelude::*;

use super::cells::Cells;
use crate::{bake::LayoutTexel, scene::InstanceId};

/// Cosine between normals below which surfaces are not alike.
const COS: f32 = 0.8;
/// Texels nearer than this, in texels, touch.
const TOUCH: f32 = 1.8;
/// Beyond this radius in texels neighbours must be reachable from texel to texel.
const REACH: f32 = 3.0;

/// The texels as points of surfaces.
pub(super) struct Surface {
    position: Vec<Vec3A>,
    /// What the texels' light is for.
    normal: Vec<Vec3A>,
    /// Normals of their triangles.
    geometric: Vec<Vec3A>,
    /// Edge of each texel in metres.
    edge: Vec<f32>,
    /// Whether a texel gives and takes.
    usable: Vec<bool>,
    spacing: f32,
    /// Where the texels that each one touches start in `links`; an end.
    starts: Vec<u32>,
    links: Vec<u32>,
}

/// A neighbour of a texel, itself included.
#[derive(Clone, Copy)]
pub(super) struct Near {
    pub(super) texel: u32,
    /// Place in the texel's tangent plane, in units of the radius.
    pub(super) x: f32,
    pub(super) y: f32,
    /// From distance and likeness of normals, 0 to 1.
    pub(super) weight: f32,
}

impl Surface {
    /// `spacing` is the edge of most texels in metres.
    pub(super) fn new(texels: &[LayoutTexel], usable: Vec<bool>, spacing: f32) -> Self {
        let grid = Grid::new(texels);
        let mut surface = Self {
            position: texels.iter().map(|t| t.position.into()).collect(),
            normal: texels.iter().map(|t| t.normal.into()).collect(),
            geometric: texels.iter().map(|t| t.geometric.into()).collect(),
            edge: edges(texels, &grid, spacing),
            usable,
            spacing,
            starts: Vec::new(),
            links: Vec::new(),
        };
        let touching: Vec<Vec<u32>> =
            surface.each(TOUCH, |_, near| near.iter().map(|n| n.texel).collect());
        surface.starts.push(0);
        for (i, mut touching) in touching.into_iter().enumerate() {
            if surface.usable[i] {
                // Texels of stretched charts may be far from each other.
                let beside = grid.around(texels, i).filter(|&j| surface.weight(i, j).is_some());
                touching.extend(beside.map(|j| j as u32));
            }
            surface.links.extend(touching);
            surface.starts.push(surface.links.len() as u32);
        }
        surface
    }

    /// How many texels there are.
    pub(super) fn len(&self) -> usize {
        self.position.len()
    }

    /// Whether a texel gives and takes.
    pub(super) fn is_usable(&self, texel: usize) -> bool {
        self.usable[texel]
    }

    /// Calls `f` for every usable texel with its neighbours within `radius` texels; others get the default.
    pub(super) fn each<T: Send + Clone + Default>(
        &self,
        radius: f32,
        f: impl Fn(usize, &[Near]) -> T + Sync,
    ) -> Vec<T> {
        let points: Vec<Vec3> = self.position.iter().map(|p| Vec3::from(*p)).collect();
        let edge = (radius * 0.5).max(2.0) * self.spacing;
        let cells = Cells::new(&points, &self.usable, edge);
        let results: Vec<Vec<T>> = (0..cells.len())
            .into_par_iter()
            .with_min_len(16)
            .map_init(
                || (Flood::new(self.len()), Vec::new(), Vec::new()),
                |(flood, around, near), cell| {
                    let points = cells.points(cell);
                    let largest = points.iter().map(|&i| self.edge[i as usize]).fold(0.0, f32::max);
                    cells.around(cell, radius * largest, around);
                    let flooded = radius > REACH;
                    if flooded {
                        flood.run(self, points, around);
                    }
                    let results = points.iter().map(|&i| {
                        let piece = flood.pieces[i as usize];
                        let same = |j: &&u32| !flooded || flood.pieces[**j as usize] == piece;
                        self.near(i as usize, radius, around.iter().filter(same), near);
                        f(i as usize, near)
                    });
                    let results = results.collect();
                    if flooded {
                        flood.clear(around);
                    }
                    results
                },
            )
            .collect();
        let mut out = vec![T::default(); self.len()];
        for (&i, value) in cells.order.iter().zip(results.into_iter().flatten()) {
            out[i as usize] = value;
        }
        out
    }

    fn near<'a>(
        &self,
        i: usize,
        radius: f32,
        around: impl Iterator<Item = &'a u32>,
        near: &mut Vec<Near>,
    ) {
        near.clear();
        let scale = 1.0 / (radius * self.edge[i]);
        let (right, up) = Vec3::from(self.normal[i]).any_orthonormal_pair();
        let (right, up) = (Vec3A::from(right) * scale, Vec3A::from(up) * scale);
        for &texel in around {
            let offset = self.position[texel as usize] - self.position[i];
            let kernel = 1.0 - offset.length_squared() * scale * scale;
            if kernel > 0.0
                && let Some(alike) = self.weight(i, texel as usize)
            {
                let (x, y) = (offset.dot(right), offset.dot(up));
                near.push(Near { texel, x, y, weight: kernel * alike });
            }
        }
    }

    /// How much two texels look the same way and lie in each other's plane, above 0 to 1; `None` for
    /// surfaces that differ.
    fn weight(&self, i: usize, j: usize) -> Option<f32> {
        let offset = self.position[j] - self.position[i];
        let cos = self.normal[i].dot(self.normal[j]);
        // On a mesh with smooth normals these tell what goes on across its edges, those of the triangles
        // what lies in one plane.
        let off =
            |normals: &[Vec3A]| offset.dot(normals[i]).abs().max(offset.dot(normals[j]).abs());
        let height = off(&self.normal).min(off(&self.geometric));
        let alike = cos > COS && height <= 0.35 * offset.length() + 0.1 * self.edge[i];
        (alike && self.usable[j]).then(|| ((cos - COS) / (1.0 - COS)).min(1.0))
    }
}

/// Finds what is connected within a neighbourhood: light must not pass a wall that stands on a floor.
struct Flood {
    /// The connected piece of each texel around; 0 for others, [`OPEN`] while not known.
    pieces: Vec<u32>,
    stack: Vec<u32>,
}

/// Not reached yet.
const OPEN: u32 = u32::MAX;

impl Flood {
    fn new(texels: usize) -> Self {
        Self { pieces: vec![0; texels], stack: Vec::new() }
    }

    fn run(&mut self, surface: &Surface, from: &[u32], around: &[u32]) {
        for &i in around {
            self.pieces[i as usize] = OPEN;
        }
        for (piece, &start) in (1..).zip(from) {
            if self.pieces[start as usize] != OPEN {
                continue;
            }
            self.pieces[start as usize] = piece;
            self.stack.push(start);
            while let Some(i) = self.stack.pop() {
                let links = surface.starts[i as usize]..surface.starts[i as usize + 1];
                for &j in &surface.links[links.start as usize..links.end as usize] {
                    if self.pieces[j as usize] == OPEN {
                        self.pieces[j as usize] = piece;
                        self.stack.push(j);
                    }
                }
            }
        }
    }

    fn clear(&mut self, around: &[u32]) {
        for &i in around {
            self.pieces[i as usize] = 0;
        }
    }
}

/// Texels by page, column and row.
struct Grid(HashMap<(u32, u32, u32), u32>);

impl Grid {
    fn new(texels: &[LayoutTexel]) -> Self {
        let key = |t: &LayoutTexel| (t.page.0, t.x, t.y);
        Self(texels.iter().enumerate().map(|(i, t)| (key(t), i as u32)).collect())
    }

    /// The texel of the same chart at an offset.
    fn beside(&self, texels: &[LayoutTexel], i: usize, dx: i32, dy: i32) -> Option<usize> {
        let t = &texels[i];
        let (x, y) = (t.x.checked_add_signed(dx)?, t.y.checked_add_signed(dy)?);
        let j = *self.0.get(&(t.page.0, x, y))? as usize;
        ((texels[j].instance, texels[j].chart) == (t.instance, t.chart)).then_some(j)
    }

    fn around<'a>(
        &'a self,
        texels: &'a [LayoutTexel],
        i: usize,
    ) -> impl Iterator<Item = usize> + 'a {
        let offsets = (-1..=1).flat_map(|dy| (-1..=1).map(move |dx| (dx, dy)));
        offsets.filter_map(move |(dx, dy)| self.beside(texels, i, dx, dy))
    }
}

/// Edge of each texel in metres, the mean over its chart; about `spacing`.
fn edges(texels: &[LayoutTexel], grid: &Grid, spacing: f32) -> Vec<f32> {
    let mut charts: HashMap<(InstanceId, u32), (f32, f32)> = HashMap::new();
    for (i, t) in texels.iter().enumerate() {
        let step = |dx, dy| Some(texels[grid.beside(texels, i, dx, dy)?].position - t.position);
        if let (Some(x), Some(y)) = (step(1, 0), step(0, 1)) {
            let area = x.cross(y).length();
            if area.is_finite() {
                let chart = charts.entry((t.instance, t.chart)).or_default();
                *chart = (chart.0 + area.sqrt(), chart.1 + 1.0);
            }
        }
    }
    let edge = |t: &LayoutTexel| {
        let (sum, count) = charts.get(&(t.instance, t.chart)).copied().unwrap_or((spacing, 1.0));
        (sum / count).clamp(spacing * 0.25, spacing * 4.0)
    };
    texels.iter().map(edge).collect()
}
