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
    /// Entries that the file held wrongly and that were put right when it was read.
    pub repairs: Vec<Repair>,
    /// Other things about the source that whoever uses the material should know, one a line.
    pub remarks: Vec<String>,
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
