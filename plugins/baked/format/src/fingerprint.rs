//! Short content hashes, for file names and for asking whether two things are the same.

use std::{fmt, str::FromStr};

use glam::Vec2;
use serde::{Deserialize, Deserializer, Serialize, Serializer, de::Error};

/// The first 128 bits of a BLAKE3 hash; written as 32 hexadecimal digits.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, PartialOrd, Ord, Hash)]
pub struct Fingerprint(pub u128);

impl Fingerprint {
    /// That of some bytes.
    #[must_use]
    pub fn of(bytes: &[u8]) -> Self {
        Self::from(&blake3::hash(bytes))
    }

    /// That of a second UV set as the graphics card sees it: the bits of u and v of every vertex, in
    /// order.
    #[must_use]
    pub fn of_uv(uv: impl IntoIterator<Item = Vec2>) -> Self {
        let mut hasher = blake3::Hasher::new();
        for uv in uv {
            hasher.update(&uv.x.to_bits().to_le_bytes());
            hasher.update(&uv.y.to_bits().to_le_bytes());
        }
        Self::from(&hasher.finalize())
    }

    /// The first eight digits, for file names.
    #[must_use]
    pub fn short(&self) -> String {
        self.to_string()[..8].to_owned()
    }
}

impl From<&blake3::Hash> for Fingerprint {
    fn from(hash: &blake3::Hash) -> Self {
        let (half, _) = hash.as_bytes().split_at(16);
        Self(half.iter().fold(0, |all, &byte| all << 8 | u128::from(byte)))
    }
}

impl fmt::Display for Fingerprint {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(f, "{:032x}", self.0)
    }
}

impl FromStr for Fingerprint {
    type Err = String;

    fn from_str(text: &str) -> Result<Self, String> {
        let digits = text.len() == 32 && text.bytes().all(|b| b.is_ascii_hexdigit());
        match u128::from_str_radix(text, 16) {
            Ok(bits) if digits => Ok(Self(bits)),
            _ => Err(format!("{text:?} is not a fingerprint of 32 hexadecimal digits")),
        }
    }
}

impl Serialize for Fingerprint {
    fn serialize<S: Serializer>(&self, serializer: S) -> Result<S::Ok, S::Error> {
        serializer.collect_str(self)
    }
}

impl<'de> Deserialize<'de> for Fingerprint {
    fn deserialize<D: Deserializer<'de>>(deserializer: D) -> Result<Self, D::Error> {
        String::deserialize(deserializer)?.parse().map_err(D::Error::custom)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn text_there_and_back() {
        let print = Fingerprint::of(b"a texel");
        assert_eq!(print.to_string().parse(), Ok(print));
        assert_eq!(print.to_string()[..8], print.short());
        for bad in ["", "12", "+0000000000000000000000000000000", &"g".repeat(32)] {
            assert!(bad.parse::<Fingerprint>().is_err(), "{bad}");
        }
    }

    #[test]
    fn uv_sets_differ_by_their_bits_and_order() {
        let set = [Vec2::new(0.25, 0.5), Vec2::new(0.75, 0.5)];
        let print = Fingerprint::of_uv(set);
        assert_eq!(print, Fingerprint::of_uv(set));
        assert_ne!(print, Fingerprint::of_uv([set[1], set[0]]));
        assert_ne!(print, Fingerprint::of_uv([Vec2::new(0.25, 0.500_001), set[1]]));
    }
}
