//! How much of the light a material gives back.

use std::f32::consts::{FRAC_PI_2, PI};

use glam::{DVec3, Vec3};
use rayon::prelude::*;

use crate::{Btf, ColourSpace, Layout, Rules, SliceAngles, ViewSlices, linear};

/// Part of the light from everywhere that goes towards a view.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Albedo {
    /// Red, green and blue, in linear light.
    pub value: Vec3,
    /// How far off a channel may be: of the quadrature for one texel; together with the standard error
    /// (one sigma) of the choice of texels for a mean.
    pub error: f32,
}

impl Albedo {
    /// Whether no more light leaves than arrives, within the error.
    pub fn conserves_energy(&self) -> bool {
        self.value.max_element() <= 1.0 + self.error
    }
}

/// Panels over an axis: as many as it has intervals, but not more than this.
const MOST_PANELS: u32 = 48;

/// Points and weights of Gauss and Legendre on 0 to 1.
const THREE: [(f32, f32); 3] =
    [(0.112_701_67, 0.277_777_8), (0.5, 0.444_444_45), (0.887_298_35, 0.277_777_8)];
const FOUR: [(f32, f32); 4] = [
    (0.069_431_84, 0.173_927_42),
    (0.330_009_47, 0.326_072_57),
    (0.669_990_5, 0.326_072_57),
    (0.930_568_16, 0.173_927_42),
];

/// Lights with their weights: solid angle over pi.
struct Quadrature {
    lights: Vec<SliceAngles>,
    weights: Vec<f32>,
}

impl Quadrature {
    /// Of a rule in each panel between the samples, where the values are smooth.
    fn new(layout: &Layout, rule: &[(f32, f32)]) -> Self {
        let axis = |count: u32, angle: &dyn Fn(f32) -> f32| -> Vec<(f32, f32)> {
            let last = count - 1;
            let panels = last.min(MOST_PANELS);
            (0..panels)
                .flat_map(|panel| {
                    let edge = |panel: u32| angle((panel * last / panels) as f32 / last as f32);
                    let (from, to) = (edge(panel), edge(panel + 1));
                    rule.iter()
                        .map(move |(at, weight)| (from + (to - from) * at, (to - from) * weight))
                })
                .collect()
        };
        let even = |part: f32| PI * part - FRAC_PI_2;
        let in_sine = |part: f32| (2.0 * part - 1.0).clamp(-1.0, 1.0).asin();
        let alphas = axis(layout.alpha_count, &even);
        let betas = if layout.flags & Layout::BETA_IN_SINE != 0 {
            axis(layout.beta_count, &in_sine)
        } else {
            axis(layout.beta_count, &even)
        };
        let mut this = Self { lights: Vec::new(), weights: Vec::new() };
        for (alpha, alpha_weight) in &alphas {
            for (beta, beta_weight) in &betas {
                let (sin_beta, cos_beta) = beta.sin_cos();
                this.lights.push(SliceAngles { beta: *beta, sin_beta, alpha: *alpha });
                this.weights.push(alpha_weight * beta_weight * cos_beta / PI);
            }
        }
        this
    }

    fn integrate(&self, btf: &Btf, slices: &ViewSlices, values: &mut Vec<Vec3>) -> DVec3 {
        values.resize(self.lights.len(), Vec3::ZERO);
        btf.evaluate_lights(slices, &self.lights, Rules::SHADING, values);
        let space = btf.colour_space();
        let terms = values.iter().zip(&self.weights);
        terms.map(|(value, weight)| (space.to_linear(*value) * *weight).as_dvec3()).sum()
    }
}

impl Btf {
    /// The directional albedo of a texel for a view: the integral of linear(v) / pi over the light's
    /// hemisphere (the values contain the light's cosine already), by Gauss's rule between the tables'
    /// samples. The error is the difference to the rule of one point less an axis.
    pub fn albedo(&self, x: i32, y: i32, theta_v: f32, phi_v: f32) -> Albedo {
        let slices = self.view_slices(x, y, theta_v, phi_v);
        let mut values = Vec::new();
        let [fine, coarse] = [&FOUR[..], &THREE[..]]
            .map(|rule| Quadrature::new(self.layout(), rule).integrate(self, &slices, &mut values));
        let error = (fine - coarse).abs().max_element() as f32;
        Albedo { value: fine.as_vec3(), error }
    }

    /// The mean over all texels, from at most `texels` of them that lie evenly scattered.
    pub fn mean_albedo(&self, theta_v: f32, phi_v: f32, texels: u32) -> Albedo {
        let [width, height] = self.size();
        let count = texels.clamp(1, (width * height).max(1));
        let all = count == width * height;
        let [fine, coarse] =
            [&FOUR[..], &THREE[..]].map(|rule| Quadrature::new(self.layout(), rule));
        let texel = |at: u32| {
            if all {
                return [at % width, at / width];
            }
            // Roberts's R2 sequence (2018): the plastic number's powers.
            let part = |step: f64, size: u32| {
                ((0.5 + f64::from(at) * step).fract() * f64::from(size)) as u32
            };
            [part(0.754_877_666_246_692_7, width), part(0.569_840_290_998_053_3, height)]
        };
        let sums = (0..count)
            .into_par_iter()
            .map_init(Vec::new, |values, at| {
                let [x, y] = texel(at);
                let slices = self.view_slices(x as i32, y as i32, theta_v, phi_v);
                let value = fine.integrate(self, &slices, values);
                let other = coarse.integrate(self, &slices, values);
                [value, value * value, (value - other).abs()]
            })
            .collect::<Vec<_>>()
            .into_iter()
            .fold([DVec3::ZERO; 3], |a, b| [a[0] + b[0], a[1] + b[1], a[2] + b[2]]);
        let [mean, square, quadrature] = sums.map(|sum| sum / f64::from(count));
        let variance = (square - mean * mean).max(DVec3::ZERO).max_element();
        let standard = if all { 0.0 } else { (variance / f64::from(count)).sqrt() };
        let error = (quadrature.max_element() + standard) as f32;
        Albedo { value: mean.as_vec3(), error }
    }
}

impl ColourSpace {
    /// Linear light of a value made by [`Rules::SHADING`]: 1 is what a white Lambertian surface shows
    /// under a light that stands straight above it.
    pub fn to_linear(self, value: Vec3) -> Vec3 {
        match self {
            Self::YCbCr => (value * (1.0 / 255.0)).map(linear),
            Self::LogLuv { .. } => value,
        }
    }

    /// Chroma of a grey.
    pub(crate) fn neutral(self) -> [f32; 2] {
        match self {
            Self::YCbCr => [128.0; 2],
            // u' and v' of D65.
            Self::LogLuv { .. } => [410.0 * 0.197_83, 410.0 * 0.468_32],
        }
    }
}
