//! What the two sides say to each other.
//!
//! A message is a kind (`u16`) and its fields, little-endian. A reader skips kinds that it does not
//! know, and ignores what follows the fields that it does, so that newer versions can add both.
//! Greetings begin with a mark and the version instead: [`MAJOR`] changes when old readers would
//! misunderstand, [`MINOR`] when something was added.

mod change;
#[cfg(test)]
mod fuzz;
mod greeting;
mod scene;
mod service;

pub(crate) use change::{Object, ObjectKey, SkyObject, total_probes};
pub(crate) use scene::{is_readable, write_change};
pub(crate) use service::{Service, agree};

use farlight_gi_solver::session::SnapshotId;

use crate::{
    BlobHash, Channel, View, WireError,
    codec::{Reader, Writer},
};

/// Versions of the wire; see the [module](self).
pub(crate) const MAJOR: u16 = 1;
/// See [`MAJOR`].
pub(crate) const MINOR: u16 = 0;

/// Hashes that one message may ask for.
pub(crate) const MAX_WANTED: usize = 1024;
/// Sequence numbers that one message may acknowledge.
pub(crate) const MAX_ACKS: usize = 256;
/// Poses that a view may predict.
const MAX_PREDICTED: usize = 64;

/// From the client, after its greeting.
#[derive(Clone, Debug, PartialEq)]
pub(crate) enum ClientMessage {
    /// A part of a snapshot: what changed since the last one.
    Snapshot(SnapshotPart),
    /// A piece of a blob that the server asked for.
    Chunk(Chunk),
    /// The client no longer has a blob that the server asked for.
    Gone(BlobHash),
    /// Light that arrived.
    Acks(Vec<u64>),
    /// The client wants all light again.
    Resync,
    /// Where it looks from.
    View(View),
    /// Answer it.
    Ping(u64),
    /// The answer.
    Pong(u64),
}

/// From the server, after its welcome. Light travels as a
/// [`LightingMessage`](crate::LightingMessage) on [`Channel::Latest`].
#[derive(Clone, Debug, PartialEq)]
pub(crate) enum ServerMessage {
    /// The newest snapshot that is complete, blobs aside.
    Acknowledged(SnapshotId),
    /// Blobs that it doesn't have, each from a byte offset on (what it has of it is kept).
    Wanted(Vec<(BlobHash, u32)>),
    /// Something that people should know.
    Notice(String),
    /// Answer it.
    Ping(u64),
    /// The answer.
    Pong(u64),
}

/// A part of a snapshot; parts come in order.
#[derive(Clone, Debug, PartialEq)]
pub(crate) struct SnapshotPart {
    /// Which snapshot.
    pub snapshot: SnapshotId,
    /// Whether it is the last part: the snapshot counts from now on.
    pub last: bool,
    /// Objects and their newest state; `None`: removed.
    pub changes: Vec<(ObjectKey, Option<Object>)>,
}

/// A piece of a blob's encoding.
#[derive(Clone, Debug, PartialEq)]
pub(crate) struct Chunk {
    /// The blob.
    pub hash: BlobHash,
    /// Bytes of the whole encoding.
    pub total: u32,
    /// Where the piece belongs.
    pub offset: u32,
    /// The piece.
    pub data: Vec<u8>,
}

/// Numbers of the kinds. 1 and 2 are the greetings.
mod kind {
    pub(super) const SNAPSHOT: u16 = 10;
    pub(super) const CHUNK: u16 = 11;
    pub(super) const GONE: u16 = 12;
    pub(super) const ACKS: u16 = 13;
    pub(super) const RESYNC: u16 = 14;
    pub(super) const VIEW: u16 = 15;
    pub(super) const ACKNOWLEDGED: u16 = 20;
    pub(super) const WANTED: u16 = 21;
    pub(super) const NOTICE: u16 = 22;
    pub(super) const PING: u16 = 30;
    pub(super) const PONG: u16 = 31;
}

impl ClientMessage {
    /// How it travels.
    pub(crate) fn channel(&self) -> Channel {
        match self {
            Self::Chunk(_) => Channel::Bulk,
            _ => Channel::Control,
        }
    }

    pub(crate) fn encode(&self) -> Vec<u8> {
        let mut w = Writer::default();
        match self {
            Self::Snapshot(part) => {
                w.u16(kind::SNAPSHOT);
                scene::write_part(&mut w, part);
            }
            Self::Chunk(chunk) => {
                w.u16(kind::CHUNK);
                w.raw(&chunk.hash.0);
                w.u32(chunk.total);
                w.u32(chunk.offset);
                w.bytes(&chunk.data);
            }
            Self::Gone(hash) => {
                w.u16(kind::GONE);
                w.raw(&hash.0);
            }
            Self::Acks(sequences) => {
                w.u16(kind::ACKS);
                w.count(sequences.len());
                sequences.iter().for_each(|s| w.varint(*s));
            }
            Self::Resync => w.u16(kind::RESYNC),
            Self::View(view) => {
                w.u16(kind::VIEW);
                write_view(&mut w, view);
            }
            Self::Ping(time) => {
                w.u16(kind::PING);
                w.u64(*time);
            }
            Self::Pong(time) => {
                w.u16(kind::PONG);
                w.u64(*time);
            }
        }
        w.finish()
    }

    /// `None` for a kind of a newer version.
    pub(crate) fn decode(channel: Channel, bytes: &[u8]) -> Result<Option<Self>, WireError> {
        let mut r = Reader::new("a message of the client", bytes);
        let message = match r.u16()? {
            kind::SNAPSHOT => Self::Snapshot(scene::read_part(r.rest())?),
            kind::CHUNK => {
                let mut r = Reader::new("a piece of a blob", r.rest());
                let (hash, total, offset) = (BlobHash(r.array()?), r.u32()?, r.u32()?);
                let data = r.bytes(usize::MAX)?.to_vec();
                Self::Chunk(Chunk { hash, total, offset, data })
            }
            kind::GONE => Self::Gone(BlobHash(r.array()?)),
            kind::ACKS => {
                let count = r.count(1, MAX_ACKS)?;
                Self::Acks((0..count).map(|_| r.varint()).collect::<Result<_, _>>()?)
            }
            kind::RESYNC => Self::Resync,
            kind::VIEW => Self::View(read_view(r.rest())?),
            kind::PING => Self::Ping(r.u64()?),
            kind::PONG => Self::Pong(r.u64()?),
            _ => return Ok(None),
        };
        if message.channel() != channel {
            return Err(WireError::Unexpected(format!("a message on the channel {channel:?}")));
        }
        Ok(Some(message))
    }
}

impl ServerMessage {
    pub(crate) fn encode(&self) -> Vec<u8> {
        let mut w = Writer::default();
        match self {
            Self::Acknowledged(snapshot) => {
                w.u16(kind::ACKNOWLEDGED);
                w.u64(snapshot.0);
            }
            Self::Wanted(blobs) => {
                w.u16(kind::WANTED);
                w.count(blobs.len());
                for (hash, offset) in blobs {
                    w.raw(&hash.0);
                    w.u32(*offset);
                }
            }
            Self::Notice(text) => {
                w.u16(kind::NOTICE);
                w.bytes(clip(text, MAX_NOTICE).as_bytes());
            }
            Self::Ping(time) => {
                w.u16(kind::PING);
                w.u64(*time);
            }
            Self::Pong(time) => {
                w.u16(kind::PONG);
                w.u64(*time);
            }
        }
        w.finish()
    }

    /// `None` for a kind of a newer version.
    pub(crate) fn decode(bytes: &[u8]) -> Result<Option<Self>, WireError> {
        let mut r = Reader::new("a message of the server", bytes);
        Ok(Some(match r.u16()? {
            kind::ACKNOWLEDGED => Self::Acknowledged(SnapshotId(r.u64()?)),
            kind::WANTED => {
                let count = r.count(36, MAX_WANTED)?;
                let mut blobs = Vec::with_capacity(count);
                for _ in 0..count {
                    blobs.push((BlobHash(r.array()?), r.u32()?));
                }
                Self::Wanted(blobs)
            }
            kind::NOTICE => Self::Notice(r.text(MAX_NOTICE)?.to_owned()),
            kind::PING => Self::Ping(r.u64()?),
            kind::PONG => Self::Pong(r.u64()?),
            _ => return Ok(None),
        }))
    }
}

/// Bytes of a notice.
const MAX_NOTICE: usize = 1024;

/// The front of a text, at most so many bytes.
pub(crate) fn clip(text: &str, bytes: usize) -> &str {
    &text[..text.floor_char_boundary(bytes)]
}

fn write_view(w: &mut Writer, view: &View) {
    w.u32(view.id);
    w.u64(view.frame);
    w.floats(view.position.to_array());
    w.floats(view.rotation.to_array());
    w.floats(view.projection.to_cols_array());
    w.u32(view.size.x);
    w.u32(view.size.y);
    w.count(view.predicted.len().min(MAX_PREDICTED));
    for (after, position, rotation) in view.predicted.iter().take(MAX_PREDICTED) {
        w.u32(*after);
        w.floats(position.to_array());
        w.floats(rotation.to_array());
    }
}

fn read_view(bytes: &[u8]) -> Result<View, WireError> {
    let mut r = Reader::new("a view", bytes);
    let mut view = View {
        id: r.u32()?,
        frame: r.u64()?,
        position: r.floats()?.into(),
        rotation: glam::Quat::from_array(r.floats()?),
        projection: glam::Mat4::from_cols_array(&r.floats()?),
        size: glam::UVec2::new(r.u32()?, r.u32()?),
        predicted: Vec::new(),
    };
    for _ in 0..r.count(32, MAX_PREDICTED)? {
        view.predicted.push((r.u32()?, r.floats()?.into(), glam::Quat::from_array(r.floats()?)));
    }
    Ok(view)
}
