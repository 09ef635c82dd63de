//! A simulated network in real time, and a lighting server at its end.

use std::{
    sync::{
        Arc,
        atomic::{AtomicBool, Ordering},
    },
    thread::JoinHandle,
    time::{Duration, Instant},
};

use farlight_server::{Server, ServerSettings};
use farlight_wire::{Limits, Token, simulated::Network};

/// What lets a game in.
pub(crate) const TOKEN: Token = Token([7; 16]);

/// Lets the time of a network pass as it does outside.
pub(crate) struct Clock {
    network: Network,
    stop: Arc<AtomicBool>,
    thread: Option<JoinHandle<()>>,
}

impl Clock {
    pub(crate) fn new(network: &Network) -> Self {
        let (stop, network) = (Arc::new(AtomicBool::new(false)), network.clone());
        let (stopped, ticking) = (stop.clone(), network.clone());
        let thread = std::thread::spawn(move || {
            let start = Instant::now();
            while !stopped.load(Ordering::Relaxed) {
                ticking.advance(start.elapsed());
                std::thread::sleep(Duration::from_millis(1));
            }
        });
        Self { network, stop, thread: Some(thread) }
    }

    /// A server at the other end.
    pub(crate) fn serve(&self) -> Server {
        let listener = Box::new(self.network.listener(&Limits::default()));
        Server::start(ServerSettings::default(), listener, TOKEN).unwrap()
    }
}

impl Drop for Clock {
    fn drop(&mut self) {
        self.stop.store(true, Ordering::Relaxed);
        if let Some(thread) = self.thread.take() {
            let _ = thread.join();
        }
    }
}
