//! The server's threads, over QUIC on this machine.

#[path = "../examples/reconnect/client.rs"]
mod client;
#[path = "../examples/reconnect/scene.rs"]
mod scene;

use std::{
    net::Ipv4Addr,
    sync::{Arc, mpsc::sync_channel},
    time::{Duration, Instant},
};

use client::Client;
use farlight_gi_solver::session::{LightingUpdate, Session, SessionChange, SnapshotId};
use farlight_quic::{Authority, ListenConfig, QuicConnector, QuicListener};
use farlight_server::{Server, ServerSettings, Solve};
use farlight_wire::{CloseCode, Closed, Connector, Invitation, Limits};

/// Only a guard against waiting for ever.
const PATIENCE: Duration = Duration::from_secs(60);

/// Solves as usual, but panics at the second snapshot.
struct Fragile(Session);

impl Solve for Fragile {
    fn apply(&mut self, snapshot: SnapshotId, changes: Vec<SessionChange>) {
        assert!(snapshot.0 < 2, "told to fail");
        self.0.apply(snapshot, changes);
    }

    fn step(&mut self) -> Option<LightingUpdate> {
        self.0.step()
    }

    fn is_idle(&self) -> bool {
        self.0.is_idle()
    }
}

#[track_caller]
fn wait(mut so: impl FnMut() -> bool) {
    let end = Instant::now() + PATIENCE;
    while !so() {
        assert!(Instant::now() < end, "it does not happen");
        std::thread::sleep(Duration::from_millis(5));
    }
}

#[test]
fn sessions_live_and_end_in_threads_of_their_own() {
    let folder = tempfile::tempdir().unwrap();
    let authority = Arc::new(Authority::open(folder.path()).unwrap());
    let config = ListenConfig::new((Ipv4Addr::LOCALHOST, 0).into(), authority.clone());
    let listener = QuicListener::bind(config).unwrap();
    let invitation = Invitation {
        host: Ipv4Addr::LOCALHOST.to_string(),
        port: listener.local_addr().port(),
        token: authority.token(),
        authority: authority.fingerprint(),
    };
    let server = Server::start_with(
        ServerSettings::default(),
        Box::new(listener),
        authority.token(),
        Box::new(|settings| Box::new(Fragile(Session::new(settings)))),
    );
    let server = server.unwrap();
    assert!(server.is_running() && server.sessions().is_empty());

    let (sender, woken) = sync_channel(1);
    let start = Instant::now();
    let mut connector = QuicConnector::new(&invitation);
    let mut connect = |name| {
        let sender = sender.clone();
        let wake = Arc::new(move || {
            // A full channel wakes as well.
            let _ = sender.try_send(());
        });
        let mut client = Client::new(name, invitation.token);
        client.use_link(connector.connect(&Limits::default(), wake));
        client.submit(start.elapsed(), scene::room(3.0));
        client
    };
    let mut clients = [connect("robust"), connect("unlucky")];
    let tick = |clients: &mut [Client; 2]| {
        let next = clients.iter_mut().filter_map(|client| client.tick(start.elapsed())).min();
        let pause = next.map_or(PATIENCE, |next| next.saturating_sub(start.elapsed()));
        // A timeout is as good as a message.
        let _ = woken.recv_timeout(pause.min(Duration::from_millis(100)));
    };
    let end = Instant::now() + PATIENCE;
    while !clients.iter().all(Client::is_lit) {
        assert!(Instant::now() < end, "no light");
        tick(&mut clients);
    }
    assert_eq!(server.sessions().len(), 2);

    // The solver of one fails; the other's is as it was.
    let unlucky = server.sessions().into_iter().find(|s| s.name == "unlucky").unwrap().number;
    clients[1].submit(start.elapsed(), scene::room(4.0));
    while clients[1].closed.is_none() {
        assert!(Instant::now() < end, "no goodbye");
        tick(&mut clients);
    }
    let Some(Closed::Goodbye(CloseCode::Failed, why)) = &clients[1].closed else {
        panic!("{:?}", clients[1].closed)
    };
    assert!(why.contains("told to fail"), "{why}");
    wait(|| server.ended() == 1);
    let rest = server.sessions();
    assert!(rest.len() == 1 && rest[0].number != unlucky, "{rest:?}");

    server.stop();
    while clients[0].closed.is_none() {
        assert!(Instant::now() < end, "no goodbye");
        tick(&mut clients);
    }
    let Some(Closed::Goodbye(CloseCode::ShuttingDown, _)) = &clients[0].closed else {
        panic!("{:?}", clients[0].closed)
    };
}
