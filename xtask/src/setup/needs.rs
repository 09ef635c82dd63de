//! The table of what is needed, for what, and how each is called where.

use super::distribution::Family;
use super::probe::Probe;
use crate::manifest;

/// What a command is about to do.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Purpose {
    /// Compile the workspace.
    Build,
    /// Render without a window.
    Render,
    /// Open a window.
    Window,
    /// Compare with peers in the benchmark.
    Bench,
}

/// One thing that must be there.
#[derive(Clone, Debug)]
pub(super) struct Need {
    pub(super) what: &'static str,
    pub(super) why: &'static str,
    pub(super) purpose: Purpose,
    pub(super) probe: Probe,
    /// Needed only while `Cargo.lock` names this package.
    locked: Option<&'static str>,
    pub(super) optional: bool,
    debian: &'static str,
    fedora: &'static str,
    arch: &'static str,
}

impl Need {
    /// Whether the workspace as locked has a use for it.
    pub(super) fn applies(&self, lockfile: &str) -> bool {
        self.locked.is_none_or(|package| manifest::locks(lockfile, package))
    }

    /// The package's name in a family of distributions; Debian's where there is none of its own.
    pub(super) fn package(&self, family: Family) -> &'static str {
        match family {
            Family::Fedora => self.fedora,
            Family::Arch => self.arch,
            Family::Debian | Family::Unknown | Family::Other => self.debian,
        }
    }
}

/// Everything that any command may need. Libraries that are loaded at run time are looked for
/// under the names that the crates use: ash for Vulkan, x11-dl, x11rb and xkbcommon-dl for windows.
pub(super) fn all() -> Vec<Need> {
    let need = |purpose, what, why, probe, [debian, fedora, arch]: [&'static str; 3]| Need {
        what,
        why,
        purpose,
        probe,
        locked: None,
        optional: false,
        debian,
        fedora,
        arch,
    };
    let library = |what, why, name, packages| {
        need(Purpose::Window, what, why, Probe::Library(name), packages)
    };
    let window = "winit loads it to open a window";
    vec![
        Need {
            locked: Some("cc"),
            ..need(
                Purpose::Build,
                "C and C++ compiler",
                "build scripts compile a little C and C++, and Rust links with it",
                Probe::Program("c++"),
                ["build-essential", "gcc-c++", "base-devel"],
            )
        },
        Need {
            locked: Some("libudev-sys"),
            ..need(
                Purpose::Build,
                "pkg-config",
                "finds the headers of libudev",
                Probe::Program("pkg-config"),
                ["pkg-config", "pkgconf-pkg-config", "pkgconf"],
            )
        },
        Need {
            locked: Some("libudev-sys"),
            ..need(
                Purpose::Build,
                "libudev with headers",
                "gamepads (gilrs) are found through it",
                Probe::PkgConfig("libudev"),
                ["libudev-dev", "systemd-devel", "systemd-libs"],
            )
        },
        need(
            Purpose::Render,
            "Vulkan loader",
            "wgpu renders through it",
            Probe::Library(&["libvulkan.so.1"]),
            ["libvulkan1", "vulkan-loader", "vulkan-icd-loader"],
        ),
        need(
            Purpose::Render,
            "Vulkan driver",
            "no GPU with a driver was found, and Mesa's lavapipe renders on the CPU",
            Probe::VulkanDriver,
            ["mesa-vulkan-drivers", "mesa-vulkan-drivers", "vulkan-swrast"],
        ),
        library("libX11", window, &["libX11.so.6"], ["libx11-6", "libX11", "libx11"]),
        library(
            "libX11-xcb",
            window,
            &["libX11-xcb.so.1"],
            ["libx11-xcb1", "libX11-xcb", "libx11"],
        ),
        library("libxcb", window, &["libxcb.so.1"], ["libxcb1", "libxcb", "libxcb"]),
        library(
            "libXcursor",
            "winit loads it for the pointer's shape",
            &["libXcursor.so.1"],
            ["libxcursor1", "libXcursor", "libxcursor"],
        ),
        library(
            "libXi",
            "winit loads it for the mouse",
            &["libXi.so.6"],
            ["libxi6", "libXi", "libxi"],
        ),
        library(
            "libxkbcommon",
            "winit loads it for the keyboard",
            &["libxkbcommon.so.0"],
            ["libxkbcommon0", "libxkbcommon", "libxkbcommon"],
        ),
        library(
            "libxkbcommon-x11",
            "winit loads it for the keyboard",
            &["libxkbcommon-x11.so.0"],
            ["libxkbcommon-x11-0", "libxkbcommon-x11", "libxkbcommon-x11"],
        ),
        Need {
            optional: true,
            ..need(
                Purpose::Bench,
                "Embree",
                "the benchmark prints our rays per second beside its",
                Probe::Library(&["libembree3.so", "libembree3.so.3", "libembree4.so.4"]),
                ["libembree-dev", "embree-devel", "embree"],
            )
        },
    ]
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn udev_is_needed_only_while_a_crate_wants_it() {
        let udev: Vec<_> =
            all().into_iter().filter(|need| need.locked == Some("libudev-sys")).collect();
        assert_eq!(udev.len(), 2);
        assert!(udev.iter().all(|need| !need.applies("name = \"winit\"")));
        assert!(udev.iter().all(|need| need.applies("name = \"libudev-sys\"")));
    }

    #[test]
    fn every_need_says_why_and_has_a_name_everywhere() {
        for need in all() {
            assert!(!need.why.is_empty() && !need.what.is_empty());
            for family in [Family::Debian, Family::Fedora, Family::Arch] {
                let package = need.package(family);
                assert!(!package.is_empty() && !package.contains(' '), "{need:?}");
            }
        }
    }

    #[test]
    fn only_peers_of_the_benchmark_are_optional() {
        assert!(all().iter().all(|need| need.optional == (need.purpose == Purpose::Bench)));
    }
}
