//! `cargo xtask bench reference`: `farlight bake` against references from another renderer.

use std::path::Path;

use crate::{Failure, environment, process};

/// Scenes with a reference, in `reference/` of the test data.
const SCENES: [&str; 2] = ["CornellBox", "TwoRooms"];

/// Bakes the points of both references with `samples` paths each and prints how they compare.
pub(crate) fn run(samples: u32) -> Result<(), Failure> {
    let folder =
        environment::test_data().ok_or_else(environment::test_data_line)?.join("reference");
    let out = environment::target_dir().join("reference");
    std::fs::create_dir_all(&out).map_err(|error| format!("{}: {error}.", out.display()))?;
    for scene in SCENES {
        println!("\n==== {scene}, {samples} paths a receiver and a probe");
        let reference = folder.join(format!("{scene}.reference.json"));
        let job = out.join(format!("{scene}.receivers.json"));
        let result = out.join(format!("{scene}.result.json"));
        compare(&["job".as_ref(), &reference, &job])?;
        let mut bake = process::cargo();
        bake.args(["run", "--release", "--package", "farlight_cli", "--", "bake"]);
        bake.arg(folder.join(format!("{scene}.glb")));
        bake.arg("--receivers").arg(&job).arg("--result").arg(&result);
        bake.args(["--samples", &samples.to_string()]);
        process::run(&mut bake)?;
        compare(&[&reference, &result])?;
    }
    Ok(())
}

/// Runs the example that makes a job of a reference and compares results with it.
fn compare(arguments: &[&Path]) -> Result<(), Failure> {
    let mut cargo = process::cargo();
    cargo.args(["run", "--release", "--package", "farlight_gi_solver"]);
    cargo.args(["--example", "compare_reference", "--"]);
    process::run(cargo.args(arguments))
}
