//! `--watch`.

use std::{
    fs,
    io::{BufRead, BufReader},
    process::{Child, Command, Stdio},
    sync::mpsc::{Receiver, channel},
    time::Duration,
};

use crate::{
    folder::{SCENE, checked, command},
    support::Folder,
};

/// Machines may be busy.
const PATIENCE: Duration = Duration::from_secs(120);

/// A running command, and its lines.
struct Watching {
    child: Child,
    lines: Receiver<String>,
}

impl Watching {
    fn start(mut command: Command) -> Self {
        let mut child = command.stdout(Stdio::piped()).stderr(Stdio::piped()).spawn().unwrap();
        let (send, lines) = channel();
        let (out, err) = (child.stdout.take().unwrap(), child.stderr.take().unwrap());
        let also = send.clone();
        std::thread::spawn(move || {
            BufReader::new(out).lines().map_while(Result::ok).try_for_each(|line| send.send(line))
        });
        std::thread::spawn(move || {
            BufReader::new(err).lines().map_while(Result::ok).try_for_each(|line| also.send(line))
        });
        Self { child, lines }
    }

    /// Waits for a line with this text.
    #[track_caller]
    fn hear(&self, text: &str) -> String {
        loop {
            let line = self.lines.recv_timeout(PATIENCE).unwrap();
            if line.contains(text) {
                return line;
            }
        }
    }
}

impl Drop for Watching {
    fn drop(&mut self) {
        let _ = self.child.kill();
        let _ = self.child.wait();
    }
}

#[test]
fn bakes_again_when_files_change() {
    let folder = Folder::new("bake-watch");
    let (out, scene) = (folder.at("out"), folder.at("TwoRooms.glb"));
    fs::copy(SCENE, &scene).unwrap();
    let file = |text: &str| folder.write("rooms.lights.ron", text);
    let with = |name: &str, intensity: u32| {
        format!(
            "BakeLights(add: [(name: \"{name}\", position: (7, 2, 2), intensity: ({intensity}, 1, 1))])"
        )
    };
    let lights = file(&with("lamp", 5));
    let more = [
        "--size",
        "64",
        "--samples",
        "2",
        "--no-probes",
        "--watch",
        "--lights",
        lights.to_str().unwrap(),
    ];
    let mut watching = Watching::start(command(scene.to_str().unwrap(), &out, &more));
    watching.hear("11 primitives");
    let intensity = || checked(&out).unwrap().scenarios[0].lights[1].intensity[0];
    assert_eq!(intensity(), 5.0);

    file(&with("lamp", 10));
    watching.hear("11 primitives");
    assert_eq!(intensity(), 10.0);
    // After an error the last good result stays, and so does the command.
    file("BakeLights(add: [(nam: 3)])");
    let error = watching.hear("error: ");
    assert!(error.contains("rooms.lights.ron:1:"), "{error}");
    assert_eq!(intensity(), 10.0);
    file(&with("lamp", 20));
    watching.hear("11 primitives");
    assert_eq!(intensity(), 20.0);
    // A scene that is being replaced is gone for a moment.
    fs::remove_file(&scene).unwrap();
    watching.hear("error: ");
    fs::copy(SCENE, &scene).unwrap();
    watching.hear("nothing changed");
    #[cfg(unix)]
    {
        let id = watching.child.id().to_string();
        assert!(Command::new("kill").args(["-INT", &id]).status().unwrap().success());
        assert!(watching.child.wait().unwrap().success());
    }
}
