//! The folder of the results, and what is kept in it for the next bake.
//!
//! | file | what |
//! |---|---|
//! | `NAME.baked.ron` | the manifest: replaced last, by renaming |
//! | `NAME.glb` | the lit scene |
//! | `NAME.SCENARIO.*.HASH.ktx2`, `.exr` | what the manifest names; the hash is that of the content, so no file is ever changed |
//! | `.bake/` | the cache; may be deleted |
//!
//! Whatever a bake is killed in the middle of, the manifest and the files that it names belong together.

mod cache;
mod folder;
mod key;
mod lock;

pub(crate) use cache::{Cache, Record};
pub(crate) use folder::{Folder, files};
pub(crate) use key::Key;
pub(crate) use lock::Lock;
