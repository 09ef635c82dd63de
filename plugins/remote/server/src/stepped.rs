//! A server without threads and without a clock.

use std::{sync::Arc, time::Duration};

use farlight_gi_solver::settings::SettingsError;
use farlight_wire::{CloseCode, Listener, Token};

use crate::{
    door::{Door, Opened},
    driver::{Driver, Next},
    house::House,
    report::SessionReport,
    server,
    settings::ServerSettings,
    worker::{SolverFactory, Worker},
};

/// The parts of a [`Server`](crate::Server) driven from outside: by a test in virtual time, or by a
/// host that has no threads. Solvers work inside of [`tick`](Self::tick), a piece each.
pub struct SteppedServer {
    house: Arc<House>,
    door: Door,
    sessions: Vec<(Driver, Worker)>,
    now: Duration,
}

impl SteppedServer {
    /// A server that lets in whoever knows `token`.
    ///
    /// # Errors
    /// A setting is out of its range.
    pub fn new(
        settings: ServerSettings,
        listener: Box<dyn Listener>,
        token: Token,
    ) -> Result<Self, SettingsError> {
        Self::new_with(settings, listener, token, server::solver())
    }

    /// [`new`](Self::new) with something else that solves.
    ///
    /// # Errors
    /// A setting is out of its range.
    pub fn new_with(
        settings: ServerSettings,
        listener: Box<dyn Listener>,
        token: Token,
        solver: SolverFactory,
    ) -> Result<Self, SettingsError> {
        settings.validate()?;
        let house = Arc::new(House::new(settings, token, solver));
        let door = Door::new(house.clone(), listener);
        Ok(Self { house, door, sessions: Vec::new(), now: Duration::ZERO })
    }

    /// Does what is to be done at the time `now` (since any fixed moment, never going back), and one
    /// piece of work of each solver. Returns when to be called again if nothing arrives: at once
    /// (`now`) while a solver works.
    pub fn tick(&mut self, now: Duration) -> Option<Duration> {
        self.now = now;
        let (opened, mut next) = self.door.tick(now);
        self.sessions.extend(opened.into_iter().map(|Opened { driver, worker }| (driver, worker)));
        let sooner = |a: Option<Duration>, b| [a, b].into_iter().flatten().min();
        self.sessions.retain_mut(|(driver, worker)| {
            for again in [true, false] {
                match driver.tick(now) {
                    Next::At(at) => next = sooner(next, at),
                    Next::Over => return false,
                }
                if !(again && worker.tick(|| now)) {
                    break;
                }
                // What was solved leaves at once, and more may follow.
                next = Some(now);
            }
            true
        });
        next
    }

    /// The sessions that there are.
    #[must_use]
    pub fn sessions(&self) -> Vec<SessionReport> {
        self.house.rooms().iter().map(|room| SessionReport::new(room, self.now)).collect()
    }

    /// Says goodbye to all clients and ends the sessions.
    pub fn stop(mut self) {
        self.door.close();
        for (mut driver, _) in self.sessions {
            driver.room().end(CloseCode::ShuttingDown, "the server is being stopped");
            driver.tick(self.now);
        }
    }
}

impl std::fmt::Debug for SteppedServer {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        f.debug_struct("SteppedServer").field("sessions", &self.sessions()).finish()
    }
}
