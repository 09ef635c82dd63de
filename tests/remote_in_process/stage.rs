//! A game and a lighting server over a simulated network, in virtual time.

use std::time::Duration;

use farlight::{
    gi::{
        BackendState, LightingBackend, LinkState,
        solver::session::{SessionChange, SnapshotId},
    },
    remote::{Driver, RemoteBackend, RemoteSettings},
};
use farlight_server::{ServerSettings, SteppedServer};
use farlight_wire::{
    Limits, Token,
    simulated::{LinkConditions, Network},
};

use crate::{
    clock::TOKEN,
    picture::Picture,
    scene::{lamp, room, settings},
};

pub(crate) const MS: Duration = Duration::from_millis(1);
/// What a piece of the solver's work takes here, whatever it takes really.
const SOLVER_STEP: Duration = Duration::from_millis(5);

/// 100 ms round trip, one packet in twenty is lost.
pub(crate) fn bad_line() -> LinkConditions {
    LinkConditions {
        delay: 50 * MS,
        jitter: 5 * MS,
        loss: 0.05,
        reorder: 0.02,
        ..Default::default()
    }
}

pub(crate) struct Stage {
    pub(crate) network: Network,
    pub(crate) server: Option<SteppedServer>,
    pub(crate) backend: RemoteBackend,
    driver: Driver,
    pub(crate) picture: Picture,
    pub(crate) snapshot: SnapshotId,
    /// Whether the game polls.
    pub(crate) polls: bool,
    now: Duration,
    server_due: Option<Duration>,
    driver_due: Option<Duration>,
}

impl Stage {
    /// A game with an empty scene, connecting to a server.
    pub(crate) fn new(seed: u64, conditions: LinkConditions) -> Self {
        Self::with_token(seed, conditions, TOKEN)
    }

    pub(crate) fn with_token(seed: u64, conditions: LinkConditions, token: Token) -> Self {
        let network = Network::new(seed);
        network.set_conditions(conditions);
        let remote = RemoteSettings { seed, ..Default::default() };
        let connector = Box::new(network.connector());
        let (backend, driver) = RemoteBackend::stepped(connector, token, &remote, settings());
        let mut stage = Self {
            network,
            server: None,
            backend,
            driver,
            picture: Picture::default(),
            snapshot: SnapshotId(0),
            polls: true,
            now: Duration::ZERO,
            server_due: None,
            driver_due: Some(Duration::ZERO),
        };
        stage.start_server();
        stage
    }

    /// A new server, that knows nothing of the one before.
    pub(crate) fn start_server(&mut self) {
        let listener = Box::new(self.network.listener(&Limits::default()));
        let settings = ServerSettings { threads: 1, ..Default::default() };
        self.server = Some(SteppedServer::new(settings, listener, TOKEN).unwrap());
        self.server_due = Some(self.now);
    }

    /// The end of a server without a word.
    pub(crate) fn kill_server(&mut self) {
        self.server = None;
        self.server_due = None;
    }

    pub(crate) fn now(&self) -> Duration {
        self.now
    }

    /// Hands the scene and a light to the backend.
    pub(crate) fn submit(&mut self, changes: Vec<SessionChange>) {
        self.snapshot.0 += 1;
        self.backend.submit(self.snapshot, changes);
        self.driver_due = Some(self.now);
    }

    pub(crate) fn submit_room(&mut self, phase: f32) {
        let mut changes = room();
        changes.push(lamp(phase));
        self.submit(changes);
    }

    pub(crate) fn resync(&mut self) {
        self.backend.resync();
        self.driver_due = Some(self.now);
    }

    /// Lets time pass.
    pub(crate) fn run(&mut self, time: Duration) {
        let end = self.now + time;
        loop {
            let due = [self.network.next_event(), self.server_due, self.driver_due];
            let next = due.into_iter().flatten().min().unwrap_or(end).clamp(self.now, end);
            self.network.advance(next);
            self.now = next;
            if let Some(server) = &mut self.server {
                let due = server.tick(next);
                self.server_due = due.map(|due| due.max(next + SOLVER_STEP));
            }
            let due = self.driver.tick(next);
            self.driver_due = due.map(|due| due.max(next + MS / 10));
            while self.polls
                && let Some(update) = self.backend.poll()
            {
                self.picture.show(update);
            }
            if next >= end {
                return;
            }
        }
    }

    /// Lets time pass until something is so; panics after `patience`. Answers how long it took.
    pub(crate) fn run_until(
        &mut self,
        patience: Duration,
        mut done: impl FnMut(&Self) -> bool,
    ) -> Duration {
        let start = self.now;
        while !done(self) {
            assert!(self.now - start < patience, "at {:?}: {self:?}", self.now);
            self.run(10 * MS);
        }
        self.now - start
    }

    /// Runs until the newest snapshot is solved as well as it will be.
    pub(crate) fn settle(&mut self) -> Duration {
        self.run_until(Duration::from_secs(60), |stage| {
            stage.backend.state() == BackendState::Converged
                && stage.picture.snapshot == stage.snapshot
        })
    }

    pub(crate) fn link_state(&self) -> LinkState {
        self.backend.link().unwrap().state
    }
}

impl std::fmt::Debug for Stage {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        let mut out = f.debug_struct("Stage");
        out.field("state", &self.backend.state()).field("link", &self.backend.link());
        out.field("snapshot", &self.snapshot).field("shown", &self.picture.snapshot);
        out.field("quality", &self.picture.quality).field("server", &self.server).finish()
    }
}
