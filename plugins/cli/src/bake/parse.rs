//! Values of options.

use std::time::Duration;

use farlight_baker::Emission;
use glam::Vec3;

/// Three numbers with commas, finite and not negative.
pub(super) fn rgb(text: &str) -> Result<Vec3, String> {
    let numbers: Vec<f32> = text
        .split(',')
        .map(|t| t.trim().parse().map_err(|_| format!("{t:?} is not a number")))
        .collect::<Result<_, _>>()?;
    let [r, g, b] = numbers[..] else {
        return Err(format!("{} numbers, must be three: R,G,B", numbers.len()));
    };
    let rgb = Vec3::new(r, g, b);
    if rgb.is_finite() && rgb.min_element() >= 0.0 {
        Ok(rgb)
    } else {
        Err("must be finite and not negative".to_owned())
    }
}

/// A finite number above 0.
pub(super) fn scale(text: &str) -> Result<f32, String> {
    let scale: f32 = text.parse().map_err(|_| "not a number".to_owned())?;
    if scale.is_finite() && scale > 0.0 {
        Ok(scale)
    } else {
        Err("must be finite and above 0".to_owned())
    }
}

/// Seconds, at most a year.
pub(super) fn seconds(text: &str) -> Result<f64, String> {
    let seconds: f64 = text.parse().map_err(|_| "not a number".to_owned())?;
    if seconds > 0.0 && seconds <= 3.2e7 {
        Ok(seconds)
    } else {
        Err("must be above 0, and at most a year".to_owned())
    }
}

/// Seconds that [`seconds`] accepted.
pub(super) fn duration(seconds: f64) -> Duration {
    Duration::try_from_secs_f64(seconds).unwrap_or_default()
}

/// An EV100, or `nits`.
pub(super) fn emission(text: &str) -> Result<Emission, String> {
    match text.parse::<f32>() {
        _ if text == "nits" => Ok(Emission::Nits),
        Ok(ev100) if (-10.0..=30.0).contains(&ev100) => Ok(Emission::Exposure(ev100)),
        _ => Err("must be an EV100 from -10 to 30, or nits".to_owned()),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn colours() {
        assert_eq!(rgb("1, 2.5,0"), Ok(Vec3::new(1.0, 2.5, 0.0)));
        for bad in ["1,2", "1,2,3,4", "1,x,2", "1,-1,2", "1,inf,2", "1,NaN,2", ""] {
            assert!(rgb(bad).is_err(), "{bad}");
        }
    }

    #[test]
    fn scales() {
        assert_eq!(scale("0.001"), Ok(0.001));
        for bad in ["0", "-1", "inf", "NaN", "m"] {
            assert!(scale(bad).is_err(), "{bad}");
        }
    }

    #[test]
    fn times_and_exposures() {
        assert_eq!(seconds("0.5"), Ok(0.5));
        for bad in ["0", "-1", "inf", "NaN", "1e9", "x"] {
            assert!(seconds(bad).is_err(), "{bad}");
        }
        assert_eq!(emission("nits"), Ok(Emission::Nits));
        assert_eq!(emission("12"), Ok(Emission::Exposure(12.0)));
        for bad in ["", "NaN", "99", "cd"] {
            assert!(emission(bad).is_err(), "{bad}");
        }
    }
}
