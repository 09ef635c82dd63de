//! `cargo xtask bench`: figures beside those of what a user would otherwise pick.

use crate::args::Args;
use crate::setup::{self, Purpose};
use crate::{Failure, bake_peer, demo, environment, process, reference, soak};

pub(crate) const HELP: &str = "\
cargo xtask bench [tracing] [--no-install] [-- OPTIONS]
cargo xtask bench btf [--gpu | --frames] [--json FILE] [--no-install] [-- OPTIONS]
cargo xtask bench ibl [--json FILE] [--no-install] [-- OPTIONS]
cargo xtask bench controls [--json FILE] [--no-install] [-- OPTIONS]
cargo xtask bench reference [--samples N] [--no-install]
cargo xtask bench bake [--python PROGRAM] [--no-install] [-- OPTIONS]
cargo xtask bench soak [server | demo] [--minutes N | --seconds N] [--no-install]

  tracing        rays per second on one core, ours beside Embree's where it is installed (Debian's
                 libembree-dev), coherent and incoherent, closest and any hits; the scene is a
                 real room if FARLIGHT_TEST_DATA names the folder with it, else a generated one
  btf            values of measured materials a second on one core, one at a time and in vectors, at
                 random and in raster order, for the suite's own materials and those in the folder
                 that FARLIGHT_TEST_DATA names; with --fastest after -- the quickest of all rounds
                 counts, for a busy machine
  btf --gpu      nanoseconds a value in a compute kernel, for views under one and more lights, beside
                 one core
  btf --frames   the time of a frame that a measured material fills, under one and five lights, over
                 that of StandardMaterial in the same run
  ibl            the time of a frame while the environment's light refines, still and in motion, over
                 that of the same lights alone, and of a refined picture, at two resolutions
  controls       what the systems of the controls take of a frame while gamepads come and go, move and
                 hang, over a quiet desk
  reference      bakes two scenes and compares irradiance, probes and visibility with those of an
                 independent renderer, in the folder that FARLIGHT_TEST_DATA names
  bake           bakes three scenes with `farlight bake` and, for as much processor time, with Blender's
                 Cycles, and compares both with Mitsuba; needs Python 3.11 with bpy and mitsuba, and the
                 folder that FARLIGHT_TEST_DATA names; says how to get them. After -- for example
                 --scene TwoRooms --size 512 --quality draft
  soak server    runs `farlight serve` and clients that come, get light, leave in every way, come back
                 or send garbage, for ten minutes, and watches the memory of the server's process;
                 fails if it grows after the second fifth of the time, or a client got no light
  soak demo      the same for the demo, run headless
  soak           both, one after the other

  --python PROGRAM  the Python that has them (default target/peers/bin/python)
  --samples N    paths a receiver (default 65536)
  --minutes N    how long to soak (default 10), or --seconds N; below five minutes a program is still
                 warming up
  --json FILE    the figures for programs, too
  --no-install   only name missing system packages
  -- ...         is given to the benchmark or the demo
";

pub(crate) fn run(mut args: Args) -> Result<(), Failure> {
    let install = !args.flag("--no-install");
    match args.command().as_deref() {
        None | Some("tracing") => {
            let rest = args.finish()?;
            setup::prepare(&[Purpose::Build, Purpose::Bench], install);
            println!("{}", environment::test_data_line());
            let mut cargo = process::cargo();
            cargo.args(["bench", "-p", "farlight_gi_solver", "--bench", "tracing"]);
            if !rest.is_empty() {
                cargo.arg("--").args(rest);
            }
            process::run(&mut cargo)
        }
        Some("btf") => {
            let (gpu, frames) = (args.flag("--gpu"), args.flag("--frames"));
            let json = args.value("--json")?;
            let rest = args.finish()?;
            let purposes = [Purpose::Build, Purpose::Render];
            setup::prepare(&purposes[..if gpu || frames { 2 } else { 1 }], install);
            println!("{}", environment::test_data_line());
            if frames {
                return time_frames("btf_frame_time", json.as_deref(), &rest);
            }
            let mut cargo = process::cargo();
            if gpu {
                // The driver's work is measured, which the profile does not change.
                cargo.args(["bench", "--profile", "dev", "-p", "farlight_btf_codec"]);
                cargo.args(["--features", "gpu", "--bench", "gpu", "--"]);
                environment::for_headless(&mut cargo);
            } else {
                cargo.args(["bench", "-p", "farlight_btf_codec", "--bench", "evaluate", "--"]);
            }
            if let Some(file) = json {
                // The benchmark runs in the folder of its package.
                let file = std::path::absolute(&file).map_err(|e| format!("{file}: {e}"))?;
                cargo.arg("--json").arg(file);
            }
            process::run(cargo.args(rest))
        }
        Some("ibl") => {
            let json = args.value("--json")?;
            let rest = args.finish()?;
            setup::prepare(&[Purpose::Build, Purpose::Render], install);
            time_frames("ibl_frame_time", json.as_deref(), &rest)
        }
        Some("controls") => {
            let json = args.value("--json")?;
            let rest = args.finish()?;
            setup::prepare(&[Purpose::Build], install);
            time_frames("controls_frame_time", json.as_deref(), &rest)
        }
        Some("reference") => {
            let samples = args.parsed::<u32>("--samples", "a number of paths")?.unwrap_or(65_536);
            args.finish()?;
            setup::prepare(&[Purpose::Build], install);
            reference::run(samples)
        }
        Some("bake") => {
            let python = args.value("--python")?;
            let rest = args.finish()?;
            setup::prepare(&[Purpose::Build], install);
            bake_peer::run(python.as_deref(), &rest)
        }
        Some("soak") => {
            let (server, demo) = match args.command().as_deref() {
                None => (true, true),
                Some("server") => (true, false),
                Some("demo") => (false, true),
                Some(other) => return Err(format!("there is no soak '{other}': server, demo.")),
            };
            let minutes = args.parsed::<f64>("--minutes", "a number of minutes")?;
            let seconds = args.parsed::<f64>("--seconds", "a number of seconds")?;
            let seconds = seconds.unwrap_or(minutes.unwrap_or(10.0) * 60.0);
            if !(seconds > 0.0 && seconds <= 24.0 * 3600.0) {
                return Err("a soak takes more than nothing and at most a day.".to_owned());
            }
            let rest = args.finish()?;
            let purposes = [Purpose::Build, Purpose::Render];
            setup::prepare(&purposes[..if demo { 2 } else { 1 }], install);
            if server {
                soak::server::run(seconds)?;
            }
            if demo {
                soak::demo::run(seconds, &rest)?;
            }
            Ok(())
        }
        Some(other) => Err(format!(
            "there is no benchmark '{other}': tracing, btf, ibl, controls, reference, bake, \
             soak."
        )),
    }
}

/// Builds and runs an example that times frames.
fn time_frames(example: &str, json: Option<&str>, rest: &[String]) -> Result<(), Failure> {
    let mut cargo = process::cargo();
    cargo.args(["build", "--workspace", "--example", example]);
    cargo.arg("--message-format=json-render-diagnostics");
    let mut program = None;
    let built = process::run_by_line(&mut cargo, |line| {
        let found = demo::executable(line);
        program = found.filter(|p| p.file_stem().is_some_and(|n| n == example)).or(program.take());
    })?;
    let Some(program) = program.filter(|_| built) else {
        return Err(format!("the example {example} does not build (see above)."));
    };
    let mut command = std::process::Command::new(program);
    environment::for_headless(&mut command);
    if let Some(file) = json {
        command.args(["--json", file]);
    }
    process::run(command.args(rest))
}
