//! `cargo xtask bench bake`: `farlight bake` beside Blender's Cycles.

use std::{
    path::{Path, PathBuf},
    process::Command,
};

use crate::{Failure, environment, process};

/// What does the work.
const SCRIPT: &str = "tests/references/baking/run.py";

/// Bakes scenes with both and prints how far they are from the truth. `rest` is given to the script.
pub(crate) fn run(python: Option<&str>, rest: &[String]) -> Result<(), Failure> {
    let data = environment::test_data().ok_or_else(environment::test_data_line)?;
    let target = environment::target_dir();
    let own = target.join("peers");
    let python = python.map_or_else(|| own.join("bin/python"), PathBuf::from);
    if !has_modules(&python) {
        return Err(missing(&python, &own));
    }
    let mut build = process::cargo();
    process::run(build.args(["build", "--release", "--package", "farlight_cli"]))?;
    let mut bench = Command::new(&python);
    bench.arg(process::root().join(SCRIPT));
    bench.arg("--farlight").arg(target.join("release/farlight"));
    bench.arg("--data").arg(data).arg("--out").arg(target.join("bench-bake")).args(rest);
    process::run(&mut bench)
}

fn has_modules(python: &Path) -> bool {
    let mut command = Command::new(python);
    let imported = command.args(["-c", "import bpy, mitsuba, numpy"]).output();
    imported.is_ok_and(|output| output.status.success())
}

fn missing(python: &Path, own: &Path) -> Failure {
    let own = own.display();
    format!(
        "{} has no bpy and mitsuba. With Python 3.11 (bpy 4.2 takes no other):\n  \
         python3.11 -m venv {own}\n  {own}/bin/pip install bpy==4.2.0 mitsuba==3.9.1\n\
         Mitsuba also looks for LLVM 17 or newer (Debian: libllvm19).",
        python.display()
    )
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn what_is_missing_is_said() {
        let text = missing(Path::new("nowhere/python"), Path::new("target/peers"));
        assert!(text.contains("nowhere/python") && text.contains("target/peers/bin/pip install"));
        assert!(!has_modules(Path::new("nowhere/python")));
    }

    #[test]
    fn the_script_is_there() {
        assert!(process::root().join(SCRIPT).is_file());
    }
}
