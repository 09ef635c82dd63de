//! Takes noise out of gathered light.
//!
//! Adaptive weights smoothing with local polynomials (Polzehl and Spokoiny 2006, "Propagation-separation
//! approach for local likelihood estimation"), guided as denoisers of path tracers are. Around every
//! texel a polynomial in the coordinates of its tangent plane is fitted to its neighbours' irradiance, over
//! neighbourhoods that grow from 1.5 to 12 texels. A neighbour counts as long as what is known from the
//! last, smaller neighbourhoods differs by no more than the noise explains. So contact shadows,
//! where neighbours differ significantly, are left alone, and the filter fades away as noise does.
//!
//! Noise is known from the two halves of the rays, as in Rousselle et al. 2012, "Adaptive Rendering with
//! Non-Local Means Filtering": their difference gives the variance, and the weights for one half come
//! from the other, so that they don't prefer values for their noise. The polynomials are those of
//! Bitterli et al. 2016, "Nonlinearly Weighted First-order Regression for Denoising Monte Carlo Renderings", with
//! one degree more: irradiance is smooth over a surface, and planes through its bumps take 1 to 2 %
//! of the light from coarse lightmaps. At the end, where smoothed and raw light differ by more than
//! noise explains, the raw one comes back.
//!
//! Neighbours are found in the world, not on the page: texels on both sides of a chart's border help each
//! other where the surface goes on smoothly, so that the border doesn't show; charts that are next to
//! each other on a page alone never mix, nor do floors of two rooms through the wall between them (`surface`).
//!
//! Measured with full path tracing against 8192 rays (doorway: 4096), relative errors of open texels:
//! median (with the noise of the reference, up to 1 %; 2.5 % in the hotel), and root mean square (without). Gain is the square of the
//! ratio of the latter: so many times more rays would have done the same.
//!
//! | scene, texels a metre | rays | before | after | gain |
//! |---|---|---|---|---|
//! | TwoRooms, 7 | 64 | 11.5 %, 31.7 % | 2.4 %, 8.1 % | 16 |
//! | | 256 | 5.5 %, 18.8 % | 1.6 %, 5.0 % | 14 |
//! | | 1024 | 3.0 %, 9.4 % | 1.3 %, 2.7 % | 12 |
//! | Cornell box, 7 | 64 | 8.2 %, 14.3 % | 1.7 %, 3.4 % | 18 |
//! | | 256 | 4.2 %, 6.8 % | 1.3 %, 2.3 % | 9 |
//! | | 1024 | 2.0 %, 3.3 % | 0.9 %, 1.7 % | 4 |
//! | doorway, 21 | 64 | 13.6 %, 33.2 % | 3.0 %, 10.2 % | 11 |
//! | | 256 | 6.8 %, 20.5 % | 2.0 %, 6.2 % | 11 |
//! | furniture of a hotel room, 33 | 64 | 25.1 %, 38.7 % | 5.1 %, 15.9 % | 6 |
//! | | 256 | 14.1 %, 23.4 % | 3.7 %, 11.3 % | 4 |

mod cells;
mod fit;
mod noise;
mod smooth;
mod surface;

#[cfg(test)]
mod tests;

use glam::Vec3;

use super::{Gathered, Layout, LayoutTexel};
use surface::Surface;

/// Values of all texels from the two halves of the rays.
type Halves = [Vec<Vec3>; 2];

/// The irradiance of all texels with less noise. Texels that are not open, or not finite, keep what they
/// have and give nothing.
///
/// Adaptive smoothing along surfaces by local polynomials (Polzehl and Spokoiny 2006), guided by the two
/// halves of the rays (Rousselle et al. 2012): neighbours mix as long as they differ by no more than
/// the noise explains. Equal inputs give equal results on any number of threads. With 64 rays it does
/// what 6 to 18 times as many rays would; about 45 µs a texel on one core.
#[must_use]
pub fn denoise(layout: &Layout, gathered: &Gathered) -> Vec<Vec3> {
    let texels: Vec<LayoutTexel> = layout.texels().collect();
    let share = 2.0 / gathered.rays.max(1) as f32;
    let halves = [0, 1].map(|h| gathered.halves[h].iter().map(|sum| *sum * share).collect());
    filter(&texels, 1.0 / layout.texels_per_metre, halves)
}

/// As [`denoise`], for texels with edges of about `spacing` metres and the means of both halves.
fn filter(texels: &[LayoutTexel], spacing: f32, mut halves: Halves) -> Vec<Vec3> {
    let mut out = means(&halves);
    let usable: Vec<bool> = texels
        .iter()
        .zip(&out)
        .map(|(t, o)| {
            t.open && [*o, t.position, t.normal, t.geometric].iter().all(|v| v.is_finite())
        })
        .collect();
    // Squares must not overflow, nor what isn't used be counted.
    let brightest = (0..texels.len())
        .filter(|&i| usable[i])
        .map(|i| halves[0][i].abs().max_element().max(halves[1][i].abs().max_element()))
        .fold(0.0, f32::max);
    if !(brightest > 0.0 && brightest.is_finite() && spacing > 0.0 && spacing.is_finite()) {
        return out;
    }
    for half in &mut halves {
        for (value, usable) in half.iter_mut().zip(&usable) {
            *value = if *usable { *value / brightest } else { Vec3::ZERO };
        }
    }
    let surface = Surface::new(texels, usable, spacing);
    noise::clamp_outliers(&surface, &mut halves);
    let variance = noise::variance(&surface, &halves);
    let mut smooth = means(&smooth::smooth(&surface, &halves, &variance));
    noise::restore(&surface, &means(&halves), &mut smooth, &variance);
    for i in (0..out.len()).filter(|&i| surface.is_usable(i)) {
        // Parabolas may swing below the darkness of a corner.
        out[i] = (smooth[i] * brightest).max(Vec3::ZERO);
    }
    out
}

fn means(halves: &Halves) -> Vec<Vec3> {
    halves[0].iter().zip(&halves[1]).map(|(a, b)| (*a + *b) * 0.5).collect()
}
