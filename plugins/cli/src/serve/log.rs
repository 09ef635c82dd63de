//! The log of the server.

use std::io::IsTerminal as _;

use tracing_subscriber::EnvFilter;

/// Sends the log to standard error.
pub(super) fn start(verbose: bool) {
    let level = if verbose { "debug" } else { "info" };
    // What it says of every connection the sessions say as well.
    let quic = if verbose { ",farlight_quic=debug" } else { "" };
    let own = ["farlight", "farlight_server", "farlight_wire"];
    let default = own.map(|name| format!("{name}={level}")).join(",") + quic + ",warn";
    let filter = EnvFilter::try_from_default_env().unwrap_or_else(|_| EnvFilter::new(default));
    let log = tracing_subscriber::fmt()
        .with_env_filter(filter)
        .with_writer(std::io::stderr)
        .with_ansi(std::io::stderr().is_terminal())
        .with_target(false);
    // Somebody else's log goes on where there is one.
    let _ = log.try_init();
}
