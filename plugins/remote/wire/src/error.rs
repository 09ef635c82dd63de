//! What goes wrong on the wire.

use std::fmt;

use thiserror::Error;

/// What the other side sent does not fit. The connection ends; the session's owner says why.
#[derive(Clone, Debug, Error, PartialEq, Eq)]
pub enum WireError {
    /// A message ended early.
    #[error("{what} ends {missing} bytes too early")]
    Truncated {
        /// What was being read.
        what: &'static str,
        /// How many bytes were missing at least.
        missing: usize,
    },
    /// Something is larger than allowed.
    #[error("{what}: {found} is over the limit of {limit}")]
    TooLarge {
        /// What.
        what: &'static str,
        /// How large it says it is.
        found: u64,
        /// How large it may be.
        limit: u64,
    },
    /// A value that means nothing.
    #[error("{what} is not valid: {why}")]
    Invalid {
        /// What was being read.
        what: &'static str,
        /// Why it can't be.
        why: String,
    },
    /// A message at a time or on a channel where it makes no sense.
    #[error("unexpected: {0}")]
    Unexpected(String),
    /// The other side speaks another version of the protocol.
    #[error("the other side speaks version {theirs} of the protocol, this one speaks {ours}")]
    Version {
        /// Our version.
        ours: u16,
        /// The other side's.
        theirs: u16,
    },
    /// Data that does not have the hash that it was announced with.
    #[error("the content of a blob does not have the announced hash")]
    WrongHash,
}

impl WireError {
    /// An [`WireError::Invalid`].
    pub(crate) fn invalid(what: &'static str, why: impl fmt::Display) -> Self {
        Self::Invalid { what, why: why.to_string() }
    }

    /// What to tell the other side.
    #[must_use]
    pub fn close_code(&self) -> CloseCode {
        match self {
            Self::TooLarge { .. } => CloseCode::Limit,
            Self::Version { .. } => CloseCode::Incompatible,
            _ => CloseCode::Protocol,
        }
    }

    /// Checks a size.
    pub(crate) fn check(what: &'static str, found: usize, limit: usize) -> Result<(), Self> {
        if found <= limit {
            return Ok(());
        }
        Err(Self::TooLarge { what, found: found as u64, limit: limit as u64 })
    }
}

/// Why one side says goodbye.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub enum CloseCode {
    /// It is done.
    Done,
    /// The token is not the server's.
    Unauthorized,
    /// No version or no service that both know.
    Incompatible,
    /// The server has as many sessions as it may.
    Full,
    /// The other side broke the rules of the wire.
    Protocol,
    /// More was asked for than the other side gives.
    Limit,
    /// The server is being stopped; it may come back.
    ShuttingDown,
    /// The solver failed, for example by a bug.
    Failed,
    /// The same session goes on over another connection.
    Replaced,
    /// The connection is given up, for example because nothing was heard over it; the session may go
    /// on over another one.
    Abandoned,
    /// A code of a newer version.
    Other(u32),
}

impl CloseCode {
    const KNOWN: [(Self, u32, &'static str); 10] = [
        (Self::Done, 0, "goodbye"),
        (Self::Unauthorized, 1, "the access token is wrong"),
        (Self::Incompatible, 2, "the versions don't fit together"),
        (Self::Full, 3, "the server is full"),
        (Self::Protocol, 4, "the protocol was broken"),
        (Self::Limit, 5, "a limit was reached"),
        (Self::ShuttingDown, 6, "the server is shutting down"),
        (Self::Failed, 7, "the solver failed"),
        (Self::Replaced, 8, "the session goes on over another connection"),
        (Self::Abandoned, 9, "the connection was given up"),
    ];

    /// Its number on the wire.
    #[must_use]
    pub fn number(self) -> u32 {
        match self {
            Self::Other(number) => number,
            known => Self::KNOWN.iter().find(|(code, ..)| *code == known).map_or(0, |k| k.1),
        }
    }

    /// The code with a number.
    #[must_use]
    pub fn from_number(number: u32) -> Self {
        Self::KNOWN.iter().find(|(_, n, _)| *n == number).map_or(Self::Other(number), |k| k.0)
    }

    /// Whether connecting again can help.
    #[must_use]
    pub fn is_worth_retrying(self) -> bool {
        !matches!(self, Self::Unauthorized | Self::Incompatible | Self::Protocol | Self::Limit)
    }
}

impl fmt::Display for CloseCode {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match Self::KNOWN.iter().find(|(code, ..)| code == self) {
            Some((_, _, text)) => f.write_str(text),
            None => write!(f, "closed with code {}", self.number()),
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn codes_have_numbers_and_back() {
        for (code, number, _) in CloseCode::KNOWN {
            assert_eq!(code.number(), number);
            assert_eq!(CloseCode::from_number(number), code);
        }
        assert_eq!(CloseCode::from_number(99), CloseCode::Other(99));
        assert_eq!(CloseCode::Other(99).number(), 99);
    }
}
