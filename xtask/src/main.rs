//! The developer's tool of Farlight, run as `cargo xtask COMMAND` (the alias is in
//! `.cargo/config.toml`).
//!
//! It depends on nothing but the standard library and uses no shell: every program is started with
//! an argument vector, so it behaves the same on every system and with every folder name.

mod args;
mod assets;
mod bake_peer;
mod bench;
mod ci;
mod demo;
#[cfg(test)]
mod documents;
mod environment;
mod fuzz;
mod lighting_server;
mod manifest;
mod process;
mod prune;
mod reference;
mod setup;
mod soak;
mod test;

use std::process::ExitCode;

use args::Args;

/// What went wrong, in words for the person at the terminal.
type Failure = String;

/// Help of the whole tool; every command has its own.
const HELP: &str = "\
cargo xtask COMMAND [OPTIONS]

  demo     build and run the demo, a room lit by a server of its own (in a window or headless)
  test     every test of the workspace, and a list of what was skipped and why
  ci       what runs before a change is merged: format, lints, docs, features, targets, tests
  bench    rays per second beside Embree; `bench soak`: ten minutes of the server and of the demo
  fuzz     damaged and random input for every decoder, longer than the tests do
  setup    only look for missing system packages, and install them
  prune    bound the size of a build folder that several checkouts share
  assets   write the scene in assets/ that this project makes itself, or check it

demo, test, ci and bench begin with what setup does; --no-install makes them print what is missing
and go on. `cargo xtask COMMAND --help` says more.
";

fn main() -> ExitCode {
    let mut args = Args::from_env();
    let Some(command) = args.command() else {
        print!("{HELP}");
        return if args.wants_help() { ExitCode::SUCCESS } else { ExitCode::from(2) };
    };
    let (help, run): (&str, fn(Args) -> Result<(), Failure>) = match command.as_str() {
        "demo" => (demo::HELP, demo::run),
        "test" => (test::HELP, test::run),
        "ci" => (ci::HELP, ci::run),
        "bench" => (bench::HELP, bench::run),
        "fuzz" => (fuzz::HELP, fuzz::run),
        "setup" => (setup::HELP, setup::run),
        "prune" => (prune::HELP, prune::run),
        "assets" => (assets::HELP, assets::run),
        "help" => (HELP, |_| {
            print!("{HELP}");
            Ok(())
        }),
        other => {
            eprintln!("xtask: there is no command '{other}'.\n\n{HELP}");
            return ExitCode::from(2);
        }
    };
    if args.wants_help() {
        print!("{help}");
        return ExitCode::SUCCESS;
    }
    match run(args) {
        Ok(()) => ExitCode::SUCCESS,
        Err(failure) => {
            eprintln!("xtask {command}: {failure}");
            ExitCode::FAILURE
        }
    }
}
