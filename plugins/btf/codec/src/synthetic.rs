//! Materials with a formula, to test evaluators and renderers against.

use glam::DVec3;

use crate::colour::video_from_rgb;
use crate::{Btf, BtfError, ColourSpace, Info, References, Samples, Scaled, Tables};

/// Samples over alpha: as many as the format has room for, because there a value is interpolated
/// linearly, and the encoded cosine is steep at the horizon.
const ALPHAS: usize = 1023;
/// Samples over beta, where the interpolation is cubic.
const BETAS: usize = 255;
/// Steps of the chromas between black and the colour.
const COLOURS: usize = 8192;

/// A Lambertian surface: linear(v) = `albedo` times the cosine of the light, whatever the view,
/// on `size` columns and rows.
///
/// Between samples as well as at them, linear light is exact to 0.1 % for a grey, to 0.2 % of the
/// brightest channel for a colour where the light stands at least 2 degrees above the horizon, and
/// to 0.0002 below.
///
/// # Errors
///
/// An albedo outside 0 to 1, or a size that [`Btf::new`] refuses.
pub fn lambert(albedo: [f32; 3], size: [u32; 2]) -> Result<Btf, BtfError> {
    if !albedo.iter().all(|channel| (0.0..=1.0).contains(channel)) {
        return Err(BtfError::Tables(format!("the albedo {albedo:?} is not within 0 to 1")));
    }
    let info = Info {
        name: "lambert".to_owned(),
        source: format!("the formula of a Lambertian surface of albedo {albedo:?}"),
        ..Info::default()
    };
    let texels = (size[0] as usize).saturating_mul(size[1] as usize);
    if texels > 1 << 26 {
        return Err(BtfError::Tables(format!("{} x {} texels are too many", size[0], size[1])));
    }
    Btf::new(info, size[0] as usize, &lambert_tables(albedo, texels))
}

fn lambert_tables(albedo: [f32; 3], texels: usize) -> Tables {
    let albedo = DVec3::from(albedo.map(f64::from));
    // A function of the cosine alone; its mirror image over alpha shares the rows.
    let rows = ALPHAS.div_ceil(2);
    let mut shapes = Vec::with_capacity(rows * BETAS);
    let mut colour_rows = Vec::with_capacity(rows * BETAS);
    let mut sums = Vec::with_capacity(rows);
    for row in 0..rows {
        let mut luminances = Vec::with_capacity(BETAS);
        for beta in 0..BETAS {
            let cosine = from_horizon(row, ALPHAS).sin() * from_horizon(beta, BETAS).sin();
            luminances.push(video(albedo, cosine)[0]);
            // Equal steps of what is seen, not of light.
            colour_rows.push((encode(cosine) * (COLOURS - 1) as f64).round() as u32);
        }
        let sum: f64 = luminances.iter().sum();
        shapes.extend(luminances.iter().map(|luminance| (luminance / sum) as f32));
        sums.push(sum as f32);
    }
    let colours = (0..COLOURS).flat_map(|step| {
        let cosine = decode(step as f64 / (COLOURS - 1) as f64);
        let [_, blue, red] = video(albedo, cosine);
        [blue as f32, red as f32]
    });
    let mirrored = |alpha: usize| alpha.min(ALPHAS - 1 - alpha);
    let alphas: Vec<u32> = (0..ALPHAS).map(|alpha| mirrored(alpha) as u32).collect();
    Tables {
        colour_space: ColourSpace::YCbCr,
        beta_uniform_in_sine: false,
        texels: constant(1, texels),
        azimuths: constant(1, 1),
        elevations: constant(2, 2),
        slices: References { columns: 2, index: vec![0, 0] },
        luminances: Scaled {
            columns: ALPHAS,
            index: alphas.clone(),
            scale: (0..ALPHAS).map(|alpha| sums[mirrored(alpha)]).collect(),
            range: None,
        },
        shapes: Samples { columns: BETAS, value: shapes, range: None },
        chromas: References { columns: ALPHAS, index: alphas },
        colour_rows: References { columns: BETAS, index: colour_rows },
        colours: Samples { columns: 2, value: colours.collect(), range: None },
    }
}

/// `entries` entries that all lead to row 0.
fn constant(columns: usize, entries: usize) -> Scaled {
    Scaled { columns, index: vec![0; entries], scale: vec![1.0; entries], range: None }
}

/// Angle from -90 degrees, of a sample in the lower half; exact at the end.
fn from_horizon(sample: usize, count: usize) -> f64 {
    sample as f64 * std::f64::consts::PI / (count - 1) as f64
}

fn video(albedo: DVec3, cosine: f64) -> [f64; 3] {
    video_from_rgb((255.0 * (albedo * cosine.max(0.0)).map(encode)).into())
}

fn encode(value: f64) -> f64 {
    if value <= 0.003_130_8 { 12.92 * value } else { 1.055 * value.powf(1.0 / 2.4) - 0.055 }
}

fn decode(value: f64) -> f64 {
    if value <= 0.04045 { value / 12.92 } else { ((value + 0.055) / 1.055).powf(2.4) }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::{Angles, Rules, linear};

    /// Everywhere on the hemisphere, with the error that its documentation promises.
    #[test]
    fn lambert_is_the_cosine_between_samples_too() {
        for (albedo, limit) in [([1.0, 1.0, 1.0], 1e-3), ([0.8, 0.35, 0.05], 2e-3)] {
            let btf = lambert(albedo, [3, 2]).unwrap();
            let (mut relative, mut absolute) = (0.0_f64, 0.0_f64);
            for step in 0..40_000_u32 {
                // Golden ratio in azimuth, equal steps of the elevation.
                let theta_i = 90.0 * (f64::from(step) + 0.5) / 40_000.0;
                let phi_i = f64::from(step) * 222.492_235_949_9;
                let [phi_v, theta_v] = [f64::from(step) * 1.7, f64::from(step % 91)];
                let angles = Angles::from_degrees(theta_i, phi_i, theta_v, phi_v);
                let value = btf.evaluate(step as i32, 0, angles, Rules::SHADING);
                for channel in 0..3 {
                    let found = f64::from(linear(value[channel] / 255.0));
                    let expected = f64::from(albedo[channel]) * theta_i.to_radians().cos();
                    let error = (found - expected).abs();
                    if theta_i <= 88.0 {
                        // Red is the brightest.
                        let brightest = expected / f64::from(albedo[channel] / albedo[0]);
                        relative = relative.max(error / brightest);
                    } else {
                        absolute = absolute.max(error);
                    }
                }
            }
            println!("{albedo:?}: {relative:.6} of the value, {absolute:.6} at the horizon");
            assert!(relative < limit && absolute < 2e-4, "{relative} {absolute}");
        }
    }

    #[test]
    fn an_impossible_albedo_or_size_is_an_error() {
        assert!(lambert([1.1, 0.0, 0.0], [1, 1]).is_err());
        assert!(lambert([f32::NAN; 3], [1, 1]).is_err());
        assert!(lambert([0.5; 3], [0, 4]).is_err());
        assert!(lambert([0.5; 3], [u32::MAX; 2]).is_err());
    }
}
