//! What both benchmarks of materials share: options, the materials, queries.

use std::path::{Path, PathBuf};

use farlight_btf_codec::{Angles, Btf, BtfError, Query, read};
use serde::Serialize;

/// The command line.
pub(crate) struct Options {
    pub(crate) materials: Vec<PathBuf>,
    /// How often everything is timed.
    pub(crate) rounds: usize,
    /// Whether the shortest time counts, not the median.
    pub(crate) fastest: bool,
    /// Queries in a run.
    pub(crate) count: usize,
    json: Option<PathBuf>,
}

impl Options {
    /// From the arguments of this process, with `count` queries where they name no number.
    pub(crate) fn from_args(count: usize) -> Result<Self, String> {
        let mut options =
            Self { materials: Vec::new(), rounds: 9, fastest: false, count, json: None };
        let mut args = std::env::args().skip(1);
        while let Some(arg) = args.next() {
            let mut value = || args.next().ok_or(format!("{arg} needs a value"));
            let number = |text: String| {
                text.parse::<usize>()
                    .ok()
                    .filter(|number| *number > 0)
                    .ok_or(format!("{text} is no number above 0"))
            };
            match arg.as_str() {
                "--bench" => {} // cargo's own
                "--rounds" => options.rounds = number(value()?)?,
                "--count" => options.count = number(value()?)?,
                "--fastest" => options.fastest = true,
                "--json" => options.json = Some(value()?.into()),
                _ if arg.starts_with('-') => return Err(format!("unknown argument {arg}")),
                _ => options.materials.push(arg.into()),
            }
        }
        if options.materials.is_empty() {
            options.materials = found();
        }
        Ok(options)
    }

    /// The materials that can be read; others are named.
    pub(crate) fn open(&self) -> impl Iterator<Item = Btf> {
        self.materials.iter().filter_map(|path| {
            open(path).map_err(|error| println!("{} SKIPPED: {error}", path.display())).ok()
        })
    }

    /// The time that counts.
    pub(crate) fn chosen(&self, times: &mut [f64]) -> f64 {
        times.sort_by(f64::total_cmp);
        times[if self.fastest { 0 } else { times.len() / 2 }]
    }

    /// Writes what was asked for.
    pub(crate) fn write(&self, rows: &impl Serialize) -> Result<(), String> {
        let Some(path) = &self.json else { return Ok(()) };
        let text = serde_json::to_string_pretty(rows).map_err(|error| error.to_string())?;
        std::fs::write(path, text).map_err(|error| format!("{}: {error}", path.display()))
    }
}

/// Measured materials and those of the suite.
fn found() -> Vec<PathBuf> {
    let mut folders = vec![Path::new(env!("CARGO_MANIFEST_DIR")).join("../../../assets/materials")];
    match std::env::var_os("FARLIGHT_TEST_DATA") {
        Some(data) => folders.push(PathBuf::from(data).join("btfbase")),
        None => println!("measured materials SKIPPED: FARLIGHT_TEST_DATA is not set"),
    }
    let mut found: Vec<PathBuf> = (folders.iter())
        .filter_map(|folder| std::fs::read_dir(folder).ok())
        .flat_map(|entries| entries.flatten().map(|entry| entry.path()))
        .filter(|path| path.is_dir() || path.extension().is_some_and(|e| e == "fbtf"))
        .collect();
    found.sort();
    found
}

fn open(path: &Path) -> Result<Btf, BtfError> {
    match read::open(path, &read::Options::default())? {
        read::Material::Tables(btf) => Ok(btf),
        read::Material::Images(_) => Err(BtfError::Unsupported("pictures, not tables".to_owned())),
    }
}

/// Random texels, both directions uniform over their hemispheres.
pub(crate) fn random(size: [u32; 2], count: usize) -> Vec<Query> {
    let mut state = 1_u64;
    // SplitMix64.
    let mut number = || {
        state = state.wrapping_add(0x9e37_79b9_7f4a_7c15);
        let z = (state ^ (state >> 30)).wrapping_mul(0xbf58_476d_1ce4_e5b9);
        let z = (z ^ (z >> 27)).wrapping_mul(0x94d0_49bb_1331_11eb);
        ((z ^ (z >> 31)) >> 40) as f32 / (1 << 24) as f32
    };
    (0..count)
        .map(|_| Query {
            x: (number() * size[0] as f32) as i32,
            y: (number() * size[1] as f32) as i32,
            angles: Angles {
                theta_i: number().acos(),
                phi_i: number() * std::f32::consts::TAU,
                theta_v: number().acos(),
                phi_v: number() * std::f32::consts::TAU,
            },
        })
        .collect()
}

/// Texel after texel, row after row, from the same directions.
pub(crate) fn raster(size: [u32; 2], count: usize) -> Vec<Query> {
    let angles = Angles::from_degrees(40.0, 70.0, 25.0, 200.0);
    (0..count as u32)
        .map(|at| Query { x: (at % size[0]) as i32, y: (at / size[0] % size[1]) as i32, angles })
        .collect()
}
