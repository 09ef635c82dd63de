//! What can be wrong with a file, said so that it can be fixed.

use thiserror::Error;

/// Why a file could not be read: which one, and what is wrong with it.
#[derive(Debug, Error)]
#[error("{file}: {problem}")]
pub struct ImportError {
    /// The path, or `glTF data in memory`.
    pub file: String,
    /// What is wrong.
    #[source]
    pub problem: ImportProblem,
}

/// What is wrong with a file.
#[derive(Debug, Error)]
#[non_exhaustive]
pub enum ImportProblem {
    /// The operating system refused.
    #[error("cannot be read: {0}")]
    Io(#[from] std::io::Error),
    /// Neither binary glTF nor JSON of glTF 2.0.
    #[error("is not glTF 2.0: {0}")]
    NotGltf(String),
    /// A length in the file promises more than there is, or two lengths contradict each other.
    #[error("is truncated or damaged: {0}; export or download it again")]
    Damaged(String),
    /// An accessor, index or mode of a primitive is not usable.
    #[error("{place}: {what}; the file is damaged or its exporter has a bug, export it again")]
    Primitive {
        /// Mesh, primitive and attribute.
        place: String,
        /// What is wrong there.
        what: String,
    },
    /// An extension that changes how geometry must be read.
    #[error("needs the glTF extension {extension}, which is not supported: {fix}")]
    Extension {
        /// Its name.
        extension: String,
        /// What to do.
        fix: &'static str,
    },
    /// A buffer or image outside of the file cannot or must not be read.
    #[error("refers to {uri:?}: {what}")]
    External {
        /// The reference, shortened.
        uri: String,
        /// What is wrong with it.
        what: String,
    },
    /// More than [`ImportLimits`](super::ImportLimits) allow.
    #[error(
        "has {found} {what}, the limit is {limit}: split or simplify the scene, \
         or raise ImportLimits::{field}"
    )]
    Limit {
        /// What is counted.
        what: &'static str,
        /// How many there are (at least).
        found: u64,
        /// How many may be.
        limit: u64,
        /// The field that holds the limit.
        field: &'static str,
    },
}

/// Warnings up to a number; a hostile file must not fill memory with them.
#[derive(Default)]
pub(super) struct Warnings {
    messages: Vec<String>,
    more: usize,
}

impl Warnings {
    const MAX: usize = 100;

    pub(super) fn push(&mut self, message: impl FnOnce() -> String) {
        if self.messages.len() < Self::MAX {
            self.messages.push(message());
        } else {
            self.more += 1;
        }
    }

    pub(super) fn finish(mut self) -> Vec<String> {
        if self.more > 0 {
            self.messages.push(format!("and {} more warnings", self.more));
        }
        self.messages
    }
}

/// A thing of the file for messages: `mesh 3 "bed"`. Names are shortened and escaped.
pub(super) fn label(kind: &str, index: usize, name: Option<&str>) -> String {
    match name {
        Some(name) if !name.is_empty() => format!("{kind} {index} {:?}", shorten(name)),
        _ => format!("{kind} {index}"),
    }
}

/// The first characters of a text from outside.
pub(super) fn shorten(text: &str) -> String {
    const MAX: usize = 60;
    match text.char_indices().nth(MAX) {
        Some((end, _)) => format!("{}...", &text[..end]),
        None => text.to_owned(),
    }
}
