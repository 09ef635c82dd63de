//! Why a connection ends, for both sides.

use std::sync::Arc;

use farlight_wire::{CloseCode, Closed};
use wtransport::{VarInt, quinn};

/// Bytes of a reason that are told to the other side, and believed from it.
const REASON: usize = 256;

/// The codes below are ours; HTTP/3 and WebTransport use larger ones for themselves (RFC 9114, 8.1).
const OUR_CODES: u64 = 0x100;

/// What ended a connection, as seen from this side.
#[derive(Debug)]
pub(crate) enum End {
    /// This side wants it.
    Ours(CloseCode, String),
    /// The other side broke the rules.
    Broken(CloseCode, String),
    /// The connection is gone.
    Gone(quinn::ConnectionError),
    /// The connection can't be used any more.
    Lost(String),
}

impl End {
    /// What to tell the other side.
    pub(crate) fn code_and_reason(&self) -> (VarInt, &[u8]) {
        let (code, reason) = match self {
            Self::Ours(code, reason) | Self::Broken(code, reason) => (*code, reason.as_str()),
            Self::Lost(why) => (CloseCode::Abandoned, why.as_str()),
            Self::Gone(_) => (CloseCode::Abandoned, ""),
        };
        (VarInt::from_u32(code.number()), cut(reason).as_bytes())
    }

    /// What to tell the session.
    pub(crate) fn into_closed(self) -> Closed {
        match self {
            Self::Ours(code, reason) => Closed::Goodbye(code, reason.into()),
            Self::Broken(_, why) => Closed::Broken(why.into()),
            Self::Gone(error) => closed(&error),
            Self::Lost(why) => Closed::Lost(why.into()),
        }
    }
}

/// What the end of a connection means.
pub(crate) fn closed(error: &quinn::ConnectionError) -> Closed {
    use quinn::ConnectionError as E;
    let lost = |why: &str| Closed::Lost(why.into());
    match error {
        E::ApplicationClosed(close) => goodbye(close.error_code.into_inner(), &close.reason),
        E::ConnectionClosed(close) => lost(&close.to_string()),
        E::TimedOut => lost("nothing was heard from the other side for too long"),
        E::Reset => lost("the other side doesn't know the connection; it was probably restarted"),
        E::LocallyClosed => lost("it was closed here"),
        other => lost(&other.to_string()),
    }
}

/// What the other side said when it left.
pub(crate) fn goodbye(code: u64, reason: &[u8]) -> Closed {
    if code < OUR_CODES {
        return Closed::Goodbye(CloseCode::from_number(code as u32), readable(reason));
    }
    let why = format!("the other side closed the WebTransport session (code {code:#x})");
    Closed::Lost(why.into())
}

/// Text of the other side, fit for a log.
fn readable(reason: &[u8]) -> Arc<str> {
    let text = String::from_utf8_lossy(&reason[..reason.len().min(REASON)]);
    text.chars().map(|c| if c.is_control() { ' ' } else { c }).collect::<String>().into()
}

/// The beginning of a text.
fn cut(text: &str) -> &str {
    &text[..text.floor_char_boundary(REASON)]
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn reasons_are_short_and_fit_for_a_log() {
        let long = "ä".repeat(1000);
        let end = End::Ours(CloseCode::Full, long);
        assert_eq!(end.code_and_reason().1.len(), 256);
        assert_eq!(&*readable(b"a\nb\x1b[31m\xff"), "a b [31m\u{fffd}");
        assert_eq!(readable(&[b'x'; 5000]).len(), 256);
    }
}
