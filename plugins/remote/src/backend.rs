//! The backend that the plugin talks to, and its thread.

use std::sync::Arc;
#[cfg(not(target_arch = "wasm32"))]
use std::time::Duration;

use farlight_gi::{
    BackendState, GiUpdate, LightingBackend, LinkStatus,
    solver::session::{SessionChange, SessionSettings, SnapshotId},
};
use farlight_wire::{Connector, Token, View};

use crate::{Driver, RemoteSettings, shared::Shared};

/// How long the end of a backend waits for its goodbye to leave.
#[cfg(not(target_arch = "wasm32"))]
const GOODBYE: Duration = Duration::from_millis(300);

/// Light solved on another machine. A thread of its own speaks with the server, decodes, and
/// connects again when the connection is lost; no method waits for it.
///
/// Dropping it says goodbye: the server forgets the scene.
#[derive(Debug)]
pub struct RemoteBackend {
    shared: Arc<Shared>,
    #[cfg(not(target_arch = "wasm32"))]
    threaded: bool,
}

impl RemoteBackend {
    /// A backend whose driver is called by the caller, in whatever time: for tests, and for hosts
    /// without threads.
    #[must_use]
    pub fn stepped(
        connector: Box<dyn Connector>,
        token: Token,
        settings: &RemoteSettings,
        session: SessionSettings,
    ) -> (Self, Driver) {
        let shared = Arc::new(Shared::default());
        let driver = Driver::new(shared.clone(), connector, token, settings, session);
        let backend = Self {
            shared,
            #[cfg(not(target_arch = "wasm32"))]
            threaded: false,
        };
        (backend, driver)
    }

    /// A backend that reaches its server over `connector`, which lets the client in with `token`.
    #[cfg(not(target_arch = "wasm32"))]
    #[must_use]
    pub fn new(
        connector: Box<dyn Connector>,
        token: Token,
        settings: &RemoteSettings,
        session: SessionSettings,
    ) -> Self {
        let mut connector = Some(connector);
        Self::start(settings.clone(), session, move || match connector.take() {
            Some(connector) => Ok((connector, token)),
            None => Err(crate::invite::Wait::Never("there is no connector".into())),
        })
    }

    /// What [`GiPlugin::with_backend`](farlight_gi::GiPlugin::with_backend) takes: backends that reach
    /// the server of an invitation over QUIC. What is wrong with the settings becomes the backend's
    /// state.
    #[cfg(not(target_arch = "wasm32"))]
    pub fn factory(
        settings: RemoteSettings,
    ) -> impl Fn(&farlight_gi::GiSettings) -> Box<dyn LightingBackend> + Send + Sync + 'static {
        move |gi| {
            let named = settings.clone();
            let find = move || {
                crate::invite::find(&named, |invitation| {
                    Box::new(farlight_quic::QuicConnector::new(invitation))
                })
            };
            Box::new(Self::start(settings.clone(), gi.session(), find))
        }
    }

    /// Tells the server where the game looks from. Lightmaps and probes don't need it.
    pub fn set_view(&mut self, view: View) {
        self.shared.tell(|orders| orders.view = Some(view));
    }
}

impl LightingBackend for RemoteBackend {
    fn submit(&mut self, snapshot: SnapshotId, changes: Vec<SessionChange>) {
        self.shared.tell(|orders| orders.submitted.push((snapshot, changes)));
    }

    fn poll(&mut self) -> Option<GiUpdate> {
        self.shared.lock().updates.pop()
    }

    fn state(&self) -> BackendState {
        let mail = self.shared.lock();
        match &mail.state {
            // What has not been polled is better than what is shown.
            BackendState::Converged if !mail.updates.is_empty() => BackendState::Solving,
            state => state.clone(),
        }
    }

    fn resync(&mut self) {
        self.shared.tell(|orders| orders.resync = true);
    }

    fn link(&self) -> Option<LinkStatus> {
        Some(self.shared.lock().link.clone())
    }
}

impl Drop for RemoteBackend {
    fn drop(&mut self) {
        self.shared.tell(|orders| orders.stop = true);
        #[cfg(not(target_arch = "wasm32"))]
        if self.threaded {
            self.shared.wait_for_end(GOODBYE);
        }
    }
}

#[cfg(not(target_arch = "wasm32"))]
mod thread {
    use std::{
        panic::{AssertUnwindSafe, catch_unwind},
        sync::Arc,
        time::{Duration, Instant},
    };

    use bevy::log::error;
    use farlight_gi::{
        BackendState,
        solver::session::{SessionSettings, panic_message},
    };
    use farlight_wire::{Connector, Token};

    use super::RemoteBackend;
    use crate::{Driver, RemoteSettings, invite::Wait, shared::Shared};

    /// How often it is looked whether an invitation is there.
    const LOOK_AGAIN: Duration = Duration::from_millis(200);

    impl RemoteBackend {
        /// Starts the thread; `find` says how the server is reached, and is asked again while it
        /// answers that this isn't known yet.
        pub(crate) fn start(
            settings: RemoteSettings,
            session: SessionSettings,
            find: impl FnMut() -> Result<(Box<dyn Connector>, Token), Wait> + Send + 'static,
        ) -> Self {
            let shared = Arc::new(Shared::default());
            let for_thread = shared.clone();
            let thread = std::thread::Builder::new()
                .name("farlight remote".into())
                .spawn(move || work(&for_thread, &settings, session, find));
            if let Err(problem) = &thread {
                shared.fail(format!("the thread of remote lighting can't be started: {problem}"));
            }
            Self { shared, threaded: thread.is_ok() }
        }
    }

    /// The thread: its panics end it, not the game.
    fn work(
        shared: &Arc<Shared>,
        settings: &RemoteSettings,
        session: SessionSettings,
        find: impl FnMut() -> Result<(Box<dyn Connector>, Token), Wait>,
    ) {
        let run = AssertUnwindSafe(|| run(shared, settings, session, find));
        if let Err(panic) = catch_unwind(run) {
            error!("the thread of remote lighting failed: {}", panic_message(&*panic));
            shared.fail(format!("remote lighting failed: {}", panic_message(&*panic)));
        }
        shared.end();
    }

    fn run(
        shared: &Arc<Shared>,
        settings: &RemoteSettings,
        session: SessionSettings,
        mut find: impl FnMut() -> Result<(Box<dyn Connector>, Token), Wait>,
    ) {
        let (connector, token) = loop {
            match find() {
                Ok(found) => break found,
                Err(Wait::Later(reason)) => {
                    shared.lock().state = BackendState::Disconnected { reason };
                }
                Err(Wait::Never(reason)) => {
                    shared.lock().state = BackendState::Failed(reason);
                    return;
                }
            }
            shared.wait(Some(LOOK_AGAIN));
            if shared.lock().to_driver.stop {
                return;
            }
        };
        let start = Instant::now();
        let mut driver = Driver::new(shared.clone(), connector, token, settings, session);
        while !driver.is_over() {
            let next = driver.tick(start.elapsed());
            if !driver.is_over() {
                shared.wait(next.map(|next| next.saturating_sub(start.elapsed())));
            }
        }
    }
}
