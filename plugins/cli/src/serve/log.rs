//! The log of the server.

use std::io::IsTerminal as _;

use tracing_subscriber::EnvFilter;

/// Sends the log to standard error.
pub(super) fn start(verbose: bool) {
    // What the network says of every connection the sessions say as well.
    let [own, network] = if verbose { ["debug", "debug"] } else { ["info", "warn"] };
    let default = format!("warn,farlight={own},farlight_quic={network}");
    let filter = EnvFilter::try_from_default_env().unwrap_or_else(|_| EnvFilter::new(default));
    let log = tracing_subscriber::fmt()
        .with_env_filter(filter)
        .with_writer(std::io::stderr)
        .with_ansi(std::io::stderr().is_terminal())
        .with_target(false);
    // Somebody else's log goes on where there is one.
    let _ = log.try_init();
}
