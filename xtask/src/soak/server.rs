//! The lighting server under observation, while clients come and go.

use std::path::{Path, PathBuf};
use std::process::{Command, Stdio};
use std::time::{Duration, Instant};

use super::{Running, spawn, watch};
use crate::{Failure, demo, environment, process};

/// Few sessions, so that a client that fell silent makes room for the next ones early on: the
/// memory of the second fifth is that of a full server.
const SETTINGS: &str = "ServerSettings(max_sessions: 6, resume_seconds: 10, unused_blob_mib: 16)\n";

/// Clients at the same time.
const CLIENTS: &str = "4";

/// How long the server may take to start; the machine may be busy.
const PATIENCE: Duration = Duration::from_secs(60);

/// Runs `farlight serve` and reconnecting clients for `seconds`; fails if the memory of the server
/// grows, a client that should get light gets none, or the server does not end as it should.
pub(crate) fn run(seconds: f64) -> Result<(), Failure> {
    let [server, clients] = build()?;
    let folder = Folder::new()?;
    let settings = folder.0.join("server.ron");
    std::fs::write(&settings, SETTINGS).map_err(|e| format!("{}: {e}.", settings.display()))?;
    let invite = folder.0.join("invite");
    let log_path = environment::target_dir().join("soak-server.log");
    let log =
        std::fs::File::create(&log_path).map_err(|e| format!("{}: {e}.", log_path.display()))?;

    let mut command = Command::new(server);
    command.args(["serve", "--listen", "127.0.0.1:0", "--config"]).arg(&settings);
    command.arg("--state").arg(folder.0.join("identity")).arg("--invite-file").arg(&invite);
    command.stdout(Stdio::null()).stderr(log);
    println!("$ {}\n  (its log: {})", process::shown(&command), log_path.display());
    let mut server = spawn(&mut command, "the server")?;
    let invitation = wait_for(&invite, &mut server)?;

    let mut command = Command::new(clients);
    command.args(["--clients", CLIENTS, "--seconds", &format!("{seconds:.0}")]);
    println!("$ {} INVITATION", process::shown(&command));
    process::flush();
    let mut clients = spawn(command.arg(invitation.trim()), "the clients")?;
    let id = server.id();
    let watched = watch(&mut clients, "the clients", id)?;
    if let Some(status) = server.has_ended()? {
        return Err(format!("the server ended ({status}); see {}.", log_path.display()));
    }
    watched.judge("the server")?;
    end(&mut server, &invite)
}

/// Builds the server and the clients.
fn build() -> Result<[PathBuf; 2], Failure> {
    let mut cargo = process::cargo();
    cargo.args(["build", "--workspace", "--bin", "farlight", "--example", "reconnect"]);
    cargo.arg("--message-format=json-render-diagnostics");
    let mut programs = [None, None];
    let built = process::run_by_line(&mut cargo, |line| {
        if let Some(path) = demo::executable(line) {
            let names = ["farlight", "reconnect"];
            let which = names.iter().position(|name| path.file_stem().is_some_and(|f| f == *name));
            if let Some(which) = which {
                programs[which] = Some(path);
            }
        }
    })?;
    match programs {
        [Some(server), Some(clients)] if built => Ok([server, clients]),
        _ if built => Err("cargo did not say where it built the server.".to_owned()),
        _ => Err("the server or its clients do not build (see above).".to_owned()),
    }
}

/// The invitation, once the server has written it.
fn wait_for(invite: &Path, server: &mut Running) -> Result<String, Failure> {
    let start = Instant::now();
    loop {
        if let Ok(invitation) = std::fs::read_to_string(invite) {
            return Ok(invitation);
        }
        if let Some(status) = server.has_ended()? {
            return Err(format!("the server does not start ({status})."));
        }
        if start.elapsed() > PATIENCE {
            return Err("the server does not write its invitation.".to_owned());
        }
        std::thread::sleep(Duration::from_millis(20));
    }
}

/// Asks the server to end, which it must do by itself and cleanly.
fn end(server: &mut Running, invite: &Path) -> Result<(), Failure> {
    if !cfg!(unix) {
        println!("SKIPPED: how the server ends: this system has no SIGTERM.");
        return Ok(());
    }
    process::run(Command::new("kill").args(["-TERM", &server.id().to_string()]))?;
    let start = Instant::now();
    while start.elapsed() < PATIENCE {
        if let Some(status) = server.has_ended()? {
            return match (status.success(), invite.exists()) {
                (true, false) => Ok(()),
                (true, true) => Err("the server left its invitation behind.".to_owned()),
                (false, _) => Err(format!("the server did not end cleanly ({status}).")),
            };
        }
        std::thread::sleep(Duration::from_millis(20));
    }
    Err("the server does not end.".to_owned())
}

/// A folder that is removed at the end.
struct Folder(PathBuf);

impl Folder {
    fn new() -> Result<Self, Failure> {
        let path = environment::target_dir().join(format!("soak-{}", std::process::id()));
        std::fs::create_dir_all(&path).map_err(|e| format!("{}: {e}.", path.display()))?;
        Ok(Self(path))
    }
}

impl Drop for Folder {
    fn drop(&mut self) {
        let _ = std::fs::remove_dir_all(&self.0);
    }
}
