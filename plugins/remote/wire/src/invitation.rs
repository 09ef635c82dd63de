//! `farlight://HOST:PORT/#TOKEN.SHA256`: how to reach a server, and how to know it.

use std::{fmt, str::FromStr};

use thiserror::Error;

/// The scheme and what follows it.
const PREFIX: &str = "farlight://";
/// Bytes of a token and of a fingerprint.
const TOKEN: usize = 16;
const FINGERPRINT: usize = 32;

/// A secret that lets a client in. Not shown by `Debug`.
#[derive(Clone, Copy)]
pub struct Token(pub [u8; TOKEN]);

impl PartialEq for Token {
    /// Takes the same time wherever the two differ.
    fn eq(&self, other: &Self) -> bool {
        self.0.iter().zip(other.0).fold(0, |differs, (a, b)| differs | (a ^ b)) == 0
    }
}

impl Eq for Token {}

impl fmt::Debug for Token {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str("Token(..)")
    }
}

impl fmt::Display for Token {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write_hex(f, &self.0)
    }
}

impl FromStr for Token {
    type Err = InvitationError;

    fn from_str(text: &str) -> Result<Self, Self::Err> {
        read_hex(text).map(Self).ok_or(InvitationError::Token)
    }
}

/// How to reach a server, and how to know it. Its text is
/// `farlight://HOST:PORT/#TOKEN.SHA256-OF-AUTHORITY`, both in hexadecimal. Behind `#`, so that tools
/// which take it for an URL don't send the secrets along.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Invitation {
    /// Name or address; IPv6 without brackets.
    pub host: String,
    /// UDP port.
    pub port: u16,
    /// Lets the client in.
    pub token: Token,
    /// SHA-256 of the DER encoding of the authority's certificate, which signs the server's.
    pub authority: [u8; FINGERPRINT],
}

impl Invitation {
    /// Whether a text can stand for the host: a name or an address without brackets.
    #[must_use]
    pub fn is_host(text: &str) -> bool {
        let odd = |c: char| c.is_whitespace() || c.is_control() || "[]/@#?".contains(c);
        !text.is_empty() && !text.contains(odd)
    }
}

/// What is wrong with the text of an invitation.
#[derive(Clone, Copy, Debug, Error, PartialEq, Eq)]
pub enum InvitationError {
    /// It is something else.
    #[error("an invitation looks like farlight://HOST:PORT/#TOKEN.SHA256")]
    Form,
    /// No host.
    #[error("the invitation names no host")]
    Host,
    /// No number from 1 to 65535.
    #[error("the invitation's port is not a number from 1 to 65535")]
    Port,
    /// Not 32 hexadecimal digits.
    #[error("the invitation's token is not 32 hexadecimal digits; was it cut off?")]
    Token,
    /// Not 64 hexadecimal digits.
    #[error("the invitation's fingerprint is not 64 hexadecimal digits; was it cut off?")]
    Fingerprint,
}

impl fmt::Display for Invitation {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let v6 = self.host.contains(':');
        let (open, close) = if v6 { ("[", "]") } else { ("", "") };
        write!(f, "{PREFIX}{open}{}{close}:{}/#{}.", self.host, self.port, self.token)?;
        write_hex(f, &self.authority)
    }
}

impl FromStr for Invitation {
    type Err = InvitationError;

    fn from_str(text: &str) -> Result<Self, Self::Err> {
        let rest = text.trim().strip_prefix(PREFIX).ok_or(InvitationError::Form)?;
        let (place, secrets) = rest.split_once("/#").ok_or(InvitationError::Form)?;
        let (host, port) = place.rsplit_once(':').ok_or(InvitationError::Port)?;
        let bare = host.strip_prefix('[').and_then(|h| h.strip_suffix(']'));
        let host = bare.unwrap_or(host);
        if !Self::is_host(host) || (bare.is_none() && host.contains(':')) {
            return Err(InvitationError::Host);
        }
        let digits = !port.is_empty() && port.bytes().all(|b| b.is_ascii_digit());
        let port = port.parse().ok().filter(|p| digits && *p != 0).ok_or(InvitationError::Port)?;
        let (token, authority) = secrets.split_once('.').ok_or(InvitationError::Form)?;
        Ok(Self {
            host: host.to_owned(),
            port,
            token: token.parse()?,
            authority: read_hex(authority).ok_or(InvitationError::Fingerprint)?,
        })
    }
}

fn write_hex(f: &mut fmt::Formatter<'_>, bytes: &[u8]) -> fmt::Result {
    bytes.iter().try_for_each(|byte| write!(f, "{byte:02x}"))
}

fn read_hex<const N: usize>(text: &str) -> Option<[u8; N]> {
    let digits = text.as_bytes();
    if digits.len() != 2 * N {
        return None;
    }
    let digit = |byte: u8| char::from(byte).to_digit(16);
    let mut bytes = [0; N];
    for (byte, pair) in bytes.iter_mut().zip(digits.chunks(2)) {
        *byte = (digit(pair[0])? * 16 + digit(pair[1])?) as u8;
    }
    Some(bytes)
}

#[cfg(test)]
mod tests {
    use super::*;

    fn invitation(host: &str) -> Invitation {
        let authority = std::array::from_fn(|i| i as u8);
        Invitation { host: host.into(), port: 4433, token: Token([0xab; 16]), authority }
    }

    #[test]
    fn text_and_back() {
        for host in ["localhost", "192.168.0.7", "light.example.org", "::1", "fe80::1%eth0"] {
            let invitation = invitation(host);
            assert_eq!(invitation.to_string().parse(), Ok(invitation.clone()), "{invitation}");
        }
        assert!(invitation("::1").to_string().starts_with("farlight://[::1]:4433/#abab"));
        let padded = format!("  {}\n", invitation("a"));
        assert_eq!(padded.parse(), Ok(invitation("a")));
    }

    #[test]
    fn what_is_wrong_is_said() {
        let good = invitation("host").to_string();
        let error = |text: String| text.parse::<Invitation>().unwrap_err();
        assert_eq!(error("https://host:1/".into()), InvitationError::Form);
        assert_eq!(error(good.replace("/#", "/")), InvitationError::Form);
        assert_eq!(error(good.replace("host", "")), InvitationError::Host);
        assert_eq!(error(good.replace("host", "a b")), InvitationError::Host);
        assert_eq!(error(good.replace("host", "::1")), InvitationError::Host);
        for port in ["0", "65536", "+1", "", "x"] {
            assert_eq!(error(good.replace("4433", port)), InvitationError::Port, "{port}");
        }
        assert_eq!(error(good.replace("abab", "ab")), InvitationError::Token);
        assert_eq!(error(good.replace("abab", "xyxy")), InvitationError::Token);
        assert_eq!(error(good[..good.len() - 1].to_owned()), InvitationError::Fingerprint);
        assert_eq!(error(format!("{good}é")), InvitationError::Fingerprint);
    }

    #[test]
    fn tokens_are_not_shown() {
        assert!(!format!("{:?}", invitation("host")).contains("ab, ab"));
        assert!(!format!("{:?}", Token([0xab; 16])).contains("171"));
    }
}
