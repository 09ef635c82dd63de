//! Memory of sessions that are over.
//!
//! The allocator of the GNU C library keeps what is freed for the threads that share one of its
//! arenas, of which there are eight a core. A session's threads come and go, so a server would end up
//! holding several of its largest sessions: 110 MB where 45 MB do, with six small ones on two cores.

/// Keeps the memory of the process near what its sessions use.
#[derive(Debug)]
pub(super) struct Memory {
    ended: u64,
}

impl Memory {
    /// To be made before there are many threads.
    pub(super) fn new() -> Self {
        system::few_arenas();
        Self { ended: 0 }
    }

    /// Gives freed memory back to the system; to be called now and then with the number of sessions
    /// that have ended so far.
    pub(super) fn give_back(&mut self, ended: u64) {
        if std::mem::replace(&mut self.ended, ended) != ended {
            system::trim();
        }
    }
}

#[cfg(all(target_os = "linux", target_env = "gnu"))]
mod system {
    use std::ffi::c_int;

    /// `M_ARENA_MAX` of malloc.h.
    const ARENA_MAX: c_int = -8;
    /// Threads rarely meet: what they allocate while they solve is large and lives long, and small
    /// things come from caches of their own.
    const ARENAS: c_int = 2;

    // The declarations are those of malloc.h.
    unsafe extern "C" {
        fn mallopt(parameter: c_int, value: c_int) -> c_int;
        fn malloc_trim(pad: usize) -> c_int;
    }

    pub(super) fn few_arenas() {
        // Whoever sets the variable of mallopt(3) knows better.
        if std::env::var_os("MALLOC_ARENA_MAX").is_none() {
            // SAFETY: mallopt(3) takes two numbers and may be called at any time; it locks what it
            // changes.
            unsafe {
                mallopt(ARENA_MAX, ARENAS);
            }
        }
    }

    pub(super) fn trim() {
        // SAFETY: malloc_trim(3) takes a number and may be called at any time from any thread.
        unsafe {
            malloc_trim(0);
        }
    }
}

#[cfg(not(all(target_os = "linux", target_env = "gnu")))]
mod system {
    pub(super) fn few_arenas() {}
    pub(super) fn trim() {}
}
