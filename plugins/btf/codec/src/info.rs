//! What is known of a material besides its tables.

use serde::{Deserialize, Serialize};

/// What is known of a material besides its tables.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
#[serde(default)]
pub struct Info {
    /// Its name.
    pub name: String,
    /// What it was made from, and how.
    pub source: String,
    /// Width and height of the picture in metres, if known.
    pub size: Option<[f32; 2]>,
    /// Numbers of directions of view and of light that were measured, if known.
    pub measured: Option<[u32; 2]>,
    /// Greatest angle from the normal, in degrees, at which light was measured, if known: what is
    /// beyond is extrapolated. See [`fade_slope`]. Measured pictures have none: what lies beyond their
    /// lowest lights falls with the cosine already.
    pub light_limit: Option<f32>,
    /// Entries that the file held wrongly and that were put right when it was read.
    pub repairs: Vec<Repair>,
    /// Other things about the source that whoever uses the material should know, one a line.
    pub remarks: Vec<String>,
}

/// How light fades out beyond [`Info::light_limit`], for who makes pictures: its share is
/// min(1, slope times the cosine of its angle from the normal), which is 1 up to the limit.
///
/// Without a limit, or with one that is none (not within 0 to 90 degrees), the slope is so great that nothing fades
/// above the horizon.
pub fn fade_slope(light_limit: Option<f32>) -> f32 {
    const NONE: f32 = 1e9;
    match light_limit {
        Some(limit) if (0.0..90.0).contains(&limit) => limit.to_radians().cos().recip().min(NONE),
        _ => NONE,
    }
}

/// An entry of a table that was put right: see [`read::Repairs`](crate::read::Repairs).
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct Repair {
    /// The table, by its name in the BTFbase format.
    pub table: String,
    /// Row of the table, from 0.
    pub row: u32,
    /// Column of the table, from 0.
    pub column: u32,
    /// What the file says.
    pub from: f32,
    /// What it was taken for.
    pub to: f32,
    /// How sure that is.
    pub certainty: Certainty,
}

/// How sure a [`Repair`] is.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord, Serialize, Deserialize)]
pub enum Certainty {
    /// The best of several candidates that the data hardly tells apart.
    Guess,
    /// The data speaks for it, and leaves no second candidate that is nearly as good.
    Likely,
    /// Nothing else is possible, or a sum that is known proves it.
    Certain,
}

impl std::fmt::Display for Repair {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        let Self { table, row, column, from, to, certainty } = self;
        let certainty = match certainty {
            Certainty::Guess => "a guess",
            Certainty::Likely => "likely",
            Certainty::Certain => "certain",
        };
        write!(
            f,
            "{table} row {row} column {column}: {to} instead of {from}, a greatest value that was \
             stored as the least ({certainty})"
        )
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn light_fades_beyond_the_limit_alone() {
        let share = |limit, degrees: f32| (fade_slope(limit) * degrees.to_radians().cos()).min(1.0);
        assert_eq!(share(Some(75.0), 74.9), 1.0);
        assert!((share(Some(60.0), 75.0) - 0.517_638).abs() < 1e-5);
        assert!(share(Some(75.0), 90.0).abs() < 1e-6);
        for none in [None, Some(90.0), Some(f32::NAN), Some(-1.0)] {
            assert_eq!(share(none, 89.99), 1.0, "{none:?}");
        }
    }

    #[test]
    fn descriptions_without_a_limit_are_understood() {
        let info: Info = ron::from_str(r#"(name: "old")"#).unwrap();
        assert_eq!((info.name.as_str(), info.light_limit), ("old", None));
    }
}
