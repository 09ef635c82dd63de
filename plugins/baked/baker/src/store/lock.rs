//! One bake a folder.

use std::{
    fs::{File, OpenOptions, TryLockError},
    io::{Read, Seek, Write},
    path::Path,
};

use crate::BakeError;

/// Held while a bake writes into a folder. The system gives it up with the process, however that ends.
pub(crate) struct Lock(#[expect(dead_code, reason = "it is held, not used")] File);

impl Lock {
    /// Takes the lock of a folder whose cache is `cache`.
    pub(crate) fn take(folder: &Path, cache: &Path) -> Result<Self, BakeError> {
        let path = cache.join("lock");
        let io = |source| BakeError::Io { path: path.clone(), doing: "written", source };
        let mut file = OpenOptions::new()
            .create(true)
            .truncate(false)
            .read(true)
            .write(true)
            .open(&path)
            .map_err(io)?;
        match file.try_lock() {
            Ok(()) => {}
            Err(TryLockError::WouldBlock) => {
                let mut process = String::new();
                let read = file.take(20).read_to_string(&mut process);
                let known = read.is_ok() && !process.is_empty();
                let process = if known { process } else { "unknown".to_owned() };
                return Err(BakeError::Locked { folder: folder.to_owned(), process });
            }
            // File systems that know no locks: better a bake than none.
            Err(TryLockError::Error(_)) => {}
        }
        file.set_len(0).and_then(|()| file.rewind()).map_err(io)?;
        write!(file, "{}", std::process::id()).map_err(io)?;
        Ok(Self(file))
    }
}
