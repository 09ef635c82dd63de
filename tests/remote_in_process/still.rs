//! A still scene sends nothing but keep-alives.

use std::time::Duration;

use farlight_wire::{Channel, simulated::Counters};

use crate::stage::{Stage, bad_line};

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
