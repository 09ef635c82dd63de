//! Where clients come in: greetings, the access token, old and new sessions.

use std::{
    collections::VecDeque,
    sync::{Arc, atomic::Ordering},
    time::Duration,
};

use farlight_wire::{
    ClientHello, CloseCode, Limits, Link, LinkEvent, Listener, ServerConfig, ServerSession, Token,
};
use tracing::{debug, info, warn};

use crate::{
    driver::Driver,
    grant::grant,
    house::{Guest, House, Room},
    worker::Worker,
};

/// Connections that may be at the door at the same time; when one more comes, the oldest goes.
const MAX_WAITING: usize = 64;
/// How long a wrong token is left without an answer, so that guessing is slow.
const WRONG_TOKEN_DELAY: Duration = Duration::from_millis(300);
/// A client that was not heard of for so long (three of its keep-alives) does not keep others out.
const QUIET: Duration = Duration::from_secs(6);
/// How often the log sums up.
const SUMMARY: Duration = Duration::from_secs(60);

/// Looks after connections until their clients are in a session.
pub(crate) struct Door {
    house: Arc<House>,
    listener: Box<dyn Listener>,
    waiting: VecDeque<Waiting>,
    next_room: u64,
    summary: Summary,
}

/// A connection whose client is not in yet.
struct Waiting {
    link: Box<dyn Link>,
    address: String,
    /// When patience ends.
    until: Duration,
    /// What it is told then.
    code: CloseCode,
    why: &'static str,
    /// Whether its greeting was read: a wrong one is not read a second time.
    refused: bool,
}

/// What became of a connection.
enum Step {
    Waits,
    Gone,
    Greets(Box<ClientHello>),
}

/// A new session's two halves.
pub(crate) struct Opened {
    pub(crate) driver: Driver,
    pub(crate) worker: Worker,
}

impl Door {
    pub(crate) fn new(house: Arc<House>, listener: Box<dyn Listener>) -> Self {
        let (waiting, summary) = (VecDeque::new(), Summary::default());
        Self { house, listener, waiting, next_room: 1, summary }
    }

    /// Does what is to be done at the time `now`; the new sessions, and when to be called again
    /// although nothing happens.
    pub(crate) fn tick(&mut self, now: Duration) -> (Vec<Opened>, Option<Duration>) {
        while let Some((link, address)) = self.listener.accept() {
            debug!("a connection from {address}");
            if self.waiting.len() >= MAX_WAITING
                && let Some(mut oldest) = self.waiting.pop_front()
            {
                oldest.link.close(CloseCode::Full, "too many clients at the door");
                self.note_refusal(&oldest.address, "too many connections did not say who they are");
            }
            let until = now + self.house.settings.hello_time();
            let (code, why) = (CloseCode::Protocol, "no greeting came");
            self.waiting.push_back(Waiting { link, address, until, code, why, refused: false });
        }
        let mut opened = Vec::new();
        for mut waiting in std::mem::take(&mut self.waiting) {
            match self.look_at(now, &mut waiting) {
                Step::Waits => self.waiting.push_back(waiting),
                Step::Gone => {}
                Step::Greets(hello) => opened.extend(self.greet(now, waiting, *hello)),
            }
        }
        self.summary.tick(now, &self.house);
        let due = self.waiting.iter().map(|waiting| waiting.until);
        let next = due.chain([self.summary.next]).min();
        (opened, next)
    }

    /// Sends everyone away.
    pub(crate) fn close(&mut self) {
        for mut waiting in std::mem::take(&mut self.waiting) {
            waiting.link.close(CloseCode::ShuttingDown, "");
        }
        while let Some((mut link, _)) = self.listener.accept() {
            link.close(CloseCode::ShuttingDown, "");
        }
    }

    fn look_at(&mut self, now: Duration, waiting: &mut Waiting) -> Step {
        // How many texels it gets is decided later, with a better answer.
        let limits = Limits { texels: usize::MAX, ..self.house.limits };
        while let Some(event) = if waiting.refused { None } else { waiting.link.poll() } {
            match event {
                LinkEvent::Opened | LinkEvent::Sent(_) => {}
                LinkEvent::Closed(closed) => {
                    debug!("{} left before its greeting: {closed}", waiting.address);
                    return Step::Gone;
                }
                LinkEvent::Received(channel, message) => {
                    match ClientHello::read(channel, &message, &limits) {
                        Ok(hello) if hello.token == self.house.token => {
                            return Step::Greets(Box::new(hello));
                        }
                        Ok(hello) => {
                            let address = format!("{:?} at {}", hello.name, waiting.address);
                            self.note_refusal(&address, "its access token is wrong");
                            waiting.until = now + WRONG_TOKEN_DELAY;
                            waiting.code = CloseCode::Unauthorized;
                            waiting.why = "the access token is not this server's";
                            waiting.refused = true;
                        }
                        Err(error) => {
                            let (code, why) = (error.close_code(), error.to_string());
                            self.refuse(&mut *waiting.link, &waiting.address, code, &why);
                            return Step::Gone;
                        }
                    }
                }
            }
        }
        if now < waiting.until {
            return Step::Waits;
        }
        if !waiting.refused {
            self.note_refusal(&waiting.address, waiting.why);
        }
        waiting.link.close(waiting.code, waiting.why);
        Step::Gone
    }

    /// A client with the right token.
    fn greet(&mut self, now: Duration, waiting: Waiting, hello: ClientHello) -> Option<Opened> {
        let Waiting { mut link, address, .. } = waiting;
        let settings = match grant(&self.house.settings, &hello.settings) {
            Ok(settings) => settings,
            Err(why) => {
                self.refuse(&mut *link, &address, CloseCode::Limit, &why);
                return None;
            }
        };
        if let Some(room) = hello.resume.and_then(|key| self.house.find(key)) {
            if room.settings == settings {
                match room.enter(Guest { link, address: address.clone(), resumed: true }) {
                    Ok(()) => return None,
                    // It ended this very moment: a new one.
                    Err(guest) => link = guest.link,
                }
            } else {
                self.house.remove(&room);
                room.end(CloseCode::Replaced, "its client asks for other settings");
            }
        }
        if !self.make_room(now) {
            let most = self.house.settings.max_sessions;
            self.refuse(
                &mut *link,
                &address,
                CloseCode::Full,
                &format!("there are {most} sessions"),
            );
            return None;
        }
        let mut key = [0; 16];
        if let Err(error) = getrandom::fill(&mut key) {
            let why = format!("the system gives no random numbers: {error}");
            self.refuse(&mut *link, &address, CloseCode::Failed, &why);
            return None;
        }
        let key = Token(key);
        let config = ServerConfig { limits: self.house.limits };
        let wire = ServerSession::new(key, settings.clone(), config);
        let room = Arc::new(Room::new(self.next_room, key, hello.name, settings, wire));
        self.next_room += 1;
        info!("{room} begins, from {address}");
        self.house.counters.admitted.fetch_add(1, Ordering::Relaxed);
        // Nobody can have ended it yet.
        drop(room.enter(Guest { link, address, resumed: false }));
        self.house.add(room.clone());
        Some(Opened {
            driver: Driver::new(self.house.clone(), room.clone()),
            worker: Worker::new(self.house.clone(), room),
        })
    }

    /// Whether one more session is possible; the one whose client was not heard of for the longest
    /// makes room.
    fn make_room(&self, now: Duration) -> bool {
        let most = self.house.settings.max_sessions as usize;
        // Solvers of sessions that are over end after their piece of work.
        if self.house.solvers.load(Ordering::Relaxed) >= 2 * most {
            return false;
        }
        let rooms = self.house.rooms();
        if rooms.len() < most {
            return true;
        }
        let quiet = |room: &Room| {
            let heard = room.last_heard().filter(|heard| now.saturating_sub(*heard) >= QUIET);
            room.away_since().or(heard)
        };
        let away = rooms.iter().filter_map(|room| Some((quiet(room)?, room)));
        let Some((since, room)) = away.min_by_key(|(since, _)| *since) else { return false };
        let seconds = now.saturating_sub(since).as_secs();
        self.house.remove(room);
        room.end(CloseCode::Full, &format!("it makes room, its client is silent for {seconds} s"));
        true
    }

    fn refuse(&self, link: &mut dyn Link, address: &str, code: CloseCode, why: &str) {
        self.note_refusal(address, why);
        link.close(code, why);
    }

    fn note_refusal(&self, who: &str, why: &str) {
        warn!("{who} is refused: {why}");
        self.house.counters.refused.fetch_add(1, Ordering::Relaxed);
    }
}

/// What a server did since it last said so.
#[derive(Default)]
struct Summary {
    next: Duration,
    seen: [u64; 3],
    bytes: [u64; 2],
}

impl Summary {
    fn tick(&mut self, now: Duration, house: &House) {
        if now < self.next {
            return;
        }
        self.next = now + SUMMARY;
        let counters = &house.counters;
        let load = |counter: &std::sync::atomic::AtomicU64| counter.load(Ordering::Relaxed);
        let seen = [load(&counters.updates), load(&counters.admitted), load(&counters.refused)];
        let bytes = [load(&counters.sent_bytes), load(&counters.received_bytes)];
        if seen != self.seen {
            let new = |i: usize| seen[i] - self.seen[i];
            let mebibytes = |i: usize| (bytes[i] - self.bytes[i]) as f64 / f64::from(1 << 20);
            let rooms = house.rooms();
            let away = rooms.iter().filter(|room| room.away_since().is_some()).count();
            let scenes = house.blobs.bytes() >> 20;
            info!(
                "{} sessions ({away} without their client), {} of them new, {} refused; {} \
                 updates of light, {:.2} MiB sent, {:.2} MiB received; {scenes} MiB of meshes and \
                 images",
                rooms.len(),
                new(1),
                new(2),
                new(0),
                mebibytes(0),
                mebibytes(1),
            );
        }
        (self.seen, self.bytes) = (seen, bytes);
    }
}
