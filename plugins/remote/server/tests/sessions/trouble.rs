//! Clients that may not come in, or behave badly, and solvers that fail.

use std::sync::{
    Arc,
    atomic::{AtomicU64, Ordering},
};

use farlight_gi_solver::session::{
    LightingUpdate, Session, SessionChange, SessionSettings, SnapshotId,
};
use farlight_server::{ServerSettings, Solve};
use farlight_wire::{
    Channel, ClientConfig, ClientSession, CloseCode, Closed, Limits, LinkEvent, Token, Transmit,
    TransmitId,
};

use crate::{
    client::Client,
    light::assert_like_local,
    scene,
    world::{TOKEN, World, secs},
};

#[track_caller]
fn goodbye(world: &mut World, client: usize) -> (CloseCode, String) {
    world.run_until(|w| w.clients[client].closed.is_some());
    match &world.clients[client].closed {
        Some(Closed::Goodbye(code, why)) => (*code, why.to_string()),
        other => panic!("{other:?}"),
    }
}

#[test]
fn a_wrong_token_is_refused_after_a_while() {
    let mut world = World::new(ServerSettings::default());
    let client = world.add(Client::new("guesses", Token([8; 16])));
    world.run(std::time::Duration::from_millis(200));
    assert!(world.clients[client].closed.is_none(), "guessing must be slow");
    let (code, why) = goodbye(&mut world, client);
    assert_eq!(code, CloseCode::Unauthorized);
    assert!(why.contains("token"), "{why}");
    assert!(world.server().sessions().is_empty());
}

#[test]
fn who_does_not_greet_is_sent_away() {
    let settings = ServerSettings { hello_seconds: 2, ..ServerSettings::default() };
    let mut world = World::new(settings);
    let mut silent = world.link();
    world.run(secs(4));
    let end = std::iter::from_fn(|| silent.poll()).last();
    let Some(LinkEvent::Closed(Closed::Goodbye(code, why))) = end else { panic!("{end:?}") };
    assert_eq!(code, CloseCode::Protocol);
    assert!(why.contains("greeting"), "{why}");
}

#[test]
fn many_who_do_not_greet_keep_nobody_out() {
    let mut world = World::new(ServerSettings::default());
    let mut crowd: Vec<_> = (0..200).map(|_| world.link()).collect();
    world.run(secs(1));
    let client = world.connect("a game");
    world.run_until(|w| w.clients[client].welcomed.is_some());
    let sent_away = crowd.iter_mut().filter_map(|link| std::iter::from_fn(|| link.poll()).last());
    let full =
        |event: &LinkEvent| matches!(event, LinkEvent::Closed(Closed::Goodbye(CloseCode::Full, _)));
    assert!(sent_away.filter(full).count() >= 200 - 64);
}

#[test]
fn a_full_server_says_so_and_has_room_again_later() {
    let settings = ServerSettings { max_sessions: 2, ..ServerSettings::default() };
    let mut world = World::new(settings);
    let [first, second] = ["first", "second"].map(|name| world.connect(name));
    world.run_until(|w| [first, second].iter().all(|c| w.clients[*c].welcomed.is_some()));
    let third = world.connect("third");
    let (code, why) = goodbye(&mut world, third);
    assert_eq!(code, CloseCode::Full);
    assert!(why.contains('2'), "{why}");
    // One that only waits for its client makes room.
    world.clients[first].cut();
    world.run(secs(20));
    assert_eq!(world.server().sessions().len(), 2);
    world.reconnect(third);
    world.run_until(|w| w.clients[third].welcomed.is_some());
    let names: Vec<_> = world.server().sessions().into_iter().map(|s| s.name).collect();
    assert_eq!(names, ["second", "third"]);
}

#[test]
fn pages_that_are_too_large_are_refused_with_both_numbers() {
    let settings = ServerSettings { max_page_size: 32, ..ServerSettings::default() };
    let mut world = World::new(settings);
    let client = world.connect("greedy");
    let (code, why) = goodbye(&mut world, client);
    assert_eq!(code, CloseCode::Limit);
    assert!(why.contains("64") && why.contains("32"), "{why}");
}

#[test]
fn other_numbers_are_lowered() {
    let settings = ServerSettings { max_pages: 1, ray_memory_mib: 1, ..ServerSettings::default() };
    let mut world = World::new(settings);
    let client = world.connect("modest");
    world.submit(client, scene::room(3.0));
    world.run_until(|w| w.clients[client].is_lit());
    assert!(world.clients[client].light.pages.keys().all(|page| page.0 == 0));
}

#[test]
fn scenes_over_a_limit_end_their_session() {
    let settings = ServerSettings { max_triangles: 10, ..ServerSettings::default() };
    let mut world = World::new(settings);
    let client = world.connect("large");
    world.submit(client, scene::room(3.0));
    let (code, why) = goodbye(&mut world, client);
    assert_eq!(code, CloseCode::Limit);
    assert!(why.contains("10"), "{why}");
    assert!(world.server().sessions().is_empty());
}

/// Whatever the third one sends.
#[test]
fn two_sessions_are_undisturbed_by_a_third_that_sends_garbage() {
    let mut world = World::new(ServerSettings::default());
    let good = [3.0, 4.0].map(|size| {
        let client = world.connect("good");
        world.submit(client, scene::room(size));
        (client, size)
    });
    let mut random = 12345_u64;
    let mut ends = Vec::new();
    for round in 0..40_u64 {
        let bad = world.connect("bad");
        world.run_until(|w| w.clients[bad].welcomed.is_some());
        for i in 0..5 {
            let mut message = vec![0; 1 + (round * 7 + i) as usize];
            for byte in &mut message {
                random = random.wrapping_mul(6_364_136_223_846_793_005).wrapping_add(1);
                *byte = (random >> 56) as u8;
            }
            // Kinds that exist are more interesting than those that are skipped.
            message[0] = [10, 11, 12, 13, 15, 30, 31][(round % 7) as usize];
            if message.len() > 1 {
                message[1] = 0;
            }
            let channel = Channel::ALL[(random % 3) as usize];
            let id = TransmitId(1 << 40 | i);
            if let Some(link) = &mut world.clients[bad].link {
                link.send(Transmit { id, channel, message });
            }
        }
        world.run(secs(1));
        ends.extend(world.clients[bad].closed.take());
        world.clients[bad].close();
    }
    let protocol =
        |end: &Closed| matches!(end, Closed::Goodbye(CloseCode::Protocol | CloseCode::Limit, _));
    assert!(ends.len() > 20 && ends.iter().all(protocol), "{ends:?}");
    for (client, size) in good {
        world.run_until(|w| w.clients[client].session.is_converged());
        assert!(world.clients[client].closed.is_none());
        assert_like_local(&world.clients[client], size);
    }
    assert_eq!(world.server().sessions().len(), 2);
}

/// What is not even a greeting.
#[test]
fn garbage_instead_of_a_greeting_is_refused() {
    let mut world = World::new(ServerSettings::default());
    for (channel, message) in [
        (Channel::Control, vec![]),
        (Channel::Control, b"GET / HTTP/1.1\r\n\r\n".to_vec()),
        (Channel::Control, b"farlight\xff\xff\0\0\x01\0".to_vec()),
        (Channel::Bulk, vec![0; 1000]),
        (Channel::Latest, vec![1]),
    ] {
        let mut link = world.link();
        link.send(Transmit { id: TransmitId(1), channel, message });
        world.run(secs(1));
        let end = std::iter::from_fn(|| link.poll()).last();
        let Some(LinkEvent::Closed(Closed::Goodbye(code, _))) = end else { panic!("{end:?}") };
        assert!(matches!(code, CloseCode::Protocol | CloseCode::Incompatible), "{code:?}");
    }
}

/// Solves as usual, but panics at the second snapshot of the session with seed 666.
struct Fragile {
    session: Session,
    fragile: bool,
}

impl Solve for Fragile {
    fn apply(&mut self, snapshot: SnapshotId, changes: Vec<SessionChange>) {
        assert!(!(self.fragile && snapshot.0 >= 2), "told to fail");
        self.session.apply(snapshot, changes);
    }

    fn step(&mut self) -> Option<LightingUpdate> {
        self.session.step()
    }

    fn is_idle(&self) -> bool {
        self.session.is_idle()
    }
}

#[test]
fn a_solver_that_fails_ends_its_session_alone() {
    static MADE: AtomicU64 = AtomicU64::new(0);
    let mut world = World::with_solver(
        ServerSettings::default(),
        Box::new(|settings| {
            MADE.fetch_add(1, Ordering::Relaxed);
            let fragile = settings.seed == 666;
            Box::new(Fragile { session: Session::new(settings), fragile })
        }),
    );
    let good = world.connect("good");
    world.submit(good, scene::room(3.0));
    let bad = world.add(Client::with(ClientSession::new(ClientConfig {
        name: "unlucky".into(),
        token: TOKEN,
        settings: SessionSettings { seed: 666, ..scene::settings() },
        limits: Limits::default(),
    })));
    world.submit(bad, scene::room(3.0));
    world.run_until(|w| w.clients[bad].is_lit());
    world.submit(bad, scene::room(4.0));
    let (code, why) = goodbye(&mut world, bad);
    assert_eq!(code, CloseCode::Failed);
    assert!(why.contains("told to fail"), "{why}");
    world.run_until(|w| w.clients[good].session.is_converged());
    assert_like_local(&world.clients[good], 3.0);
    assert_eq!(world.server().sessions().len(), 1);
    // The client gets a new session with a new solver, which fails again at its first snapshot.
    world.reconnect(bad);
    assert_eq!(goodbye(&mut world, bad).0, CloseCode::Failed);
    assert_eq!(MADE.load(Ordering::Relaxed), 3);
    assert!(world.clients[good].closed.is_none());
}

/// Always finds something to do; counts how often it is asked.
struct Tireless {
    pending: Option<SnapshotId>,
    steps: Arc<AtomicU64>,
}

impl Solve for Tireless {
    fn apply(&mut self, snapshot: SnapshotId, _: Vec<SessionChange>) {
        self.pending = Some(snapshot);
    }

    fn step(&mut self) -> Option<LightingUpdate> {
        self.steps.fetch_add(1, Ordering::Relaxed);
        let snapshot = self.pending.take()?;
        Some(LightingUpdate { snapshot, ..LightingUpdate::default() })
    }

    fn is_idle(&self) -> bool {
        false
    }
}

#[test]
fn a_solver_rests_while_its_client_is_away() {
    let steps = Arc::new(AtomicU64::new(0));
    let for_solver = steps.clone();
    let mut world = World::with_solver(
        ServerSettings::default(),
        Box::new(move |_| Box::new(Tireless { pending: None, steps: for_solver.clone() })),
    );
    let count = || steps.load(Ordering::Relaxed);
    let client = world.connect("comes and goes");
    world.submit(client, vec![scene::lamp(glam::Vec3::ONE, 1.0)]);
    world.run_until(|w| w.clients[client].light.snapshot == SnapshotId(1));
    let before = count();
    world.run(secs(1));
    assert!(count() > before + 100, "somebody is looking");
    world.clients[client].cut();
    world.run_until(|w| w.server().sessions()[0].away.is_some());
    world.run(secs(1));
    let before = count();
    world.run(secs(20));
    assert_eq!(count(), before, "nobody is looking");
    world.reconnect(client);
    world.run_until(|w| w.clients[client].welcomed == Some(true));
    world.run(secs(1));
    assert!(count() > before + 100, "somebody is looking again");
}
