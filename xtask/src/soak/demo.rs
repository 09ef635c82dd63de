//! The demo under observation.
//!
//! The program counts its own allocations and reports them; here the process is looked at from
//! outside, so that what the allocator, the driver or a library keeps is seen too.

use super::watch;
use crate::{Failure, demo, process};

/// Runs the demo headless for `seconds` and fails if its memory grows. Its own output, the report
/// of its allocations included, is passed on.
pub(crate) fn run(seconds: f64, rest: &[String]) -> Result<(), Failure> {
    let program = demo::build()?;
    let mut command = demo::command(&program, true);
    command.args(["--soak", &format!("{seconds:.0}")]).args(rest);
    println!("$ {}", process::shown(&command));
    process::flush();
    let mut demo = super::spawn(&mut command, "the demo")?;
    let watched = demo.id();
    watch(&mut demo, "the demo", watched)?.judge("the demo")
}
