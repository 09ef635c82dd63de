//! How much of anything one side takes from the other.

/// Bounds that are checked before memory is taken. Both sides use their own.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Limits {
    /// Bytes of a message on [`Channel::Control`](crate::Channel::Control).
    pub control_bytes: usize,
    /// Bytes of a message on [`Channel::Bulk`](crate::Channel::Bulk), one chunk of a blob.
    pub bulk_bytes: usize,
    /// Bytes of a message on [`Channel::Latest`](crate::Channel::Latest).
    pub latest_bytes: usize,
    /// Bytes of one decoded blob (a mesh, a texture, a sky).
    pub blob_bytes: usize,
    /// Bytes of all decoded blobs of a session.
    pub session_blob_bytes: usize,
    /// Objects (meshes, textures, materials, instances, lights, grids) of a session.
    pub objects: usize,
    /// Triangles of all instances of a session.
    pub triangles: usize,
    /// Texels of all lightmap pages that a session may ask for.
    pub texels: usize,
    /// Probes of all grids of a session.
    pub probes: usize,
}

impl Default for Limits {
    fn default() -> Self {
        Self {
            control_bytes: 256 << 10,
            bulk_bytes: 256 << 10,
            latest_bytes: 1 << 20,
            blob_bytes: 256 << 20,
            session_blob_bytes: 1 << 30,
            objects: 200_000,
            triangles: 20_000_000,
            texels: 16 << 20,
            probes: 1 << 20,
        }
    }
}
