//! Pings: they measure the round trip, keep the connection, and wake it after an outage.
//!
//! QUIC sends lost data again after a time that doubles with every try. A ping is new data, which
//! is sent at once; its acknowledgement shows what was lost. So while an answer is missing, pings
//! are frequent.

use std::time::Duration;

/// While something is expected and not heard of.
const BUSY: Duration = Duration::from_millis(200);
/// While nothing is: keep-alive.
const STILL: Duration = Duration::from_secs(2);

#[derive(Debug, Default)]
pub(crate) struct Pinger {
    last_ping: Duration,
    last_heard: Option<Duration>,
    to_answer: Option<u64>,
    rtt: Option<Duration>,
}

impl Pinger {
    /// A connection begins.
    pub(crate) fn start(&mut self, now: Duration) {
        *self = Self { last_ping: now, last_heard: Some(now), ..Self::default() };
    }

    /// A message came.
    pub(crate) fn heard(&mut self, now: Duration) {
        self.last_heard = Some(now);
    }

    /// The other side pings. Only its newest ping is answered.
    pub(crate) fn asked(&mut self, time: u64) {
        self.to_answer = Some(time);
    }

    /// The other side answers.
    pub(crate) fn answered(&mut self, now: Duration, time: u64) {
        // A time that we can't have sent says nothing.
        self.rtt = now.checked_sub(Duration::from_micros(time)).or(self.rtt);
    }

    /// The ping to answer.
    pub(crate) fn answer(&mut self) -> Option<u64> {
        self.to_answer.take()
    }

    /// The ping to send now, if it is time.
    pub(crate) fn due(&mut self, now: Duration, busy: bool) -> Option<u64> {
        if now < self.next(busy) {
            return None;
        }
        self.last_ping = now;
        Some(u64::try_from(now.as_micros()).unwrap_or(u64::MAX))
    }

    /// When the next ping is due.
    pub(crate) fn next(&self, busy: bool) -> Duration {
        // Silence after a ping is as good as business.
        let silent = self.last_heard.is_some_and(|heard| heard < self.last_ping);
        self.last_ping + if busy || silent { BUSY } else { STILL }
    }

    pub(crate) fn rtt(&self) -> Option<Duration> {
        self.rtt
    }

    pub(crate) fn last_heard(&self) -> Option<Duration> {
        self.last_heard
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn pings_are_frequent_while_something_is_missing() {
        let ms = Duration::from_millis;
        let mut pinger = Pinger::default();
        pinger.start(ms(1000));
        assert_eq!(pinger.due(ms(1100), true), None);
        assert_eq!(pinger.due(ms(1200), true), Some(1_200_000));
        pinger.heard(ms(1210));
        pinger.answered(ms(1210), 1_200_000);
        assert_eq!(pinger.rtt(), Some(ms(10)));
        assert_eq!(pinger.next(false), ms(3200));
        assert_eq!(pinger.due(ms(3200), false), Some(3_200_000));
        assert_eq!(pinger.next(false), ms(3400), "no answer yet");
        pinger.answered(ms(3500), u64::MAX);
        assert_eq!(pinger.rtt(), Some(ms(10)));
    }
}
