//! Servers that die, come back, or don't let the game in.

use std::time::Duration;

use farlight::gi::{BackendState, LightingBackend, LinkState};
use farlight_wire::{Channel, Token};

use crate::{
    scene::{Locals, lamp},
    stage::{MS, Stage, bad_line},
};

const RIGHT: f32 = 0.05;

/// Bytes of blobs that have gone to servers.
fn blob_bytes(stage: &Stage) -> u64 {
    stage.network.counters().to_server(Channel::Bulk).bytes
}

#[test]
fn a_killed_server_is_replaced_by_a_new_one_which_gets_the_scene() {
    let mut locals = Locals::default();
    for seed in 0..4 {
        let mut stage = Stage::new(seed, bad_line());
        stage.submit_room(0.0);
        stage.settle();
        let first = blob_bytes(&stage);
        assert!(first > 0);
        let right = stage.picture.clone();
        stage.kill_server();
        stage.run(Duration::from_secs(seed * 6));
        // Nothing that was solved is lost meanwhile.
        assert!(stage.picture.error(&right) < 1e-6);
        if seed > 0 {
            let BackendState::Disconnected { reason } = stage.backend.state() else {
                panic!("{stage:?}")
            };
            assert!(!reason.is_empty());
            let LinkState::Reconnecting { attempt, .. } = stage.link_state() else {
                panic!("{stage:?}")
            };
            assert!(attempt > 0);
        }
        stage.submit(vec![lamp(1.0)]);
        stage.start_server();
        let took = stage.run_until(Duration::from_secs(10), |stage| {
            stage.picture.error(locals.get(1.0)) < RIGHT
        });
        println!("seed {seed}: right {took:?} after a new server came up");
        assert_eq!(blob_bytes(&stage), 2 * first, "the new server knows nothing");
        stage.settle();
        assert_eq!(stage.link_state(), LinkState::Connected);
        assert_eq!(stage.backend.link().unwrap().reconnects, 1);
    }
}

#[test]
fn a_session_that_the_server_still_has_is_resumed_without_sending_blobs_again() {
    let mut locals = Locals::default();
    for seed in 0..4 {
        let mut stage = Stage::new(seed, bad_line());
        stage.submit_room(0.0);
        stage.settle();
        let first = blob_bytes(&stage);
        stage.network.set_down(true);
        stage.submit(vec![lamp(1.0)]);
        // The link is lost after ten seconds; the server keeps the session for a minute.
        stage.run(Duration::from_secs(30));
        assert!(matches!(stage.backend.state(), BackendState::Disconnected { .. }));
        stage.network.set_down(false);
        let took = stage.run_until(Duration::from_secs(8), |stage| {
            stage.picture.error(locals.get(1.0)) < RIGHT
        });
        println!("seed {seed}: right {took:?} after half a minute without a line");
        stage.settle();
        assert_eq!(blob_bytes(&stage), first);
        assert_eq!(stage.server.as_ref().unwrap().sessions().len(), 1);
    }
}

#[test]
fn a_wrong_token_is_final_and_is_said() {
    let mut stage = Stage::with_token(1, Default::default(), Token([8; 16]));
    stage.submit_room(0.0);
    stage.run(Duration::from_secs(5));
    let BackendState::Failed(reason) = stage.backend.state() else { panic!("{stage:?}") };
    assert!(reason.contains("token"), "{reason}");
    assert_eq!(stage.link_state(), LinkState::GivenUp);
    let connections = stage.network.counters().connections;
    stage.submit(vec![lamp(1.0)]);
    stage.run(Duration::from_secs(60));
    assert_eq!(stage.network.counters().connections, connections, "it has given up");
}

#[test]
fn a_server_that_stops_says_so_and_may_come_back() {
    let mut stage = Stage::new(1, Default::default());
    stage.submit_room(0.0);
    stage.settle();
    stage.server.take().unwrap().stop();
    stage.run(500 * MS);
    let BackendState::Disconnected { reason } = stage.backend.state() else { panic!("{stage:?}") };
    assert!(reason.contains("stopped") || reason.contains("shutting down"), "{reason}");
    stage.start_server();
    stage.settle();
}

#[test]
fn a_resync_brings_all_light_again() {
    let mut locals = Locals::default();
    let mut stage = Stage::new(1, bad_line());
    stage.submit_room(0.0);
    stage.settle();
    stage.run(Duration::from_secs(2));
    let blobs = blob_bytes(&stage);
    stage.picture = Default::default();
    stage.resync();
    stage.run_until(2000 * MS, |stage| stage.picture.error(locals.get(0.0)) < RIGHT);
    assert_eq!(blob_bytes(&stage), blobs);
    stage.settle();
}

#[test]
fn a_server_that_is_not_there_yet_is_waited_for() {
    let mut stage = Stage::new(1, Default::default());
    stage.kill_server();
    stage.submit_room(0.0);
    stage.run(MS);
    assert_eq!(stage.link_state(), LinkState::Connecting);
    stage.run(Duration::from_secs(30));
    assert!(matches!(stage.backend.state(), BackendState::Disconnected { .. }));
    stage.start_server();
    stage.settle();
    assert_eq!(stage.backend.link().unwrap().reconnects, 0);
}
