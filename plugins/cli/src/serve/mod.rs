//! `farlight serve`: a lighting server.

mod invite;
mod log;
mod memory;
mod place;

use std::{
    io::{self, Write as _},
    net::{Ipv4Addr, SocketAddr},
    path::PathBuf,
    sync::Arc,
    time::Duration,
};

use farlight_quic::{Authority, ListenConfig, ListenError, QuicListener};
use farlight_server::{Server, ServerSettings};
use farlight_wire::Invitation;
use tracing::{info, warn};

use crate::{
    check::server_settings,
    error::{CliError, read_text},
    signals::Signals,
};

/// Solve the light of games on other machines
///
/// Waits for games that use the network backend of Farlight's global illumination, takes their
/// scenes, and streams lightmaps and probes back. It needs no GPU and knows no game: whoever has the
/// invitation can send any scene.
///
/// The invitation is printed on one line of standard output once the server listens, and written to
/// a file if one is named; give it to the game (demo: --server INVITATION). It holds the access
/// token, so treat it like a password. It stays the same for as long as the folder of the server's
/// identity does, which is made at the first start.
///
/// The log goes to standard error. Ctrl-C (or SIGTERM) says goodbye to the clients and ends with
/// exit code 0; a second one ends at once.
#[derive(clap::Args)]
#[command(after_long_help = EXAMPLES)]
pub(crate) struct Args {
    /// Where to listen: ADDRESS:PORT, an address (port 4433), or :PORT (every address). UDP. Port 0
    /// is any free one. Default: the configuration's, or [::]:4433
    #[arg(long, value_name = "ADDR", value_parser = place::parse_listen)]
    listen: Option<SocketAddr>,
    /// Settings of the server, a ServerSettings(...) in RON: how many sessions, how much of
    /// everything each may have. `farlight check` checks it
    #[arg(long, value_name = "FILE.ron")]
    config: Option<PathBuf>,
    /// Write the invitation to this file, readable for you alone, once the server listens; removed
    /// when it ends
    #[arg(long, value_name = "FILE")]
    invite_file: Option<PathBuf>,
    /// Keep the SHA-256 hashes of the present and the next server certificate in this file, for
    /// browsers (serverCertificateHashes of WebTransport)
    #[arg(long, value_name = "FILE")]
    hashes_file: Option<PathBuf>,
    /// Folder of the server's identity: the authority that clients pin, and the access token.
    /// Default: the configuration's, or the user's data folder
    #[arg(long, value_name = "DIR")]
    state: Option<PathBuf>,
    /// Name or address that the invitation tells clients to connect to. Default: the
    /// configuration's, or the address that is listened on, or a guess of this machine's
    #[arg(long, value_name = "NAME")]
    host: Option<String>,
    /// Log more: connections, messages that were refused
    #[arg(short, long)]
    verbose: bool,
}

const EXAMPLES: &str = "\
Examples:
  farlight serve --listen 127.0.0.1:0 --invite-file light.invite
      for games on this machine alone, on any free port
  farlight serve --host light.example.org --config server.ron
      for games elsewhere; UDP port 4433 must get through

server.ron:
  ServerSettings(
      max_sessions: 2,
      resume_seconds: 300,
  )

RUST_LOG, if set, says what is logged (for example farlight=debug,warn).";

/// Runs the subcommand.
pub(crate) fn run(args: &Args) -> Result<(), CliError> {
    let (settings, chosen) = settings(args)?;
    log::start(args.verbose);
    let mut memory = memory::Memory::new();
    let folder = place::state_folder(&settings.state)?;
    let authority = Authority::open(&folder).map_err(|e| CliError::new(e.to_string()))?;
    let authority = Arc::new(authority);
    let listener = listen(args, &settings, chosen, &authority)?;
    let address = listener.local_addr();
    let host = place::public_host(&settings.public_host, address.ip());
    if let Some(warning) = &host.warning {
        warn!("{warning}");
    }
    let token = authority.token();
    let invitation = Invitation {
        host: host.name,
        port: address.port(),
        token,
        authority: authority.fingerprint(),
    };
    let signals = Signals::new()?;
    let sessions = settings.max_sessions;
    let server = Server::start(settings, Box::new(listener), token)
        .map_err(|e| CliError::new(e.to_string()))?;
    // The file says that the server can be reached, so it comes last.
    let file = args.invite_file.as_deref();
    let file = file.map(|path| invite::InviteFile::write(path, &invitation)).transpose()?;
    // A closed pipe is no reason to stop.
    let _ = writeln!(io::stdout(), "{invitation}").and_then(|()| io::stdout().flush());
    info!("listening at {address} for {sessions} sessions; identity in {}", folder.display());
    let ended = signals.wait(|| {
        memory.give_back(server.ended());
        server.is_running()
    });
    if let Some(file) = file {
        file.remove();
    }
    let name = ended.ok_or_else(|| CliError::new("the server's thread has failed (see above)"))?;
    info!("{name}: saying goodbye to the clients");
    server.stop();
    // The last packets leave on the network's own thread.
    std::thread::sleep(Duration::from_millis(100));
    Ok(())
}

/// Listens. Where no address was chosen and the machine has no IPv6, on every IPv4 address.
fn listen(
    args: &Args,
    settings: &ServerSettings,
    chosen: bool,
    authority: &Arc<Authority>,
) -> Result<QuicListener, CliError> {
    let bind = |address: SocketAddr| {
        let mut config = ListenConfig::new(address, authority.clone());
        config.limits = settings.limits();
        config.hashes.clone_from(&args.hashes_file);
        QuicListener::bind(config)
    };
    let any: SocketAddr = (Ipv4Addr::UNSPECIFIED, settings.listen.port()).into();
    let bound = match bind(settings.listen) {
        Err(ListenError::Address { source, .. })
            if !chosen && source.kind() != io::ErrorKind::AddrInUse =>
        {
            info!("{} can't be had ({source}), trying {any}", settings.listen);
            bind(any)
        }
        bound => bound,
    };
    bound.map_err(|error| match error {
        ListenError::Address { address, source } if source.kind() == io::ErrorKind::AddrInUse => {
            CliError::new(format!(
                "{address} is in use, perhaps by another server; --listen :0 takes a free port"
            ))
        }
        error => CliError::new(error.to_string()),
    })
}

/// The settings, checked, and whether the address was chosen by the user.
fn settings(args: &Args) -> Result<(ServerSettings, bool), CliError> {
    let mut settings = match &args.config {
        Some(path) => server_settings(path, &read_text(path)?)?,
        None => ServerSettings::default(),
    };
    let chosen = args.listen.is_some() || settings.listen != ServerSettings::default().listen;
    if let Some(listen) = args.listen {
        settings.listen = listen;
    }
    if let Some(host) = &args.host {
        settings.public_host.clone_from(host);
    }
    if let Some(state) = &args.state {
        settings.state.clone_from(state);
    }
    settings.validate().map_err(|e| CliError::new(format!("--host: {e}")))?;
    Ok((settings, chosen))
}
