//! Clients that come and go, for watching a server: `cargo run -p farlight_server --example
//! reconnect -- INVITATION [--clients N] [--seconds N] [--seed N] [--only VISIT]`.
//!
//! Every client connects, sends a small scene, waits for its light, and leaves: with a goodbye, by
//! being killed, with a resumption in between, in the middle of sending a mesh; some have a wrong
//! token or send garbage. Ends with an error if one that should get light gets none.

mod client;
mod scene;
mod visit;

use std::{
    process::ExitCode,
    sync::Mutex,
    time::{Duration, Instant},
};

use farlight_wire::Invitation;
use visit::{Visit, Visitor};

/// What the command line says.
struct Options {
    invitation: Invitation,
    clients: u32,
    time: Duration,
    seed: u64,
    only: Option<Visit>,
    /// It is to be killed by another one.
    victim: bool,
}

fn main() -> ExitCode {
    let options = match options(std::env::args().skip(1)) {
        Ok(options) => options,
        Err(problem) => {
            eprintln!(
                "{problem}\nreconnect INVITATION [--clients N] [--seconds N] [--seed N] [--only VISIT]"
            );
            return ExitCode::from(2);
        }
    };
    if options.victim {
        let mut visitor = Visitor::new(&options.invitation, options.seed);
        return match visitor.be_killed() {
            Ok(()) => ExitCode::SUCCESS,
            Err(why) => {
                println!("{why}");
                ExitCode::FAILURE
            }
        };
    }
    let end = Instant::now() + options.time;
    let tally = Mutex::new(Tally::default());
    std::thread::scope(|scope| {
        for number in 0..options.clients {
            let (options, tally) = (&options, &tally);
            scope.spawn(move || stay(options, number, end, tally));
        }
    });
    let tally = tally.into_inner().unwrap_or_default();
    tally.print();
    if tally.failures.is_empty() && tally.visits.iter().any(|(_, count)| *count > 0) {
        ExitCode::SUCCESS
    } else {
        ExitCode::FAILURE
    }
}

/// What happened.
#[derive(Default)]
struct Tally {
    visits: Vec<(Visit, u32)>,
    /// Seconds from the submission of a scene to its light.
    lit: Vec<f32>,
    failures: Vec<String>,
}

/// One client after the other until the time is over.
fn stay(options: &Options, number: u32, end: Instant, tally: &Mutex<Tally>) {
    let mut visitor = Visitor::new(&options.invitation, options.seed + u64::from(number));
    for turn in number.. {
        if Instant::now() >= end {
            return;
        }
        let visit = options.only.unwrap_or(Visit::ALL[turn as usize % Visit::ALL.len()]);
        let outcome = visitor.visit(visit);
        let Ok(mut tally) = tally.lock() else { return };
        match outcome {
            Ok(lit) => tally.lit.extend(lit),
            Err(why) => {
                println!("FAILED: {visit:?}: {why}");
                tally.failures.push(format!("{visit:?}: {why}"));
            }
        }
        match tally.visits.iter_mut().find(|(known, _)| *known == visit) {
            Some((_, count)) => *count += 1,
            None => tally.visits.push((visit, 1)),
        }
    }
}

impl Tally {
    fn print(&self) {
        for (visit, count) in &self.visits {
            println!("{count:6} {visit:?}");
        }
        let mut lit = self.lit.clone();
        lit.sort_by(f32::total_cmp);
        if let (Some(median), Some(longest)) = (lit.get(lit.len() / 2), lit.last()) {
            let count = lit.len();
            println!(
                "light came {count} times, after {median:.3} s (median), {longest:.3} s at most"
            );
        }
        println!("{} failures", self.failures.len());
    }
}

fn options(mut words: impl Iterator<Item = String>) -> Result<Options, String> {
    let (mut invitation, mut only) = (None, None);
    let (mut clients, mut seconds, mut seed, mut victim) = (4, 10.0, 1, false);
    while let Some(word) = words.next() {
        let mut value = || words.next().ok_or_else(|| format!("{word} needs a value"));
        let number = |text: String| text.parse().map_err(|_| format!("{text} is not a number"));
        match word.as_str() {
            "--clients" => clients = number(value()?)? as u32,
            "--seconds" => seconds = number(value()?)?,
            "--victim" => victim = number(value()?)? > 0.0,
            "--only" => {
                let name = value()?;
                let known = Visit::ALL.into_iter().find(|visit| format!("{visit:?}") == name);
                only = Some(known.ok_or_else(|| format!("there is no visit {name}"))?);
            }
            "--seed" => seed = number(value()?)? as u64,
            text => invitation = Some(text.parse().map_err(|e| format!("{text}: {e}"))?),
        }
    }
    let invitation = invitation.ok_or("an invitation is missing")?;
    let time = Duration::try_from_secs_f64(seconds).map_err(|e| e.to_string())?;
    Ok(Options { invitation, clients, time, seed, only, victim })
}
