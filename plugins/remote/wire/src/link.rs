//! What moves the bytes: the seam between sessions and a network.

use std::{fmt, sync::Arc, time::Duration};

use crate::{CloseCode, Limits};

/// How a message travels. Whole messages go in and come out.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash, PartialOrd, Ord)]
pub enum Channel {
    /// Arrives for sure and in order. Small and urgent.
    Control,
    /// Arrives for sure, in any order, after everything else: blobs in chunks.
    Bulk,
    /// Arrives in any order or not at all if it was cancelled: newer messages replace older ones.
    Latest,
}

impl Channel {
    /// All of them.
    pub const ALL: [Self; 3] = [Self::Control, Self::Bulk, Self::Latest];

    /// Its number on the wire.
    #[must_use]
    pub fn tag(self) -> u8 {
        match self {
            Self::Control => 1,
            Self::Bulk => 2,
            Self::Latest => 3,
        }
    }

    /// The channel with a number.
    #[must_use]
    pub fn from_tag(tag: u8) -> Option<Self> {
        Self::ALL.into_iter().find(|channel| channel.tag() == tag)
    }

    /// Bytes that a message on it may have.
    #[must_use]
    pub fn limit(self, limits: &Limits) -> usize {
        match self {
            Self::Control => limits.control_bytes,
            Self::Bulk => limits.bulk_bytes,
            Self::Latest => limits.latest_bytes,
        }
    }
}

/// Names a message within its session, growing.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Hash, PartialOrd, Ord)]
pub struct TransmitId(pub u64);

/// A message to send.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Transmit {
    /// Its name.
    pub id: TransmitId,
    /// How it travels.
    pub channel: Channel,
    /// Its bytes, at most [`Channel::limit`].
    pub message: Vec<u8>,
}

/// What a link has to tell.
#[derive(Clone, Debug, PartialEq, Eq)]
pub enum LinkEvent {
    /// The other side can be reached; comes once, before any message.
    Opened,
    /// A message arrived.
    Received(Channel, Vec<u8>),
    /// A message was taken over by the network: there is room for more. Comes once for every
    /// message that was sent and not cancelled.
    Sent(TransmitId),
    /// Over. Nothing comes after it.
    Closed(Closed),
}

/// Why a link is over.
#[derive(Clone, Debug, PartialEq, Eq)]
pub enum Closed {
    /// No connection, or it broke; trying again may help.
    Lost(Arc<str>),
    /// The other side said goodbye.
    Goodbye(CloseCode, Arc<str>),
    /// The server is not who it should be: its certificate is not of the pinned authority, or not
    /// valid now.
    Untrusted(Arc<str>),
    /// The other side broke the rules of the wire.
    Broken(Arc<str>),
}

impl fmt::Display for Closed {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::Lost(why) => write!(f, "the connection is lost: {why}"),
            Self::Goodbye(code, why) if why.is_empty() => write!(f, "{code}"),
            Self::Goodbye(code, why) => write!(f, "{code}: {why}"),
            Self::Untrusted(why) => write!(f, "the server can't be trusted: {why}"),
            Self::Broken(why) => write!(f, "the other side broke the protocol: {why}"),
        }
    }
}

/// Counters of a link.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct LinkStats {
    /// Bytes of messages sent, without what the network adds.
    pub sent_bytes: u64,
    /// Bytes of messages received.
    pub received_bytes: u64,
    /// Round trip time as the network estimates it, if it does.
    pub rtt: Option<Duration>,
}

/// A connection to the other side. No method waits for anything.
pub trait Link: Send {
    /// Takes a message over.
    fn send(&mut self, transmit: Transmit);

    /// Gives up a message on [`Channel::Latest`] if it has not left yet, or as much of it as has
    /// not. The other side gets it whole or not at all.
    fn cancel(&mut self, id: TransmitId);

    /// The next event.
    fn poll(&mut self) -> Option<LinkEvent>;

    /// Says goodbye (after what was sent on [`Channel::Control`], as far as possible) and ends.
    fn close(&mut self, code: CloseCode, reason: &str);

    /// Its counters.
    fn stats(&self) -> LinkStats;
}

/// Called by a link, from any thread, when [`Link::poll`] or [`Listener::accept`] has something.
pub type Wake = Arc<dyn Fn() + Send + Sync>;

/// Makes links to one server.
pub trait Connector: Send {
    /// Begins to connect. Failure is a [`LinkEvent::Closed`] of the link.
    fn connect(&mut self, limits: &Limits, wake: Wake) -> Box<dyn Link>;

    /// Whom it connects to, for people.
    fn peer(&self) -> String;
}

/// Takes links of clients.
pub trait Listener: Send {
    /// A new client's link, if there is one, and its address for the log.
    fn accept(&mut self) -> Option<(Box<dyn Link>, String)>;

    /// Calls `wake` from now on.
    fn set_wake(&mut self, wake: Wake);
}
