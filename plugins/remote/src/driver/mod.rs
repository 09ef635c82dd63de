//! Moves the messages between the session and the network, and keeps a connection.

mod report;

use std::{sync::Arc, time::Duration};

use bevy::{
    log::{debug, info, warn},
    platform::time::Instant,
};
use farlight_gi::{LinkStatus, solver::session::SessionSettings};
use farlight_wire::{
    Channel, ClientConfig, ClientEvent, ClientSession, CloseCode, Closed, Connector, Limits, Link,
    LinkEvent, LinkStats, Token, Wake,
};

use crate::{
    RemoteSettings,
    attempts::{Attempted, Attempts},
    light::Grids,
    mailbox::merge,
    shared::{Shared, ToDriver},
};
use report::{FIRST, SHOWN_AFTER};

/// While light is expected the server is heard at least five times a second (it answers pings); after
/// such a silence other ways are tried, besides waiting.
const BUSY_SILENCE: Duration = Duration::from_secs(1);
/// While nothing is expected pings go every other second.
const STILL_SILENCE: Duration = Duration::from_secs(3);
/// Where a new connection did not help, patience doubles up to this.
const MAX_SILENCE: Duration = Duration::from_secs(8);
/// After such a silence a connection is gone, whatever the network says.
const GIVEN_UP: Duration = Duration::from_secs(15);
/// A connection that holds so long has lasted.
const LASTING: Duration = Duration::from_secs(10);

/// The network's side of a [`RemoteBackend`](crate::RemoteBackend): what its thread runs. Without a
/// thread (in tests in virtual time, or where there are none) whoever holds it calls
/// [`tick`](Self::tick).
pub struct Driver {
    shared: Arc<Shared>,
    session: ClientSession,
    connector: Box<dyn Connector>,
    peer: Arc<str>,
    limits: Limits,
    wake: Wake,
    attempts: Attempts,
    line: Option<Line>,
    grids: Grids,
    /// Why there is no connection, or what was last wrong with it.
    why: Arc<str>,
    failed: Option<Arc<str>>,
    over: bool,
    /// What the log was last told: whether there is a connection.
    told: Option<bool>,
    /// How long silence is borne.
    patience: Duration,
    decode: Duration,
    status: LinkStatus,
    /// What links that are over had moved.
    moved: LinkStats,
    welcomes: u64,
}

/// The connection in use.
struct Line {
    link: Box<dyn Link>,
    since: Duration,
    welcomed: bool,
}

impl Driver {
    pub(crate) fn new(
        shared: Arc<Shared>,
        connector: Box<dyn Connector>,
        token: Token,
        settings: &RemoteSettings,
        session: SessionSettings,
    ) -> Self {
        let limits = Limits::default();
        let peer: Arc<str> = connector.peer().into();
        let name = settings.name.clone();
        let config = ClientConfig { name, token, settings: session, limits };
        Self {
            wake: shared.waker(),
            shared,
            session: ClientSession::new(config),
            connector,
            limits,
            attempts: Attempts::new(settings.retry(), settings.seed()),
            line: None,
            grids: Grids::default(),
            why: "there is no answer".into(),
            failed: None,
            over: false,
            told: None,
            patience: BUSY_SILENCE,
            decode: Duration::ZERO,
            status: LinkStatus { peer: peer.clone(), ..Default::default() },
            peer,
            moved: LinkStats::default(),
            welcomes: 0,
        }
    }

    /// Does what is to be done at the time `now` (since any fixed moment, never going back). Returns
    /// when to be called again if nothing happens; whatever happens before wakes the backend.
    pub fn tick(&mut self, now: Duration) -> Option<Duration> {
        let orders = std::mem::take(&mut self.shared.lock().to_driver);
        if orders.stop {
            self.stop();
        }
        if self.over || self.failed.is_some() {
            return None;
        }
        self.obey(now, orders);
        self.listen(now);
        self.connect(now);
        self.transmit(now);
        self.report(now);
        if self.failed.is_some() {
            return None;
        }
        let heard = self.line.as_ref().map(|line| self.heard(line));
        let bearable = self.bearable(now);
        let silences = [bearable, bearable + SHOWN_AFTER, GIVEN_UP];
        let silences = silences.map(|silence| heard.map(|heard| heard + silence));
        let next = silences.into_iter().flatten().filter(|at| *at > now);
        let first = self.attempts.wanted_since().map(|since| since + FIRST).filter(|at| *at > now);
        next.chain(self.session.next_timeout()).chain(self.attempts.next()).chain(first).min()
    }

    /// Whether the game is done with it, so that it need not be called again.
    #[must_use]
    pub fn is_over(&self) -> bool {
        self.over
    }

    fn stop(&mut self) {
        self.over = true;
        self.attempts.end();
        if let Some(mut line) = self.line.take() {
            line.link.close(CloseCode::Done, "");
        }
    }

    fn obey(&mut self, now: Duration, orders: ToDriver) {
        for (snapshot, changes) in orders.submitted {
            self.grids.submitted(&changes);
            self.session.submit(now, snapshot, changes);
        }
        if orders.resync {
            self.session.resync();
        }
        if let Some(view) = orders.view {
            self.session.set_view(view);
        }
    }

    /// Takes what came over the connection.
    fn listen(&mut self, now: Duration) {
        while let Some(event) = self.line.as_mut().and_then(|line| line.link.poll()) {
            match event {
                LinkEvent::Opened => {}
                LinkEvent::Sent(id) => self.session.sent(now, id),
                LinkEvent::Received(channel, message) => self.receive(now, channel, &message),
                LinkEvent::Closed(closed) => self.lost(now, &closed),
            }
        }
    }

    fn receive(&mut self, now: Duration, channel: Channel, message: &[u8]) {
        let start = Instant::now();
        let outcome = self.session.receive(now, channel, message);
        if let Err(error) = outcome {
            let text = error.to_string();
            self.hang_up(error.close_code(), &text);
            self.fail(format!("a message of the lighting server can't be used: {text}"));
            return;
        }
        if channel == Channel::Latest {
            self.decode += start.elapsed();
            self.status.updates += 1;
            self.status.update_bytes += message.len() as u64;
        }
        while let Some(event) = self.session.poll_event() {
            self.take(event);
        }
        if let Some(line) = &self.line
            && line.welcomed
        {
            // It speaks.
            if now.saturating_sub(line.since) > LASTING {
                self.attempts.forget();
                self.patience = BUSY_SILENCE;
            }
            self.attempts.end();
        }
    }

    fn take(&mut self, event: ClientEvent) {
        match event {
            ClientEvent::Welcomed { resumed, settings: _ } => {
                if let Some(line) = &mut self.line {
                    line.welcomed = true;
                }
                self.welcomes += 1;
                let has = if resumed { "it has the scene" } else { "it gets the scene" };
                match self.told {
                    _ if self.welcomes == 1 => info!("light is solved by {}", self.peer),
                    Some(false) => info!("the lighting server {} is back; {has}", self.peer),
                    _ => debug!("a new connection to {}; {has}", self.peer),
                }
                self.told = Some(true);
            }
            ClientEvent::Lighting { message, trip } => {
                let start = Instant::now();
                let mut update = self.grids.update(message, trip);
                let merged = self.shared.lock().updates.pop_to_merge();
                self.decode += start.elapsed();
                update.times.decode = Some(std::mem::take(&mut self.decode));
                let update = match merged {
                    Some(mut older) => {
                        merge(&mut older, update);
                        older
                    }
                    None => update,
                };
                self.shared.lock().updates.push(update);
            }
            ClientEvent::Notice(text) => warn!("the lighting server {} says: {text}", self.peer),
        }
    }

    /// When the connection was last heard of.
    fn heard(&self, line: &Line) -> Duration {
        self.session.state().last_heard.unwrap_or(line.since)
    }

    /// How much silence is normal.
    fn bearable(&self, now: Duration) -> Duration {
        match &self.line {
            // A greeting may have to wait for a busy server.
            Some(line) if !line.welcomed => {
                let gone = now.saturating_sub(self.attempts.wanted_since().unwrap_or(line.since));
                (gone / 2).max(STILL_SILENCE)
            }
            Some(_) if self.session.is_converged() => self.patience.max(STILL_SILENCE),
            _ => self.patience,
        }
    }

    /// Looks for a connection where there is none, or none that is heard of.
    fn connect(&mut self, now: Duration) {
        if let Some(line) = &self.line {
            let silence = now.saturating_sub(self.heard(line));
            if silence >= GIVEN_UP {
                let why = format!("nothing was heard for {} s", GIVEN_UP.as_secs());
                self.hang_up(CloseCode::Abandoned, "");
                self.lost(now, &Closed::Lost(why.into()));
            } else if silence >= self.bearable(now) && self.attempts.next().is_none() {
                debug!("nothing was heard of {} for {silence:?}", self.peer);
                self.why = "the server does not answer".into();
                self.attempts.begin(now);
            }
        } else {
            self.attempts.begin(now);
        }
        while let Some(attempted) = self.attempts.poll() {
            match attempted {
                Attempted::Opened(link) => self.switch(now, link),
                Attempted::Failed(closed) => {
                    debug!("no connection to {}: {closed}", self.peer);
                    self.note(&closed);
                }
            }
        }
        if self.failed.is_none() && self.attempts.next().is_some_and(|next| next <= now) {
            let link = self.connector.connect(&self.limits, self.wake.clone());
            self.attempts.start(now, link);
        }
    }

    /// A new connection is open: it takes the place of the old one.
    fn switch(&mut self, now: Duration, link: Box<dyn Link>) {
        if self.line.is_some() {
            self.patience = (self.patience * 2).min(MAX_SILENCE);
            self.hang_up(CloseCode::Replaced, "");
        }
        self.line = Some(Line { link, since: now, welcomed: false });
        self.session.connected(now);
        self.listen(now);
    }

    /// Ends the connection from this side.
    fn hang_up(&mut self, code: CloseCode, why: &str) {
        if let Some(mut line) = self.line.take() {
            self.count(&*line.link);
            line.link.close(code, why);
        }
        self.session.disconnected();
    }

    /// The connection is gone.
    fn lost(&mut self, now: Duration, closed: &Closed) {
        if let Some(line) = self.line.take() {
            self.count(&*line.link);
        }
        self.session.disconnected();
        self.note(closed);
        if self.failed.is_none() {
            self.attempts.begin(now);
        }
    }

    fn count(&mut self, link: &dyn Link) {
        let LinkStats { sent_bytes, received_bytes, .. } = link.stats();
        self.moved.sent_bytes += sent_bytes;
        self.moved.received_bytes += received_bytes;
    }

    /// Notes why a connection is gone or was not made; some reasons are final.
    fn note(&mut self, closed: &Closed) {
        let is_final = match closed {
            Closed::Lost(_) => false,
            Closed::Goodbye(code, _) => !code.is_worth_retrying(),
            Closed::Untrusted(_) | Closed::Broken(_) => true,
        };
        if is_final {
            self.fail(format!("the lighting server {}: {closed}", self.peer));
        } else {
            self.why = closed.to_string().into();
        }
    }

    fn fail(&mut self, why: String) {
        self.attempts.end();
        self.hang_up(CloseCode::Done, "");
        self.failed.get_or_insert(why.into());
    }

    fn transmit(&mut self, now: Duration) {
        let Some(line) = &mut self.line else { return };
        while let Some(transmit) = self.session.poll_transmit(now) {
            line.link.send(transmit);
        }
    }
}

impl std::fmt::Debug for Driver {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        f.debug_struct("Driver").field("status", &self.status).finish_non_exhaustive()
    }
}
