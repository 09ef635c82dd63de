//! Which system this is, and what to tell its user.

use super::needs::Need;
use crate::process;

/// Systems that name their packages alike.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Family {
    /// Debian, Ubuntu and relatives: apt.
    Debian,
    /// Fedora, RHEL and relatives: dnf.
    Fedora,
    /// Arch and relatives: pacman.
    Arch,
    /// A Linux that we know no package names for.
    Unknown,
    /// macOS, Windows and others, whose system comes with what is needed.
    Other,
}

/// The system's family and its name for people.
#[derive(Debug, PartialEq, Eq)]
pub(super) struct System {
    pub(super) family: Family,
    pub(super) name: String,
}

impl System {
    /// This machine.
    pub(super) fn look() -> Self {
        if !cfg!(target_os = "linux") {
            return Self { family: Family::Other, name: std::env::consts::OS.to_owned() };
        }
        let files = ["/etc/os-release", "/usr/lib/os-release"];
        let text = files.iter().find_map(|file| std::fs::read_to_string(file).ok());
        let mut system = Self::from_os_release(&text.unwrap_or_default());
        if system.family == Family::Debian && !process::is_on_path("apt-get") {
            system.family = Family::Unknown;
        }
        system
    }

    /// Reads the text of `/etc/os-release` (freedesktop.org, os-release(5)): `ID` decides, then the
    /// relatives in `ID_LIKE`.
    fn from_os_release(text: &str) -> Self {
        let value = |key: &str| {
            text.lines()
                .filter_map(|line| line.trim().split_once('='))
                .find(|(name, _)| *name == key)
                .map(|(_, value)| value.trim_matches(['"', '\'']).to_owned())
        };
        let id = value("ID").unwrap_or_default();
        let like = value("ID_LIKE").unwrap_or_default();
        let family = std::iter::once(id.as_str())
            .chain(like.split_whitespace())
            .find_map(|id| match id {
                "debian" | "ubuntu" => Some(Family::Debian),
                "fedora" | "rhel" | "centos" => Some(Family::Fedora),
                "arch" => Some(Family::Arch),
                _ => None,
            })
            .unwrap_or(Family::Unknown);
        let name = value("PRETTY_NAME").unwrap_or_else(|| "a Linux without os-release".to_owned());
        Self { family, name }
    }

    /// Where nothing is looked for: what Rust and the renderer want there.
    pub(super) fn note(&self) -> Option<&'static str> {
        match (self.family, self.name.as_str()) {
            (Family::Other, "macos") => Some(
                "macOS comes with Metal; a compiler is in Xcode's command line tools \
                 (xcode-select --install).",
            ),
            (Family::Other, "windows") => Some(
                "Windows comes with DirectX 12; a compiler is in the Visual Studio Build Tools \
                 (\"Desktop development with C++\").",
            ),
            (Family::Other, _) => Some("This system is not known here: nothing was looked for."),
            _ => None,
        }
    }

    /// What to type here, where we do not install ourselves.
    pub(super) fn advice(&self, missing: &[Need]) -> String {
        let mut packages: Vec<&str> =
            missing.iter().map(|need| need.package(self.family)).collect();
        packages.dedup();
        let packages = packages.join(" ");
        match self.family {
            Family::Fedora => format!("Install them with: sudo dnf install {packages}"),
            Family::Arch => format!("Install them with: sudo pacman -S --needed {packages}"),
            _ => format!("Install what Debian calls: {packages}"),
        }
    }
}

#[cfg(test)]
mod tests {
    use super::super::needs;
    use super::*;

    fn family(text: &str) -> Family {
        System::from_os_release(text).family
    }

    #[test]
    fn distributions_and_their_relatives() {
        assert_eq!(family("PRETTY_NAME=\"Debian GNU/Linux 12\"\nID=debian\n"), Family::Debian);
        assert_eq!(family("ID=ubuntu\nID_LIKE=debian\n"), Family::Debian);
        assert_eq!(family("ID=linuxmint\nID_LIKE=\"ubuntu debian\"\n"), Family::Debian);
        assert_eq!(family("ID='fedora'\n"), Family::Fedora);
        assert_eq!(family("ID=\"rocky\"\nID_LIKE=\"rhel centos fedora\"\n"), Family::Fedora);
        assert_eq!(family("ID=manjaro\nID_LIKE=arch\n"), Family::Arch);
        assert_eq!(family("ID=nixos\n"), Family::Unknown);
        assert_eq!(family(""), Family::Unknown);
        assert_eq!(family("VERSION_ID=12\nID_LIKE_NOT=debian\n"), Family::Unknown);
    }

    #[test]
    fn the_name_is_the_pretty_one() {
        let system = System::from_os_release("ID=debian\nPRETTY_NAME=\"Debian GNU/Linux 12\"\n");
        assert_eq!(system.name, "Debian GNU/Linux 12");
    }

    #[test]
    fn systems_without_packages_get_a_note() {
        let note = |family, name: &str| System { family, name: name.to_owned() }.note();
        assert!(note(Family::Other, "macos").is_some_and(|text| text.contains("Xcode")));
        assert!(note(Family::Other, "windows").is_some_and(|text| text.contains("Visual Studio")));
        assert!(note(Family::Other, "freebsd").is_some());
        assert!(note(Family::Debian, "Debian").is_none());
    }

    #[test]
    fn advice_uses_the_system_s_own_tool() {
        let needs = needs::all();
        let advice = |family| System { family, name: String::new() }.advice(&needs);
        assert!(advice(Family::Fedora).contains("dnf install gcc-c++"));
        assert!(advice(Family::Arch).contains("pacman -S --needed base-devel"));
        assert!(advice(Family::Unknown).contains("libvulkan1"));
    }
}
