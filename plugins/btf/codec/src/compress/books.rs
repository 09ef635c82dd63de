//! All code-books together: how a texel becomes rows, and what rows become tables.

use super::basis::{Basis, Features, dot};
use super::slices::{MOST_ROWS, Slices, Target, stored_chroma, too_many, with_black};
use super::views::{Rows, best_scale, error};
use super::{Grid, Limits};
use crate::colour::video_from_rgb;
use crate::{BtfError, ColourSpace, References, Samples, Scaled, Tables};

/// Code-books on their way.
#[derive(Clone)]
pub(super) struct Books {
    grid: Grid,
    pub(super) slices: Slices,
    pub(super) elevations: Rows,
    pub(super) azimuths: Rows,
    pub(super) texels: Vec<(u32, f32)>,
}

/// A texel's samples in the order of the levels: for each view, all lights of a channel before
/// those of the next.
pub(super) struct Texel {
    /// Red, green, blue.
    pub(super) colours: Vec<f32>,
    /// Luma above black, both chromas.
    video: Vec<f32>,
}

impl Texel {
    pub(super) fn new(grid: &Grid, samples: &[[f32; 3]]) -> Result<Self, BtfError> {
        let area = grid.slice();
        let mut texel =
            Self { colours: vec![0.0; 3 * samples.len()], video: vec![0.0; 3 * samples.len()] };
        for (at, sample) in samples.iter().enumerate() {
            if !sample.iter().all(|channel| channel.is_finite()) {
                return Err(BtfError::Tables("a sample is not finite".to_owned()));
            }
            let rgb = sample.map(|channel| channel.clamp(0.0, MOST));
            let [y, cb, cr] = video_from_rgb(rgb.map(f64::from));
            let place = at / area * 3 * area + at % area;
            let video = [y - 16.0, cb - 128.0, cr - 128.0].map(|value| value as f32);
            for channel in 0..3 {
                texel.colours[place + channel * area] = rgb[channel];
                texel.video[place + channel * area] = video[channel];
            }
        }
        Ok(texel)
    }
}

/// Brighter samples are cut off.
const MOST: f32 = 65_535.0;

/// What was found for a texel in the books as they were before it.
pub(super) enum Plan {
    /// A row of azimuths with its scale.
    Whole(u32, f32),
    Views {
        features: Features,
        views: Vec<ViewPlan>,
    },
}

pub(super) enum ViewPlan {
    /// A row of elevations with its scale.
    Found(u32, f32),
    Slices {
        features: Features,
        slices: Vec<SlicePlan>,
    },
}

pub(super) struct SlicePlan {
    scale: f32,
    luminance: Option<u32>,
    luminance_features: Features,
    chroma: Option<u32>,
    chroma_features: Features,
}

/// How many rows there were when a plan was made.
#[derive(Clone, Copy)]
pub(super) struct Before {
    luminances: usize,
    chromas: usize,
    elevations: usize,
    azimuths: usize,
}

impl Books {
    pub(super) fn new(grid: Grid) -> Self {
        Self {
            grid,
            slices: Slices::new(&grid),
            elevations: Rows::new(grid.theta),
            azimuths: Rows::new(grid.phi),
            texels: Vec::new(),
        }
    }

    /// Finds directions along which the material varies, from some of its texels.
    pub(super) fn learn(&mut self, texels: &[Texel]) {
        let slice = 3 * self.grid.slice();
        let view = self.grid.theta * slice;
        let every = |count: usize, most: usize| count.div_ceil(most).max(1);
        let slices: Vec<_> = texels.iter().flat_map(|t| t.video.chunks_exact(slice)).collect();
        let (mut luma, mut chroma, mut colours) = (Vec::new(), Vec::new(), Vec::new());
        for values in slices.iter().step_by(every(slices.len(), 512)) {
            let target = self.slices.target(values);
            let [y, c] = self.slices.normalized(values, target.scale);
            luma.push(y);
            let (blue, red) = c.split_at(c.len() / 2);
            let rows = blue.chunks_exact(self.grid.beta).zip(red.chunks_exact(self.grid.beta));
            // One of them does, in turn.
            let row = rows.skip(colours.len() % self.grid.alpha).map(|row| [row.0, row.1].concat());
            colours.extend(row.take(1).map(|row| super::slices::weighed(&row)));
            chroma.push(super::slices::weighed(&c));
        }
        let area = self.grid.slice();
        let unit = |values: Vec<f32>| {
            let length = dot(&values, &values).sqrt().max(1e-6);
            values.into_iter().map(|value| value / length).collect::<Vec<_>>()
        };
        let arcs: Vec<_> = luma.iter().flat_map(|luma| luma.chunks_exact(self.grid.beta)).collect();
        let arcs = arcs.iter().step_by(every(arcs.len(), 512));
        let arcs: Vec<_> = arcs.map(|arc| unit(arc.iter().map(with_black).collect())).collect();
        self.slices.shape_basis = Basis::new(self.grid.beta, &arcs);
        self.slices.colour_basis = Basis::new(2 * self.grid.beta, &colours);
        self.slices.luminance_basis = Basis::new(area, &luma);
        self.slices.chroma_basis = Basis::new(2 * area, &chroma);
        let views: Vec<_> = texels.iter().flat_map(|t| t.colours.chunks_exact(view)).collect();
        let some: Vec<_> =
            views.iter().step_by(every(views.len(), 256)).map(|view| unit(view.to_vec())).collect();
        self.elevations.basis = Basis::new(view, &some);
        let wholes: Vec<_> = texels.iter().map(|texel| unit(texel.colours.clone())).collect();
        self.azimuths.basis = Basis::new(self.grid.phi * view, &wholes);
    }

    pub(super) fn before(&self) -> Before {
        Before {
            luminances: self.slices.luminance_book.len(),
            chromas: self.slices.chroma_book.len(),
            elevations: self.elevations.len(),
            azimuths: self.azimuths.len(),
        }
    }

    /// From the top down, rows that are near enough.
    pub(super) fn plan(&self, texel: &Texel, limits: &Limits) -> Plan {
        let goal = self.azimuths.goal(&texel.colours);
        let decode = |row, out: &mut [f32]| self.decode_azimuths(row, out);
        if let Some((row, scale)) = self.azimuths.nearest(&goal, 0, limits.total, decode) {
            return Plan::Whole(row, scale);
        }
        let length = self.grid.theta * 3 * self.grid.slice();
        let parts = texel.colours.chunks_exact(length).zip(texel.video.chunks_exact(length));
        let views = parts.map(|(colours, video)| self.plan_view(colours, video, limits)).collect();
        Plan::Views { features: goal.features, views }
    }

    fn plan_view(&self, colours: &[f32], video: &[f32], limits: &Limits) -> ViewPlan {
        let goal = self.elevations.goal(colours);
        let decode = |row, out: &mut [f32]| self.decode_elevations(row, out);
        if let Some((row, scale)) = self.elevations.nearest(&goal, 0, limits.total, decode) {
            return ViewPlan::Found(row, scale);
        }
        let slices = video.chunks_exact(3 * self.grid.slice()).map(|values| {
            let target = self.slices.target(values);
            SlicePlan {
                scale: target.scale,
                luminance: self.slices.luminance(&target, 0, limits),
                luminance_features: target.luminance,
                chroma: self.slices.chroma(&target, 0, limits),
                chroma_features: target.chroma,
            }
        });
        ViewPlan::Slices { features: goal.features, slices: slices.collect() }
    }

    /// Carries out a plan: what it did not find may have been added since; else it is added now.
    pub(super) fn commit(&mut self, texel: &Texel, plan: Plan, before: Before, limits: &Limits) {
        let (features, plans) = match plan {
            Plan::Whole(row, scale) => return self.texels.push((row, scale)),
            Plan::Views { features, views } => (features, views),
        };
        let goal = self.azimuths.goal_with(&texel.colours, features);
        let decode = |row, out: &mut [f32]| self.decode_azimuths(row, out);
        let found = self.azimuths.nearest(&goal, before.azimuths, limits.total, decode);
        if let Some(found) = found {
            return self.texels.push(found);
        }
        let length = self.grid.theta * 3 * self.grid.slice();
        let mut entries = Vec::with_capacity(plans.len());
        for (at, plan) in plans.into_iter().enumerate() {
            let range = at * length..(at + 1) * length;
            let (colours, video) = (&texel.colours[range.clone()], &texel.video[range]);
            entries.push(match plan {
                ViewPlan::Found(row, scale) => (row, scale),
                ViewPlan::Slices { features, slices } => {
                    self.commit_view(colours, video, features, slices, before, limits)
                }
            });
        }
        let mut colours = vec![0.0; texel.colours.len()];
        for (entry, out) in entries.iter().zip(colours.chunks_exact_mut(length)) {
            self.decode_elevations(entry.0, out);
            out.iter_mut().for_each(|colour| *colour *= entry.1);
        }
        let row = self.azimuths.push(&entries, &colours);
        self.texels.push((row, 1.0));
    }

    fn commit_view(
        &mut self,
        colours: &[f32],
        video: &[f32],
        features: Features,
        plans: Vec<SlicePlan>,
        before: Before,
        limits: &Limits,
    ) -> (u32, f32) {
        let goal = self.elevations.goal_with(colours, features);
        let decode = |row, out: &mut [f32]| self.decode_elevations(row, out);
        let found = self.elevations.nearest(&goal, before.elevations, limits.total, decode);
        if let Some(found) = found {
            return found;
        }
        let length = 3 * self.grid.slice();
        let mut entries = Vec::with_capacity(plans.len());
        let mut row_colours = vec![0.0; colours.len()];
        for (at, plan) in plans.into_iter().enumerate() {
            let range = at * length..(at + 1) * length;
            let out = &mut row_colours[range.clone()];
            let goal = &colours[range.clone()];
            let entry = self.commit_slice(goal, &video[range], plan, before, limits, out);
            entries.push(entry);
        }
        (self.elevations.push(&entries, &row_colours), 1.0)
    }

    /// A pair with its scale; `out` gets the colours that it gives.
    fn commit_slice(
        &mut self,
        goal: &[f32],
        values: &[f32],
        plan: SlicePlan,
        before: Before,
        limits: &Limits,
        out: &mut [f32],
    ) -> (u32, f32) {
        let target = Target {
            values,
            scale: plan.scale,
            luminance: plan.luminance_features,
            chroma: plan.chroma_features,
        };
        let slices = &mut self.slices;
        let mut luminance =
            plan.luminance.or_else(|| slices.luminance(&target, before.luminances, limits));
        let mut chroma = plan.chroma.or_else(|| slices.chroma(&target, before.chromas, limits));
        // A new row's own error grows with the scale.
        let own = limits.tightened(plan.scale);
        let [luma, colour] = slices.normalized(values, plan.scale);
        loop {
            let found = [luminance, chroma];
            let row = luminance.unwrap_or_else(|| slices.add_luminance(&luma, &own));
            let colours = chroma.unwrap_or_else(|| slices.add_chroma(&colour, &own));
            let pair = slices.pair(row, colours);
            slices.decode(pair, out);
            let scale = best_scale(goal, out, dot(out, out));
            let allowed = limits.total * limits.total * goal.len() as f32;
            // Two errors within their limits can add up to more than the whole may have.
            if found == [None; 2] || error(goal, out, scale) <= allowed {
                out.iter_mut().for_each(|colour| *colour *= scale);
                return (pair, scale);
            }
            match found {
                [Some(_), _] => luminance = None,
                _ => chroma = None,
            }
        }
    }

    pub(super) fn decode_elevations(&self, row: u32, out: &mut [f32]) {
        let (index, scale) = self.elevations.row(row);
        let parts = out.chunks_exact_mut(3 * self.grid.slice());
        for ((out, pair), scale) in parts.zip(index).zip(scale) {
            self.slices.decode(*pair, out);
            out.iter_mut().for_each(|colour| *colour *= scale);
        }
    }

    fn decode_azimuths(&self, row: u32, out: &mut [f32]) {
        let (index, scale) = self.azimuths.row(row);
        let parts = out.chunks_exact_mut(self.grid.theta * 3 * self.grid.slice());
        for ((out, row), scale) in parts.zip(index).zip(scale) {
            self.decode_elevations(*row, out);
            out.iter_mut().for_each(|colour| *colour *= scale);
        }
    }

    /// Sum of the squares of a texel's errors, and the largest one.
    pub(super) fn errors(&self, texel: &Texel, (row, scale): (u32, f32)) -> (f32, f32) {
        let mut colours = vec![0.0; texel.colours.len()];
        self.decode_azimuths(row, &mut colours);
        let differences = texel.colours.iter().zip(&colours).map(|(a, b)| (a - scale * b).abs());
        (error(&texel.colours, &colours, scale), differences.fold(0.0, f32::max))
    }

    /// Whether the format has room for the rows.
    pub(super) fn check(&self) -> Result<(), BtfError> {
        self.slices.check()?;
        match self.elevations.len().max(self.azimuths.len()) > MOST_ROWS {
            true => Err(too_many("rows over the view")),
            false => Ok(()),
        }
    }

    /// Bytes of the tables, packed ([`crate::Layout`] says how).
    pub(super) fn bytes(&self) -> usize {
        let slices = &self.slices;
        4 * (self.texels.len()
            + self.azimuths.index.len()
            + 2 * self.elevations.index.len()
            + slices.luminance_index.len()
            + slices.shape_count() * slices.beta.div_ceil(2)
            + slices.chroma_index.len()
            + slices.colour_rows.len())
    }

    pub(super) fn grid(&self) -> &Grid {
        &self.grid
    }

    /// Luma above black and both chromas of a view's slice.
    pub(super) fn video<'a>(&self, texel: &'a Texel, view: usize) -> &'a [f32] {
        let length = 3 * self.grid.slice();
        &texel.video[view * length..][..length]
    }

    pub(super) fn into_tables(self) -> Tables {
        let Self { slices, elevations, azimuths, texels, grid } = self;
        let scaled = |columns, index, scale| Scaled { columns, index, scale, range: None };
        Tables {
            colour_space: ColourSpace::YCbCr,
            beta_uniform_in_sine: grid.beta_uniform_in_sine,
            texels: scaled(
                1,
                texels.iter().map(|texel| texel.0).collect(),
                texels.iter().map(|texel| texel.1).collect(),
            ),
            azimuths: scaled(grid.phi, azimuths.index, azimuths.scale),
            elevations: scaled(grid.theta, elevations.index, elevations.scale),
            slices: References { columns: 2, index: slices.pairs.concat() },
            luminances: scaled(grid.alpha, slices.luminance_index, slices.luminance_scale),
            shapes: Samples { columns: grid.beta, value: slices.shapes, range: None },
            chromas: References { columns: grid.alpha, index: slices.chroma_index },
            colour_rows: References { columns: grid.beta, index: slices.colour_rows },
            colours: Samples {
                columns: 2,
                value: slices.colours.into_iter().flat_map(stored_chroma).collect(),
                range: None,
            },
        }
    }
}
