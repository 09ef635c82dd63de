//! The `farlight` command: everything of the suite that needs no game.

mod bake;
mod btf;
mod check;
mod controls;
mod error;
mod ibl;
mod job;
mod output;
mod progress;
mod serve;
mod signals;

use std::process::ExitCode;

use clap::{Parser, Subcommand};

/// Light that a game can't compute itself, from the command line.
///
/// Lengths are metres, axes those of glTF (right-handed, y up), colours linear Rec. 709. The numbers
/// of KHR_lights_punctual are taken as they are: read results in W or in lm, whichever the scene's
/// lights use.
#[derive(Parser)]
#[command(version, propagate_version = true)]
struct Cli {
    #[command(subcommand)]
    command: Command,
}

#[derive(Subcommand)]
enum Command {
    Bake(bake::Args),
    Btf(btf::Args),
    Check(check::Args),
    Controls(controls::Args),
    Ibl(ibl::Args),
    Serve(serve::Args),
}

fn main() -> ExitCode {
    let result = match Cli::parse().command {
        Command::Bake(args) => bake::run(&args),
        Command::Btf(args) => btf::run(&args),
        Command::Check(args) => check::run(&args),
        Command::Controls(args) => controls::run(&args),
        Command::Ibl(args) => ibl::run(&args),
        Command::Serve(args) => serve::run(&args),
    };
    match result {
        Ok(()) => ExitCode::SUCCESS,
        Err(error) => {
            eprintln!("error: {error}");
            ExitCode::FAILURE
        }
    }
}
