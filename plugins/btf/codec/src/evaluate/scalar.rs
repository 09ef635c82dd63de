//! One value at a time.

use glam::Vec3;

use crate::angles::stored_azimuth;
use crate::layout::Packed;
use crate::{Angles, Btf, Cell, Layout, Rules, SliceAngles};

/// What a texel looks like from one direction: four slices with their weights, found once for any
/// number of lights.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct ViewSlices {
    /// Rows of luminances.
    pub luminances: [u32; 4],
    /// Rows of chromas.
    pub chromas: [u32; 4],
    /// Interpolation weights times the scales of three levels.
    pub weights: [f32; 4],
}

impl Btf {
    /// The value of the texel in column `x` and row `y` (both wrap round): red, green and blue in
    /// the range of the [`ColourSpace`](crate::ColourSpace), with the cosine of the light
    /// already in it. Black below the horizon.
    pub fn evaluate(&self, x: i32, y: i32, angles: Angles, rules: Rules) -> Vec3 {
        if !angles.above() {
            return Vec3::ZERO;
        }
        let slices = self.view_slices(x, y, angles.theta_v, angles.phi_v);
        let difference = angles.phi_i - angles.phi_v;
        let light = SliceAngles::new(angles.theta_i, difference, rules.guard_beta_pole);
        self.evaluate_slices(&slices, light, rules)
    }

    /// The part of an evaluation that depends on texel and view.
    pub fn view_slices(&self, x: i32, y: i32, theta_v: f32, phi_v: f32) -> ViewSlices {
        let layout = self.layout();
        let x = x.rem_euclid(layout.columns as i32) as u32;
        let y = y.rem_euclid(layout.rows as i32) as u32;
        let (azimuth_row, texel_scale) = self.packed(&layout.texels, y * layout.columns + x);
        let theta = Cell::between(theta_v, 0.0, std::f32::consts::FRAC_PI_2, layout.theta_count);
        let phi = Cell::round(stored_azimuth(phi_v), layout.phi_count);

        let mut slices = ViewSlices::default();
        for (half, (column, phi_weight)) in
            [(phi.low, 1.0 - phi.weight), (phi.high, phi.weight)].into_iter().enumerate()
        {
            let entry = azimuth_row * layout.phi_count + column;
            let (elevation_row, azimuth_scale) = self.packed(&layout.azimuths, entry);
            for (quarter, (column, theta_weight)) in
                [(theta.low, 1.0 - theta.weight), (theta.high, theta.weight)]
                    .into_iter()
                    .enumerate()
            {
                let entry = 2 * (elevation_row * layout.theta_count + column);
                let (luminances, elevation_scale) = self.packed(&layout.elevations, entry);
                let at = 2 * half + quarter;
                slices.luminances[at] = luminances;
                slices.chromas[at] = self.word(layout.elevations.offset + entry + 1);
                slices.weights[at] =
                    phi_weight * azimuth_scale * theta_weight * elevation_scale * texel_scale;
            }
        }
        slices
    }

    /// The part of an evaluation that depends on the light.
    pub fn evaluate_slices(&self, slices: &ViewSlices, light: SliceAngles, rules: Rules) -> Vec3 {
        let layout = self.layout();
        let half_turn = std::f32::consts::FRAC_PI_2;
        let alpha = Cell::between(light.alpha, -half_turn, half_turn, layout.alpha_count);
        let beta = if layout.flags & Layout::BETA_IN_SINE != 0 {
            Cell::in_sine(light, layout.beta_count)
        } else {
            Cell::between(light.beta, -half_turn, half_turn, layout.beta_count)
        };
        let mut sum = Vec3::ZERO;
        for slice in 0..4 {
            let luminance = self.luminance(slices.luminances[slice], alpha, beta, rules);
            let chroma = self.chroma(slices.chromas[slice], alpha, beta);
            let colour = self.colour_space().decode(luminance, chroma, rules.linear);
            sum += slices.weights[slice] * colour;
        }
        sum
    }

    /// Linear over alpha between two curves over beta.
    fn luminance(&self, row: u32, alpha: Cell, beta: Cell, rules: Rules) -> f32 {
        let layout = self.layout();
        let mut sum = 0.0;
        for (column, weight) in [(alpha.low, 1.0 - alpha.weight), (alpha.high, alpha.weight)] {
            let (shape, scale) = self.packed(&layout.luminances, row * layout.alpha_count + column);
            sum += weight * scale * self.shape(shape, beta, rules);
        }
        sum
    }

    /// Cubic Hermite interpolation of a row of shapes.
    fn shape(&self, row: u32, beta: Cell, rules: Rules) -> f32 {
        let at = |sample: u32| self.shape_sample(row, sample);
        let (low, t) = (beta.low, beta.weight);
        let (p0, p1) = (at(low), at(low + 1));
        let rise = p1 - p0;
        let first = low == 0;
        let last = low + 2 == self.layout().beta_count;
        let m0 = if first { rise } else { 0.5 * (p1 - at(low - 1)) };
        let m1 = match (last, rules.half_end_slope) {
            (true, _) => rise,
            (false, true) => 0.5 * rise,
            (false, false) => 0.5 * (at(low + 2) - p0),
        };
        // Horner's form of the four Hermite polynomials.
        let bend = m0 + m1 - 2.0 * rise;
        p0 + t * (m0 + t * (rise - m0 - bend + t * bend))
    }

    pub(crate) fn shape_sample(&self, row: u32, sample: u32) -> f32 {
        let shapes = &self.layout().shapes;
        let word = self.word(shapes.offset + row * shapes.stride + sample / 2);
        let code = word >> (16 * (sample % 2)) & 0xffff;
        shapes.min + code as f32 * shapes.step
    }

    /// Chroma, linear over beta, then over alpha.
    fn chroma(&self, row: u32, alpha: Cell, beta: Cell) -> [f32; 2] {
        let layout = self.layout();
        let mut sum = [0.0; 2];
        for (column, alpha_weight) in [(alpha.low, 1.0 - alpha.weight), (alpha.high, alpha.weight)]
        {
            let colour_row = self.word(layout.chromas + row * layout.alpha_count + column);
            for (column, beta_weight) in [(beta.low, 1.0 - beta.weight), (beta.high, beta.weight)] {
                let colours = &layout.colour_rows;
                let codes = self.word(colours.offset + colour_row * colours.stride + column);
                for (sum, code) in sum.iter_mut().zip([codes & 0xffff, codes >> 16]) {
                    let value = colours.min + code as f32 * colours.step;
                    *sum += alpha_weight * beta_weight * value;
                }
            }
        }
        sum
    }

    /// Index and factor of an entry.
    pub(crate) fn packed(&self, table: &Packed, entry: u32) -> (u32, f32) {
        let word = self.word(table.offset + entry);
        let code = word >> table.index_bits;
        (word & ((1 << table.index_bits) - 1), table.min + code as f32 * table.step)
    }

    pub(crate) fn word(&self, at: u32) -> u32 {
        self.words()[at as usize]
    }
}
