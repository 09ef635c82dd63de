//! Settings of a lighting server as a user writes them down.
//!
//! Plain data for serde. In RON:
//!
//! ```ron
//! ServerSettings(
//!     listen: "192.168.0.7:4433",
//!     max_sessions: 2,
//! )
//! ```

use std::{
    net::{IpAddr, Ipv6Addr, SocketAddr},
    path::PathBuf,
    time::Duration,
};

use farlight_gi_solver::settings::SettingsError;
use farlight_wire::{Invitation, Limits};
use serde::{Deserialize, Serialize};

/// Where a server listens and what it gives to whom. Every field may be left out; an unknown one is
/// an error.
#[derive(Clone, Debug, PartialEq, Eq, Serialize, Deserialize)]
#[serde(deny_unknown_fields, default)]
pub struct ServerSettings {
    /// Address and UDP port to listen on; `[::]` is every address of the machine (IPv4 too), port 0
    /// any free one. Default `[::]:4433`.
    pub listen: SocketAddr,
    /// Name or address that the invitation tells clients to connect to. Default empty: the address
    /// that is listened on, or, where that is every one, a guess of the machine's address in its
    /// network.
    pub public_host: String,
    /// Folder of the server's identity: the authority that clients pin, and the access token.
    /// Default empty: `$XDG_DATA_HOME/farlight` or `~/.local/share/farlight`, on Windows
    /// `%APPDATA%\farlight`.
    pub state: PathBuf,
    /// Sessions at the same time, those that wait for their client to come back included, 1 to 1024.
    /// Where there are as many, the one whose client has been silent the longest makes room if that
    /// is at least 6 seconds, or its connection is lost. Default 8.
    pub max_sessions: u32,
    /// Threads that solve a session, 0 to 1024; 0 is one fewer than there are cores. The system
    /// shares its cores among all sessions. Default 0.
    pub threads: u32,
    /// Largest edge of a lightmap page in texels, a power of two from 16 to 4096. A client that wants
    /// larger ones is refused. Default 4096.
    pub max_page_size: u32,
    /// Most lightmap pages of a session, 1 to 64. Default 64.
    pub max_pages: u32,
    /// Most texels of all pages of a session, 256 to 1073741824. Default 16777216.
    pub max_texels: u32,
    /// Most probes of a session, 1 to 16777216. Default 1048576.
    pub max_probes: u32,
    /// Most objects (meshes, textures, materials, instances, lights, grids) of a session, 1 to
    /// 10000000. Default 200000.
    pub max_objects: u32,
    /// Most triangles of all instances of a session, 1 to 1000000000. Default 20000000.
    pub max_triangles: u32,
    /// Most memory for kept rays of a session in MiB, 1 to 1048576. Default 512.
    pub ray_memory_mib: u32,
    /// Most memory of one mesh or image in MiB, 1 to 65536. Default 256.
    pub blob_mib: u32,
    /// Most memory of the meshes and images of a session in MiB, 1 to 1048576. Default 1024.
    pub session_blob_mib: u32,
    /// Memory of meshes and images that no session uses but a client may come back with, in MiB, 0
    /// to 1048576. Default 256.
    pub unused_blob_mib: u32,
    /// How long a session is kept whose client has lost its connection, in seconds, 0 to 86400.
    /// Default 60.
    pub resume_seconds: u32,
    /// How long a new connection may take to say who it is, in seconds, 1 to 60. Default 5.
    pub hello_seconds: u32,
}

impl Default for ServerSettings {
    fn default() -> Self {
        let limits = Limits::default();
        Self {
            listen: SocketAddr::new(IpAddr::V6(Ipv6Addr::UNSPECIFIED), 4433),
            public_host: String::new(),
            state: PathBuf::new(),
            max_sessions: 8,
            threads: 0,
            max_page_size: 4096,
            max_pages: 64,
            max_texels: limits.texels as u32,
            max_probes: limits.probes as u32,
            max_objects: limits.objects as u32,
            max_triangles: limits.triangles as u32,
            ray_memory_mib: 512,
            blob_mib: mebibytes(limits.blob_bytes),
            session_blob_mib: mebibytes(limits.session_blob_bytes),
            unused_blob_mib: 256,
            resume_seconds: 60,
            hello_seconds: 5,
        }
    }
}

impl ServerSettings {
    /// Checks every range.
    ///
    /// # Errors
    /// The first field that is out of its range.
    pub fn validate(&self) -> Result<(), SettingsError> {
        let check = SettingsError::check;
        check(
            self.public_host.is_empty() || Invitation::is_host(&self.public_host),
            "public_host",
            &format_args!("{:?}", self.public_host),
            "a name or an address, without port and brackets",
        )?;
        check(
            self.max_page_size.is_power_of_two() && (16..=4096).contains(&self.max_page_size),
            "max_page_size",
            &self.max_page_size,
            "a power of two from 16 to 4096 (texels)",
        )?;
        let ranges: [(&'static str, u32, u32, u32, &'static str); 13] = [
            ("max_sessions", self.max_sessions, 1, 1024, "1 to 1024"),
            ("threads", self.threads, 0, 1024, "0 to 1024"),
            ("max_pages", self.max_pages, 1, 64, "1 to 64"),
            ("max_texels", self.max_texels, 256, 1 << 30, "256 to 1073741824"),
            ("max_probes", self.max_probes, 1, 1 << 24, "1 to 16777216"),
            ("max_objects", self.max_objects, 1, 10_000_000, "1 to 10000000"),
            ("max_triangles", self.max_triangles, 1, 1_000_000_000, "1 to 1000000000"),
            ("ray_memory_mib", self.ray_memory_mib, 1, 1 << 20, "1 to 1048576 (MiB)"),
            ("blob_mib", self.blob_mib, 1, 1 << 16, "1 to 65536 (MiB)"),
            ("session_blob_mib", self.session_blob_mib, 1, 1 << 20, "1 to 1048576 (MiB)"),
            ("unused_blob_mib", self.unused_blob_mib, 0, 1 << 20, "0 to 1048576 (MiB)"),
            ("resume_seconds", self.resume_seconds, 0, 86_400, "0 to 86400 (seconds)"),
            ("hello_seconds", self.hello_seconds, 1, 60, "1 to 60 (seconds)"),
        ];
        for (field, value, least, most, expected) in ranges {
            check((least..=most).contains(&value), field, &value, expected)?;
        }
        Ok(())
    }

    /// What sessions take from their clients at most.
    #[must_use]
    pub fn limits(&self) -> Limits {
        Limits {
            blob_bytes: bytes(self.blob_mib),
            session_blob_bytes: bytes(self.session_blob_mib),
            objects: self.max_objects as usize,
            triangles: self.max_triangles as usize,
            texels: self.max_texels as usize,
            probes: self.max_probes as usize,
            ..Limits::default()
        }
    }

    /// Bytes of meshes and images that are kept although no session uses them.
    #[must_use]
    pub fn unused_blob_bytes(&self) -> usize {
        bytes(self.unused_blob_mib)
    }

    pub(crate) fn resume_time(&self) -> Duration {
        Duration::from_secs(self.resume_seconds.into())
    }

    pub(crate) fn hello_time(&self) -> Duration {
        Duration::from_secs(self.hello_seconds.into())
    }
}

pub(crate) fn bytes(mebibytes: u32) -> usize {
    (mebibytes as usize).saturating_mul(1 << 20)
}

fn mebibytes(bytes: usize) -> u32 {
    u32::try_from(bytes >> 20).unwrap_or(u32::MAX)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn defaults_are_valid_and_are_those_of_the_wire() {
        let settings = ServerSettings::default();
        assert_eq!(settings.validate(), Ok(()));
        assert_eq!(settings.limits(), Limits::default());
        assert!(settings.listen.ip().is_unspecified());
    }

    #[test]
    fn files_may_leave_fields_out_but_not_invent_any() {
        let settings: ServerSettings =
            ron::from_str("ServerSettings(listen: \"127.0.0.1:0\", max_sessions: 3)").unwrap();
        assert_eq!((settings.listen.port(), settings.max_sessions), (0, 3));
        assert_eq!(settings.resume_seconds, ServerSettings::default().resume_seconds);
        let error = ron::from_str::<ServerSettings>("ServerSettings(\n  max_session: 4\n)");
        let error = error.unwrap_err();
        assert!(error.to_string().contains("max_session"), "{error}");
        assert_eq!(error.span.start.line, 2);
        let text = ron::to_string(&settings).unwrap();
        assert_eq!(ron::from_str::<ServerSettings>(&text), Ok(settings));
    }

    #[test]
    fn ranges_are_checked_and_errors_name_the_field() {
        let bad = |change: fn(&mut ServerSettings)| {
            let mut settings = ServerSettings::default();
            change(&mut settings);
            settings.validate().unwrap_err().field
        };
        assert_eq!(bad(|s| s.public_host = "a b".into()), "public_host");
        assert_eq!(bad(|s| s.max_sessions = 0), "max_sessions");
        assert_eq!(bad(|s| s.threads = 5000), "threads");
        assert_eq!(bad(|s| s.max_page_size = 500), "max_page_size");
        assert_eq!(bad(|s| s.max_page_size = 8192), "max_page_size");
        assert_eq!(bad(|s| s.max_pages = 0), "max_pages");
        assert_eq!(bad(|s| s.max_texels = 0), "max_texels");
        assert_eq!(bad(|s| s.max_probes = 0), "max_probes");
        assert_eq!(bad(|s| s.max_objects = 0), "max_objects");
        assert_eq!(bad(|s| s.max_triangles = 0), "max_triangles");
        assert_eq!(bad(|s| s.ray_memory_mib = 0), "ray_memory_mib");
        assert_eq!(bad(|s| s.blob_mib = 0), "blob_mib");
        assert_eq!(bad(|s| s.session_blob_mib = 0), "session_blob_mib");
        assert_eq!(bad(|s| s.unused_blob_mib = u32::MAX), "unused_blob_mib");
        assert_eq!(bad(|s| s.resume_seconds = u32::MAX), "resume_seconds");
        assert_eq!(bad(|s| s.hello_seconds = 0), "hello_seconds");
        let error = ServerSettings { hello_seconds: 0, ..ServerSettings::default() };
        let error = error.validate().unwrap_err().to_string();
        assert_eq!(error, "hello_seconds is 0, must be 1 to 60 (seconds)");
    }
}
