//! Directions of light drawn about in proportion to what they contribute.
//!
//! In the angles of the tables the hemisphere is flat: dw = cos(beta) dalpha dbeta = dalpha dsin(beta),
//! so a density over (alpha, sin beta) is one per solid angle. It is taken bilinear between the
//! tables' samples, from the luminance there, and drawn exactly: first alpha from the marginal, then
//! sin beta under that alpha (Pharr, Jakob and Humphreys, *Physically Based Rendering*, 4th edition,
//! section A.5, for piecewise linear densities).

use std::f32::consts::{FRAC_PI_2, PI};

use glam::{Vec2, Vec3};

use crate::{Btf, Layout, SliceAngles, ViewSlices};

/// More nodes an axis than this are thinned out.
const MOST_NODES: u32 = 32;

/// Part of the mean density that every direction has at least: the values between the samples, and
/// their colour, are not known here, and must not be left out.
const FLOOR: f32 = 0.1;

/// The surface's frame turned round the normal, so that it stands on the view: the axes of
/// [`SliceAngles::from_vector`].
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct ViewFrame {
    /// Unit azimuth of the view.
    azimuth: Vec2,
}

impl ViewFrame {
    /// Of a view's unit vector in the frame of the surface; straight from above, of azimuth 0.
    pub fn new(view: Vec3) -> Self {
        Self { azimuth: view.truncate().try_normalize().unwrap_or(Vec2::X) }
    }

    /// The view's azimuth in radians.
    pub fn phi(&self) -> f32 {
        self.azimuth.y.atan2(self.azimuth.x)
    }

    /// Angles in the tables of a light's unit vector in the frame of the surface.
    pub fn slice_angles(&self, light: Vec3) -> SliceAngles {
        let along = self.azimuth.dot(light.truncate());
        let left = self.azimuth.perp_dot(light.truncate());
        SliceAngles::from_vector(-left, -along, light.z, false)
    }

    /// The unit vector of a light in the frame of the surface.
    pub fn direction(&self, angles: SliceAngles) -> Vec3 {
        let v = angles.to_vector();
        let (along, left) = (-v.y, -v.x);
        (self.azimuth * along + self.azimuth.perp() * left).extend(v.z)
    }
}

/// A density of the light's direction for one texel and view, per solid angle over the hemisphere.
#[derive(Clone, Debug)]
pub struct LightSampler {
    /// Angles, ascending from -pi/2 to pi/2.
    alphas: Vec<f32>,
    /// Sines of beta, ascending from -1 to 1.
    sines: Vec<f32>,
    /// Density at each (alpha, sine), alpha by alpha.
    density: Vec<f32>,
    /// Integral of each alpha's densities over the sine.
    marginal: Vec<f32>,
}

/// A direction of light that was drawn.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct LightSample {
    /// Where it is, in the frame of the view.
    pub light: SliceAngles,
    /// With what density per solid angle it was drawn.
    pub pdf: f32,
}

impl LightSampler {
    /// For what a texel shows one view.
    pub fn new(btf: &Btf, slices: &ViewSlices) -> Self {
        let layout = btf.layout();
        let alpha_nodes = nodes(layout.alpha_count);
        let beta_nodes = nodes(layout.beta_count);
        let alphas = (alpha_nodes.iter())
            .map(|node| PI * *node as f32 / (layout.alpha_count - 1) as f32 - FRAC_PI_2)
            .collect();
        let sine = |node: u32| {
            let part = node as f32 / (layout.beta_count - 1) as f32;
            if layout.flags & Layout::BETA_IN_SINE != 0 {
                2.0 * part - 1.0
            } else {
                (PI * part - FRAC_PI_2).sin()
            }
        };
        let sines = beta_nodes.iter().map(|node| sine(*node)).collect();
        let density = btf.brightness(slices, &alpha_nodes, &beta_nodes);
        Self::from_density(alphas, sines, density)
    }

    fn from_density(alphas: Vec<f32>, sines: Vec<f32>, mut density: Vec<f32>) -> Self {
        let marginal = |density: &[f32]| -> Vec<f32> {
            density.chunks_exact(sines.len()).map(|row| trapezium(&sines, row)).collect()
        };
        let total = trapezium(&alphas, &marginal(&density));
        // The hemisphere has 2 pi. Where everything is black, any direction will do.
        let floor = if total > 0.0 { FLOOR * total / (2.0 * PI) } else { 1.0 };
        for density in &mut density {
            *density = density.max(floor);
        }
        let total = trapezium(&alphas, &marginal(&density));
        for density in &mut density {
            *density /= total;
        }
        let marginal = marginal(&density);
        Self { alphas, sines, density, marginal }
    }

    /// A direction for a point of the unit square, and its density.
    pub fn sample(&self, u: [f32; 2]) -> LightSample {
        let (row, t) = draw(&self.alphas, |at| self.marginal[at], u[0]);
        let alpha = mix(self.alphas[row], self.alphas[row + 1], t);
        let density = |at: usize| mix(self.at(row, at), self.at(row + 1, at), t);
        let (column, s) = draw(&self.sines, density, u[1]);
        let sin_beta = mix(self.sines[column], self.sines[column + 1], s).clamp(-1.0, 1.0);
        let light = SliceAngles { beta: sin_beta.asin(), sin_beta, alpha };
        LightSample { light, pdf: mix(density(column), density(column + 1), s) }
    }

    /// The density per solid angle with which [`LightSampler::sample`] draws a direction.
    pub fn pdf(&self, light: SliceAngles) -> f32 {
        let (row, t) = find(&self.alphas, light.alpha);
        let (column, s) = find(&self.sines, light.sin_beta);
        let density = |row: usize| mix(self.at(row, column), self.at(row, column + 1), s);
        mix(density(row), density(row + 1), t)
    }

    fn at(&self, row: usize, column: usize) -> f32 {
        self.density[row * self.sines.len() + column]
    }
}

impl Btf {
    /// About the luminance, in linear light, at some samples of alpha and beta, alpha by alpha.
    fn brightness(&self, slices: &ViewSlices, alphas: &[u32], betas: &[u32]) -> Vec<f32> {
        let layout = self.layout();
        let space = self.colour_space();
        let neutral = space.neutral();
        let mut sums = vec![0.0; alphas.len() * betas.len()];
        for (row, weight) in slices.luminances.into_iter().zip(slices.weights) {
            for (alpha, sums) in alphas.iter().zip(sums.chunks_exact_mut(betas.len())) {
                let entry = row * layout.alpha_count + alpha;
                let (shape, scale) = self.packed(&layout.luminances, entry);
                for (beta, sum) in betas.iter().zip(sums) {
                    let luma = scale * self.shape_sample(shape, *beta);
                    *sum += weight * space.decode(luma, neutral, true).y;
                }
            }
        }
        if layout.flags & Layout::LOG_LUV == 0 {
            // The square is close enough to the decoding of sRGB, and quicker.
            for sum in &mut sums {
                *sum *= *sum;
            }
        }
        sums
    }
}

/// Up to [`MOST_NODES`] of `count` samples, the first and the last among them.
fn nodes(count: u32) -> Vec<u32> {
    let last = count - 1;
    let steps = last.min(MOST_NODES - 1);
    (0..=steps).map(|step| step * last / steps).collect()
}

/// Integral of a piecewise linear function.
fn trapezium(at: &[f32], value: &[f32]) -> f32 {
    at.windows(2).zip(value.windows(2)).map(|(x, y)| (x[1] - x[0]) * 0.5 * (y[0] + y[1])).sum()
}

fn mix(from: f32, to: f32, part: f32) -> f32 {
    from + (to - from) * part
}

/// The interval of `at` that holds a value, and where in it, 0 to 1.
fn find(at: &[f32], value: f32) -> (usize, f32) {
    let interval = at.partition_point(|start| *start <= value).clamp(1, at.len() - 1) - 1;
    let (from, to) = (at[interval], at[interval + 1]);
    (interval, ((value - from) / (to - from)).clamp(0.0, 1.0))
}

/// Inverts the integral of a piecewise linear density at a part `u` of the whole: the interval, and
/// where in it, 0 to 1.
fn draw(at: &[f32], density: impl Fn(usize) -> f32, u: f32) -> (usize, f32) {
    let area = |interval: usize| {
        (at[interval + 1] - at[interval]) * 0.5 * (density(interval) + density(interval + 1))
    };
    let last = at.len() - 2;
    let total: f32 = (0..=last).map(area).sum();
    let mut rest = u * total;
    let mut interval = 0;
    while interval < last && rest >= area(interval) {
        rest -= area(interval);
        interval += 1;
    }
    let part = (rest / area(interval)).clamp(0.0, 1.0);
    let (from, to) = (density(interval), density(interval + 1));
    // The root of from t + (to - from) t^2 / 2 = part (from + to) / 2, in the stable form.
    let root = mix(from * from, to * to, part).sqrt();
    (interval, (part * (from + to) / (from + root)).clamp(0.0, 1.0))
}
