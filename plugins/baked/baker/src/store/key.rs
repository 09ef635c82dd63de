//! Names of results by everything that they depend on.

use farlight_baked_format::Fingerprint;
use glam::Vec3;

/// Counts changes of baker and solver after which the same inputs give other results.
const RESULTS: u32 = 4;

/// Hashes what a result depends on.
#[derive(Clone)]
pub(crate) struct Key(blake3::Hasher);

impl Key {
    /// For results of a kind.
    pub(crate) fn new(kind: &str) -> Self {
        let mut key = Self(blake3::Hasher::new());
        key.text(kind).text(env!("CARGO_PKG_VERSION")).number(RESULTS);
        key
    }

    pub(crate) fn bytes(&mut self, bytes: &[u8]) -> &mut Self {
        // With its length, so that two texts beside each other can't be mistaken for others.
        self.0.update(&(bytes.len() as u64).to_le_bytes());
        self.0.update(bytes);
        self
    }

    pub(crate) fn text(&mut self, text: &str) -> &mut Self {
        self.bytes(text.as_bytes())
    }

    pub(crate) fn number(&mut self, number: impl Into<u64>) -> &mut Self {
        self.0.update(&number.into().to_le_bytes());
        self
    }

    pub(crate) fn float(&mut self, float: f32) -> &mut Self {
        self.0.update(&float.to_bits().to_le_bytes());
        self
    }

    pub(crate) fn vector(&mut self, vector: Vec3) -> &mut Self {
        self.floats(&vector.to_array())
    }

    pub(crate) fn floats(&mut self, floats: &[f32]) -> &mut Self {
        for &float in floats {
            self.float(float);
        }
        self
    }

    pub(crate) fn print(&mut self, print: Fingerprint) -> &mut Self {
        self.0.update(&print.0.to_le_bytes());
        self
    }

    pub(crate) fn finish(&self) -> Fingerprint {
        Fingerprint::from(&self.0.finalize())
    }
}
