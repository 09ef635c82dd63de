//! A line in virtual time.

use super::*;

const MTU: u64 = 1200;
const TRIP: Duration = Duration::from_millis(100);

/// A line that is filled to the window every round trip.
struct Line {
    steady: Steady,
    now: Instant,
    packet: u64,
    /// Bytes that pass in a round trip; more waits in a queue.
    passes: u64,
}

impl Line {
    fn new(passes: u64) -> Self {
        let now = Instant::now();
        Self { steady: Steady::new(MTU as u16), now, packet: 0, passes }
    }

    /// One round trip: every packet is sent, and arrives or not.
    fn round(&mut self, lost: impl Fn(u64) -> bool) {
        let sent = self.now;
        let first = self.packet + 1;
        let count = self.steady.window_at(sent) / MTU;
        for _ in 0..count {
            self.packet += 1;
            self.steady.on_sent(sent, MTU, self.packet);
        }
        self.now += TRIP.mul_f64((count * MTU) as f64 / self.passes as f64).max(TRIP);
        let all = first..=self.packet;
        let lost_bytes = all.clone().filter(|packet| lost(*packet)).count() as u64 * MTU;
        let Some(largest) = all.rev().find(|packet| !lost(*packet)) else { return };
        self.steady.on_end_acks(self.now, lost_bytes, false, Some(largest));
        if lost_bytes > 0 {
            self.steady.on_congestion_event(self.now, sent, false, lost_bytes);
        }
        self.steady.on_end_acks(self.now, 0, false, Some(largest));
    }

    fn rounds(&mut self, count: u32, lost: impl Fn(u64) -> bool) -> u64 {
        (0..count).for_each(|_| self.round(&lost));
        self.steady.window / MTU
    }
}

/// The same for a packet always, and evenly spread.
fn one_in(n: u64) -> impl Fn(u64) -> bool {
    move |packet| packet.wrapping_mul(0x9e37_79b9_7f4a_7c15).rotate_left(20) % n == 0
}

#[test]
fn a_free_line_is_used() {
    assert!(Line::new(u64::MAX).rounds(6, |_| false) >= 32 * START);
    assert_eq!(Line::new(u64::MAX).rounds(60, |_| false), MOST);
}

#[test]
fn some_losses_are_noise_and_many_are_congestion() {
    assert!(Line::new(u64::MAX).rounds(50, one_in(20)) > 8 * START);
    assert!(Line::new(u64::MAX).rounds(50, one_in(4)) < 2 * LEAST);
}

#[test]
fn queues_stay_short() {
    // 400 KB/s: 40 KB a round trip.
    let mut line = Line::new(40_000);
    let mut starved = 0;
    for round in 0..1000 {
        line.round(|_| false);
        let window = line.steady.window;
        assert!(window < 120_000, "{window} in round {round}");
        starved += u32::from(window < 35_000);
    }
    // Now and then, to see how long the way is.
    assert!(starved < 50, "{starved}");
}

#[test]
fn what_is_not_used_does_not_grow() {
    let mut steady = Steady::new(MTU as u16);
    let mut now = Instant::now();
    for packet in 1..1000 {
        steady.on_sent(now, MTU, packet);
        now += TRIP;
        steady.on_end_acks(now, 0, true, Some(packet));
    }
    assert_eq!(steady.window, START * MTU);
}

#[test]
fn silence_lets_packets_go_and_is_no_congestion() {
    let mut line = Line::new(u64::MAX);
    line.rounds(4, |_| false);
    let window = line.steady.window;
    // Full when the line goes out.
    let sent = line.now;
    let count = window / MTU;
    line.packet += count;
    line.steady.on_sent(sent, count * MTU, line.packet);
    assert_eq!(line.steady.window_at(sent), window);
    let at = |seconds| sent + Duration::from_secs(seconds);
    assert_eq!(line.steady.window_at(at(1)), window + 10 * MTU);
    assert_eq!(line.steady.window_at(at(5)), window + 50 * MTU);
    assert_eq!(line.steady.window_at(at(1000)), window + PROBES * MTU);
    line.packet += 50;
    line.steady.on_sent(at(4), 50 * MTU, line.packet);

    // An old acknowledgement comes first: still two packets may go.
    let flying = window + 49 * MTU;
    line.steady.on_end_acks(at(5), flying, false, Some(line.packet - 60));
    assert_eq!(line.steady.window_at(at(5)), flying + 2 * MTU);
    // Then a new one, and all before it is lost.
    line.packet += 1;
    line.steady.on_sent(at(5), MTU, line.packet);
    let soon = at(5) + TRIP;
    line.steady.on_end_acks(soon, flying, false, Some(line.packet));
    line.steady.on_congestion_event(soon, at(4), true, flying);
    line.steady.on_end_acks(soon, 0, false, Some(line.packet));
    assert!(line.steady.window_at(soon) >= window / 2, "{}", line.steady.window / MTU);
    assert!(line.steady.window_at(soon) <= window);
    // And soon all is as it was.
    line.now = soon;
    assert!(line.rounds(4, |_| false) * MTU > window);
}

#[test]
fn being_idle_is_no_outage() {
    let mut line = Line::new(u64::MAX);
    line.rounds(2, |_| false);
    let window = line.steady.window;
    line.now += Duration::from_secs(100);
    line.steady.on_sent(line.now, 50, line.packet + 1);
    line.steady.on_end_acks(line.now + TRIP, 0, true, Some(line.packet + 1));
    assert_eq!(line.steady.window_at(line.now + TRIP), window);
}
