//! A server, clients and a network in virtual time.

use std::{sync::Arc, time::Duration};

use farlight_gi_solver::session::SessionChange;
use farlight_server::{ServerSettings, SolverFactory, SteppedServer};
use farlight_wire::{Connector, Limits, Link, Token, simulated::Network};

use crate::client::Client;

pub(crate) const TOKEN: Token = Token([7; 16]);

/// The longest step of virtual time.
const STRIDE: Duration = Duration::from_millis(100);

pub(crate) fn secs(seconds: u64) -> Duration {
    Duration::from_secs(seconds)
}

pub(crate) struct World {
    pub(crate) network: Network,
    server: Option<SteppedServer>,
    pub(crate) clients: Vec<Client>,
    settings: ServerSettings,
    now: Duration,
}

impl World {
    pub(crate) fn new(settings: ServerSettings) -> Self {
        let mut world = Self::empty(settings.clone());
        world.start_server(settings);
        world
    }

    /// With something else that solves.
    pub(crate) fn with_solver(settings: ServerSettings, solver: SolverFactory) -> Self {
        let mut world = Self::empty(settings.clone());
        let listener = Box::new(world.network.listener(&settings.limits()));
        world.server = Some(SteppedServer::new_with(settings, listener, TOKEN, solver).unwrap());
        world
    }

    fn empty(settings: ServerSettings) -> Self {
        let (network, clients) = (Network::new(1), Vec::new());
        Self { network, server: None, clients, settings, now: Duration::ZERO }
    }

    pub(crate) fn start_server(&mut self, settings: ServerSettings) {
        let listener = Box::new(self.network.listener(&settings.limits()));
        self.server = Some(SteppedServer::new(settings, listener, TOKEN).unwrap());
    }

    pub(crate) fn stop_server(&mut self) {
        self.server.take().unwrap().stop();
    }

    pub(crate) fn server(&self) -> &SteppedServer {
        self.server.as_ref().unwrap()
    }

    pub(crate) fn limits(&self) -> Limits {
        self.settings.limits()
    }

    /// A link to the server without a client.
    pub(crate) fn link(&self) -> Box<dyn Link> {
        self.network.connector().connect(&Limits::default(), Arc::new(|| {}))
    }

    pub(crate) fn connect(&mut self, name: &str) -> usize {
        self.add(Client::new(name, TOKEN))
    }

    pub(crate) fn add(&mut self, mut client: Client) -> usize {
        client.use_link(self.link());
        self.clients.push(client);
        self.clients.len() - 1
    }

    pub(crate) fn reconnect(&mut self, client: usize) {
        let link = self.link();
        self.clients[client].use_link(link);
    }

    pub(crate) fn submit(&mut self, client: usize, changes: Vec<SessionChange>) {
        self.clients[client].submit(self.now, changes);
    }

    /// Everything that is to be done now, then on to what comes next, at most to `until`.
    fn step(&mut self, until: Duration) {
        let now = self.now;
        let server = self.server.as_mut().and_then(|server| server.tick(now));
        let clients: Vec<_> = self.clients.iter_mut().map(|c| c.tick(now)).collect();
        let next = [server, self.network.next_event()].into_iter().chain(clients);
        // Not far: whoever waits for something looks between steps.
        let next = next.flatten().min().unwrap_or(until).min(until).min(now + STRIDE);
        // Solving takes no virtual time of its own; the millisecond is what a piece of it counts.
        self.now = next.max(now + Duration::from_millis(1));
        self.network.advance(self.now);
    }

    pub(crate) fn run(&mut self, time: Duration) {
        let until = self.now + time;
        while self.now < until {
            self.step(until);
        }
    }

    /// Runs until something is so; virtual minutes are the guard against waiting for ever.
    #[track_caller]
    pub(crate) fn run_until(&mut self, so: impl Fn(&Self) -> bool) {
        let until = self.now + secs(120);
        while !so(self) {
            assert!(self.now < until, "it does not happen");
            self.step(until);
        }
    }
}
