//! `cargo xtask ci`: what must hold before a change is merged.

use std::time::{Duration, Instant};

use crate::args::Args;
use crate::setup::{self, Purpose};
use crate::{Failure, manifest, process, test};

pub(crate) const HELP: &str = "\
cargo xtask ci [--checks-only] [--no-install]

Runs, quick ones first, and goes on after a failure so that one run shows them all:
  lockfile   Cargo.lock fits the manifests
  format     cargo fmt --all --check
  typos      typos, if installed
  deny       cargo deny check (licences, advisories, bans), if cargo-deny is installed
  clippy     the whole workspace with all targets, warnings are errors
  docs       cargo doc, warnings are errors
  packages   cargo package of every published crate (not built again)
  features   the umbrella with no feature, and with each feature alone
  targets    farlight_remote, farlight_btf and farlight_baked for wasm32-unknown-unknown, farlight_gi,
             farlight_btf and farlight_baked for x86_64-pc-windows-gnu, if those are installed or rustup can add them
  tests      what `cargo xtask test` does, if nothing failed before

A table at the end says what passed, what failed, what was skipped and why, and how long it took.

  --checks-only  without the tests
  --no-install   only name missing system packages, and add no target
";

/// Targets for which a plugin must compile, though no test runs there. (The transport of
/// `farlight_remote` needs a C compiler for Windows; the web gets none.)
///
/// Packages of one target are checked together, so that the engine is once.
const TARGETS: [(&str, &[&str]); 2] = [
    ("wasm32-unknown-unknown", &["farlight_remote", "farlight_btf", "farlight_baked"]),
    ("x86_64-pc-windows-gnu", &["farlight_gi", "farlight_btf", "farlight_baked"]),
];

/// Whether the manifests are fit to be published; files that are not committed may be there.
const PACKAGE: [&str; 6] =
    ["package", "--workspace", "--exclude=xtask", "--no-verify", "--allow-dirty", "--quiet"];

pub(crate) fn run(mut args: Args) -> Result<(), Failure> {
    let install = !args.flag("--no-install");
    let checks_only = args.flag("--checks-only");
    args.finish()?;
    setup::prepare(&[Purpose::Build, Purpose::Render], install);

    let mut report = Report::default();
    report.cargo("lockfile", &["tree", "--locked", "--workspace", "--depth", "0"]);
    report.cargo("format", &["fmt", "--all", "--check"]);
    if process::is_on_path("typos") {
        report.step("typos", || process::run(&mut std::process::Command::new("typos")));
    } else {
        report.skip("typos", "typos is not installed (cargo install typos-cli)");
    }
    if process::is_on_path("cargo-deny") {
        report.cargo("deny", &["deny", "--all-features", "check"]);
    } else {
        report.skip("deny", "cargo-deny is not installed (cargo install cargo-deny)");
    }
    report.cargo("clippy", &["clippy", "--workspace", "--all-targets", "--", "-D", "warnings"]);
    report.step("docs", docs);
    report.cargo("packages", &PACKAGE);
    for feature in features() {
        report.step(&format!("features: {}", feature.as_deref().unwrap_or("none")), || {
            alone(feature.as_deref())
        });
    }
    for (target, packages) in TARGETS {
        let name = format!("target {target}: {}", packages.join(", "));
        match add_target(target, install) {
            Ok(()) => {
                let mut arguments = vec!["check", "--target", target];
                arguments.extend(packages.iter().flat_map(|package| ["-p", package]));
                report.cargo(&name, &arguments);
            }
            Err(reason) => report.skip(&name, &reason),
        }
    }
    if checks_only {
        report.skip("tests", "--checks-only");
    } else if report.failed() == 0 {
        report.step("tests", || test::all(&[]));
    } else {
        report.skip("tests", "a check failed");
    }
    print!("{}", report.table());
    match report.failed() {
        0 => Ok(()),
        count => Err(format!("{count} failed.")),
    }
}

/// Documentation of our own crates. Naming the examples makes cargo resolve features as for the
/// tests, so that the engine's check from clippy is used again.
fn docs() -> Result<(), Failure> {
    let mut cargo = process::cargo();
    cargo.args(["doc", "--workspace", "--no-deps", "--lib", "--examples"]);
    process::run(cargo.env("RUSTDOCFLAGS", "-D warnings"))
}

/// `None` for no feature at all, then each feature of the umbrella.
fn features() -> Vec<Option<String>> {
    let manifest = std::fs::read_to_string(process::root().join("Cargo.toml")).unwrap_or_default();
    std::iter::once(None).chain(manifest::features(&manifest).into_iter().map(Some)).collect()
}

fn alone(feature: Option<&str>) -> Result<(), Failure> {
    let mut cargo = process::cargo();
    cargo.args(["check", "-p", "farlight", "--no-default-features"]);
    if let Some(feature) = feature {
        cargo.args(["--features", feature]);
    }
    process::run(&mut cargo)
}

/// Makes sure that the standard library for the target is there, or says why it is not.
fn add_target(target: &str, install: bool) -> Result<(), String> {
    let installed = || {
        process::output("rustc", &["--print", "sysroot"]).is_some_and(|sysroot| {
            std::path::Path::new(sysroot.trim()).join("lib/rustlib").join(target).is_dir()
        })
    };
    if installed() {
        return Ok(());
    }
    if install && process::is_on_path("rustup") {
        // Without a network this fails, and the check is skipped.
        let _ = process::run(std::process::Command::new("rustup").args(["target", "add", target]));
    }
    if installed() { Ok(()) } else { Err(format!("not installed (rustup target add {target})")) }
}

/// The steps so far.
#[derive(Default)]
struct Report {
    steps: Vec<(String, Outcome)>,
}

enum Outcome {
    Passed(Duration),
    Failed(Duration, Failure),
    Skipped(String),
}

impl Report {
    fn cargo(&mut self, name: &str, arguments: &[&str]) {
        self.step(name, || process::run(process::cargo().args(arguments)));
    }

    fn step(&mut self, name: &str, work: impl FnOnce() -> Result<(), Failure>) {
        println!("\n==== {name}");
        let start = Instant::now();
        let outcome = match work() {
            Ok(()) => Outcome::Passed(start.elapsed()),
            Err(failure) => Outcome::Failed(start.elapsed(), failure),
        };
        self.steps.push((name.to_owned(), outcome));
    }

    fn skip(&mut self, name: &str, reason: &str) {
        println!("\n==== {name}: SKIPPED: {reason}");
        self.steps.push((name.to_owned(), Outcome::Skipped(reason.to_owned())));
    }

    fn failed(&self) -> usize {
        self.steps.iter().filter(|(_, outcome)| matches!(outcome, Outcome::Failed(..))).count()
    }

    fn table(&self) -> String {
        let width = self.steps.iter().map(|(name, _)| name.len()).max().unwrap_or(0);
        let mut text = "\n".to_owned();
        for (name, outcome) in &self.steps {
            let outcome = match outcome {
                Outcome::Passed(time) => format!("passed   {:4} s", time.as_secs()),
                Outcome::Failed(time, failure) => {
                    format!("FAILED   {:4} s  {failure}", time.as_secs())
                }
                Outcome::Skipped(reason) => format!("SKIPPED          {reason}"),
            };
            text.push_str(&format!("{name:width$}  {outcome}\n"));
        }
        text
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_failure_is_counted_and_the_rest_still_runs() {
        let mut report = Report::default();
        report.step("one", || Err("broken".to_owned()));
        report.step("two", || Ok(()));
        report.skip("three", "no tool");
        assert_eq!(report.failed(), 1);
        let table = report.table();
        assert!(table.contains("one    FAILED") && table.contains("broken"), "{table}");
        assert!(table.contains("two    passed") && table.contains("three  SKIPPED"), "{table}");
    }

    #[test]
    fn no_feature_comes_first() {
        let features = features();
        assert_eq!(features[0], None);
        assert!(features.contains(&Some("gi".to_owned())));
    }
}
