//! `farlight serve` as a process of its own.

use std::{
    fs,
    path::{Path, PathBuf},
    process::{Child, Command, Stdio},
    sync::OnceLock,
    time::{Duration, Instant},
};

/// Only a guard against hanging.
const PATIENCE: Duration = Duration::from_secs(60);

/// A running server; killed when dropped.
pub struct ServerProcess {
    child: Child,
    folder: PathBuf,
}

impl ServerProcess {
    /// Starts one with its identity in `folder`, listening on a port of loopback (0: any free one),
    /// and waits for its invitation.
    pub fn start(folder: &Path, port: u16) -> Self {
        let folder = folder.to_owned();
        fs::create_dir_all(&folder).unwrap();
        let _ = fs::remove_file(folder.join("invitation"));
        let log = fs::File::options().create(true).append(true).open(folder.join("log")).unwrap();
        let child = Command::new(program())
            .args(["serve", "--listen", &format!("127.0.0.1:{port}"), "--state"])
            .arg(folder.join("state"))
            .arg("--invite-file")
            .arg(folder.join("invitation"))
            .stdin(Stdio::null())
            .stdout(Stdio::null())
            .stderr(log)
            .spawn()
            .unwrap();
        let mut server = Self { child, folder };
        let start = Instant::now();
        while !server.folder.join("invitation").exists() {
            let ended = server.child.try_wait().unwrap();
            assert!(ended.is_none(), "the server ended ({ended:?}):\n{}", server.log());
            assert!(start.elapsed() < PATIENCE, "no invitation:\n{}", server.log());
            std::thread::sleep(Duration::from_millis(5));
        }
        server
    }

    /// Its invitation.
    pub fn invitation(&self) -> String {
        fs::read_to_string(self.folder.join("invitation")).unwrap().trim().to_owned()
    }

    /// What all servers in this folder have logged.
    pub fn log(&self) -> String {
        fs::read_to_string(self.folder.join("log")).unwrap_or_default()
    }

    /// Whether it still runs.
    pub fn is_running(&mut self) -> bool {
        self.child.try_wait().unwrap().is_none()
    }

    /// Ends it at once, without a word to anybody (SIGKILL on Unix).
    pub fn kill(mut self) {
        self.child.kill().unwrap();
        self.child.wait().unwrap();
    }
}

impl Drop for ServerProcess {
    fn drop(&mut self) {
        let _ = self.child.kill();
        let _ = self.child.wait();
    }
}

/// The built command `farlight`. `cargo test --workspace` builds it, since its own package has tests;
/// a narrower command may not, and then it is built here.
pub fn program() -> &'static Path {
    static PROGRAM: OnceLock<PathBuf> = OnceLock::new();
    PROGRAM.get_or_init(|| {
        let test = std::env::current_exe().unwrap();
        let folder = test.parent().and_then(Path::parent).unwrap();
        let program = folder.join(format!("farlight{}", std::env::consts::EXE_SUFFIX));
        if !program.exists() {
            // With an example, so that cargo chooses features as it does for tests.
            let mut cargo =
                Command::new(std::env::var_os("CARGO").unwrap_or_else(|| "cargo".into()));
            cargo.args(["build", "--workspace", "--bin", "farlight", "--example", "remote_room"]);
            if folder.file_name().is_some_and(|name| name == "release") {
                cargo.arg("--release");
            }
            let built = cargo.current_dir(env!("CARGO_MANIFEST_DIR")).status().unwrap();
            assert!(built.success() && program.exists(), "{} can't be built", program.display());
        }
        program
    })
}
