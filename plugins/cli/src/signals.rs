//! Being told to stop.

use std::{io, time::Duration};

use tokio::runtime::{Builder, Runtime};

use crate::error::CliError;

/// Listens for Ctrl-C and what else asks a process to end.
pub(crate) struct Signals {
    runtime: Runtime,
    source: Source,
}

impl Signals {
    /// From now on signals don't end the process by themselves.
    pub(crate) fn new() -> Result<Self, CliError> {
        let listen = || {
            let runtime = Builder::new_current_thread().enable_all().build()?;
            let source = {
                let _guard = runtime.enter();
                Source::new()?
            };
            Ok(Self { runtime, source })
        };
        listen()
            .map_err(|e: io::Error| CliError::new(format!("signals can't be listened for: {e}")))
    }

    /// Waits for one and returns its name, or nothing once `running`, which is asked every second,
    /// says no. From then on another one ends the process at once.
    pub(crate) fn wait(mut self, mut running: impl FnMut() -> bool) -> Option<&'static str> {
        let look = Duration::from_secs(1);
        loop {
            let source = &mut self.source;
            let next = async { tokio::time::timeout(look, source.next()).await };
            match self.runtime.block_on(next) {
                Ok(name) => {
                    self.end_at_the_second();
                    return Some(name);
                }
                Err(_) if running() => {}
                Err(_) => return None,
            }
        }
    }

    fn end_at_the_second(mut self) {
        let wait = move || {
            self.runtime.block_on(self.source.next());
            std::process::exit(130);
        };
        // Without the thread the second one is merely not heard.
        let _ = std::thread::Builder::new().name("signals".into()).spawn(wait);
    }
}

/// What asks a process to end.
#[cfg(unix)]
struct Source([(&'static str, tokio::signal::unix::Signal); 3]);

#[cfg(unix)]
impl Source {
    fn new() -> io::Result<Self> {
        use tokio::signal::unix::{SignalKind, signal};
        Ok(Self([
            ("Ctrl-C", signal(SignalKind::interrupt())?),
            ("SIGTERM", signal(SignalKind::terminate())?),
            ("SIGHUP", signal(SignalKind::hangup())?),
        ]))
    }

    async fn next(&mut self) -> &'static str {
        use std::{future::poll_fn, task::Poll};
        poll_fn(|context| {
            for (name, signal) in &mut self.0 {
                if signal.poll_recv(context).is_ready() {
                    return Poll::Ready(*name);
                }
            }
            Poll::Pending
        })
        .await
    }
}

/// What asks a process to end.
#[cfg(not(unix))]
struct Source;

#[cfg(not(unix))]
impl Source {
    fn new() -> io::Result<Self> {
        Ok(Self)
    }

    async fn next(&mut self) -> &'static str {
        match tokio::signal::ctrl_c().await {
            Ok(()) => "Ctrl-C",
            Err(_) => std::future::pending().await,
        }
    }
}
