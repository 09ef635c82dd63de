//! The environment in which tests and headless renders run.

use std::path::{Path, PathBuf};
use std::process::Command;

use crate::process;
use crate::setup::probe;

/// The variable that names the folder with scenes and references too large for the repository.
const TEST_DATA: &str = "FARLIGHT_TEST_DATA";

/// Sets what a headless render needs, and leaves alone what the user has set.
pub(crate) fn for_headless(command: &mut Command) {
    // Without a GPU, Mesa's Vulkan driver for the CPU is the one that renders correctly; wgpu would
    // otherwise also try GL.
    if cfg!(target_os = "linux")
        && !probe::Machine::look().has_gpu()
        && std::env::var_os("WGPU_BACKEND").is_none()
    {
        command.env("WGPU_BACKEND", "vulkan");
    }
    for_any_render(command);
}

/// Sets what every render needs.
pub(crate) fn for_any_render(command: &mut Command) {
    // Drivers and window libraries complain on every start where there is no such folder, as in a
    // container; any private folder will do.
    if cfg!(unix) && std::env::var_os("XDG_RUNTIME_DIR").is_none() {
        let folder = target_dir().join("xdg-runtime");
        if make_private(&folder).is_ok() {
            command.env("XDG_RUNTIME_DIR", folder);
        }
    }
}

#[cfg(unix)]
fn make_private(folder: &Path) -> std::io::Result<()> {
    use std::os::unix::fs::PermissionsExt as _;
    std::fs::create_dir_all(folder)?;
    std::fs::set_permissions(folder, std::fs::Permissions::from_mode(0o700))
}

#[cfg(not(unix))]
fn make_private(folder: &Path) -> std::io::Result<()> {
    std::fs::create_dir_all(folder)
}

/// Where cargo builds: what the environment says, else `target/`.
pub(crate) fn target_dir() -> PathBuf {
    let root = process::root();
    std::env::var_os("CARGO_TARGET_DIR")
        .map_or_else(|| root.join("target"), |folder| root.join(folder))
}

/// The folder with the large test data, if the variable names one.
pub(crate) fn test_data() -> Option<PathBuf> {
    std::env::var_os(TEST_DATA).map(PathBuf::from).filter(|folder| folder.is_dir())
}

/// One line on the large test data: where it is, or that tests will skip what needs it.
pub(crate) fn test_data_line() -> String {
    match (test_data(), std::env::var_os(TEST_DATA)) {
        (Some(folder), _) => format!("{TEST_DATA} is {}", folder.display()),
        (None, Some(name)) => format!("{TEST_DATA} is {}, which is no folder", name.display()),
        (None, None) => format!("{TEST_DATA} is not set: what needs it is skipped and says so"),
    }
}
