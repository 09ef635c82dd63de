use std::{
    sync::{
        Arc,
        atomic::{AtomicUsize, Ordering},
    },
    time::Duration,
};

use super::*;
use crate::{
    CloseCode, Closed, Connector, Limits, Link, LinkEvent, Listener, Transmit, TransmitId, Wake,
};

const MS: Duration = Duration::from_millis(1);
const SECOND: Duration = Duration::from_secs(1);

/// 100 ms round trip, one packet in twenty is lost.
fn lossy() -> LinkConditions {
    LinkConditions {
        delay: 50 * MS,
        jitter: 10 * MS,
        loss: 0.05,
        reorder: 0.1,
        ..Default::default()
    }
}

fn nobody() -> Wake {
    Arc::new(|| {})
}

fn pair(network: &Network) -> [SimulatedLink; 2] {
    let mut pair = network.pair(&Limits::default(), [nobody(), nobody()]);
    for link in &mut pair {
        assert_eq!(link.poll(), Some(LinkEvent::Opened));
        assert_eq!(link.poll(), None);
    }
    pair
}

fn send(link: &mut dyn Link, id: u64, channel: Channel, message: Vec<u8>) {
    link.send(Transmit { id: TransmitId(id), channel, message });
}

fn events(link: &mut dyn Link) -> Vec<LinkEvent> {
    std::iter::from_fn(|| link.poll()).collect()
}

fn received(events: &[LinkEvent]) -> Vec<(Channel, Vec<u8>)> {
    let received = |event: &LinkEvent| match event {
        LinkEvent::Received(channel, message) => Some((*channel, message.clone())),
        _ => None,
    };
    events.iter().filter_map(received).collect()
}

/// A message that tells where a piece is missing or in the wrong place.
fn message(number: u64, bytes: usize) -> Vec<u8> {
    (0..bytes as u64).map(|i| (i ^ (i >> 8) ^ number) as u8).collect()
}

#[test]
fn everything_arrives_whole_and_control_in_order() {
    for seed in 0..20 {
        let network = Network::new(seed);
        network.set_conditions(lossy());
        let [mut client, mut server] = pair(&network);
        for i in 0..100 {
            let channel = Channel::ALL[i % 3];
            send(&mut client, i as u64, channel, message(i as u64, i * 97));
            network.advance(network.now() + 5 * MS);
        }
        network.advance(8 * SECOND);
        let arrived = received(&events(&mut server));
        assert_eq!(arrived.len(), 100, "seed {seed}");
        let control: Vec<_> =
            arrived.iter().filter(|(channel, _)| *channel == Channel::Control).collect();
        let in_order = (0..100).step_by(3).map(|i| message(i as u64, i * 97));
        assert!(control.iter().map(|(_, bytes)| bytes.clone()).eq(in_order), "seed {seed}");
        for i in 0..100 {
            let expected = (Channel::ALL[i % 3], message(i as u64, i * 97));
            assert!(arrived.contains(&expected), "seed {seed}, message {i}");
        }
        let sent = events(&mut client);
        assert_eq!(sent.iter().filter(|e| matches!(e, LinkEvent::Sent(_))).count(), 100);
        let stats = (client.stats(), server.stats());
        assert_eq!(stats.0.sent_bytes, stats.1.received_bytes);
        let rtt = stats.0.rtt.unwrap();
        assert!(rtt > 95 * MS && rtt < 160 * MS, "{rtt:?}");
    }
}

#[test]
fn the_same_seed_is_the_same_run() {
    let run = |seed| {
        let network = Network::new(seed);
        network.set_conditions(lossy());
        let [mut client, mut server] = pair(&network);
        let mut log = Vec::new();
        for i in 0..200 {
            send(&mut client, i, Channel::Latest, message(i, 5000));
            network.advance(network.now() + 10 * MS);
            log.extend(events(&mut server).into_iter().map(|event| (network.now(), event)));
        }
        (log, network.counters())
    };
    assert_eq!(run(3), run(3));
    assert_ne!(run(3).0, run(4).0);
}

#[test]
fn a_message_takes_the_time_of_the_line() {
    let network = Network::new(1);
    let delay = 50 * MS;
    network.set_conditions(LinkConditions {
        delay,
        bandwidth: Some(100_000),
        window: 1 << 20,
        ..Default::default()
    });
    let [mut client, mut server] = pair(&network);
    // 100 kB at 100 kB/s and half a round trip: about 1.05 s, and 5 % for what packets add.
    send(&mut client, 1, Channel::Bulk, vec![7; 100_000]);
    network.advance(1050 * MS);
    assert!(received(&events(&mut server)).is_empty());
    network.advance(1150 * MS);
    assert_eq!(received(&events(&mut server)).len(), 1);
}

#[test]
fn the_window_holds_messages_back_and_urgent_ones_overtake() {
    let network = Network::new(1);
    network.set_conditions(LinkConditions { delay: 50 * MS, window: 12_000, ..Default::default() });
    let [mut client, mut server] = pair(&network);
    send(&mut client, 1, Channel::Bulk, vec![1; 60_000]);
    send(&mut client, 2, Channel::Control, vec![2; 10]);
    assert_eq!(events(&mut client), [], "ten packets of fifty have left");
    network.advance(SECOND);
    let arrived = received(&events(&mut server));
    assert_eq!(arrived[0].0, Channel::Control, "it did not wait for the blob");
    assert_eq!(arrived.len(), 2);
    let sent = [LinkEvent::Sent(TransmitId(2)), LinkEvent::Sent(TransmitId(1))];
    assert_eq!(events(&mut client), sent);
}

#[test]
fn cancelled_messages_do_not_arrive_and_their_room_is_free_again() {
    let network = Network::new(1);
    network.set_conditions(LinkConditions { delay: 50 * MS, window: 12_000, ..Default::default() });
    let [mut client, mut server] = pair(&network);
    send(&mut client, 1, Channel::Latest, vec![1; 60_000]);
    send(&mut client, 2, Channel::Latest, vec![2; 1000]);
    network.advance(10 * MS);
    client.cancel(TransmitId(1));
    client.cancel(TransmitId(9));
    network.advance(SECOND);
    assert_eq!(received(&events(&mut server)), [(Channel::Latest, vec![2; 1000])]);
    assert_eq!(events(&mut client), [LinkEvent::Sent(TransmitId(2))]);
    send(&mut client, 3, Channel::Latest, vec![3; 60_000]);
    network.advance(2 * SECOND);
    assert_eq!(received(&events(&mut server)).len(), 1);
}

#[test]
fn lost_packets_come_again_after_a_bit_more_than_a_round_trip() {
    let network = Network::new(1);
    network.set_conditions(LinkConditions { delay: 50 * MS, ..Default::default() });
    let [mut client, mut server] = pair(&network);
    send(&mut client, 1, Channel::Control, vec![1]);
    network.advance(200 * MS);
    assert_eq!(events(&mut server).len(), 1);
    network.set_down(true);
    send(&mut client, 2, Channel::Latest, vec![2]);
    network.set_down(false);
    send(&mut client, 3, Channel::Latest, vec![3]);
    network.advance(260 * MS);
    assert_eq!(received(&events(&mut server)), [(Channel::Latest, vec![3])]);
    // The acknowledgement of 3 is back at 300 ms; at 312.5 ms message 2 counts as lost.
    network.advance(362 * MS);
    assert_eq!(events(&mut server).len(), 0);
    network.advance(363 * MS);
    assert_eq!(received(&events(&mut server)), [(Channel::Latest, vec![2])]);
}

#[test]
fn timeouts_double_in_an_outage_until_something_new_gets_through() {
    let silent = |with_news: bool| {
        let network = Network::new(1);
        network.set_conditions(LinkConditions { delay: 50 * MS, ..Default::default() });
        let [mut client, mut server] = pair(&network);
        send(&mut client, 1, Channel::Control, vec![1]);
        network.advance(SECOND);
        events(&mut server);
        network.set_down_until(4 * SECOND);
        send(&mut client, 2, Channel::Latest, vec![2]);
        network.advance(4 * SECOND);
        if with_news {
            send(&mut client, 3, Channel::Latest, vec![3]);
        }
        let mut at = network.now();
        while received(&events(&mut server)).iter().all(|(_, bytes)| bytes[0] != 2) {
            at += MS;
            network.advance(at);
            assert!(at < 20 * SECOND);
        }
        at - 4 * SECOND
    };
    let (alone, with_news) = (silent(false), silent(true));
    assert!(alone > SECOND, "{alone:?}");
    assert!(with_news < 200 * MS, "{with_news:?}");
}

#[test]
fn a_link_opens_in_two_round_trips_and_is_accepted() {
    let network = Network::new(1);
    network.set_conditions(LinkConditions { delay: 50 * MS, ..Default::default() });
    let mut listener = network.listener(&Limits::default());
    let woken = Arc::new(AtomicUsize::new(0));
    let count = woken.clone();
    listener.set_wake(Arc::new(move || {
        count.fetch_add(1, Ordering::Relaxed);
    }));
    let mut client = network.connector().connect(&Limits::default(), nobody());
    send(&mut *client, 1, Channel::Control, vec![1]);
    network.advance(199 * MS);
    assert_eq!(events(&mut *client), []);
    network.advance(200 * MS);
    assert_eq!(events(&mut *client), [LinkEvent::Opened, LinkEvent::Sent(TransmitId(1))]);
    assert!(woken.load(Ordering::Relaxed) > 0);
    let (mut server, _) = listener.accept().unwrap();
    assert!(listener.accept().is_none());
    network.advance(250 * MS);
    let first = LinkEvent::Received(Channel::Control, vec![1]);
    assert_eq!(events(&mut *server), [LinkEvent::Opened, first]);
}

#[test]
fn goodbye_comes_after_what_was_sent_and_is_repeated_when_it_is_lost() {
    for lose_first in [false, true] {
        let network = Network::new(1);
        network.set_conditions(LinkConditions { delay: 50 * MS, ..Default::default() });
        let [mut client, mut server] = pair(&network);
        if lose_first {
            network.set_down(true);
            server.close(CloseCode::ShuttingDown, "maintenance");
            network.set_down(false);
            send(&mut client, 1, Channel::Control, vec![1]);
        } else {
            send(&mut server, 1, Channel::Control, vec![1]);
            server.close(CloseCode::ShuttingDown, "maintenance");
        }
        drop(server);
        network.advance(SECOND);
        let mut heard = events(&mut client);
        let goodbye = Closed::Goodbye(CloseCode::ShuttingDown, "maintenance".into());
        assert_eq!(heard.pop(), Some(LinkEvent::Closed(goodbye)));
        assert_eq!(received(&heard).len(), usize::from(!lose_first));
        drop(client);
        network.advance(20 * SECOND);
        assert_eq!(network.next_event(), None, "nothing is left of the connection");
    }
}

#[test]
fn a_killed_peer_is_noticed_after_the_idle_timeout() {
    let network = Network::new(1);
    let [mut client, server] = pair(&network);
    network.advance(5 * SECOND);
    drop(server);
    network.advance(9 * SECOND);
    assert_eq!(events(&mut client), []);
    network.advance(IDLE);
    let [LinkEvent::Closed(Closed::Lost(why))] = &events(&mut client)[..] else { panic!() };
    assert!(why.contains("10 s"), "{why}");
}

#[test]
fn nobody_listens() {
    let network = Network::new(1);
    drop(network.listener(&Limits::default()));
    let mut client = network.connector().connect(&Limits::default(), nobody());
    network.advance(IDLE);
    assert!(matches!(events(&mut *client)[..], [LinkEvent::Closed(Closed::Lost(_))]));
}

#[test]
fn messages_over_the_limit_end_the_link() {
    let network = Network::new(1);
    let [mut client, mut server] = pair(&network);
    let limit = Limits::default().control_bytes;
    send(&mut client, 1, Channel::Control, vec![0; limit]);
    send(&mut client, 2, Channel::Control, vec![0; limit + 1]);
    network.advance(SECOND);
    let events = [events(&mut client), events(&mut server)];
    assert_eq!(received(&events[1]).len(), 1);
    assert!(matches!(events[1].last(), Some(LinkEvent::Closed(Closed::Broken(_)))));
    let told =
        Closed::Goodbye(CloseCode::Limit, "a message of 262145 bytes is over the limit".into());
    assert_eq!(events[0].last(), Some(&LinkEvent::Closed(told)));
}
