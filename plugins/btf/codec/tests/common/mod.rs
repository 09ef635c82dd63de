//! Small materials in every form, for several tests.
#![allow(dead_code, clippy::allow_attributes, reason = "each test uses a part")]

pub(crate) mod base;

use farlight_btf_codec::{
    Btf, Certainty, ColourSpace, Info, References, Repair, Samples, Scaled, Tables,
};

/// A small material with different numbers everywhere.
pub(crate) fn small() -> Btf {
    let scaled = |columns: usize, rows: usize, below: u32, near: f32| {
        let count = columns * rows;
        Scaled {
            columns,
            index: (0..count as u32).map(|at| at * 7 % below).collect(),
            scale: (0..count).map(|at| near + 0.3 * (at as f32).sin()).collect(),
            range: None,
        }
    };
    let references = |columns: usize, rows: usize, below: u32| References {
        columns,
        index: (0..(columns * rows) as u32).map(|at| at * 5 % below).collect(),
    };
    let samples = |columns: usize, rows: usize, near: f32| Samples {
        columns,
        value: (0..columns * rows).map(|at| near * (1.0 + 0.2 * (at as f32).cos())).collect(),
        range: None,
    };
    let tables = Tables {
        colour_space: ColourSpace::YCbCr,
        beta_uniform_in_sine: true,
        texels: scaled(3, 2, 2, 1.0),
        azimuths: scaled(4, 2, 3, 1.0),
        elevations: scaled(3, 3, 4, 1.0),
        slices: references(2, 4, 3),
        luminances: scaled(5, 3, 6, 700.0),
        shapes: samples(5, 6, 0.2),
        chromas: references(5, 3, 2),
        colour_rows: references(5, 2, 4),
        colours: samples(2, 4, 128.0),
    };
    let info = Info {
        name: "small \"cloth\"".to_owned(),
        source: "a test".to_owned(),
        size: Some([0.1, 0.2]),
        measured: Some([81, 80]),
        light_limit: Some(75.0),
        repairs: vec![Repair {
            table: "PDF1D".to_owned(),
            row: 3,
            column: 4,
            from: 0.1,
            to: 0.3,
            certainty: Certainty::Certain,
        }],
        remarks: vec!["made up".to_owned()],
    };
    Btf::new(info, 3, &tables).unwrap()
}
