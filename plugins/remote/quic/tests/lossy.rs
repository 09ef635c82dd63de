//! Links over bad lines, in real time.
//!
//! Both ends behave as sessions do: the client pings every 200 ms while it waits for something, the server
//! sends its newest state as soon as there is room and cancels what is late.

mod support;

use std::{
    collections::VecDeque,
    sync::atomic::Ordering::Relaxed,
    time::{Duration, Instant},
};

use farlight_wire::{Channel, Limits, LinkEvent, TransmitId};
use support::{
    End, Host, PATIENCE, connect, noise,
    proxy::{Line, Proxy},
    raw,
};

const PING: Duration = Duration::from_millis(200);
/// The server has a new state so often.
const STATES: Duration = Duration::from_millis(33);
/// Messages of state on the way, and when they are given up.
const UNDER_WAY: usize = 4;
const LATE: Duration = Duration::from_millis(500);

/// What arrived at the client.
#[derive(Clone, Copy, Debug)]
struct Arrival {
    at: Duration,
    /// When the state was made.
    made: Duration,
    bytes: usize,
}

/// A client and a server in lockstep with the clock.
struct Play {
    start: Instant,
    client: End,
    server: End,
    bytes: usize,
    upload: bool,
    uploads: usize,
    uploaded: u64,
    pings: u64,
    pongs: Vec<Duration>,
    last_ping: Duration,
    last_state: Duration,
    under_way: VecDeque<(TransmitId, u64, Duration)>,
    sequence: u64,
    states: Vec<Arrival>,
}

impl Play {
    /// States of so many bytes; with `upload`, the client sends as much as it can beside.
    fn new(client: End, server: End, bytes: usize, upload: bool) -> Self {
        Self {
            start: Instant::now(),
            client,
            server,
            bytes,
            upload,
            uploads: 0,
            uploaded: 0,
            pings: 0,
            pongs: Vec::new(),
            last_ping: Duration::ZERO,
            last_state: Duration::ZERO,
            under_way: VecDeque::new(),
            sequence: 0,
            states: Vec::new(),
        }
    }

    fn now(&self) -> Duration {
        self.start.elapsed()
    }

    fn run(&mut self, time: Duration) {
        let end = self.now() + time;
        while self.now() < end {
            self.step();
            std::thread::sleep(Duration::from_millis(2));
        }
    }

    fn run_until(&mut self, what: &str, done: impl Fn(&Self) -> bool) {
        let start = self.now();
        while !done(self) {
            assert!(self.now() < start + PATIENCE, "waiting for {what}");
            self.run(Duration::from_millis(10));
        }
    }

    fn step(&mut self) {
        let now = self.now();
        while let Some(event) = self.client.link.poll() {
            match event {
                LinkEvent::Received(Channel::Control, _) => self.pongs.push(now),
                LinkEvent::Received(_, message) => {
                    let micros = u64::from_le_bytes(message[8..16].try_into().unwrap());
                    let (made, bytes) = (Duration::from_micros(micros), message.len());
                    self.states.push(Arrival { at: now, made, bytes });
                    self.client.send(Channel::Control, message[..8].to_vec());
                }
                LinkEvent::Sent(_) => {}
                other => panic!("{other:?}"),
            }
        }
        while let Some(event) = self.server.link.poll() {
            match event {
                LinkEvent::Received(Channel::Control, message) if message.len() == 8 => {
                    let sequence = u64::from_le_bytes(message.try_into().unwrap());
                    self.under_way.retain(|message| message.1 != sequence);
                }
                LinkEvent::Received(Channel::Control, _) => {
                    self.server.send(Channel::Control, b"pong".to_vec());
                }
                LinkEvent::Received(_, message) => {
                    self.uploaded += message.len() as u64;
                    self.uploads -= 1;
                }
                LinkEvent::Sent(_) => {}
                other => panic!("{other:?}"),
            }
        }
        if now >= self.last_ping + PING {
            self.last_ping = now;
            self.pings += 1;
            self.client.send(Channel::Control, b"ping".to_vec());
        }
        while self.upload && self.uploads < 8 {
            self.uploads += 1;
            self.client.send(Channel::Bulk, noise(1, 64 << 10));
        }
        while self.under_way.front().is_some_and(|message| now >= message.2 + LATE) {
            let late = self.under_way.pop_front().unwrap();
            self.server.link.cancel(late.0);
        }
        if now >= self.last_state + STATES && self.under_way.len() < UNDER_WAY && self.bytes > 0 {
            self.last_state = now;
            self.sequence += 1;
            let mut message = self.sequence.to_le_bytes().to_vec();
            message.extend((now.as_micros() as u64).to_le_bytes());
            message.resize(self.bytes.max(16), 7);
            let id = self.server.send(Channel::Latest, message);
            self.under_way.push_back((id, self.sequence, now));
        }
    }

    /// How old arriving states were, the middle and the worst tenth, and bytes a second, since a time.
    fn ages(&self, since: Duration) -> (Duration, Duration, f64) {
        let recent: Vec<_> = self.states.iter().filter(|a| a.at >= since).collect();
        let mut ages: Vec<_> = recent.iter().map(|a| a.at - a.made).collect();
        ages.sort();
        let bytes: usize = recent.iter().map(|a| a.bytes).sum();
        let rate = bytes as f64 / (self.now() - since).as_secs_f64();
        let nth = |share: f64| ages.get((ages.len() as f64 * share) as usize).copied();
        (nth(0.5).unwrap_or_default(), nth(0.9).unwrap_or_default(), rate)
    }

    /// After an outage that ended then: until anything arrives, and until a state arrives that is newer
    /// than the end of the outage.
    fn recovery(&self, end: Duration) -> (Option<Duration>, Option<Duration>) {
        let state = self.states.iter().filter(|a| a.at > end);
        let first =
            state.clone().map(|a| a.at).chain(self.pongs.iter().copied().filter(|t| *t > end));
        let fresh = state.clone().filter(|a| a.made >= end).map(|a| a.at).min();
        (first.min().map(|t| t - end), fresh.map(|t| t - end))
    }
}

fn play(line: Line, bytes: usize, upload: bool) -> (Play, Proxy, Host, tokio::runtime::Runtime) {
    let runtime = raw::runtime();
    let mut host = Host::new();
    let proxy = Proxy::new(&runtime, host.listener.local_addr(), line);
    let mut client = connect(&host.invitation_at(proxy.address), &Limits::default());
    client.opened();
    let mut server = host.accept();
    server.opened();
    (Play::new(client, server, bytes, upload), proxy, host, runtime)
}

fn bad(seed: u64) -> Line {
    Line {
        delay: Duration::from_millis(45),
        jitter: Duration::from_millis(10),
        loss: 0.05,
        seed,
        ..Line::default()
    }
}

#[test]
fn a_bad_line_keeps_delivering() {
    let (mut play, proxy, _host, _runtime) = play(bad(2), 20_000, true);
    play.run_until("30 states, 10 answers and 1 MB up", |play| {
        play.states.len() >= 30 && play.pongs.len() >= 10 && play.uploaded >= 1_000_000
    });
    let lost = proxy.lost.load(Relaxed);
    assert!(lost > 10, "the line was good: {lost} lost");
    let (middle, worst, rate) = play.ages(Duration::ZERO);
    println!(
        "age of states {middle:.0?} median, {worst:.0?} 90 %, {:.0} KB/s; {lost} packets lost of {}",
        rate / 1e3,
        lost + proxy.passed.load(Relaxed),
    );
}

#[test]
fn an_outage_while_the_line_is_full_is_survived() {
    // Slow, so that as much as may be on its way is on its way when it goes out.
    let slow = Line { rate: 250_000, ..bad(3) };
    let (mut play, proxy, _host, _runtime) = play(slow, 20_000, true);
    play.run_until("10 states", |play| play.states.len() >= 10);
    proxy.cut(true);
    play.run(Duration::from_millis(2500));
    proxy.cut(false);
    let end = play.now();
    play.run_until("a state from after the outage", |play| play.recovery(end).1.is_some());
    let (first, fresh) = play.recovery(end);
    println!("after an outage of 2.5 s: first message {first:.0?}, fresh state {fresh:.0?}");
    // Everything goes on, up and down.
    let (states, uploaded) = (play.states.len(), play.uploaded);
    play.run_until("more of everything", |play| {
        play.states.len() > states + 5 && play.uploaded > uploaded
    });
}

#[test]
#[ignore = "takes 6 minutes and prints a table of recovery times"]
fn recovery_times() {
    let slow = Line { rate: 250_000, ..bad(1) };
    let cases = [
        (bad(1), 2_000, false),
        (bad(1), 20_000, false),
        (bad(1), 100_000, false),
        (bad(1), 20_000, true),
        (slow, 20_000, false),
        (slow, 20_000, true),
    ];
    for (line, bytes, upload) in cases {
        let (mut play, proxy, _host, _runtime) = play(line, bytes, upload);
        play.run(Duration::from_secs(4));
        let (middle, worst, rate) = play.ages(Duration::from_secs(1));
        let uploaded = play.uploaded as f64 / 1e3 / play.now().as_secs_f64();
        let at_most = match line.rate {
            0 => String::new(),
            rate => format!(" at {} KB/s", rate / 1000),
        };
        println!(
            "100 ms, 5 % lost{at_most}; states of {bytes} B: age {middle:.0?} median, {worst:.0?} 90 %, \
             {:.0} KB/s down, {uploaded:.0} KB/s up",
            rate / 1e3,
        );
        for seconds in [1.0, 1.3, 1.6, 3.0, 3.3, 3.6, 5.0, 5.3, 5.6] {
            play.run(Duration::from_millis(1500));
            proxy.cut(true);
            play.run(Duration::from_secs_f64(seconds));
            proxy.cut(false);
            let end = play.now();
            play.run(Duration::from_secs(2));
            if play.recovery(end).1.is_none() {
                play.run(Duration::from_secs(6));
            }
            let (first, fresh) = play.recovery(end);
            let ms = |time: Option<Duration>| {
                time.map_or("never".into(), |time| format!("{} ms", time.as_millis()))
            };
            println!(
                "  {seconds} s out: first message after {}, fresh state after {}",
                ms(first),
                ms(fresh)
            );
        }
    }
}
