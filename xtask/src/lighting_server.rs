//! `farlight serve` as a process of its own, for as long as somebody needs it.

use std::fs::{self, File};
use std::path::{Path, PathBuf};
use std::process::{Child, Command, Stdio};
use std::time::{Duration, Instant};

use crate::{Failure, process};

/// How long a server may take until it has written its invitation.
const PATIENCE: Duration = Duration::from_secs(30);
/// Lines of its log that are repeated when it ends too early.
const LAST_LINES: usize = 12;

/// A lighting server on this machine. It is stopped when this is dropped.
pub(crate) struct LightingServer {
    child: Child,
    invitation: PathBuf,
    log: PathBuf,
}

impl LightingServer {
    /// Starts one that only this machine reaches, on any free port, and waits for its invitation.
    /// Its identity and its log are kept in `folder`.
    pub(crate) fn start(program: &Path, folder: &Path) -> Result<Self, Failure> {
        let failed = |what: &Path, error| format!("{}: {error}.", what.display());
        fs::create_dir_all(folder).map_err(|error| failed(folder, error))?;
        // Two demos at once share the identity, nothing else.
        let own = |name: &str| folder.join(format!("{}.{name}", std::process::id()));
        let (invitation, log) = (own("invitation"), own("log"));
        remove(&invitation);
        let errors = File::create(&log).map_err(|error| failed(&log, error))?;
        let mut command = Command::new(program);
        command.args(["serve", "--listen", "127.0.0.1:0", "--state"]).arg(folder.join("state"));
        command.arg("--invite-file").arg(&invitation);
        // Its standard output is the invitation again.
        command.stdin(Stdio::null()).stdout(Stdio::null()).stderr(errors);
        println!("$ {}", process::shown(&command));
        process::flush();
        let child =
            command.spawn().map_err(|error| format!("`{}`: {error}.", process::shown(&command)))?;
        let mut server = Self { child, invitation, log };
        server.wait(PATIENCE)?;
        Ok(server)
    }

    /// The file with its invitation.
    pub(crate) fn invitation(&self) -> &Path {
        &self.invitation
    }

    /// Fails if it has ended.
    pub(crate) fn check(&mut self) -> Result<(), Failure> {
        match self.child.try_wait() {
            Ok(None) => Ok(()),
            Ok(Some(status)) => Err(self.failure(&format!("ended ({status})"))),
            Err(error) => Err(self.failure(&format!("can't be watched: {error}"))),
        }
    }

    fn wait(&mut self, patience: Duration) -> Result<(), Failure> {
        let start = Instant::now();
        loop {
            // Looked at first: the last thing that a server does may be to write it.
            let written = fs::read_to_string(&self.invitation);
            if written.is_ok_and(|text| text.starts_with("farlight://") && text.contains("/#")) {
                return Ok(());
            }
            self.check()?;
            if start.elapsed() > patience {
                return Err(self.failure(&format!("gave no invitation within {patience:?}")));
            }
            std::thread::sleep(Duration::from_millis(20));
        }
    }

    fn failure(&self, what: &str) -> Failure {
        let log = fs::read_to_string(&self.log).unwrap_or_default();
        let lines: Vec<&str> = log.lines().collect();
        let last = &lines[lines.len().saturating_sub(LAST_LINES)..];
        match last {
            [] => format!("the lighting server {what}, without a word."),
            lines => format!("the lighting server {what}. Its last lines:\n{}", lines.join("\n")),
        }
    }
}

impl Drop for LightingServer {
    fn drop(&mut self) {
        // Nothing of it is lost: it keeps no results.
        let _ = self.child.kill();
        let _ = self.child.wait();
        remove(&self.invitation);
        let kept = self.log.with_file_name("last.log");
        let _ = fs::rename(&self.log, kept);
    }
}

/// A file that is not there need not be removed.
fn remove(path: &Path) {
    let _ = fs::remove_file(path);
}

#[cfg(test)]
mod tests {
    use super::*;

    fn folder(name: &str) -> PathBuf {
        let folder = std::env::temp_dir().join(format!("farlight-{name}-{}", std::process::id()));
        fs::create_dir_all(&folder).unwrap();
        folder
    }

    /// cargo refuses `serve` as a server refuses a wrong configuration: with words, at once.
    #[test]
    fn a_server_that_ends_is_reported_with_its_last_words() {
        let folder = folder("ends");
        let cargo = std::env::var_os("CARGO").unwrap_or_else(|| "cargo".into());
        let failure = LightingServer::start(Path::new(&cargo), &folder).err().unwrap();
        assert!(failure.contains("ended (") && failure.contains("serve"), "{failure}");
        let left: Vec<_> = fs::read_dir(&folder).unwrap().map(|f| f.unwrap().file_name()).collect();
        assert_eq!(left, ["last.log"]);
        let _ = fs::remove_dir_all(folder);
    }

    #[cfg(unix)]
    #[test]
    fn a_server_is_stopped_in_the_end_and_its_invitation_is_gone() {
        use std::os::unix::fs::PermissionsExt as _;
        let folder = folder("stops");
        let program = folder.join("server");
        // $7 is the file after --invite-file.
        fs::write(&program, "#!/bin/sh\necho 'farlight://h:1/#a.b' > \"$7\"\nexec sleep 600\n")
            .unwrap();
        fs::set_permissions(&program, fs::Permissions::from_mode(0o700)).unwrap();
        let mut server = LightingServer::start(&program, &folder).unwrap();
        assert_eq!(server.check(), Ok(()));
        let invitation = server.invitation().to_owned();
        assert!(invitation.exists());
        let id = server.child.id();
        drop(server);
        assert!(!invitation.exists());
        assert!(!Path::new(&format!("/proc/{id}")).exists());
        let _ = fs::remove_dir_all(folder);
    }
}
