//! The server with clients over a simulated network, in virtual time.

#[path = "../../examples/reconnect/client.rs"]
mod client;
mod light;
#[path = "../../examples/reconnect/scene.rs"]
mod scene;
mod trouble;
mod world;

use std::time::Duration;

use farlight_server::ServerSettings;
use farlight_wire::{CloseCode, Closed, Limits, simulated::LinkConditions};
use glam::Vec3;
use light::assert_like_local;
use world::{World, secs};

#[test]
fn a_scene_goes_there_and_its_light_comes_back() {
    let mut world = World::new(ServerSettings::default());
    let client = world.connect("a game");
    world.submit(client, scene::room(3.0));
    world.run_until(|w| w.clients[client].session.is_converged());
    assert!(world.clients[client].is_lit());
    assert_like_local(&world.clients[client], 3.0);
    let report = &world.server().sessions()[0];
    assert_eq!((report.name.as_str(), report.number), ("a game", 1));
    assert!(report.converged && report.address.is_some());
    assert_eq!(report.size.triangles, 12);
}

#[test]
fn a_still_scene_costs_keep_alives_only() {
    let mut world = World::new(ServerSettings::default());
    let client = world.connect("still");
    world.submit(client, scene::room(3.0));
    world.run_until(|w| w.clients[client].session.is_converged());
    world.run(secs(5));
    let before = world.network.counters();
    let messages = world.clients[client].light.messages;
    world.run(secs(60));
    let after = world.network.counters();
    let total = |counters: farlight_wire::simulated::Counters| {
        use farlight_wire::Channel::{Bulk, Control, Latest};
        let light = [Bulk, Latest].map(|c| counters.to_client(c).messages).iter().sum::<u64>();
        let control = [counters.to_client(Control), counters.to_server(Control)];
        (light, control.iter().map(|c| c.bytes).sum::<u64>())
    };
    assert_eq!(total(after).0, total(before).0, "light of a still scene");
    assert_eq!(world.clients[client].light.messages, messages);
    let bytes = total(after).1 - total(before).1;
    assert!(bytes > 0 && bytes < 60 * 50, "{bytes} bytes of keep-alives in a minute");
}

#[test]
fn a_session_is_resumed_after_the_line_was_cut() {
    let mut world = World::new(ServerSettings::default());
    let client = world.connect("resumes");
    world.submit(client, scene::room(3.0));
    world.run_until(|w| w.clients[client].session.is_converged());
    let first = world.clients[client].light.messages;

    world.clients[client].cut();
    world.run(secs(30));
    let report = &world.server().sessions()[0];
    assert!(report.address.is_none() && report.away.is_some(), "{report:?}");
    // Changed while nobody listens.
    world.submit(client, vec![scene::lamp(Vec3::new(0.5, 1.0, 0.5), 30.0)]);
    world.reconnect(client);
    world.run_until(|w| w.clients[client].is_lit());
    assert_eq!(world.clients[client].welcomed, Some(true));
    assert!(world.clients[client].light.messages > first);
    assert_eq!(world.server().sessions().len(), 1);
    assert_eq!(world.server().sessions()[0].away, None);
}

/// The server has not noticed that the old line is dead.
#[test]
fn a_client_that_comes_back_early_replaces_itself() {
    let mut world = World::new(ServerSettings::default());
    let client = world.connect("hasty");
    world.submit(client, scene::room(3.0));
    world.run_until(|w| w.clients[client].is_lit());
    // The old link stays open beside the new one.
    let mut old = world.clients[client].link.take().unwrap();
    world.clients[client].session.disconnected();
    world.reconnect(client);
    world.run_until(|w| w.clients[client].welcomed.is_some());
    assert_eq!(world.clients[client].welcomed, Some(true));
    world.run(secs(1));
    let end = std::iter::from_fn(|| old.poll()).last();
    let closed = farlight_wire::LinkEvent::Closed(Closed::Goodbye(CloseCode::Replaced, "".into()));
    assert_eq!(end, Some(closed));
    assert_eq!(world.server().sessions().len(), 1);
}

#[test]
fn sessions_whose_client_does_not_come_back_end() {
    let settings = ServerSettings { resume_seconds: 20, ..ServerSettings::default() };
    let mut world = World::new(settings);
    let client = world.connect("gone");
    world.submit(client, scene::room(3.0));
    world.run_until(|w| w.clients[client].is_lit());
    world.clients[client].cut();
    world.run(secs(15));
    assert_eq!(world.server().sessions().len(), 1);
    // The dead line is noticed after a while, then the time runs.
    world.run(secs(25));
    assert_eq!(world.server().sessions().len(), 0);
    // A new session, and all of the scene again.
    world.reconnect(client);
    world.run_until(|w| w.clients[client].is_lit() && w.clients[client].session.is_converged());
    assert_eq!(world.clients[client].welcomed, Some(false));
    assert_like_local(&world.clients[client], 3.0);
}

#[test]
fn a_goodbye_ends_the_session_at_once() {
    let mut world = World::new(ServerSettings::default());
    let client = world.connect("polite");
    world.submit(client, scene::room(3.0));
    world.run_until(|w| w.clients[client].is_lit());
    world.clients[client].close();
    world.run(secs(1));
    assert_eq!(world.server().sessions().len(), 0);
}

#[test]
fn a_server_that_stops_says_so() {
    let mut world = World::new(ServerSettings::default());
    let client = world.connect("left");
    world.run_until(|w| w.clients[client].welcomed.is_some());
    world.stop_server();
    world.run(secs(1));
    let Some(Closed::Goodbye(code, _)) = &world.clients[client].closed else { panic!() };
    assert_eq!(*code, CloseCode::ShuttingDown);
    // Another one knows nothing of the session and gets all of the scene.
    world.submit(client, scene::room(3.0));
    world.start_server(ServerSettings::default());
    world.reconnect(client);
    world.run_until(|w| w.clients[client].is_lit());
    assert_eq!(world.clients[client].welcomed, Some(false));
}

/// 100 ms round trip, 5 % loss.
#[test]
fn light_comes_over_a_bad_line() {
    let mut world = World::new(ServerSettings::default());
    world.network.set_conditions(LinkConditions {
        delay: Duration::from_millis(50),
        jitter: Duration::from_millis(10),
        loss: 0.05,
        ..LinkConditions::default()
    });
    let client = world.connect("far away");
    world.submit(client, scene::room(3.0));
    world.run_until(|w| w.clients[client].session.is_converged());
    assert_like_local(&world.clients[client], 3.0);
    assert_eq!(world.limits(), Limits::default());
}
