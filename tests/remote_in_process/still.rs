//! A still scene sends nothing but keep-alives.

use std::time::Duration;

use farlight_wire::{Channel, simulated::Counters};

use crate::{
    scene::lamp,
    stage::{Stage, bad_line},
};

/// Keep-alives (a ping of the client and the server's answer) a minute: one in two seconds.
const PINGS: u64 = 31;
/// Where packets are lost a ping is repeated until it is answered.
const PINGS_WITH_LOSS: u64 = 50;
/// Bytes of one.
const PING_BYTES: u64 = 16;

#[test]
fn after_convergence_only_keep_alives_are_sent() {
    for (conditions, most) in [(Default::default(), PINGS), (bad_line(), PINGS_WITH_LOSS)] {
        let mut stage = Stage::new(5, conditions);
        stage.submit_room(0.5);
        stage.settle();
        // Acknowledgements and the last answers.
        stage.run(Duration::from_secs(5));
        let before = stage.network.counters();
        let updates = stage.picture.updates;
        stage.run(Duration::from_secs(60));
        let after = stage.network.counters();
        assert_eq!(stage.picture.updates, updates);
        let count = |of: &dyn Fn(&Counters) -> farlight_wire::simulated::Traffic| {
            let (before, after) = (of(&before), of(&after));
            (after.messages - before.messages, after.bytes - before.bytes)
        };
        for channel in [Channel::Bulk, Channel::Latest] {
            assert_eq!(count(&|c| c.to_server(channel)), (0, 0), "{channel:?}");
            assert_eq!(count(&|c| c.to_client(channel)), (0, 0), "{channel:?}");
        }
        let up = count(&|c| c.to_server(Channel::Control));
        let down = count(&|c| c.to_client(Channel::Control));
        println!("a still minute: {up:?} up, {down:?} down (messages, bytes)");
        for (messages, bytes) in [up, down] {
            assert!((1..=most).contains(&messages), "{messages} messages");
            assert!(bytes <= messages * PING_BYTES, "{bytes} bytes");
        }
        assert_eq!(after.connections, before.connections);
    }
}

#[test]
fn a_scene_without_anything_to_light_is_soon_still() {
    let mut stage = Stage::new(5, bad_line());
    stage.run(Duration::from_secs(2));
    let pings = |stage: &Stage| stage.network.counters().to_server(Channel::Control).messages;
    let before = pings(&stage);
    stage.run(Duration::from_secs(20));
    let empty = pings(&stage) - before;
    assert!(empty <= PINGS_WITH_LOSS / 2, "{empty} messages without a scene");
    // A light and nothing that it could shine on; then the same light again.
    for _ in 0..2 {
        stage.submit(vec![lamp(0.5)]);
        stage.settle();
        stage.run(Duration::from_secs(2));
    }
    let before = pings(&stage);
    stage.run(Duration::from_secs(20));
    let dark = pings(&stage) - before;
    assert!(dark <= PINGS_WITH_LOSS / 2, "{dark} messages with a light alone");
}
