//! Compares results of `farlight bake` with a reference and prints a table.
//!
//!     cargo run -p farlight_gi_solver --example compare_reference -- job REFERENCE.json IN.json
//!     cargo run -p farlight_cli -- bake SCENE.glb --receivers IN.json --result OUT.json
//!     cargo run -p farlight_gi_solver --example compare_reference -- REFERENCE.json OUT.json
//!
//! The first line writes the reference's points as a receivers file.

mod compare;

use std::{error::Error, fs};

use compare::{Outcome, Reference, Report};
use serde::de::DeserializeOwned;
use serde_json::json;

fn read<T: DeserializeOwned>(path: &str) -> Result<T, Box<dyn Error>> {
    let text = fs::read_to_string(path).map_err(|e| format!("{path}: {e}"))?;
    Ok(serde_json::from_str(&text).map_err(|e| format!("{path}: {e}"))?)
}

fn main() -> Result<(), Box<dyn Error>> {
    let arguments: Vec<String> = std::env::args().skip(1).collect();
    match arguments.iter().map(String::as_str).collect::<Vec<_>>()[..] {
        ["job", reference, job] => {
            let reference: Reference = read(reference)?;
            fs::write(job, points(&reference).to_string()).map_err(|e| format!("{job}: {e}"))?;
        }
        [reference, outcome] => {
            let report = Report::new(&read(reference)?, &read::<Outcome>(outcome)?)?;
            println!("{report}");
        }
        _ => {
            return Err(
                "usage: compare_reference REFERENCE.json OUT.json (or: job REFERENCE.json IN.json)"
                    .into(),
            );
        }
    }
    Ok(())
}

/// The points of a reference as a receivers file.
fn points(reference: &Reference) -> serde_json::Value {
    let surface: Vec<_> = reference
        .surface_samples
        .iter()
        .map(|s| json!({ "position": s.position, "normal": s.normal }))
        .collect();
    let probes: Vec<_> = reference.probes.iter().map(|p| p.position).collect();
    let visibility: Vec<_> = reference
        .visibility
        .iter()
        .map(|v| json!({ "point": v.point, "light": v.light }))
        .collect();
    json!({ "surface": surface, "probes": probes, "visibility": visibility })
}
