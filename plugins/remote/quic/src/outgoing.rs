//! Messages to the other side.
//!
//! QUIC would take megabytes into its send buffer, and what is in there waits in line. So a message is
//! handed over only when the line is nearly free: [`LinkEvent::Sent`](farlight_wire::LinkEvent::Sent)
//! then means that it is about to leave, and a session that waits for it always sends what is newest.

use std::{
    collections::{HashMap, VecDeque},
    sync::Arc,
};

use farlight_wire::{Channel, Transmit, TransmitId};
use tokio::{
    sync::{mpsc, oneshot},
    task::JoinSet,
};
use wtransport::{Connection, SendStream, VarInt, quinn};

use crate::shared::Shared;

/// Priorities of streams. Within a channel older messages go first, so each has a lower one than the
/// message before it. The first bytes of a stream, which WebTransport writes, have 0.
const CONTROL: i32 = i32::MAX;
const LATEST: i32 = i32::MAX - 1;
const BULK: i32 = -1;
/// After so many messages priorities begin anew.
const PRIORITIES: i32 = 1 << 30;

/// Messages of a channel on the way at once.
const MESSAGES: usize = 16;

/// Bytes of a channel on the way: twice the congestion window, so that it can grow, within these.
const LEAST: usize = 64 << 10;
const MOST: usize = 2 << 20;

/// All messages that wait or are on the way, beside those of the control channel.
pub(crate) struct Outgoing {
    connection: Connection,
    shared: Arc<Shared>,
    latest: Lane,
    bulk: Lane,
    writers: JoinSet<TransmitId>,
    under_way: HashMap<TransmitId, UnderWay>,
}

#[derive(Default)]
struct Lane {
    waiting: VecDeque<Transmit>,
    messages: usize,
    bytes: usize,
    /// Messages so far, modulo [`PRIORITIES`].
    count: i32,
}

struct UnderWay {
    channel: Channel,
    bytes: usize,
    cancel: oneshot::Sender<()>,
}

impl Outgoing {
    pub(crate) fn new(connection: Connection, shared: Arc<Shared>) -> Self {
        Self {
            connection,
            shared,
            latest: Lane::default(),
            bulk: Lane::default(),
            writers: JoinSet::new(),
            under_way: HashMap::new(),
        }
    }

    pub(crate) fn send(&mut self, transmit: Transmit) {
        self.lane(transmit.channel).waiting.push_back(transmit);
        self.advance();
    }

    pub(crate) fn cancel(&mut self, id: TransmitId) {
        self.latest.waiting.retain(|transmit| transmit.id != id);
        if self.under_way.get(&id).is_some_and(|message| message.channel == Channel::Latest)
            && let Some(message) = self.under_way.remove(&id)
        {
            // Its writer answers as if it were done; the place is free from then on.
            let _ = message.cancel.send(());
            let lane = self.lane(message.channel);
            lane.messages -= 1;
            lane.bytes -= message.bytes;
            self.advance();
        }
    }

    /// Waits until a message has arrived at the other side, and lets the next ones go.
    pub(crate) async fn arrived(&mut self) {
        match self.writers.join_next().await {
            Some(Ok(id)) => {
                if let Some(message) = self.under_way.remove(&id) {
                    let lane = self.lane(message.channel);
                    lane.messages -= 1;
                    lane.bytes -= message.bytes;
                }
                self.advance();
            }
            Some(Err(_)) => {}
            None => std::future::pending().await,
        }
    }

    fn lane(&mut self, channel: Channel) -> &mut Lane {
        if channel == Channel::Latest { &mut self.latest } else { &mut self.bulk }
    }

    fn advance(&mut self) {
        for channel in [Channel::Latest, Channel::Bulk] {
            if self.lane(channel).waiting.is_empty() {
                continue;
            }
            let window = self.connection.quic_connection().stats().path.cwnd as usize;
            let most = window.saturating_mul(2).clamp(LEAST, MOST);
            while let Some(transmit) = self.lane(channel).next(most) {
                self.start(transmit);
            }
        }
    }

    fn start(&mut self, transmit: Transmit) {
        let (id, channel, bytes) = (transmit.id, transmit.channel, transmit.message.len());
        let highest = if channel == Channel::Latest { LATEST } else { BULK };
        let priority = highest - self.lane(channel).count;
        let (cancel, cancelled) = oneshot::channel();
        let (connection, shared) = (self.connection.clone(), Arc::clone(&self.shared));
        self.writers.spawn(async move {
            write(&connection, transmit, priority, cancelled, &shared).await;
            id
        });
        self.under_way.insert(id, UnderWay { channel, bytes, cancel });
    }
}

impl Lane {
    /// The next message, if it may go now. A single one always may, whatever its size.
    fn next(&mut self, most: usize) -> Option<Transmit> {
        let bytes = self.bytes + self.waiting.front()?.message.len();
        if self.messages > 0 && (bytes > most || self.messages >= MESSAGES) {
            return None;
        }
        self.messages += 1;
        self.bytes = bytes;
        self.count = (self.count + 1) % PRIORITIES;
        self.waiting.pop_front()
    }
}

/// Writes a message to a stream of its own and waits until all of it has arrived.
async fn write(
    connection: &Connection,
    transmit: Transmit,
    priority: i32,
    mut cancelled: oneshot::Receiver<()>,
    shared: &Shared,
) {
    let Transmit { id, channel, message } = transmit;
    let open = async { connection.open_uni().await.ok()?.await.ok() };
    let stream = tokio::select! {
        biased;
        _ = &mut cancelled => return,
        stream = open => stream,
    };
    // Errors are errors of the connection, which its owner sees.
    let Some(stream) = stream else { return };
    let mut stream = Whole { stream, finished: false };
    stream.stream.set_priority(priority);
    let give = async {
        stream.stream.write_all(&[channel.tag()]).await.ok()?;
        stream.stream.write_all(&message).await.ok()?;
        stream.stream.quic_stream_mut().finish().ok()
    };
    let given = tokio::select! {
        biased;
        _ = &mut cancelled => return,
        given = give => given,
    };
    // Also if the other side wants nothing more of it: then there is room for others.
    shared.sent(id, message.len());
    // The bytes are with QUIC now.
    drop(message);
    if given.is_none() {
        return;
    }
    tokio::select! {
        biased;
        _ = cancelled => {}
        _ = stream.stream.quic_stream().stopped() => stream.finished = true,
    }
}

/// A stream that is reset unless it is finished: dropping a stream of QUIC would finish it, and the other
/// side would take half a message for a whole one.
struct Whole {
    stream: SendStream,
    finished: bool,
}

impl Drop for Whole {
    fn drop(&mut self) {
        if !self.finished {
            let _ = self.stream.reset(VarInt::from_u32(0));
        }
    }
}

/// Writes the messages of the control channel. Ends, when all are written and have arrived, after the
/// sender is dropped.
pub(crate) async fn control(
    mut stream: SendStream,
    mut messages: mpsc::UnboundedReceiver<Transmit>,
    shared: Arc<Shared>,
) {
    stream.set_priority(CONTROL);
    while let Some(Transmit { id, message, .. }) = messages.recv().await {
        let Ok(length) = u32::try_from(message.len()) else { continue };
        // One write, so that small messages leave in one packet.
        let mut frame = Vec::with_capacity(4 + message.len());
        frame.extend_from_slice(&length.to_le_bytes());
        frame.extend_from_slice(&message);
        if stream.write_all(&frame).await.is_err() {
            return;
        }
        shared.sent(id, message.len());
    }
    let quic: &mut quinn::SendStream = stream.quic_stream_mut();
    if quic.finish().is_ok() {
        let _ = quic.stopped().await;
    }
}
