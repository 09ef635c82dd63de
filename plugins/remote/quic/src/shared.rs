//! What a link and its tasks have in common.

use std::{
    collections::VecDeque,
    sync::{
        Arc, Mutex, MutexGuard, OnceLock, PoisonError,
        atomic::{AtomicU64, Ordering::Relaxed},
    },
    time::Duration,
};

use farlight_wire::{Channel, Closed, LinkEvent, LinkStats, Wake};
use tokio::sync::{OwnedSemaphorePermit, Semaphore};
use wtransport::quinn;

/// Memory of messages that wait for the session, beside their bytes.
pub(crate) const MESSAGE_OVERHEAD: usize = 64;

/// A wake that can be set later.
#[derive(Clone)]
pub(crate) struct WakeSlot(Arc<Mutex<Wake>>);

impl WakeSlot {
    pub(crate) fn new(wake: Wake) -> Self {
        Self(Arc::new(Mutex::new(wake)))
    }

    pub(crate) fn set(&self, wake: Wake) {
        *self.0.lock().unwrap_or_else(PoisonError::into_inner) = wake;
    }

    pub(crate) fn call(&self) {
        let wake = Arc::clone(&self.0.lock().unwrap_or_else(PoisonError::into_inner));
        wake();
    }
}

/// Memory that the other side may take: unfinished messages, and those that the session has not
/// fetched yet. Who gets none waits, and so does the other side.
#[derive(Clone)]
pub(crate) struct Budget(Arc<Semaphore>);

impl Budget {
    pub(crate) fn new(bytes: usize) -> Self {
        Self(Arc::new(Semaphore::new(bytes.min(Semaphore::MAX_PERMITS))))
    }

    /// Waits for room for so many bytes (at most `u32::MAX`).
    pub(crate) async fn take(&self, bytes: usize) -> OwnedSemaphorePermit {
        let bytes = u32::try_from(bytes).unwrap_or(u32::MAX);
        let permit = Arc::clone(&self.0).acquire_many_owned(bytes).await;
        permit.unwrap_or_else(|_| unreachable!("the semaphore is never closed"))
    }
}

/// Events on their way to the session, and counters.
pub(crate) struct Shared {
    events: Mutex<Events>,
    wake: WakeSlot,
    sent: AtomicU64,
    received: AtomicU64,
    connection: OnceLock<quinn::Connection>,
}

#[derive(Default)]
struct Events {
    queue: VecDeque<(LinkEvent, Option<OwnedSemaphorePermit>)>,
    closed: bool,
}

impl Shared {
    pub(crate) fn new(wake: WakeSlot) -> Arc<Self> {
        Arc::new(Self {
            events: Mutex::default(),
            wake,
            sent: AtomicU64::new(0),
            received: AtomicU64::new(0),
            connection: OnceLock::new(),
        })
    }

    fn events(&self) -> MutexGuard<'_, Events> {
        self.events.lock().unwrap_or_else(PoisonError::into_inner)
    }

    fn push(&self, event: LinkEvent, permit: Option<OwnedSemaphorePermit>) {
        {
            let mut events = self.events();
            if events.closed {
                return;
            }
            events.closed = matches!(event, LinkEvent::Closed(_));
            events.queue.push_back((event, permit));
        }
        self.wake.call();
    }

    pub(crate) fn opened(&self, connection: quinn::Connection) {
        let _ = self.connection.set(connection);
        self.push(LinkEvent::Opened, None);
    }

    /// A message arrived; `permit` is held until the session has fetched it.
    pub(crate) fn received(
        &self,
        channel: Channel,
        message: Vec<u8>,
        permit: OwnedSemaphorePermit,
    ) {
        self.received.fetch_add(message.len() as u64, Relaxed);
        self.push(LinkEvent::Received(channel, message), Some(permit));
    }

    pub(crate) fn sent(&self, id: farlight_wire::TransmitId, bytes: usize) {
        self.sent.fetch_add(bytes as u64, Relaxed);
        self.push(LinkEvent::Sent(id), None);
    }

    pub(crate) fn closed(&self, why: Closed) {
        self.push(LinkEvent::Closed(why), None);
    }

    pub(crate) fn poll(&self) -> Option<LinkEvent> {
        // The permit is given back here.
        self.events().queue.pop_front().map(|(event, _)| event)
    }

    pub(crate) fn stats(&self) -> LinkStats {
        let rtt = self.connection.get().map(quinn::Connection::rtt);
        LinkStats {
            sent_bytes: self.sent.load(Relaxed),
            received_bytes: self.received.load(Relaxed),
            rtt: rtt.filter(|rtt| *rtt > Duration::ZERO),
        }
    }
}
