//! `cargo xtask test`: every test, and a loud list of what did not run.

use crate::args::Args;
use crate::setup::{self, Purpose};
use crate::{Failure, environment, process};

pub(crate) const HELP: &str = "\
cargo xtask test [--no-install] [-- NAME]

Looks for missing system packages, then runs every test of the workspace: units, integration tests
with headless renders (Mesa's lavapipe where there is no GPU), examples in the documentation. At the
end it repeats which tests failed and which skipped themselves, and why.

  --no-install   only name missing system packages
  -- NAME        only tests whose name contains NAME; further options go to the test harness

Tests that need scenes too large for the repository look for them in the folder that the variable
FARLIGHT_TEST_DATA names.
";

pub(crate) fn run(mut args: Args) -> Result<(), Failure> {
    let install = !args.flag("--no-install");
    let rest = args.finish()?;
    setup::prepare(&[Purpose::Build, Purpose::Render], install);
    all(&rest)
}

/// Runs every test; `rest` goes to the test harness.
pub(crate) fn all(rest: &[String]) -> Result<(), Failure> {
    println!("{}", environment::test_data_line());
    let mut cargo = process::cargo();
    // --show-output, since the harness swallows what passing tests print, `SKIPPED:` included.
    cargo.args(["test", "--workspace", "--no-fail-fast", "--", "--show-output"]).args(rest);
    environment::for_headless(&mut cargo);
    let mut tally = Tally::default();
    let passed = process::run_by_line(&mut cargo, |line| {
        println!("{line}");
        tally.read(line);
    })?;
    print!("{}", tally.summary());
    process::flush();
    match (passed, tally.failed.len()) {
        (true, 0) => Ok(()),
        (_, 0) => Err("cargo test failed: a test does not build, or stopped its process.".into()),
        (_, count) => Err(format!("{count} of {} tests failed.", tally.count())),
    }
}

/// What the harness of the standard library prints, summed over all test programs.
#[derive(Debug, Default, PartialEq, Eq)]
struct Tally {
    passed: usize,
    failed: Vec<String>,
    /// Tests with `#[ignore]`, with the reason if there is one.
    ignored: Vec<String>,
    /// Tests that ended early because something is missing, with their reasons.
    skipped: Vec<String>,
    /// The test whose output is being shown.
    shown: String,
}

impl Tally {
    fn read(&mut self, line: &str) {
        if let Some(name) = line.strip_prefix("---- ") {
            self.shown =
                name.split(" stdout").next().unwrap_or(name).trim_end_matches(" ----").into();
        } else if let Some(at) = line.find("SKIPPED:").filter(|_| !line.starts_with("====")) {
            // (A step of `cargo xtask ci` begins with ====; its own tests print some.)
            // A line of the log has a time in front of it.
            let reason = line[at + "SKIPPED:".len()..].trim();
            let entry = if self.shown.is_empty() {
                reason.to_owned()
            } else {
                format!("{}: {reason}", self.shown)
            };
            if !self.skipped.contains(&entry) {
                self.skipped.push(entry);
            }
        } else if line.starts_with("test result: ") {
            self.shown.clear();
        } else if let Some((name, outcome)) =
            line.strip_prefix("test ").and_then(|line| line.rsplit_once(" ... "))
        {
            match outcome {
                "ok" => self.passed += 1,
                "FAILED" => self.failed.push(name.to_owned()),
                _ => {
                    if let Some(reason) = outcome.strip_prefix("ignored") {
                        self.ignored.push(format!("{name}{reason}"));
                    }
                }
            }
        }
    }

    fn count(&self) -> usize {
        self.passed + self.failed.len()
    }

    fn summary(&self) -> String {
        let mut text = format!(
            "\n==== {} tests passed, {} failed, {} ignored; {} times something was skipped\n",
            self.passed,
            self.failed.len(),
            self.ignored.len(),
            self.skipped.len(),
        );
        for (title, entries) in
            [("SKIPPED", &self.skipped), ("IGNORED", &self.ignored), ("FAILED", &self.failed)]
        {
            for entry in entries {
                text.push_str(&format!("{title}: {entry}\n"));
            }
        }
        text
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn tally(output: &str) -> Tally {
        let mut tally = Tally::default();
        output.lines().for_each(|line| tally.read(line));
        tally
    }

    #[test]
    fn the_harness_is_understood() {
        let tally = tally(
            "running 4 tests\ntest a::one ... ok\ntest a::two - should panic ... ok\n\
             test b::three ... FAILED\ntest c ... ignored, takes an hour\n\nsuccesses:\n\n\
             ---- a::one stdout ----\nSKIPPED: FARLIGHT_TEST_DATA is not set\n\n\
             failures:\n\n---- b::three stdout ----\npanicked\n\nfailures:\n    b::three\n\n\
             test result: FAILED. 2 passed; 1 failed; 1 ignored; 0 measured\n",
        );
        assert_eq!(tally.passed, 2);
        assert_eq!(tally.failed, ["b::three"]);
        assert_eq!(tally.ignored, ["c, takes an hour"]);
        assert_eq!(tally.skipped, ["a::one: FARLIGHT_TEST_DATA is not set"]);
        assert_eq!(tally.count(), 3);
        let summary = tally.summary();
        assert!(
            summary.contains("2 tests passed, 1 failed, 1 ignored; 1 times something was skipped")
        );
        assert!(summary.contains("\nFAILED: b::three\n"), "{summary}");
    }

    #[test]
    fn examples_in_the_documentation_count() {
        let tally = tally("test src/lib.rs - Gi (line 12) ... ok\ntest result: ok. 1 passed\n");
        assert_eq!((tally.passed, tally.failed.len()), (1, 0));
    }

    #[test]
    fn a_skip_without_a_test_around_it_is_kept_too() {
        assert_eq!(tally("12:00 WARN SKIPPED: no GPU\n").skipped, ["no GPU"]);
    }
}
