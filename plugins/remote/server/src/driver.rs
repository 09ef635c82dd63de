//! Moves the messages of one session between its link, its state machine and its solver.

use std::{
    sync::{Arc, atomic::Ordering},
    time::{Duration, Instant},
};

use farlight_wire::{
    Channel, CloseCode, Closed, Link, LinkEvent, LinkStats, SceneSize, ServerEvent,
};
use tracing::{info, warn};

use crate::{
    bell::lock,
    house::{Guest, House, Room},
};

/// A connection on which nothing was heard for so long counts as lost (clients send keep-alives).
pub(crate) const SILENCE: Duration = Duration::from_secs(20);

/// Events of a link that are handled before messages are sent again.
const EVENTS: usize = 64;

/// Drives one session from outside; see [`tick`](Self::tick).
pub(crate) struct Driver {
    house: Arc<House>,
    room: Arc<Room>,
    line: Option<Line>,
    away_since: Option<Duration>,
    over: bool,
    /// Over which a goodbye is on its way.
    leaving: Option<Box<dyn Link>>,
}

/// The present connection.
struct Line {
    link: Box<dyn Link>,
    address: String,
    since: Duration,
    /// What is already in the counters of the server.
    counted: LinkStats,
}

/// Why a session is over: what the client is told, and whether people should worry.
struct End {
    code: CloseCode,
    why: String,
    warn: bool,
}

impl End {
    fn quiet(code: CloseCode, why: impl Into<String>) -> Self {
        Self { code, why: why.into(), warn: false }
    }
}

/// What a driver wants next.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Next {
    /// To be called when the bell rings, or at this time.
    At(Option<Duration>),
    /// Nothing: the session is over.
    Over,
}

impl Driver {
    pub(crate) fn new(house: Arc<House>, room: Arc<Room>) -> Self {
        Self { house, room, line: None, away_since: None, over: false, leaving: None }
    }

    /// The session that it drives.
    pub(crate) fn room(&self) -> &Arc<Room> {
        &self.room
    }

    /// Does what is to be done at the time `now`.
    pub(crate) fn tick(&mut self, now: Duration) -> Next {
        if self.over {
            return Next::Over;
        }
        match self.work(now) {
            Ok(next) => Next::At(next),
            Err(end) => {
                self.end(&end);
                Next::Over
            }
        }
    }

    /// The driver itself failed.
    pub(crate) fn fail(&mut self, why: &str) {
        let why = format!("the server failed: {why}");
        self.end(&End { code: CloseCode::Failed, why, warn: true });
    }

    /// Sleeps until the goodbye of a session that is over has left, for a second at most.
    pub(crate) fn linger(&mut self) {
        let Some(link) = &mut self.leaving else { return };
        for _ in 0..100 {
            while let Some(event) = link.poll() {
                if matches!(event, LinkEvent::Closed(_)) {
                    return;
                }
            }
            std::thread::sleep(Duration::from_millis(10));
        }
    }

    fn work(&mut self, now: Duration) -> Result<Option<Duration>, End> {
        if let Some((code, why)) = self.room.end_order() {
            return Err(End::quiet(code, why));
        }
        if let Some(why) = self.room.task().failed.clone() {
            let why = format!("the solver failed: {why}");
            return Err(End { code: CloseCode::Failed, why, warn: true });
        }
        while let Some(guest) = self.room.next_guest() {
            self.attach(now, guest);
        }
        let more = self.receive(now)?;
        self.listen(now);
        self.transmit(now);
        self.count();
        if more {
            return Ok(Some(now));
        }
        self.next_time(now)
    }

    /// When something is due although nothing happens.
    fn next_time(&mut self, now: Duration) -> Result<Option<Duration>, End> {
        let resume = self.house.settings.resume_time();
        if self.line.is_some() {
            let wire = lock(&self.room.wire);
            let silent = wire.last_heard().map(|heard| heard + SILENCE);
            return Ok([wire.next_timeout(), silent].into_iter().flatten().min());
        }
        let due = self.away_since.unwrap_or(now) + resume;
        if due > now {
            return Ok(Some(due));
        }
        // Somebody may have come back this very moment.
        if self.room.close(false) {
            let why = format!("the client did not come back within {} s", resume.as_secs());
            return Err(End::quiet(CloseCode::Done, why));
        }
        Ok(Some(now))
    }

    /// A client comes, for the first time or back.
    fn attach(&mut self, now: Duration, guest: Guest) {
        let Guest { link, address, resumed } = guest;
        if let Some(mut old) = self.line.take() {
            let code = CloseCode::Replaced;
            info!("{}: its client comes back from {address}", self.room);
            old.link.close(code, "");
            self.detach(now);
        } else if resumed {
            info!("{}: its client is back, from {address}", self.room);
        }
        {
            let mut progress = lock(&self.room.progress);
            progress.address = Some(address.clone());
            progress.away_since = None;
        }
        self.away_since = None;
        lock(&self.room.wire).attach(now, resumed);
        self.line = Some(Line { link, address, since: now, counted: LinkStats::default() });
        self.room.set_task(|task| task.attached = true);
    }

    /// The client is gone, but may come back.
    fn detach(&mut self, now: Duration) {
        self.line = None;
        self.away_since = Some(now);
        lock(&self.room.wire).detach();
        {
            let mut progress = lock(&self.room.progress);
            progress.address = None;
            progress.away_since = Some(now);
        }
        self.room.set_task(|task| task.attached = false);
    }

    /// Takes what the link has; says whether there may be more.
    fn receive(&mut self, now: Duration) -> Result<bool, End> {
        for _ in 0..EVENTS {
            let Some(line) = &mut self.line else { return Ok(false) };
            let Some(event) = line.link.poll() else { return Ok(false) };
            match event {
                // Light is held back by its acknowledgements, everything else is small.
                LinkEvent::Opened | LinkEvent::Sent(_) => {}
                LinkEvent::Received(channel, message) => self.take(now, channel, &message)?,
                LinkEvent::Closed(closed) => self.closed(now, &closed)?,
            }
        }
        Ok(true)
    }

    fn take(&mut self, now: Duration, channel: Channel, message: &[u8]) -> Result<(), End> {
        let mut wire = lock(&self.room.wire);
        let outcome = wire.receive(now, channel, message, &self.house.blobs);
        let mut changed = false;
        while let Some(event) = wire.poll_event() {
            changed |= event == ServerEvent::Changed;
        }
        drop(wire);
        if changed {
            self.room.set_task(|task| task.changed = true);
        }
        outcome.map_err(|e| End { code: e.close_code(), why: e.to_string(), warn: true })
    }

    fn closed(&mut self, now: Duration, closed: &Closed) -> Result<(), End> {
        match closed {
            Closed::Goodbye(CloseCode::Done, _) => {
                self.line = None;
                Err(End::quiet(CloseCode::Done, "its client said goodbye"))
            }
            Closed::Broken(why) => {
                self.line = None;
                Err(End { code: CloseCode::Protocol, why: why.to_string(), warn: true })
            }
            Closed::Lost(_) | Closed::Goodbye(..) | Closed::Untrusted(_) => {
                let patience = self.house.settings.resume_seconds;
                info!("{}: {closed}; it is kept for {patience} s", self.room);
                self.detach(now);
                Ok(())
            }
        }
    }

    /// Gives up a connection on which nothing comes any more.
    fn listen(&mut self, now: Duration) {
        let Some(line) = &mut self.line else { return };
        let heard = lock(&self.room.wire).last_heard().unwrap_or(line.since);
        if now.saturating_sub(heard) < SILENCE {
            return;
        }
        let silence = SILENCE.as_secs();
        info!("{}: nothing was heard of its client for {silence} s", self.room);
        line.link.close(CloseCode::Abandoned, "nothing was heard for too long");
        self.detach(now);
    }

    fn transmit(&mut self, now: Duration) {
        let Some(line) = &mut self.line else { return };
        let mut wire = lock(&self.room.wire);
        loop {
            let start = Instant::now();
            let transmit = wire.poll_transmit(now);
            if let Some(transmit) = transmit {
                if transmit.channel == Channel::Latest {
                    wire.note_encode(start.elapsed());
                }
                line.link.send(transmit);
            } else {
                while let Some(id) = wire.poll_cancel() {
                    line.link.cancel(id);
                }
                return;
            }
        }
    }

    /// Adds what the link has moved to the sums of the server.
    fn count(&mut self) {
        let Some(line) = &mut self.line else { return };
        let stats = line.link.stats();
        let counters = &self.house.counters;
        let sent = stats.sent_bytes.saturating_sub(line.counted.sent_bytes);
        let received = stats.received_bytes.saturating_sub(line.counted.received_bytes);
        counters.sent_bytes.fetch_add(sent, Ordering::Relaxed);
        counters.received_bytes.fetch_add(received, Ordering::Relaxed);
        line.counted = stats;
    }

    fn end(&mut self, end: &End) {
        self.over = true;
        self.count();
        self.house.remove(&self.room);
        self.room.close(true);
        self.room.set_task(|task| task.stop = true);
        let size = lock(&self.room.progress).size;
        let address = self.line.as_ref().map_or("", |line| &line.address);
        let at = if address.is_empty() { "" } else { " at " };
        let (room, why) = (&self.room, &end.why);
        let SceneSize { objects, triangles, .. } = size;
        if end.warn {
            warn!("{room}{at}{address} ends: {why} ({objects} objects, {triangles} triangles)");
        } else {
            info!("{room}{at}{address} ends: {why} ({objects} objects, {triangles} triangles)");
        }
        if let Some(mut line) = self.line.take() {
            line.link.close(end.code, &end.why);
            self.leaving = Some(line.link);
        }
        // Who was about to come back tries again and gets a new session.
        while let Some(mut guest) = self.room.next_guest() {
            guest.link.close(CloseCode::Failed, "the session has just ended");
        }
        self.room.clear();
        self.house.trim();
    }
}
