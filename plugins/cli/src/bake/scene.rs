//! `farlight bake --out`: lightmaps and probes of a scene.

use std::{
    sync::{
        Arc,
        atomic::{AtomicBool, Ordering::Relaxed},
    },
    thread,
};

use farlight_baker::{Bake, BakeOptions, Outcome, Report, watch};

use super::{Args, show::Shown, summary};
use crate::{error::CliError, signals::Signals};

/// Bakes, once or until it is told to stop.
pub(super) fn run(args: &Args, options: BakeOptions) -> Result<(), CliError> {
    let bake = Bake::new(options);
    let over = Arc::new(AtomicBool::new(false));
    stop_at_signal(&bake, over.clone(), args.watch)?;
    let mut shown = Shown::new();
    let result = if args.watch {
        watch(bake, &mut shown, &mut |result| match result {
            Ok(report) => tell(&report),
            Err(error) => eprintln!("error: {error}"),
        });
        Ok(())
    } else {
        let result = bake.run(&mut shown);
        shown.end();
        result.map_err(|error| CliError::new(error.to_string())).and_then(|report| {
            tell(&report);
            match report.outcome {
                Outcome::Partial => Err(CliError::new(
                    "stopped: the folder holds what was done by then; the same command goes on from there",
                )),
                Outcome::Complete | Outcome::Unchanged => Ok(()),
            }
        })
    };
    over.store(true, Relaxed);
    result
}

fn tell(report: &Report) {
    print!("{}", summary::of(report));
}

/// The first signal stops the bake, which then writes what it has; the second one ends the process.
fn stop_at_signal(bake: &Bake, over: Arc<AtomicBool>, watching: bool) -> Result<(), CliError> {
    let signals = Signals::new()?;
    let stop = bake.stop_flag();
    let listen = move || {
        if let Some(name) = signals.wait(|| !over.load(Relaxed)) {
            if !watching {
                eprintln!("{name}: writing what is done; once more ends at once");
            }
            stop.store(true, Relaxed);
        }
    };
    thread::Builder::new()
        .name("stop".into())
        .spawn(listen)
        .map(drop)
        .map_err(|error| CliError::new(format!("no thread can be started: {error}")))
}
