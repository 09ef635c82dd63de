//! Two ends over loopback: every channel, cancelling, closing.

mod support;

use std::time::{Duration, Instant};

use farlight_wire::{Channel, CloseCode, Closed, Limits, LinkEvent};
use support::{Host, connect, join, noise, pair};

#[test]
fn messages_of_all_channels_both_ways() {
    let (_host, mut client, mut server) = pair();
    let sizes = [
        (Channel::Control, 0),
        (Channel::Latest, 0),
        (Channel::Bulk, 0),
        (Channel::Control, 1),
        (Channel::Control, 256 << 10),
        (Channel::Bulk, 256 << 10),
        (Channel::Latest, 1 << 20),
        (Channel::Latest, 100),
    ];
    for round in 0..2 {
        let (from, to) =
            if round == 0 { (&mut client, &mut server) } else { (&mut server, &mut client) };
        for (i, (channel, size)) in sizes.into_iter().enumerate() {
            let message = noise(i as u64, size);
            let id = from.send(channel, message.clone());
            assert_eq!(to.message(), (channel, message));
            from.sent(id);
        }
    }
    let bytes = sizes.iter().map(|(_, size)| *size as u64).sum();
    for stats in [client.link.stats(), server.link.stats()] {
        assert_eq!((stats.sent_bytes, stats.received_bytes), (bytes, bytes));
        assert!(stats.rtt.is_some_and(|rtt| rtt < Duration::from_secs(1)), "{stats:?}");
    }
}

#[test]
fn control_messages_stay_in_order_beside_much_else() {
    let (_host, mut client, mut server) = pair();
    for i in 0..40_u64 {
        client.send(Channel::Bulk, noise(i, 200 << 10));
        client.send(Channel::Latest, noise(i, 50 << 10));
        for k in 0..5 {
            client.send(Channel::Control, (5 * i + k).to_le_bytes().to_vec());
        }
    }
    let (mut control, mut bulk, mut latest) = (0_u64, Vec::new(), Vec::new());
    while control < 200 || bulk.len() < 40 || latest.len() < 40 {
        match server.message() {
            (Channel::Control, message) => {
                assert_eq!(message, control.to_le_bytes());
                control += 1;
            }
            (Channel::Bulk, message) => bulk.push(message),
            (Channel::Latest, message) => latest.push(message),
        }
    }
    for (list, size) in [(&mut bulk, 200 << 10), (&mut latest, 50 << 10)] {
        list.sort();
        let mut expected: Vec<_> = (0..40).map(|i| noise(i, size)).collect();
        expected.sort();
        assert!(*list == expected, "other messages than were sent");
    }
    let mut confirmed = 0;
    while confirmed < 40 * 7 {
        assert!(matches!(client.event(), LinkEvent::Sent(_)));
        confirmed += 1;
    }
}

#[test]
fn a_message_arrives_whole_or_not_at_all_when_it_is_cancelled() {
    let (_host, mut client, mut server) = pair();
    // More than the line takes at once, so that some are cancelled before, some while they leave.
    let ids: Vec<_> = (0..40).map(|i| client.send(Channel::Latest, noise(i, 900 << 10))).collect();
    ids.iter().skip(1).for_each(|id| client.link.cancel(*id));
    client.send(Channel::Latest, b"newest".to_vec());
    client.link.cancel(farlight_wire::TransmitId(999));
    let mut others = 0;
    loop {
        let (_, message) = server.message();
        if message == b"newest" {
            break;
        }
        assert!((0..40).any(|i| noise(i, 900 << 10) == message), "{} bytes", message.len());
        others += 1;
    }
    assert!(others < 40, "nothing was cancelled");
    client.send(Channel::Control, b"on".to_vec());
    while server.message().1 != b"on" {}
}

#[test]
fn goodbyes_reach_the_other_side() {
    let mut host = Host::new();
    for code in [CloseCode::Done, CloseCode::Full, CloseCode::Unauthorized, CloseCode::Other(77)] {
        for by_client in [true, false] {
            let (client, server) = join(&mut host);
            let (mut from, mut to) = if by_client { (client, server) } else { (server, client) };
            from.send(Channel::Control, b"last words".to_vec());
            from.link.close(code, "that's why");
            assert_eq!(to.message(), (Channel::Control, b"last words".to_vec()));
            assert_eq!(to.closed(), Closed::Goodbye(code, "that's why".into()));
            assert_eq!(from.closed(), Closed::Goodbye(code, "that's why".into()));
            // Nothing comes after it, whatever one asks for.
            from.send(Channel::Control, b"more".to_vec());
            assert_eq!(from.event_within(Duration::from_millis(20)), None);
            assert_eq!(to.event_within(Duration::from_millis(20)), None);
        }
    }
}

#[test]
fn long_reasons_are_cut() {
    let (_host, mut client, mut server) = pair();
    server.link.close(CloseCode::Failed, &"ä".repeat(5000));
    let Closed::Goodbye(CloseCode::Failed, why) = client.closed() else { panic!() };
    assert_eq!(&*why, "ä".repeat(128));
}

#[test]
fn dropping_a_link_gives_the_connection_up() {
    let mut host = Host::new();
    let (client, mut server) = join(&mut host);
    drop(client);
    assert_eq!(server.closed(), Closed::Goodbye(CloseCode::Abandoned, "".into()));
    let (mut client, server) = join(&mut host);
    drop(server);
    assert_eq!(client.closed(), Closed::Goodbye(CloseCode::Abandoned, "".into()));
    // Also right after the goodbye.
    let (mut client, mut server) = join(&mut host);
    server.link.close(CloseCode::ShuttingDown, "");
    drop(server);
    assert_eq!(client.closed(), Closed::Goodbye(CloseCode::ShuttingDown, "".into()));
}

#[test]
fn links_outlive_their_listener() {
    let (host, mut client, mut server) = pair();
    let invitation = host.invitation();
    drop(host);
    client.send(Channel::Control, b"still there".to_vec());
    assert_eq!(server.message().1, b"still there");
    let mut late = connect(&invitation, &Limits::default());
    late.link.close(CloseCode::Done, "");
    assert_eq!(late.closed(), Closed::Goodbye(CloseCode::Done, "".into()), "gives up at once");
}

#[test]
fn what_is_sent_before_it_is_open_leaves_then() {
    let mut host = Host::new();
    let mut client = connect(&host.invitation(), &Limits::default());
    for i in 0..10 {
        client.send(Channel::Control, vec![i]);
    }
    let mut server = host.accept();
    for i in 0..10 {
        assert_eq!(server.message(), (Channel::Control, vec![i]));
    }
}

#[test]
fn nobody_there() {
    let socket = std::net::UdpSocket::bind(("127.0.0.1", 0)).unwrap();
    let host = Host::new();
    let invitation = host.invitation_at(socket.local_addr().unwrap());
    let start = Instant::now();
    let mut client = connect(&invitation, &Limits::default());
    let closed = client.closed();
    assert!(matches!(closed, Closed::Lost(_)), "{closed:?}");
    assert!(closed.to_string().contains("no answer from 127.0.0.1:"), "{closed}");
    assert!(start.elapsed() > Duration::from_secs(1), "it has tried");
    let nowhere = farlight_wire::Invitation { host: "no.such.name.invalid".into(), ..invitation };
    let closed = connect(&nowhere, &Limits::default()).closed();
    assert!(closed.to_string().contains("no.such.name.invalid can't be found"), "{closed}");
}

#[test]
fn names_and_both_families() {
    let mut host = Host::with(Host::new().authority, |config| {
        config.address = "[::]:0".parse().unwrap();
    });
    let port = host.listener.local_addr().port();
    for name in ["127.0.0.1", "localhost", "::1"] {
        if name == "::1" && std::net::UdpSocket::bind("[::1]:0").is_err() {
            println!("SKIPPED: this machine has no IPv6");
            continue;
        }
        let invitation = farlight_wire::Invitation { host: name.into(), port, ..host.invitation() };
        let mut client = connect(&invitation, &Limits::default());
        client.opened();
        host.accept().opened();
    }
    // A name that has an address where nobody listens besides the right one.
    let mut v4 = Host::new();
    let name = farlight_wire::Invitation { host: "localhost".into(), ..v4.invitation() };
    connect(&name, &Limits::default()).opened();
    v4.accept().opened();
}
