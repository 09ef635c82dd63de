//! The thread that all links of a process share.

use std::{
    future::Future,
    io,
    sync::{Arc, Mutex, PoisonError, Weak},
};

use tokio::runtime::{Builder, Handle, Runtime};

static SHARED: Mutex<Weak<Network>> = Mutex::new(Weak::new());

/// A runtime with one thread. It lives as long as somebody holds it or a task of
/// [`spawn`](Self::spawn) runs.
pub(crate) struct Network {
    runtime: Option<Runtime>,
    handle: Handle,
}

impl Network {
    /// The one of this process, started if need be.
    pub(crate) fn shared() -> io::Result<Arc<Self>> {
        let mut shared = SHARED.lock().unwrap_or_else(PoisonError::into_inner);
        if let Some(network) = shared.upgrade() {
            return Ok(network);
        }
        let runtime = Builder::new_multi_thread()
            .worker_threads(1)
            .max_blocking_threads(4)
            .thread_name("farlight network")
            .enable_all()
            .build()?;
        let handle = runtime.handle().clone();
        let network = Arc::new(Self { runtime: Some(runtime), handle });
        *shared = Arc::downgrade(&network);
        Ok(network)
    }

    pub(crate) fn handle(&self) -> &Handle {
        &self.handle
    }

    /// Starts a task that keeps the network alive.
    pub(crate) fn spawn(self: &Arc<Self>, task: impl Future<Output = ()> + Send + 'static) {
        let keep = Arc::clone(self);
        self.handle.spawn(async move {
            task.await;
            drop(keep);
        });
    }
}

impl Drop for Network {
    fn drop(&mut self) {
        // Not waiting: the last one to let go may be a task of this very runtime.
        if let Some(runtime) = self.runtime.take() {
            runtime.shutdown_background();
        }
    }
}
