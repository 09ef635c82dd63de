//! What can go wrong on a GPU.

/// Why a GPU gave no values.
#[derive(Debug, thiserror::Error)]
pub enum GpuError {
    /// No adapter: the text names the interfaces that were tried.
    #[error("no GPU was found: {0}")]
    NoAdapter(String),
    /// The adapter gave no device.
    #[error("{adapter} gives no device: {what}")]
    NoDevice {
        /// The adapter's name.
        adapter: String,
        /// What it said.
        what: String,
    },
    /// The tables don't fit into one buffer of the device.
    #[error("the tables take {bytes} bytes; a storage buffer of {adapter} has at most {limit}")]
    TooLarge {
        /// Bytes of the tables.
        bytes: u64,
        /// The device's limit.
        limit: u64,
        /// The adapter's name.
        adapter: String,
    },
    /// The shader can't be built: an error of this crate.
    #[error("the shader is wrong: {0}")]
    Shader(#[from] farlight_shaders::ComposeError),
    /// The device refused, ran out of memory or did not answer.
    #[error("{adapter}: {what}")]
    Failed {
        /// The adapter's name.
        adapter: String,
        /// What it said.
        what: String,
    },
    /// The device is lost (taken away, reset by the system): a new [`Gpu`](super::Gpu) may work.
    #[error("{adapter} is lost: {what}")]
    Lost {
        /// The adapter's name.
        adapter: String,
        /// What the system said.
        what: String,
    },
}
