//! `farlight serve` as a process, with clients over loopback.

#[path = "../../remote/server/examples/reconnect/client.rs"]
mod client;
#[path = "../../remote/server/tests/sessions/light.rs"]
mod light;
#[path = "../../remote/server/examples/reconnect/scene.rs"]
mod scene;
mod support;

use std::{
    fs,
    io::{BufRead as _, BufReader},
    path::{Path, PathBuf},
    process::{Child, Command, ExitStatus, Output, Stdio},
    sync::{
        Arc,
        mpsc::{Receiver, sync_channel},
    },
    time::{Duration, Instant},
};

use client::Client;
use farlight_quic::QuicConnector;
use farlight_wire::{CloseCode, Closed, Connector, Invitation, Limits, Token, Wake};
use glam::Vec3;
use light::assert_like_local;
use support::Folder;

/// Only a guard against waiting for ever.
const PATIENCE: Duration = Duration::from_secs(60);

/// The command, with the folder's identity.
fn serve(folder: &Folder, more: &[&str]) -> Command {
    let mut command = Command::new(env!("CARGO_BIN_EXE_farlight"));
    command.arg("serve").arg("--state").arg(folder.at("identity")).args(more);
    command.env_remove("RUST_LOG").stdin(Stdio::null());
    command
}

/// A run that ends by itself.
fn run(folder: &Folder, more: &[&str]) -> Output {
    serve(folder, more).output().unwrap()
}

/// A running server; killed at the end of the test.
struct Server {
    child: Child,
    invitation: Invitation,
    log: PathBuf,
}

impl Server {
    fn start(folder: &Folder, more: &[&str]) -> Self {
        Self::start_at("127.0.0.1:0", folder, more)
    }

    fn start_at(listen: &str, folder: &Folder, more: &[&str]) -> Self {
        let log = folder.at("log");
        let mut command = serve(folder, &["--listen", listen]);
        command.args(more).stdout(Stdio::piped()).stderr(fs::File::create(&log).unwrap());
        let mut child = command.spawn().unwrap();
        let mut line = String::new();
        BufReader::new(child.stdout.take().unwrap()).read_line(&mut line).unwrap();
        let invitation = line.parse().unwrap_or_else(|error| {
            panic!("{line:?}: {error}\n{}", fs::read_to_string(&log).unwrap())
        });
        Self { child, invitation, log }
    }

    fn log(&self) -> String {
        fs::read_to_string(&self.log).unwrap()
    }

    /// Sends a signal and waits for the end.
    #[cfg(unix)]
    fn end(&mut self, signal: &str) -> ExitStatus {
        let id = self.child.id().to_string();
        assert!(Command::new("kill").args([signal, &id]).status().unwrap().success());
        self.wait()
    }

    fn wait(&mut self) -> ExitStatus {
        let end = Instant::now() + PATIENCE;
        while Instant::now() < end {
            if let Some(status) = self.child.try_wait().unwrap() {
                return status;
            }
            std::thread::sleep(Duration::from_millis(10));
        }
        panic!("the server does not end\n{}", self.log());
    }
}

impl Drop for Server {
    fn drop(&mut self) {
        let _ = self.child.kill();
        let _ = self.child.wait();
    }
}

/// A client over QUIC and its clock.
struct Game {
    client: Client,
    connector: QuicConnector,
    wake: Wake,
    woken: Receiver<()>,
    start: Instant,
}

impl Game {
    fn join(invitation: &Invitation) -> Self {
        let (sender, woken) = sync_channel(1);
        let wake: Wake = Arc::new(move || {
            // A full channel wakes as well.
            let _ = sender.try_send(());
        });
        let client = Client::new("a test", invitation.token);
        let connector = QuicConnector::new(invitation);
        let mut game = Self { client, connector, wake, woken, start: Instant::now() };
        game.connect();
        game
    }

    fn connect(&mut self) {
        let link = self.connector.connect(&Limits::default(), self.wake.clone());
        self.client.use_link(link);
    }

    fn submit(&mut self, changes: Vec<farlight_gi_solver::session::SessionChange>) {
        self.client.submit(self.start.elapsed(), changes);
    }

    #[track_caller]
    fn run_until(&mut self, so: impl Fn(&Client) -> bool) {
        let end = Instant::now() + PATIENCE;
        loop {
            let next = self.client.tick(self.start.elapsed());
            if so(&self.client) {
                return;
            }
            assert!(Instant::now() < end, "it does not happen: {:?}", self.client.closed);
            let next = next.map_or(PATIENCE, |next| next.saturating_sub(self.start.elapsed()));
            // A timeout is as good as a message.
            let _ = self.woken.recv_timeout(next.min(Duration::from_secs(1)));
        }
    }

    #[track_caller]
    fn goodbye(&mut self) -> (CloseCode, String) {
        self.run_until(|client| client.closed.is_some());
        match &self.client.closed {
            Some(Closed::Goodbye(code, why)) => (*code, why.to_string()),
            other => panic!("{other:?}"),
        }
    }
}

#[test]
fn light_over_loopback_is_that_of_a_session_on_the_spot() {
    let folder = Folder::new("light");
    let server = Server::start(&folder, &[]);
    let mut game = Game::join(&server.invitation);
    game.submit(scene::room(3.0));
    game.run_until(|client| client.session.is_converged());
    assert!(game.client.is_lit());
    assert_like_local(&game.client, 3.0);
    // The connection breaks; the session is resumed with what changed meanwhile.
    game.client.cut();
    game.submit(vec![scene::lamp(Vec3::new(0.5, 1.0, 0.5), 30.0)]);
    game.connect();
    game.run_until(Client::is_lit);
    assert_eq!(game.client.welcomed, Some(true));
    game.client.close();

    // Another one with a wrong token, and a third that is let in nevertheless.
    let mut invitation = server.invitation.clone();
    invitation.token = Token([1; 16]);
    let (code, why) = Game::join(&invitation).goodbye();
    assert_eq!(code, CloseCode::Unauthorized, "{why}");
    Game::join(&server.invitation).run_until(|client| client.welcomed.is_some());
    let log = server.log();
    assert!(log.contains("\"a test\"") && log.contains("token is wrong"), "{log}");
    let secrets = [server.invitation.token.to_string(), invitation.token.to_string()];
    assert!(secrets.iter().all(|secret| !log.contains(secret)), "{log}");
}

#[test]
fn a_server_killed_and_started_again_gets_the_scene_again() {
    let folder = Folder::new("killed");
    let mut server = Server::start(&folder, &[]);
    let mut game = Game::join(&server.invitation);
    game.submit(scene::room(3.0));
    game.run_until(Client::is_lit);
    server.child.kill().unwrap();
    server.wait();
    let port = server.invitation.port;
    drop(server);
    // As good as an outage: the identity stays, the address too.
    let listen = format!("127.0.0.1:{port}");
    let server = Server::start_at(&listen, &folder, &[]);
    game.connect();
    game.run_until(|client| client.is_lit() && client.session.is_converged());
    assert_eq!(game.client.welcomed, Some(false));
    assert_like_local(&game.client, 3.0);
    assert_eq!(server.invitation.port, port);
}

#[cfg(unix)]
#[test]
fn the_invitation_is_there_while_the_server_is() {
    use std::os::unix::fs::PermissionsExt as _;
    let folder = Folder::new("invitation");
    let [file, hashes] = ["invite", "hashes.json"].map(|name| folder.at(name));
    let options = [
        "--invite-file",
        file.to_str().unwrap(),
        "--hashes-file",
        hashes.to_str().unwrap(),
        "--host",
        "light.example.org",
    ];
    let mut server = Server::start(&folder, &options);
    let first = server.invitation.clone();
    assert_eq!(first.host, "light.example.org");
    assert_eq!(fs::read_to_string(&file).unwrap(), format!("{first}\n"));
    assert_eq!(fs::metadata(&file).unwrap().permissions().mode() & 0o777, 0o600);
    let hashes: serde_json::Value =
        serde_json::from_str(&fs::read_to_string(&hashes).unwrap()).unwrap();
    assert_eq!(hashes["hashes"].as_array().unwrap().len(), 2);
    assert!(server.log().contains("only this machine"), "{}", server.log());
    assert!(server.end("-INT").success());
    assert!(!file.exists());

    // The identity stays: the same token and fingerprint.
    let mut server = Server::start(&folder, &["--invite-file", file.to_str().unwrap()]);
    assert_eq!(server.invitation.token, first.token);
    assert_eq!(server.invitation.authority, first.authority);
    assert_eq!(server.invitation.host, "127.0.0.1");
    // What another server has written there stays.
    fs::write(&file, "another's").unwrap();
    let mut game = Game::join(&server.invitation);
    game.run_until(|client| client.welcomed.is_some());
    assert!(server.end("-TERM").success());
    assert_eq!(game.goodbye().0, CloseCode::ShuttingDown);
    assert_eq!(fs::read_to_string(&file).unwrap(), "another's");
    // Another identity is another server.
    let other = Folder::new("other-identity");
    assert_ne!(Server::start(&other, &[]).invitation.authority, first.authority);
}

#[test]
fn settings_come_from_a_file() {
    let folder = Folder::new("settings");
    let config = folder.at("server.ron");
    let text = "ServerSettings(max_sessions: 1, public_host: \"::1\", max_page_size: 128)";
    fs::write(&config, text).unwrap();
    let server = Server::start(&folder, &["--config", config.to_str().unwrap()]);
    assert_eq!(server.invitation.host, "::1");
    let mut invitation = server.invitation.clone();
    invitation.host = "127.0.0.1".to_owned();
    let mut first = Game::join(&invitation);
    first.run_until(|client| client.welcomed.is_some());
    let (code, why) = Game::join(&invitation).goodbye();
    assert_eq!(code, CloseCode::Full);
    assert!(why.contains('1'), "{why}");
}

/// The message of a run that must fail, and says nothing else.
#[track_caller]
fn refused(output: &Output) -> String {
    assert!(output.stdout.is_empty(), "{output:?}");
    support::refused(output)
}

#[test]
fn errors_help() {
    let folder = Folder::new("errors");
    let config = folder.at("server.ron");
    let with_config = |text: &str| {
        fs::write(&config, text).unwrap();
        refused(&run(&folder, &["--config", config.to_str().unwrap()]))
    };
    let message = with_config("ServerSettings(\n  max_sessions: 0,\n)");
    assert!(message.contains("server.ron:2") && message.contains("max_sessions"), "{message}");
    let message = with_config("ServerSettings(\n  max_session: 3,\n)");
    assert!(message.contains("server.ron:2") && message.contains("max_session"), "{message}");
    let message = refused(&run(&folder, &["--config", folder.at("none.ron").to_str().unwrap()]));
    assert!(message.contains("none.ron"), "{message}");
    let message = refused(&run(&folder, &["--listen", "nowhere"]));
    assert!(message.contains("--listen"), "{message}");
    let message = refused(&run(&folder, &["--host", "a b", "--listen", "127.0.0.1:0"]));
    assert!(message.contains("--host") && message.contains("a b"), "{message}");
    // Nobody has an address for documentation (RFC 5737).
    let message = refused(&run(&folder, &["--listen", "192.0.2.1:0"]));
    assert!(message.contains("192.0.2.1"), "{message}");

    let server = Server::start(&folder, &[]);
    let taken = format!("127.0.0.1:{}", server.invitation.port);
    let message = refused(&run(&folder, &["--listen", &taken]));
    assert!(message.contains(&taken) && message.contains("in use"), "{message}");
    let missing = folder.at("no/such/invite");
    let listen = ["--listen", "127.0.0.1:0", "--invite-file", missing.to_str().unwrap()];
    let message = refused(&run(&folder, &listen));
    assert!(message.contains("no/such/invite"), "{message}");

    let damaged = Folder::new("damaged");
    fs::create_dir_all(damaged.at("identity")).unwrap();
    fs::write(damaged.at("identity/token"), "short").unwrap();
    let message = refused(&run(&damaged, &["--listen", "127.0.0.1:0"]));
    assert!(message.contains("token") && message.contains("damaged"), "{message}");
    assert_eq!(fs::read_to_string(damaged.at("identity/token")).unwrap(), "short");
}

#[test]
fn help_explains_invitations() {
    let folder = Folder::new("help");
    let output = run(&folder, &["--help"]);
    let text = String::from_utf8_lossy(&output.stdout);
    for word in
        ["invitation", "--invite-file", "--hashes-file", "ServerSettings", "SIGTERM", "4433"]
    {
        assert!(text.contains(word), "{word}");
    }
    assert!(!Path::new(&folder.at("identity")).exists(), "help makes nothing");
}
