//! Memory of sessions that are over.

/// Gives freed memory back to the system. The allocator of the GNU C library keeps what is freed in
/// one of its arenas (several a core) for the threads of that arena; with threads that come and go
/// a server would hold the largest session of each arena.
#[derive(Debug, Default)]
pub(super) struct Memory {
    ended: u64,
}

impl Memory {
    /// To be called now and then with the number of sessions that have ended so far.
    pub(super) fn give_back(&mut self, ended: u64) {
        if std::mem::replace(&mut self.ended, ended) != ended {
            trim();
        }
    }
}

#[cfg(all(target_os = "linux", target_env = "gnu"))]
fn trim() {
    unsafe extern "C" {
        fn malloc_trim(pad: usize) -> std::ffi::c_int;
    }
    // SAFETY: malloc_trim(3) may be called at any time from any thread, and takes no pointers. The
    // declaration is that of malloc.h.
    unsafe {
        malloc_trim(0);
    }
}

#[cfg(not(all(target_os = "linux", target_env = "gnu")))]
fn trim() {}
