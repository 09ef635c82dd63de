//! What each cell gets from others: few rays a texel, kept while light between them comes to rest.
//!
//! The irradiance of a cell, but for what punctual lights send there, is
//!
//! ```text
//! S + C + T U,  U = C + T U
//! ```
//!
//! with S what emitters and the sky send straight there, C what texels reflect once of what arrives
//! straight at them, and T U the rest. S and C are estimates with all techniques there are for small bright
//! things; T is a sparse matrix of kept rays, of which each row has hundreds, and U is what Jacobi's
//! iteration makes of it (compare Lehtinen et al. 2008, "A Meshless Hierarchical Representation for Light
//! Transport", and the classic radiosity of Cohen and Greenberg 1985).

use std::f32::consts::PI;

use glam::{UVec3, Vec3};
use rayon::prelude::*;

use super::{
    field::{End, Field, Walker},
    lobe::{Cosine, Lobe},
    sources::Sources,
};
use crate::{
    Ray,
    estimate::Progress,
    lightmap::NONE,
    sampling::{PathSampler, hash_pair},
    visibility::offset_origin,
};

/// Rays a cell that are aimed for: its irradiance is noisy by some percent then, and a texel, which
/// sees hundreds of cells, by a tenth of a percent.
const RAYS_PER_CELL: u32 = 256;
/// Rays that are kept in all, where texels are few.
const KEPT_RAYS: u32 = 3_000_000;
/// Most and fewest rays a texel.
const RAYS_PER_TEXEL: (u32, u32) = (8, 512);
/// Iterations end when nothing changes by more than this part of the largest value.
const SETTLED: f32 = 1e-4;
/// They end after so many at the latest: between perfect reflectors light never comes to rest.
const MOST_ITERATIONS: u32 = 512;
/// Keeps the random numbers of links apart from those of gather rays.
const STREAM: u64 = 0x6c69_6e6b;

/// Rays a texel, and the edge of cells in texels, for so many texels.
pub(super) fn resolution(texels: usize) -> (u32, u32) {
    let (least, most) = RAYS_PER_TEXEL;
    let rays = (KEPT_RAYS / (texels.max(1) as u32)).clamp(least, most).next_power_of_two();
    let mut edge = 1;
    while edge * edge * rays < RAYS_PER_CELL {
        edge += 1;
    }
    (rays, edge)
}

/// A kept ray that met a texel at once.
#[derive(Clone, Copy)]
struct Link {
    texel: u32,
    /// Density of the texel's point as a source over that of the ray; 0 where it cannot be drawn.
    ratio: f32,
}

/// A kept path that met something else first.
struct Long {
    texel: u32,
    throughput: Vec3,
    before: u32,
}

/// The kept rays of a cell.
#[derive(Default)]
struct Row {
    rays: u32,
    links: Vec<Link>,
    /// By how much the radiance that leaves the met point differs from that of its texel, for links to
    /// uneven texels, with their places in `links`.
    uneven: Vec<(u32, Vec3)>,
    longs: Vec<Long>,
    /// Irradiance from emitters and sky, summed over rays.
    straight: Vec3,
    /// Irradiance that was reflected by surfaces without texels, summed, with the number of
    /// reflections. Without a limit of bounces, one entry at most.
    reflected: Vec<(u32, Vec3)>,
}

/// Keeps a path.
struct Keep<'a> {
    field: &'a Field<'a>,
    row: &'a mut Row,
    /// Whether the number of reflections matters.
    counted: bool,
}

impl Walker for Keep<'_> {
    fn light(&mut self, radiance: Vec3, before: u32) {
        let irradiance = radiance * PI;
        let before = if self.counted { before } else { before.min(1) };
        if before == 0 {
            self.row.straight += irradiance;
        } else if let Some(sum) = self.row.reflected.iter_mut().find(|r| r.0 == before) {
            sum.1 += irradiance;
        } else {
            self.row.reflected.push((before, irradiance));
        }
    }

    fn ends(&mut self, end: &End, sampler: &mut PathSampler) -> bool {
        let texel = end.met.texel;
        if end.before == 0 {
            if let Some(more) = self.field.unevenness(&end.met, end.origin, sampler) {
                self.row.uneven.push((self.row.links.len() as u32, more));
            }
            let ratio = if end.met.exact { end.met.solid_angle_pdf() / end.pdf } else { 0.0 };
            self.row.links.push(Link { texel, ratio });
        } else {
            // Roulette may weigh a path up. That averages out in a sum, but not in one that is taken to
            // the end: no row may send more light than arrives.
            let (throughput, before) = (end.throughput.min(Vec3::ONE), end.before);
            self.row.longs.push(Long { texel, throughput, before });
        }
        true
    }
}

/// Which part of the irradiance of each cell arrives at which other.
struct Matrix {
    rows: Vec<Vec<(u32, u32)>>,
    scale: Vec<f32>,
}

impl Matrix {
    fn new(rows: &[Row], cells: &[u32], albedo: &[Vec3]) -> Self {
        let packed = |albedo: Vec3| {
            let [r, g, b] = (albedo * 1023.0).round().as_uvec3().to_array();
            r | g << 10 | b << 20
        };
        let of = |row: &Row| {
            let entry = |l: &Link| (cells[l.texel as usize], packed(albedo[l.texel as usize]));
            let mut entries: Vec<_> = row.links.iter().map(entry).collect();
            // Reading walks through memory.
            entries.sort_unstable();
            entries
        };
        Self {
            rows: rows.par_iter().map(of).collect(),
            scale: rows.iter().map(|row| 1.0 / (1023.0 * row.rays as f32)).collect(),
        }
    }

    /// Irradiance of a cell, from that of all.
    fn row(&self, cell: usize, irradiance: &[Vec3]) -> Vec3 {
        let mut sum = Vec3::ZERO;
        for &(from, packed) in &self.rows[cell] {
            let albedo = UVec3::new(packed, packed >> 10, packed >> 20) & 1023;
            sum += albedo.as_vec3() * irradiance[from as usize];
        }
        sum * self.scale[cell]
    }
}

impl Field<'_> {
    /// Finds what all cells get. `None` if `progress` stopped the work.
    pub(super) fn solve(&mut self, rays: u32, seed: u64, progress: Progress<'_>) -> Option<()> {
        let mut members = vec![Vec::new(); self.cells.count];
        for (texel, &cell) in self.cells.of.iter().enumerate() {
            if cell != NONE {
                members[cell as usize].push(texel as u32);
            }
        }
        let rows: Vec<Row> = members
            .par_iter()
            .map(|texels| {
                let row = self.trace_row(texels, rays, seed);
                progress(0).is_continue().then_some(row)
            })
            .collect::<Option<_>>()?;
        let straight: Vec<Vec3> = rows.iter().map(|row| row.straight / row.rays as f32).collect();

        // What leaves texels before anything was reflected twice, and which of them are bright.
        let once = self.leaving_with(&straight);
        let met = self.met_by(&rows, &members);
        self.set_leaving(&once, &met);
        let albedo = &self.layout.patches.albedo;
        let reflected: Vec<Vec3> = rows
            .par_iter()
            .zip(&members)
            .map(|(row, texels)| {
                let weight = |l: &Link| 1.0 / (1.0 + self.leaving[l.texel as usize].w * l.ratio);
                let met: Vec3 = row.links.iter().map(|l| once[l.texel as usize] * weight(l)).sum();
                let uneven = row.uneven.iter();
                let more: Vec3 =
                    uneven.map(|(i, more)| more * weight(&row.links[*i as usize])).sum();
                let drawn = self.drawn_sources(texels, rays, seed);
                progress(0).is_continue().then(|| ((met + more) * PI + drawn) / row.rays as f32)
            })
            .collect::<Option<_>>()?;

        let limited = (self.bounces != u32::MAX).then_some(self.bounces);
        let matrix = Matrix::new(&rows, &self.cells.of, albedo);
        let long = |row: &Row, most: u32, of: &dyn Fn(&Long) -> Vec3| -> Vec3 {
            let longs = row.longs.iter().filter(|l| l.before < most);
            let walls = row.reflected.iter().filter(|r| r.0 <= most).map(|r| r.1);
            (longs.map(of).sum::<Vec3>() * PI + walls.sum::<Vec3>()) / row.rays as f32
        };
        // Level m: reflected at most m times. Without a limit the levels are iterations.
        let mut levels = vec![vec![Vec3::ZERO; self.cells.count]];
        for level in 1..limited.unwrap_or(MOST_ITERATIONS) {
            let before = &levels[levels.len() - 1];
            let next: Vec<Vec3> = (0..self.cells.count)
                .into_par_iter()
                .with_min_len(64)
                .map(|i| {
                    let row = &rows[i];
                    let of = |l: &Long| {
                        let t = l.texel as usize;
                        let cell = self.cells.of[t] as usize;
                        // Further reflections through it; exact for those that are counted.
                        let back = levels.len().saturating_sub(1 + l.before as usize);
                        let further = match limited {
                            Some(_) if l.before as usize + 1 > levels.len() => Vec3::ZERO,
                            Some(_) => levels[back][cell],
                            None => before[cell],
                        };
                        l.throughput * (once[t] + albedo[t] / PI * further)
                    };
                    let most = limited.map_or(u32::MAX, |_| level);
                    reflected[i] + matrix.row(i, before) + long(row, most, &of)
                })
                .collect();
            progress(0).is_continue().then_some(())?;
            let largest = next.iter().map(|v| v.max_element()).fold(0.0, f32::max);
            let change = next.iter().zip(before).map(|(a, b)| (*a - *b).abs().max_element());
            let done = change.fold(0.0, f32::max) <= SETTLED * largest;
            if limited.is_none() {
                levels.clear();
            }
            levels.push(next);
            if limited.is_none() && done {
                break;
            }
        }
        for level in &mut levels {
            for (sum, straight) in level.iter_mut().zip(&straight) {
                *sum += *straight;
            }
        }
        self.levels = levels;
        let last = self.leaving_with(self.levels.last().map_or(&[][..], Vec::as_slice));
        self.set_leaving(&last, &met);
        Some(())
    }

    /// Radiance that leaves each texel if cells get so much beside punctual light.
    fn leaving_with(&self, irradiance: &[Vec3]) -> Vec<Vec3> {
        let of = |t: usize| match self.cells.of[t] {
            NONE => Vec3::ZERO,
            cell => {
                let all = self.direct[t] + irradiance[cell as usize];
                self.layout.patches.albedo[t] / PI * all
            }
        };
        (0..self.layout.len()).map(of).collect()
    }

    /// How many kept rays met each texel, the mean over its cell.
    fn met_by(&self, rows: &[Row], members: &[Vec<u32>]) -> Vec<f32> {
        let mut cells = vec![0.0_f32; self.cells.count];
        for link in rows.iter().flat_map(|row| &row.links) {
            cells[self.cells.of[link.texel as usize] as usize] += 1.0;
        }
        let mut met = vec![0.0; self.layout.len()];
        for (cell, texels) in cells.iter().zip(members) {
            for &texel in texels {
                met[texel as usize] = cell / texels.len() as f32;
            }
        }
        met
    }

    fn set_leaving(&mut self, leaving: &[Vec3], met: &[f32]) {
        let mut drawn = vec![0.0; leaving.len()];
        self.sources = Sources::new(self.world(), self.layout, leaving, met, &mut drawn);
        self.leaving = leaving.iter().zip(drawn).map(|(l, p)| l.extend(p)).collect();
    }

    fn trace_row(&self, texels: &[u32], rays: u32, seed: u64) -> Row {
        let mut row = Row { rays: rays * texels.len() as u32, ..Row::default() };
        for &texel in texels {
            let (origin, lobe, set) = self.start(texel, seed);
            for ray in 0..rays {
                let mut sampler = PathSampler::new(set, ray, 16);
                let (direction, pdf) = lobe.draw(sampler.next_2d());
                for toward in [
                    self.tracer.toward_emitter(origin, &mut sampler, |d| lobe.pdf(d)),
                    self.tracer.toward_sky(origin, &mut sampler, |d| lobe.pdf(d)),
                ]
                .into_iter()
                .flatten()
                {
                    row.straight += toward.weighted * (lobe.pdf(toward.direction) * PI);
                }
                if pdf <= 0.0 {
                    continue;
                }
                let counted = self.bounces != u32::MAX;
                self.walk(
                    Ray::new(origin, direction),
                    pdf,
                    true,
                    &mut sampler,
                    &mut Keep { field: self, row: &mut row, counted },
                );
            }
        }
        row
    }

    /// Irradiance from bright texels, summed over as many samples as there are rays.
    fn drawn_sources(&self, texels: &[u32], rays: u32, seed: u64) -> Vec3 {
        let mut sum = Vec3::ZERO;
        if self.sources.is_empty() {
            return sum;
        }
        for &texel in texels {
            let (origin, lobe, set) = self.start(texel, seed ^ STREAM);
            for ray in 0..rays {
                let mut sampler = PathSampler::new(set, ray, 16);
                if let Some(toward) = self.toward_source(origin, &lobe, 0, false, &mut sampler) {
                    sum += toward.weighted * (lobe.pdf(toward.direction) * PI);
                }
            }
        }
        sum
    }

    fn start(&self, texel: u32, seed: u64) -> (Vec3, Cosine, u64) {
        let patches = &self.layout.patches;
        let normal = patches.normal[texel as usize];
        let origin = offset_origin(patches.position[texel as usize], normal);
        (origin, Cosine::new(normal), hash_pair(hash_pair(seed, STREAM), u64::from(texel)))
    }
}
