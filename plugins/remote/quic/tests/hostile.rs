//! Clients that break the rules are told why and thrown out; others don't notice.

mod support;

use std::{
    future::Future,
    net::UdpSocket,
    time::{Duration, Instant},
};

use farlight_wire::{Channel, CloseCode, Closed, Limits, LinkEvent};
use support::{End, Host, PATIENCE, connect, join, noise, raw};
use tokio::{runtime::Runtime, time::timeout};
use wtransport::{Connection, RecvStream, SendStream, error::ConnectionError};

/// A well-behaved client beside the others.
struct Witness(End, End);

impl Witness {
    fn new(host: &mut Host) -> Self {
        let (client, server) = join(host);
        Self(client, server)
    }

    fn is_undisturbed(&mut self) {
        for (from, to) in [(0, 1), (1, 0)] {
            let ends = [&mut self.0, &mut self.1];
            let [a, b] = ends;
            let (from, to) = if from < to { (a, b) } else { (b, a) };
            for channel in Channel::ALL {
                from.send(channel, noise(7, 10_000));
                assert_eq!(to.message(), (channel, noise(7, 10_000)));
            }
        }
    }
}

/// A client that does what it likes, and the server's end of its link.
struct Liar {
    runtime: Runtime,
    connection: Connection,
    send: SendStream,
    _receive: RecvStream,
    server: End,
    _endpoint: Box<dyn Send>,
}

impl Liar {
    fn new(host: &mut Host) -> Self {
        let runtime = raw::runtime();
        let (endpoint, connection, (send, _receive)) = runtime.block_on(async {
            let (endpoint, connection) = raw::connect(&host.invitation(), "/").await.unwrap();
            let control = connection.open_bi().await.unwrap().await.unwrap();
            (endpoint, connection, control)
        });
        let mut server = host.accept();
        server.opened();
        Self { runtime, connection, send, _receive, server, _endpoint: Box::new(endpoint) }
    }

    fn run<R>(&self, task: impl Future<Output = R>) -> R {
        self.runtime.block_on(async { timeout(PATIENCE, task).await.expect("no hanging") })
    }

    async fn stream(&self) -> SendStream {
        self.connection.open_uni().await.unwrap().await.unwrap()
    }

    /// Both sides know why it ended.
    fn must_go(mut self, code: CloseCode, why: &str) {
        let closed = self.server.closed();
        assert!(matches!(&closed, Closed::Broken(reason) if reason.contains(why)), "{closed:?}");
        let told = self.run(self.connection.closed());
        let ConnectionError::ApplicationClosed(close) = told else { panic!("{told:?}") };
        assert_eq!(close.code().into_inner(), u64::from(code.number()));
        let told = String::from_utf8_lossy(close.reason());
        assert!(told.contains(why), "{told}");
    }
}

#[test]
fn a_control_message_of_4_gb() {
    let mut host = Host::new();
    let mut witness = Witness::new(&mut host);
    let mut liar = Liar::new(&mut host);
    let claim = liar.runtime.block_on(liar.send.write_all(&u32::MAX.to_le_bytes()));
    claim.unwrap();
    liar.must_go(CloseCode::Limit, "Control has 4294967295 bytes; 262144 are allowed");
    witness.is_undisturbed();
}

#[test]
fn messages_over_their_limit() {
    for (channel, limit) in [(Channel::Bulk, 256 << 10), (Channel::Latest, 1 << 20)] {
        let mut host = Host::new();
        let mut witness = Witness::new(&mut host);
        let mut liar = Liar::new(&mut host);
        // As large as it may be.
        liar.run(async {
            let mut stream = liar.stream().await;
            stream.write_all(&[channel.tag()]).await.unwrap();
            stream.write_all(&noise(1, limit)).await.unwrap();
            stream.finish().await.unwrap();
        });
        assert_eq!(liar.server.message(), (channel, noise(1, limit)));
        // And on and on.
        liar.run(async {
            let mut stream = liar.stream().await;
            stream.write_all(&[channel.tag()]).await.unwrap();
            while stream.write_all(&[0; 10_000]).await.is_ok() {}
        });
        let why = format!("{channel:?} has");
        liar.must_go(CloseCode::Limit, &why);
        witness.is_undisturbed();
    }
}

#[test]
fn unknown_channels_and_second_control_streams() {
    let mut host = Host::new();
    let mut witness = Witness::new(&mut host);
    for tag in [0, 1, 4, 255] {
        let liar = Liar::new(&mut host);
        liar.run(async {
            let mut stream = liar.stream().await;
            stream.write_all(&[tag]).await.unwrap();
        });
        liar.must_go(CloseCode::Protocol, &format!("unknown channel {tag}"));
    }
    let liar = Liar::new(&mut host);
    let _stream = liar.run(async { liar.connection.open_bi().await.unwrap().await.unwrap() });
    liar.must_go(CloseCode::Protocol, "second control stream");
    witness.is_undisturbed();
}

#[test]
fn broken_control_streams() {
    let mut host = Host::new();
    let mut witness = Witness::new(&mut host);
    let mut liar = Liar::new(&mut host);
    liar.runtime.block_on(async {
        liar.send.write_all(&[10, 0, 0, 0, 1, 2, 3]).await.unwrap();
        liar.send.finish().await.unwrap();
    });
    liar.must_go(CloseCode::Protocol, "ends within a message");
    let mut liar = Liar::new(&mut host);
    liar.send.reset(wtransport::VarInt::from_u32(5)).unwrap();
    liar.must_go(CloseCode::Protocol, "the control stream broke");
    // Ended without a goodbye: nobody's fault, but of no use.
    let mut liar = Liar::new(&mut host);
    liar.runtime.block_on(liar.send.finish()).unwrap();
    let closed = liar.server.closed();
    assert!(matches!(closed, Closed::Lost(_)), "{closed:?}");
    witness.is_undisturbed();
}

#[test]
fn streams_that_never_end_take_bounded_memory() {
    let mut host = Host::new();
    let mut witness = Witness::new(&mut host);
    let mut liar = Liar::new(&mut host);
    // As many as it gets, each as full as it gets.
    let mut streams = Vec::new();
    let written = liar.run(async {
        let mut written = 0_usize;
        loop {
            let open = async { liar.connection.open_uni().await.unwrap().await.unwrap() };
            let Ok(stream) = timeout(Duration::from_millis(300), open).await else { break };
            streams.push(stream);
            let stream = streams.last_mut().unwrap();
            if stream.write_all(&[Channel::Latest.tag()]).await.is_err() {
                break;
            }
            for _ in 0..100 {
                let bytes = [0; 10_000];
                let write = stream.write(&bytes);
                match timeout(Duration::from_millis(100), write).await {
                    Ok(Ok(bytes)) => written += bytes,
                    _ => break,
                }
            }
        }
        written
    });
    assert!(streams.len() <= 70, "{} streams", streams.len());
    // 8 MB of messages, 4 MB of QUIC's window, and what lies in the liar's own send buffer.
    assert!(written < 24 << 20, "{written} bytes were taken");
    assert!(liar.server.event_within(Duration::from_millis(1)).is_none());
    witness.is_undisturbed();
    drop(streams);
}

#[test]
fn a_session_that_does_not_fetch_its_messages_stops_the_other_side() {
    let mut host = Host::new();
    let (mut client, mut server) = join(&mut host);
    for i in 0..100 {
        client.send(Channel::Latest, noise(i, 1 << 20));
        client.send(Channel::Control, noise(i, 256 << 10));
    }
    let mut taken = 0;
    while let Some(event) = client.event_within(Duration::from_millis(500)) {
        assert!(matches!(event, LinkEvent::Sent(_)));
        taken += 1;
    }
    assert!(taken < 100, "{taken} of 200 were taken");
    // Then everything comes.
    for _ in 0..200 {
        server.message();
    }
}

#[test]
fn garbage_at_the_port() {
    let mut host = Host::new();
    let mut witness = Witness::new(&mut host);
    let socket = UdpSocket::bind(("127.0.0.1", 0)).unwrap();
    for i in 0..2000_u64 {
        let mut packet = noise(i, (i as usize * 7) % 1400);
        // Some look like the first packet of a connection.
        if let (0, [first, a, b, c, d, ..]) = (i % 3, &mut packet[..]) {
            (*first, *a, *b, *c, *d) = (0xc3, 0, 0, 0, 1);
        }
        let _ = socket.send_to(&packet, host.listener.local_addr());
    }
    witness.is_undisturbed();
    join(&mut host);
    assert!(host.accept_within(Duration::from_millis(10)).is_none());
}

#[test]
fn other_requests_are_refused() {
    let mut host = Host::new();
    let runtime = raw::runtime();
    let error = runtime.block_on(raw::connect(&host.invitation(), "/else")).err().unwrap();
    assert!(error.to_string().contains("rejected"), "{error}");
    assert!(host.accept_within(Duration::from_millis(50)).is_none());
    join(&mut host);
}

#[test]
fn no_more_connections_than_allowed() {
    let mut host = Host::with(Host::new().authority, |config| config.connections = 2);
    let first = join(&mut host);
    let _second = join(&mut host);
    let closed = connect(&host.invitation(), &Limits::default()).closed();
    assert!(closed.to_string().contains("refused to accept a new connection"), "{closed}");
    drop(first);
    // The place is free as soon as the server has noticed.
    let start = Instant::now();
    loop {
        let mut client = connect(&host.invitation(), &Limits::default());
        match client.event() {
            LinkEvent::Opened => break,
            closed => assert!(start.elapsed() < PATIENCE, "{closed:?}"),
        }
    }
}

#[test]
fn clients_that_nobody_accepts_do_not_pile_up() {
    let host = Host::new();
    let clients: Vec<_> = (0..20)
        .map(|_| {
            let mut client = connect(&host.invitation(), &Limits::default());
            client.opened();
            client
        })
        .collect();
    let full = clients
        .into_iter()
        .filter_map(|mut client| client.event_within(Duration::from_millis(100)));
    let full: Vec<_> = full.collect();
    assert_eq!(full.len(), 4, "16 may wait");
    assert!(
        full.iter()
            .all(|event| matches!(event, LinkEvent::Closed(Closed::Goodbye(CloseCode::Full, _))))
    );
}
