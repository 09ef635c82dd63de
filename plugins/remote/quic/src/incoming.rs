//! Messages from the other side. Sizes are checked before and while reading; memory grows only as bytes
//! arrive, and all of it is counted.

use std::{sync::Arc, time::Duration};

use farlight_wire::{Channel, CloseCode, Limits};
use tokio::{sync::OwnedSemaphorePermit, task::JoinSet, time::timeout};
use tracing::debug;
use wtransport::{Connection, RecvStream, quinn};

use crate::{
    end::End,
    shared::{Budget, MESSAGE_OVERHEAD, Shared},
};

/// Messages of the other side on the way at once, beside those of the control channel.
pub(crate) const STREAMS: u32 = 64;

/// Memory grows in such steps.
const STEP: usize = 16 << 10;

/// Memory of unfinished and unfetched messages, beside those of the control channel, if limits don't
/// ask for more.
const BUDGET: usize = 8 << 20;

/// How long the other side may keep all that memory with messages that it doesn't finish.
const STUCK: Duration = Duration::from_secs(30);

/// How long the end of the control stream may precede the end of the connection.
const GOODBYE: Duration = Duration::from_secs(2);

/// Takes messages of streams until the connection ends or the other side breaks the rules.
pub(crate) async fn streams(
    connection: Connection,
    shared: Arc<Shared>,
    limits: Limits,
) -> Result<(), End> {
    let budget = Budget::new(BUDGET.max(4 * limits.bulk_bytes.max(limits.latest_bytes)));
    let mut readers = JoinSet::new();
    loop {
        tokio::select! {
            Some(result) = readers.join_next() => {
                result.unwrap_or_else(|error| Err(End::Lost(error.to_string())))?;
            }
            stream = connection.accept_uni(), if readers.len() < STREAMS as usize => {
                let Ok(stream) = stream else { return Ok(()) };
                readers.spawn(message(stream, Arc::clone(&shared), limits, budget.clone()));
            }
            // The one bidirectional stream is there already.
            stream = connection.accept_bi() => {
                let Ok(_) = stream else { return Ok(()) };
                let why = "there is a second control stream".to_owned();
                return Err(End::Broken(CloseCode::Protocol, why));
            }
        }
    }
}

/// One message on a stream of its own: a byte that names the channel, then the message.
async fn message(
    mut stream: RecvStream,
    shared: Arc<Shared>,
    limits: Limits,
    budget: Budget,
) -> Result<(), End> {
    let mut tag = [0];
    // A stream that is reset, or of a connection that is gone, carries no message.
    let Ok(()) = stream.read_exact(&mut tag).await else { return Ok(()) };
    let channel = Channel::from_tag(tag[0]).filter(|channel| *channel != Channel::Control);
    let Some(channel) = channel else {
        let why = format!("a stream has the unknown channel {}", tag[0]);
        return Err(End::Broken(CloseCode::Protocol, why));
    };
    let limit = channel.limit(&limits);
    let mut message = Vec::new();
    let mut room = Room::new(&budget).await?;
    loop {
        match stream.quic_stream_mut().read_chunk(STEP, true).await {
            Ok(Some(chunk)) => {
                let length = message.len() + chunk.bytes.len();
                if length > limit {
                    return Err(too_large(channel, length, limit));
                }
                room.grow(length).await?;
                message.extend_from_slice(&chunk.bytes);
            }
            Ok(None) => break,
            Err(quinn::ReadError::Reset(_)) => {
                debug!(
                    ?channel,
                    bytes = message.len(),
                    "a message was cancelled by the other side"
                );
                return Ok(());
            }
            Err(_) => return Ok(()),
        }
    }
    shared.received(channel, message, room.permit);
    Ok(())
}

/// Messages of the control stream: a length of four bytes, little-endian, then the message.
pub(crate) async fn control(
    mut stream: RecvStream,
    connection: Connection,
    shared: Arc<Shared>,
    limits: Limits,
) -> Result<(), End> {
    let limit = limits.control_bytes;
    let budget = Budget::new(4 * (limit + STEP));
    let stream = stream.quic_stream_mut();
    loop {
        let mut header = [0; 4];
        match stream.read_exact(&mut header).await {
            Ok(()) => {}
            Err(quinn::ReadExactError::FinishedEarly(0)) => {
                // A goodbye follows.
                if timeout(GOODBYE, connection.closed()).await.is_ok() {
                    return Ok(());
                }
                return Err(End::Lost("the other side ended the control stream".into()));
            }
            Err(error) => return exact_end(error),
        }
        let length = u32::from_le_bytes(header) as usize;
        if length > limit {
            return Err(too_large(Channel::Control, length, limit));
        }
        let permit = budget.take(length + MESSAGE_OVERHEAD).await;
        let mut message = Vec::new();
        while message.len() < length {
            match stream.read_chunk((length - message.len()).min(STEP), true).await {
                Ok(Some(chunk)) => message.extend_from_slice(&chunk.bytes),
                Ok(None) => {
                    return exact_end(quinn::ReadExactError::FinishedEarly(message.len()));
                }
                Err(error) => return exact_end(quinn::ReadExactError::ReadError(error)),
            }
        }
        shared.received(Channel::Control, message, permit);
    }
}

fn exact_end(error: quinn::ReadExactError) -> Result<(), End> {
    match error {
        // How it ended is known to the connection.
        quinn::ReadExactError::ReadError(quinn::ReadError::ConnectionLost(_)) => Ok(()),
        quinn::ReadExactError::ReadError(error) => {
            let why = format!("the control stream broke: {error}");
            Err(End::Broken(CloseCode::Protocol, why))
        }
        quinn::ReadExactError::FinishedEarly(_) => {
            let why = "the control stream ends within a message".to_owned();
            Err(End::Broken(CloseCode::Protocol, why))
        }
    }
}

fn too_large(channel: Channel, length: usize, limit: usize) -> End {
    let more = if channel == Channel::Control { "" } else { " or more" };
    let why = format!("a message on {channel:?} has {length} bytes{more}; {limit} are allowed");
    End::Broken(CloseCode::Limit, why)
}

/// Memory of one message.
struct Room<'a> {
    budget: &'a Budget,
    permit: OwnedSemaphorePermit,
    bytes: usize,
}

impl<'a> Room<'a> {
    async fn new(budget: &'a Budget) -> Result<Self, End> {
        let permit = patiently(budget, MESSAGE_OVERHEAD).await?;
        Ok(Self { budget, permit, bytes: 0 })
    }

    /// Makes sure that there is room for a message of `length` bytes.
    async fn grow(&mut self, length: usize) -> Result<(), End> {
        if length > self.bytes {
            let more = (length - self.bytes).next_multiple_of(STEP);
            self.permit.merge(patiently(self.budget, more).await?);
            self.bytes += more;
        }
        Ok(())
    }
}

async fn patiently(budget: &Budget, bytes: usize) -> Result<OwnedSemaphorePermit, End> {
    timeout(STUCK, budget.take(bytes)).await.map_err(|_| {
        // Who is to blame, the other side or the session here, is not known.
        End::Lost("unfinished or unread messages have filled the memory for them too long".into())
    })
}
