//! `cargo xtask fuzz`: damaged and random input for every decoder of the wire and every reader of
//! materials, environment maps, bindings, recordings and baked lighting, as long as one likes.

use crate::args::Args;
use crate::{Failure, process};

pub(crate) const HELP: &str = "\
cargo xtask fuzz [--seconds N] [--seed N] [TARGET]

Feeds damaged, random and lying input to the decoders and sessions of remote lighting, and what they
accept to a solver; also to the readers of measured materials, of environment maps, of input bindings,
of recordings of actions and of baked lighting, and uses what they accept.
Nothing may panic, take more memory than the limits say, or change when it is sent on. The stable
toolchain is enough: inputs are mutations of valid ones, without feedback from the code that they reach.
The tests run every target briefly; this runs each for N seconds.

  --seconds N   time for every target (default 60)
  --seed N      other inputs (default 1)
  TARGET        only targets whose name begins with it:
                blob lighting lighting_beside invitation greeting client_session server_session
                client_message server_message hello_and_welcome solver odd_scene
                material_own material_binary material_text material_archive material_list
                environment_radiance environment_openexr environment_ktx2 environment_screen
                bindings_file bindings_defaults bindings_text recording
                baked_manifest baked_ktx2 baked_exr

An input that fails is printed in hexadecimal, with its seed and number.
";

pub(crate) fn run(mut args: Args) -> Result<(), Failure> {
    let seconds: u64 = args.parsed("--seconds", "a number of seconds")?.unwrap_or(60);
    let seed: u64 = args.parsed("--seed", "a number")?.unwrap_or(1);
    let target = args.command().unwrap_or_default();
    args.finish()?;
    let mut cargo = process::cargo();
    cargo
        .args(["test", "--package", "farlight_wire", "--package", "farlight_btf_codec"])
        .args(["--package", "farlight_environment", "--package", "farlight_bindings"])
        .args(["--package", "farlight_baked_format"])
        .args(["--lib", "--test", "fuzz", "--"])
        .args([&format!("fuzz_{target}"), "--nocapture", "--test-threads=1"])
        .env("FARLIGHT_FUZZ_SECONDS", seconds.to_string())
        .env("FARLIGHT_FUZZ_SEED", seed.to_string());
    let mut targets = 0;
    let passed = process::run_by_line(&mut cargo, |line| {
        println!("{line}");
        targets += usize::from(is_report(line));
    })?;
    match (passed, targets) {
        (false, _) => Err("an input failed; it is shown above.".to_owned()),
        (true, 0) => Err(format!("there is no target '{target}'; --help lists them.")),
        (true, _) => {
            println!("{targets} targets, {seconds} s each: nothing failed.");
            Ok(())
        }
    }
}

/// What a target prints when it is through. The harness of the standard library writes the name of
/// the test in front, on the same line.
fn is_report(line: &str) -> bool {
    line.contains("fuzz_") && line.contains(" inputs, ") && line.contains(" accepted, ")
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn targets_are_counted_by_their_reports() {
        assert!(is_report("fuzz_blob: 3000 inputs, 71 accepted, 9.9ms"));
        let joined = "test values::fuzz_blob ... fuzz_blob: 3000 inputs, 71 accepted, 9.9ms";
        assert!(is_report(joined));
        assert!(!is_report("test values::fuzz_blob ... ok"));
    }
}
