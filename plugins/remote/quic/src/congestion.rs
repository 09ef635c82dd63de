//! How much may be on its way: congestion control for lines that lose packets and go silent.
//!
//! What comes with QUIC suits long downloads. Controllers that take every loss for congestion (Reno,
//! Cubic) send a few packets a round trip over a line that loses 5 %, as radio does. And all of them
//! wait after an outage: the window is full of lost packets, so nothing new may be sent, and QUIC's own
//! probes come at intervals that double, so the silence may last twice as long as the outage.
//!
//! This one
//! - takes a loss of more than [`LOSSY`] or a queue (a round trip that is much longer than the shortest)
//!   for congestion, and a few losses for noise;
//! - lets two more packets go for every [`PROBE`] of silence. The first one that arrives after the outage
//!   brings an acknowledgement, which tells QUIC what is lost;
//! - never goes below a small window, which needs its time on a slow line but does not stall on a lossy
//!   one.
//!
//! The ideas: delay as the sign of a queue is TCP Vegas' (Brakmo and Peterson 1995), loss rates as the
//! sign of congestion instead of single losses are PCC's (Dong et al. 2015) and BBR's.

use std::{
    any::Any,
    sync::Arc,
    time::{Duration, Instant},
};

use wtransport::quinn::congestion::{Controller, ControllerFactory};

/// Packets at the start, at least and at most. The first is what RFC 9002 allows, three times.
const START: u64 = 32;
const LEAST: u64 = 16;
const MOST: u64 = 8192;

/// The share of bytes lost that means congestion, and the packets that it is counted over.
const LOSSY: f64 = 0.12;
const SAMPLE: u64 = 64;

/// A queue is there when round trips last half as long again as the shortest one and this.
const QUEUE: Duration = Duration::from_millis(60);

/// A queue begins already with this.
const JITTER: Duration = Duration::from_millis(20);

/// The window after congestion, after a queue, and after an outage, of what it was.
const AFTER_LOSS: f64 = 0.7;
const AFTER_QUEUE: f64 = 0.85;
const AFTER_OUTAGE: f64 = 0.5;

/// So long nothing is acknowledged when the line is out.
const OUTAGE: Duration = Duration::from_millis(600);

/// Silence that earns two packets, and the packets that it earns at most.
const PROBE: Duration = Duration::from_millis(200);
const PROBES_AT_ONCE: u64 = 2;
const PROBES: u64 = 100;

/// Smaller packets are mostly acknowledgements, which nobody acknowledges.
const SMALL: u64 = 100;

/// The shortest round trip counts for so long; routes change.
const MEMORY: Duration = Duration::from_secs(30);

/// Makes the controller of a connection.
pub(crate) struct SteadyConfig;

impl ControllerFactory for SteadyConfig {
    fn build(self: Arc<Self>, _now: Instant, current_mtu: u16) -> Box<dyn Controller> {
        Box::new(Steady::new(current_mtu))
    }
}

/// The controller of a connection. Times are those that QUIC passes, but for [`Controller::window`], which
/// has none.
#[derive(Clone, Debug)]
struct Steady {
    mtu: u64,
    window: u64,
    /// Grow fast up to here.
    threshold: u64,
    /// Bytes on their way, as far as is known here.
    flying: u64,
    /// After an outage: what may be on its way although the window is smaller, until it is known what is
    /// lost.
    allowed: Option<u64>,
    /// Since when no acknowledgement has come for what is on its way.
    silent_since: Option<Instant>,
    /// When the last silence of the length of an outage ended.
    silent_until: Option<Instant>,
    /// Losses of what was sent before count no more.
    forgiven_until: Option<Instant>,
    round: Round,
    /// The packet whose acknowledgement ends the round.
    round_end: u64,
    last_packet: u64,
    /// A packet whose round trip is being measured.
    probe: Option<(u64, Instant)>,
    shortest: Option<(Duration, Instant)>,
    acked: u64,
    lost: u64,
}

/// What is known of one round trip.
#[derive(Clone, Copy, Debug, Default)]
struct Round {
    acked: u64,
    /// The window, and not a lack of data, bounded what was sent.
    full: bool,
    /// A router has said that it is congested.
    marked: bool,
    shortest: Option<Duration>,
}

impl Steady {
    fn new(mtu: u16) -> Self {
        let mtu = u64::from(mtu);
        Self {
            mtu,
            window: START * mtu,
            threshold: u64::MAX,
            flying: 0,
            allowed: None,
            silent_since: None,
            silent_until: None,
            forgiven_until: None,
            round: Round::default(),
            round_end: 0,
            last_packet: 0,
            probe: None,
            shortest: None,
            acked: 0,
            lost: 0,
        }
    }

    fn set_window(&mut self, window: u64) {
        self.window = window.clamp(LEAST * self.mtu, MOST * self.mtu);
    }

    fn shrink(&mut self, factor: f64) {
        self.set_window((self.window as f64 * factor) as u64);
        self.threshold = self.window;
    }

    /// Measures a round trip now and then.
    fn measure(&mut self, now: Instant, acked: u64) {
        let Some((_, sent)) = self.probe.filter(|(packet, _)| *packet <= acked) else { return };
        self.probe = None;
        let trip = now.saturating_duration_since(sent);
        self.round.shortest = Some(self.round.shortest.map_or(trip, |s| s.min(trip)));
        if self.shortest.is_none_or(|(shortest, _)| trip <= shortest) {
            self.shortest = Some((trip, now));
        }
    }

    /// Forgets the shortest round trip after a while, with a round in which no queue can hide it.
    fn forget_shortest(&mut self, now: Instant, round: &Round) -> bool {
        let Some((shortest, at)) = self.shortest else { return false };
        let Some(trip) = round.shortest else { return false };
        if now.saturating_duration_since(at) < MEMORY {
            return false;
        }
        self.shortest = None;
        if !round.full || trip < shortest.mul_f64(1.25) {
            return false;
        }
        self.threshold = self.window;
        self.set_window((self.window as f64 * 0.75 * shortest.div_duration_f64(trip)) as u64);
        true
    }

    fn end_round(&mut self, now: Instant) {
        let round = std::mem::take(&mut self.round);
        self.round_end = self.last_packet;
        let sample = self.acked + self.lost;
        if sample >= SAMPLE * self.mtu {
            let share = self.lost as f64 / sample as f64;
            (self.acked, self.lost) = (0, 0);
            if share > LOSSY {
                self.shrink(AFTER_LOSS);
                return;
            }
        }
        if self.forget_shortest(now, &round) {
            return;
        }
        if let (Some(trip), Some((shortest, _))) = (round.shortest, self.shortest) {
            if trip > shortest.mul_f64(1.5) + QUEUE {
                self.shrink(AFTER_QUEUE);
                return;
            }
            if trip > shortest.mul_f64(1.5) + JITTER {
                // A queue begins.
                self.threshold = self.threshold.min(self.window);
            }
        }
        if round.full {
            let fast = round.acked.min(self.threshold.saturating_sub(self.window));
            let more = fast.max(round.acked / 8);
            self.set_window(self.window + more);
        }
    }

    fn window_at(&self, now: Instant) -> u64 {
        self.window.max(self.allowed.unwrap_or(0)) + self.probes(now)
    }

    /// What silence adds to the window.
    fn probes(&self, now: Instant) -> u64 {
        let Some(since) = self.silent_since else { return 0 };
        let silence = now.saturating_duration_since(since).as_millis() / PROBE.as_millis();
        (PROBES_AT_ONCE * silence as u64).min(PROBES) * self.mtu
    }
}

impl Controller for Steady {
    fn on_sent(&mut self, now: Instant, bytes: u64, last_packet_number: u64) {
        self.last_packet = last_packet_number;
        if bytes < SMALL {
            return;
        }
        self.flying += bytes;
        self.silent_since.get_or_insert(now);
        self.probe.get_or_insert((last_packet_number, now));
    }

    fn on_end_acks(
        &mut self,
        now: Instant,
        in_flight: u64,
        app_limited: bool,
        largest_packet_num_acked: Option<u64>,
    ) {
        let silence = self.silent_since.map(|since| now.saturating_duration_since(since));
        self.silent_since = (in_flight > 0).then_some(now);
        let acked = self.flying.saturating_sub(in_flight);
        self.flying = in_flight;
        if silence.is_some_and(|silence| silence > OUTAGE) {
            // The first acknowledgement may be an old one that shows nothing as lost.
            self.silent_until = Some(now);
            self.allowed = Some(in_flight + PROBES_AT_ONCE * self.mtu);
            // What was measured since then is the length of the outage.
            self.probe = None;
            self.round = Round::default();
            self.round_end = self.last_packet;
        } else if in_flight <= self.window {
            self.allowed = None;
        }
        self.acked += acked;
        self.round.acked += acked;
        self.round.full |= !app_limited;
        if let Some(largest) = largest_packet_num_acked {
            self.measure(now, largest);
            if largest >= self.round_end {
                self.end_round(now);
            }
        }
    }

    fn on_congestion_event(
        &mut self,
        now: Instant,
        sent: Instant,
        _is_persistent_congestion: bool,
        lost_bytes: u64,
    ) {
        self.flying = self.flying.saturating_sub(lost_bytes);
        self.allowed = self.allowed.map(|allowed| allowed.saturating_sub(lost_bytes));
        if lost_bytes > 0 && self.silent_until == Some(now) {
            // The first acknowledgement after a silence shows that it was an outage.
            self.silent_until = None;
            self.forgiven_until = Some(now);
            self.threshold = self.window;
            self.set_window((self.window as f64 * AFTER_OUTAGE) as u64);
            (self.acked, self.lost, self.round) = (0, 0, Round::default());
        }
        if self.forgiven_until.is_some_and(|until| sent <= until) {
            return;
        }
        if lost_bytes == 0 && !self.round.marked {
            // A router says so (ECN).
            self.round.marked = true;
            self.shrink(AFTER_LOSS);
        }
        self.lost += lost_bytes;
    }

    fn on_mtu_update(&mut self, new_mtu: u16) {
        self.mtu = u64::from(new_mtu);
        self.set_window(self.window);
    }

    fn window(&self) -> u64 {
        self.window_at(Instant::now())
    }

    fn clone_box(&self) -> Box<dyn Controller> {
        Box::new(self.clone())
    }

    fn initial_window(&self) -> u64 {
        START * self.mtu
    }

    fn into_any(self: Box<Self>) -> Box<dyn Any> {
        self
    }
}

#[cfg(test)]
mod tests;
