//! System packages: what the build and the renders need beyond Rust and a C compiler, what of it
//! is really missing on this machine, and how to get it here.

mod apt;
mod distribution;
mod needs;
pub(crate) mod probe;

use crate::Failure;
use crate::args::Args;
use crate::process;
use distribution::{Family, System};
use needs::Need;
pub(crate) use needs::Purpose;
use probe::Machine;

pub(crate) const HELP: &str = "\
cargo xtask setup [--no-install]

Looks for the system packages that building, rendering and benchmarks need: by pkg-config, by the
library cache, by Vulkan driver manifests and GPU device nodes, never by asking what is installed.
What is missing is named with the reason, and installed by apt-get on Debian, Ubuntu and their
relatives, through sudo unless you are root. On other systems the names are printed.

  --no-install   only say what is missing
";

/// `cargo xtask setup`: everything, the optional peers of the benchmark included.
pub(crate) fn run(mut args: Args) -> Result<(), Failure> {
    let install = !args.flag("--no-install");
    args.finish()?;
    if cfg!(target_os = "linux") {
        println!("{}", Machine::look().summary());
    }
    let purposes = [Purpose::Build, Purpose::Render, Purpose::Window, Purpose::Bench];
    if prepare(&purposes, install) {
        println!("Nothing is missing.");
    }
    Ok(())
}

/// Finds what is missing for the purposes and installs it if `install`; returns whether everything
/// is there. A package that cannot be had is no failure here: the step that needs it knows better
/// whether it can do without.
pub(crate) fn prepare(purposes: &[Purpose], install: bool) -> bool {
    let system = System::look();
    if let Some(note) = system.note() {
        println!("{note}");
        return true;
    }
    let lockfile = std::fs::read_to_string(process::root().join("Cargo.lock")).unwrap_or_default();
    let missing = missing(purposes, &lockfile);
    if missing.is_empty() {
        return true;
    }
    println!("Missing on this system ({}):", system.name);
    for need in &missing {
        println!("  {}", line(need, system.family));
    }
    if system.family != Family::Debian {
        println!("{}", system.advice(&missing));
        return false;
    }
    if !install {
        println!("Not installed (--no-install): {}", apt::by_hand(&missing));
        return false;
    }
    // The optional ones by themselves: one that this release lacks must not hinder the others.
    let (optional, required): (Vec<Need>, Vec<Need>) =
        missing.into_iter().partition(|need| need.optional);
    for group in [required, optional] {
        if group.is_empty() {
            continue;
        }
        if let Err(failure) = apt::install(&group) {
            println!("{failure}\nGoing on without. By hand: {}", apt::by_hand(&group));
        }
    }
    let left = self::missing(purposes, &lockfile);
    for need in &left {
        println!("STILL MISSING: {} ({})", need.what, need.why);
    }
    left.is_empty()
}

fn missing(purposes: &[Purpose], lockfile: &str) -> Vec<Need> {
    let machine = Machine::look();
    needs::all()
        .into_iter()
        .filter(|need| purposes.contains(&need.purpose) && need.applies(lockfile))
        .filter(|need| !machine.has(&need.probe))
        .collect()
}

/// One line a package: its name here, and why.
fn line(need: &Need, family: Family) -> String {
    let optional = if need.optional { ", optional" } else { "" };
    format!("{}: {}{optional} ({})", need.package(family), need.what, need.why)
}
