//! A grey day: a closed layer of cloud, brightest overhead, over the same meadow.

use super::{
    PIXEL,
    landscape::{self, Daylight},
    noise::octaves,
};
use crate::assets::part::{P, scale};

/// Radiance overhead.
const ZENITH: P = [1.06, 1.10, 1.16];

/// Gives back what these clouds take from the standard sky's light on level ground.
const BALANCE: f64 = 0.012;

pub(super) fn radiance(d: P) -> P {
    let up = d[1].max(0.0);
    // The CIE's standard overcast sky, ISO 15469:2004 type 1 in its first form (Moon and Spencer
    // 1942): three times as bright overhead as at the horizon.
    let mut sky = scale(ZENITH, (1.0 + 2.0 * up) / 3.0);
    let bend = up + 0.14;
    let at = [d[0] / bend, d[2] / bend];
    let footprint = PIXEL / (bend * bend);
    let layers = octaves([at[0] * 0.8 + 2.0, at[1] * 0.5], 0.8 * footprint);
    let folds = octaves([at[0] * 1.7 + layers, at[1] * 1.3 + 8.0], 1.7 * footprint);
    // Thick parts are darker and a little bluer.
    let thick = BALANCE + 0.34 * layers + 0.22 * folds;
    sky = [0, 1, 2].map(|k| sky[k] * (1.0 + thick - [-0.06, 0.0, 0.05][k] * thick));
    let daylight = Daylight {
        sun: [0.0, 1.0, 0.0],
        sunlight: [0.0; 3],
        // Of this sky on level ground: 7 / 9 of the zenith's radiance times pi.
        skylight: scale(ZENITH, 7.0 / 9.0),
        haze: scale(ZENITH, 0.34),
    };
    landscape::before(sky, d, &daylight)
}

#[cfg(test)]
mod tests {
    use std::f64::consts::PI;

    use super::*;

    /// The clouds take nothing from the sum: within 1 % of the closed form.
    #[test]
    fn level_ground_gets_the_standard_skys_irradiance() {
        let (rows, columns) = (64, 256);
        let mut sum = [0.0; 3];
        for i in 0..rows * columns {
            // Equal parts of the disc that the hemisphere is projected to.
            let square = (f64::from(i / columns) + 0.5) / f64::from(rows);
            let turn = 2.0 * PI * (f64::from(i % columns) + 0.5) / f64::from(columns);
            let (r, up) = (square.sqrt(), (1.0 - square).sqrt());
            // Trees and hills stand in front of the lowest part.
            if up > 0.12 {
                let l = radiance([r * turn.cos(), up, r * turn.sin()]);
                sum = [0, 1, 2].map(|k| sum[k] + l[k] / f64::from(rows * columns));
            }
        }
        // The same of the standard sky above 0.12: 1/3 (1 + 2 y) times 2 y dy from there to 1.
        let low: f64 = 0.12;
        let share = (1.0 - low * low + 4.0 / 3.0 * (1.0 - low.powi(3))) / 3.0;
        for (sum, zenith) in sum.into_iter().zip(ZENITH) {
            assert!((sum / (zenith * share) - 1.0).abs() < 0.01, "{sum} of {}", zenith * share);
        }
    }
}
