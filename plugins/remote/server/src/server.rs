//! The threads of a server.

use std::{
    panic::{AssertUnwindSafe, catch_unwind},
    sync::{Arc, atomic::Ordering},
    thread::{Builder, JoinHandle},
    time::{Duration, Instant},
};

use farlight_gi_solver::{
    session::{Session, SessionSettings, panic_message},
    settings::SettingsError,
};
use farlight_wire::{CloseCode, Listener, Token};
use tracing::{error, warn};

use crate::{
    door::{Door, Opened},
    driver::{Driver, Next},
    house::House,
    report::SessionReport,
    settings::ServerSettings,
    worker::SolverFactory,
};

/// A running lighting server: clients come in over a [`Listener`], each gets a session with a solver
/// of its own. A session has two threads (its messages, its light), new connections have one.
///
/// Dropping it stops it, as [`stop`](Self::stop) does.
pub struct Server {
    house: Arc<House>,
    start: Instant,
    thread: Option<JoinHandle<()>>,
}

impl Server {
    /// Starts a server that lets in whoever knows `token`.
    ///
    /// # Errors
    /// A setting is out of its range.
    pub fn start(
        settings: ServerSettings,
        listener: Box<dyn Listener>,
        token: Token,
    ) -> Result<Self, SettingsError> {
        Self::start_with(settings, listener, token, solver())
    }

    /// [`start`](Self::start) with something else that solves; `solver` is called on the thread that
    /// will run what it makes.
    ///
    /// # Errors
    /// A setting is out of its range.
    pub fn start_with(
        settings: ServerSettings,
        mut listener: Box<dyn Listener>,
        token: Token,
        solver: SolverFactory,
    ) -> Result<Self, SettingsError> {
        settings.validate()?;
        let house = Arc::new(House::new(settings, token, solver));
        let start = Instant::now();
        let for_network = house.clone();
        listener.set_wake(Arc::new(move || for_network.wake()));
        let door = Door::new(house.clone(), listener);
        let for_thread = house.clone();
        let thread = Builder::new()
            .name("farlight door".into())
            .spawn(move || attend(&for_thread, door, start));
        let thread = thread.inspect_err(|e| error!("the server's thread can't be started: {e}"));
        Ok(Self { house, start, thread: thread.ok() })
    }

    /// Whether it takes clients; `false` only if its thread could not be started or failed.
    #[must_use]
    pub fn is_running(&self) -> bool {
        self.thread.as_ref().is_some_and(|thread| !thread.is_finished())
    }

    /// The sessions that there are.
    #[must_use]
    pub fn sessions(&self) -> Vec<SessionReport> {
        let now = self.start.elapsed();
        self.house.rooms().iter().map(|room| SessionReport::new(room, now)).collect()
    }

    /// Sessions that have ended and let go of their memory, since the start.
    #[must_use]
    pub fn ended(&self) -> u64 {
        self.house.counters.ended.load(Ordering::Relaxed)
    }

    /// Says goodbye to all clients ([`CloseCode::ShuttingDown`]) and ends the sessions. A solver
    /// finishes its piece of work on its own.
    pub fn stop(mut self) {
        self.stop_now();
    }

    fn stop_now(&mut self) {
        self.house.stopping.store(true, Ordering::Relaxed);
        self.house.wake();
        if let Some(thread) = self.thread.take()
            && thread.join().is_err()
        {
            error!("the server's thread ended with a panic");
        }
    }
}

impl Drop for Server {
    fn drop(&mut self) {
        self.stop_now();
    }
}

impl std::fmt::Debug for Server {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        f.debug_struct("Server").field("sessions", &self.sessions()).finish()
    }
}

/// Makes the solver of a session.
pub(crate) fn solver() -> SolverFactory {
    Box::new(|settings: SessionSettings| Box::new(Session::new(settings)))
}

/// The thread of new connections.
fn attend(house: &Arc<House>, mut door: Door, start: Instant) {
    let mut drivers: Vec<JoinHandle<()>> = Vec::new();
    while !house.is_stopping() {
        let now = start.elapsed();
        match catch_unwind(AssertUnwindSafe(|| door.tick(now))) {
            Ok((opened, next)) => {
                drivers.extend(opened.into_iter().filter_map(|opened| open(house, opened, start)));
                drivers.retain(|driver| !driver.is_finished());
                // Sessions that have ended hold their blobs no longer.
                house.blobs.trim();
                house.bell.wait(next.map(|next| next.saturating_sub(start.elapsed())));
            }
            // What it was looking at is gone with the panic; sessions have threads of their own.
            Err(panic) => error!("a greeting made the server fail: {}", panic_message(&*panic)),
        }
    }
    door.close();
    for room in house.rooms() {
        room.end(CloseCode::ShuttingDown, "the server is being stopped");
    }
    for driver in drivers {
        // A panic was logged where it happened.
        let _ = driver.join();
    }
    // Dropped last: goodbyes leave through the listener's socket.
    drop(door);
}

/// Starts the threads of a new session.
fn open(house: &Arc<House>, opened: Opened, start: Instant) -> Option<JoinHandle<()>> {
    let Opened { driver, worker } = opened;
    let room = driver.room().clone();
    let clock = move || start.elapsed();
    let at_the_end = house.clone();
    let solving = Builder::new()
        .name(format!("light {}", room.number))
        .spawn(move || {
            worker.run(clock);
            at_the_end.wake();
        })
        .map(|_| ());
    let at_the_end = house.clone();
    let driving = solving.and_then(|()| {
        Builder::new().name(format!("session {}", room.number)).spawn(move || {
            drive(driver, start);
            at_the_end.wake();
        })
    });
    match driving {
        Ok(thread) => Some(thread),
        Err(error) => {
            warn!("{room} can't begin, it gets no threads: {error}");
            house.remove(&room);
            room.set_task(|task| task.stop = true);
            while let Some(mut guest) = room.next_guest() {
                guest.link.close(CloseCode::Full, "the system gives no more threads");
            }
            None
        }
    }
}

/// The thread of a session's messages.
fn drive(mut driver: Driver, start: Instant) {
    loop {
        let now = start.elapsed();
        match catch_unwind(AssertUnwindSafe(|| driver.tick(now))) {
            Ok(Next::At(next)) => {
                let timeout = next.map(|next: Duration| next.saturating_sub(start.elapsed()));
                driver.room().bell.wait(timeout);
            }
            Ok(Next::Over) => break,
            Err(panic) => {
                driver.fail(panic_message(&*panic));
                break;
            }
        }
    }
    driver.linger();
}
