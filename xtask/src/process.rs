//! Starting programs: argument vectors only, what runs is printed, and a failure names the program.

use std::ffi::OsStr;
use std::io::{BufRead, BufReader, Write};
use std::path::{Path, PathBuf};
use std::process::{Command, Stdio};

use crate::Failure;

/// The workspace's root. The variable that cargo sets at run time wins over the path that was
/// compiled in: checkouts that share a build folder also share the file `xtask`.
pub(crate) fn root() -> PathBuf {
    let xtask = std::env::var_os("CARGO_MANIFEST_DIR")
        .map_or_else(|| PathBuf::from(env!("CARGO_MANIFEST_DIR")), PathBuf::from);
    xtask.parent().map_or_else(|| PathBuf::from("."), Path::to_path_buf)
}

/// `cargo`, the one that started us, in the workspace's root, without the variables that it set
/// for us alone (a build script could take them for its own).
pub(crate) fn cargo() -> Command {
    let mut command = Command::new(std::env::var_os("CARGO").unwrap_or_else(|| "cargo".into()));
    command.current_dir(root());
    for (name, _) in std::env::vars_os() {
        if is_ours_alone(&name) {
            command.env_remove(name);
        }
    }
    command
}

fn is_ours_alone(name: &OsStr) -> bool {
    let name = name.to_string_lossy();
    name.starts_with("CARGO_PKG_") || name.starts_with("CARGO_MANIFEST_") || name == "OUT_DIR"
}

/// The command as one would type it.
pub(crate) fn shown(command: &Command) -> String {
    let program = Path::new(command.get_program()).file_stem().unwrap_or(command.get_program());
    let mut line = program.to_string_lossy().into_owned();
    for argument in command.get_args() {
        let argument = argument.to_string_lossy();
        line.push(' ');
        if argument.is_empty() || argument.contains(char::is_whitespace) {
            line.push_str(&format!("'{argument}'"));
        } else {
            line.push_str(&argument);
        }
    }
    line
}

/// Prints the command, runs it, and fails unless it exits with 0.
pub(crate) fn run(command: &mut Command) -> Result<(), Failure> {
    println!("$ {}", shown(command));
    flush();
    match command.status() {
        Ok(status) if status.success() => Ok(()),
        Ok(status) => Err(format!("`{}` failed ({status}).", shown(command))),
        Err(error) => Err(format!("`{}` could not be started: {error}.", shown(command))),
    }
}

/// Prints the command and runs it; every line of its standard output goes to `line`. Its standard
/// error stays the terminal's. Returns whether it exited with 0.
pub(crate) fn run_by_line(
    command: &mut Command,
    mut line: impl FnMut(&str),
) -> Result<bool, Failure> {
    println!("$ {}", shown(command));
    flush();
    let failed = |command: &Command, error| format!("`{}`: {error}.", shown(command));
    let mut child =
        command.stdout(Stdio::piped()).spawn().map_err(|error| failed(command, error))?;
    if let Some(output) = child.stdout.take() {
        let mut output = BufReader::new(output);
        let mut bytes = Vec::new();
        // By bytes, since a test may print what is not UTF-8.
        while output.read_until(b'\n', &mut bytes).map_err(|error| failed(command, error))? > 0 {
            line(String::from_utf8_lossy(&bytes).trim_end_matches(['\n', '\r']));
            bytes.clear();
        }
    }
    child.wait().map(|status| status.success()).map_err(|error| failed(command, error))
}

/// Runs quietly and returns the standard output, or nothing where the program is missing or fails.
pub(crate) fn output(program: &str, arguments: &[&str]) -> Option<String> {
    let output =
        Command::new(program).args(arguments).stdin(Stdio::null()).stderr(Stdio::null()).output();
    let output = output.ok().filter(|output| output.status.success())?;
    Some(String::from_utf8_lossy(&output.stdout).into_owned())
}

/// Whether `program` is a file in one of the folders of `PATH`.
pub(crate) fn is_on_path(program: &str) -> bool {
    let Some(path) = std::env::var_os("PATH") else {
        return false;
    };
    let name = format!("{program}{}", std::env::consts::EXE_SUFFIX);
    std::env::split_paths(&path).any(|folder| folder.join(&name).is_file())
}

/// Ours is a pipe as often as a terminal, and a child writes to the same one.
pub(crate) fn flush() {
    // A closed pipe is no reason to stop the work.
    let _ = std::io::stdout().flush();
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_command_is_shown_as_typed() {
        let mut command = Command::new("/usr/bin/cargo");
        command.args(["run", "--", "two words", ""]);
        assert_eq!(shown(&command), "cargo run -- 'two words' ''");
    }

    #[test]
    fn only_variables_about_this_package_are_hidden_from_cargo() {
        assert!(is_ours_alone(OsStr::new("CARGO_PKG_NAME")));
        assert!(is_ours_alone(OsStr::new("CARGO_MANIFEST_DIR")));
        assert!(!is_ours_alone(OsStr::new("CARGO_TARGET_DIR")));
        assert!(!is_ours_alone(OsStr::new("CARGO_HOME")));
    }

    #[test]
    fn a_missing_program_is_an_error_with_its_name() {
        let failure = run(&mut Command::new("no-such-program-on-any-machine")).unwrap_err();
        assert!(failure.contains("no-such-program-on-any-machine"), "{failure}");
        assert!(!is_on_path("no-such-program-on-any-machine"));
    }

    #[test]
    fn lines_and_exit_status_come_back() {
        let mut lines = Vec::new();
        let mut command = Command::new(std::env::var_os("CARGO").unwrap_or("cargo".into()));
        assert_eq!(
            run_by_line(command.arg("--version"), |line| lines.push(line.to_owned())),
            Ok(true)
        );
        assert!(lines[0].starts_with("cargo "), "{lines:?}");
    }
}
