//! Installing on Debian, Ubuntu and their relatives.

use std::io::{BufRead as _, BufReader, IsTerminal as _};
use std::path::Path;
use std::process::{Command, Stdio};

use super::distribution::Family;
use super::needs::Need;
use crate::process;

/// Where apt keeps the lists of what it can install.
const LISTS: &str = "/var/lib/apt/lists";

/// Installs the packages, with fresh lists where there are none or where the old ones do not do.
pub(super) fn install(needs: &[Need]) -> Result<(), String> {
    let Some(access) = Access::look() else {
        return Err("Installing needs root, and there is no sudo.".to_owned());
    };
    let mut arguments = vec!["install", "--yes", "--no-install-recommends"];
    arguments.extend(packages(needs));
    if !has_lists(Path::new(LISTS)) {
        apt_get(access, &["update"])?;
        return apt_get(access, &arguments);
    }
    let Err(first) = apt_get(access, &arguments) else {
        return Ok(());
    };
    // Old lists name versions that the server no longer has.
    println!("{first}\nOnce more with fresh package lists.");
    apt_get(access, &["update"])?;
    apt_get(access, &arguments)
}

/// The line for someone who installs them by hand.
pub(super) fn by_hand(needs: &[Need]) -> String {
    format!("sudo apt-get install {}", packages(needs).join(" "))
}

fn packages(needs: &[Need]) -> Vec<&'static str> {
    let mut packages: Vec<_> = needs.iter().map(|need| need.package(Family::Debian)).collect();
    packages.dedup();
    packages
}

/// How we become root.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum Access {
    Root,
    /// With a terminal sudo may ask for the password; without one it must not wait for it.
    Sudo {
        may_ask: bool,
    },
}

impl Access {
    fn look() -> Option<Self> {
        // `id -u` is the one way to ask that needs no unsafe code.
        if process::output("id", &["-u"]).is_some_and(|id| id.trim() == "0") {
            return Some(Self::Root);
        }
        let may_ask = std::io::stdin().is_terminal();
        process::is_on_path("sudo").then_some(Self::Sudo { may_ask })
    }

    /// `apt-get` with everything that keeps it from asking, and from giving up on the first hiccup.
    fn command(self, arguments: &[&str]) -> Command {
        // sudo drops the environment, hence `env` behind it.
        let mut words = match self {
            Self::Root => vec![],
            Self::Sudo { may_ask: true } => vec!["sudo"],
            Self::Sudo { may_ask: false } => vec!["sudo", "-n"],
        };
        words.extend(["env", "DEBIAN_FRONTEND=noninteractive", "LC_ALL=C", "apt-get", "--quiet"]);
        words.extend(["-o", "DPkg::Lock::Timeout=300", "-o", "Acquire::Retries=3"]);
        words.extend(arguments);
        let mut command = Command::new(words[0]);
        command.args(&words[1..]);
        command
    }
}

/// Runs apt-get; what it sets up is shown, the rest only if it fails.
fn apt_get(access: Access, arguments: &[&str]) -> Result<(), String> {
    let mut command = access.command(arguments);
    println!("$ {}", process::shown(&command));
    process::flush();
    command.stdin(Stdio::null()).stdout(Stdio::piped()).stderr(Stdio::piped());
    let mut child = command.spawn().map_err(|error| format!("apt-get: {error}."))?;
    let errors = child.stderr.take().map(|stream| {
        std::thread::spawn(move || {
            BufReader::new(stream).lines().map_while(Result::ok).collect::<Vec<_>>()
        })
    });
    let mut said = Vec::new();
    if let Some(stream) = child.stdout.take() {
        for line in BufReader::new(stream).lines().map_while(Result::ok) {
            if line.starts_with("Setting up ") {
                println!("  {line}");
                process::flush();
            }
            said.push(line);
        }
    }
    if let Some(errors) = errors {
        said.extend(errors.join().unwrap_or_default());
    }
    let status = child.wait().map_err(|error| format!("apt-get: {error}."))?;
    // `update` exits with 0 even if every server was out of reach.
    let unreachable = arguments == ["update"] && said.iter().any(|line| line.starts_with("Err:"));
    if status.success() && !unreachable {
        return Ok(());
    }
    for line in said.iter().filter(|line| line.starts_with(['E', 'W'])).take(6) {
        println!("  {line}");
    }
    Err(explain(&said.join("\n")).to_owned())
}

/// What apt's own words mean for the person who only wanted to run the demo.
fn explain(said: &str) -> &'static str {
    let has = |words: &[&str]| words.iter().any(|word| said.contains(word));
    if has(&["Could not get lock", "Unable to acquire the dpkg"]) {
        "Another program is installing packages and did not finish within five minutes."
    } else if has(&["a password is required", "is not in the sudoers", "a terminal is required"]) {
        "sudo needs a password and there is no terminal to ask for it."
    } else if has(&[
        "Temporary failure resolving",
        "Could not resolve",
        "Could not connect",
        "Connection failed",
        "Network is unreachable",
        "Failed to fetch",
    ]) {
        "The package servers cannot be reached: is there a network?"
    } else if has(&["Unable to locate package", "has no installation candidate"]) {
        "This release of the system does not have all of these packages."
    } else if has(&["No space left", "enough free space"]) {
        "The disk is full."
    } else {
        "apt-get failed."
    }
}

/// Whether apt has any package list (a fresh container has none).
fn has_lists(folder: &Path) -> bool {
    std::fs::read_dir(folder).into_iter().flatten().flatten().any(|entry| {
        let name = entry.file_name();
        name.to_string_lossy().contains("_Packages")
    })
}

#[cfg(test)]
mod tests {
    use super::super::needs;
    use super::*;

    #[test]
    fn sudo_stands_before_env_and_never_waits_without_a_terminal() {
        let shown = |access: Access| process::shown(&access.command(&["install", "--yes", "x"]));
        let root = shown(Access::Root);
        assert!(root.starts_with("env DEBIAN_FRONTEND=noninteractive LC_ALL=C apt-get"), "{root}");
        assert!(root.ends_with("install --yes x"));
        assert!(shown(Access::Sudo { may_ask: true }).starts_with("sudo env DEBIAN"));
        assert!(shown(Access::Sudo { may_ask: false }).starts_with("sudo -n env DEBIAN"));
    }

    #[test]
    fn failures_are_explained() {
        let explained = |said, word: &str| explain(said).contains(word);
        assert!(explained("E: Could not get lock /var/lib/dpkg/lock-frontend", "Another program"));
        assert!(explained("Err:1 Temporary failure resolving 'deb.debian.org'", "network"));
        assert!(explained("E: Unable to locate package libfoo", "does not have"));
        assert!(explained("sudo: a password is required", "password"));
        assert!(explained("E: something new", "apt-get failed"));
    }

    #[test]
    fn lists_are_seen() {
        let folder = std::env::temp_dir().join(format!("xtask-lists-{}", std::process::id()));
        std::fs::create_dir_all(&folder).unwrap();
        assert!(!has_lists(&folder), "an empty folder");
        std::fs::write(folder.join("deb.debian.org_main_binary-amd64_Packages.lz4"), "").unwrap();
        assert!(has_lists(&folder));
        std::fs::remove_dir_all(&folder).unwrap();
        assert!(!has_lists(&folder), "no folder");
    }

    #[test]
    fn the_line_to_type_names_each_package_once() {
        let line = by_hand(&needs::all());
        assert!(line.starts_with("sudo apt-get install build-essential "), "{line}");
        assert_eq!(line.matches("libvulkan1").count(), 1);
    }
}
