//! How a server is reached.

use std::{
    hash::{BuildHasher, RandomState},
    path::Path,
    str::FromStr,
    time::Duration,
};

use bevy::{asset::Asset, reflect::TypePath};
use farlight_core::{FieldProblem, RonError, RonSettings, parse_ron};
use farlight_wire::{ClientHello, Invitation, InvitationError};
use serde::{Deserialize, Serialize};

use crate::attempts::Retry;

/// How a lighting server is reached: a value, and an asset that `RemoteSettings(...)` in a RON file
/// holds (extension `remote.ron`).
///
/// A server prints an invitation when it starts, and writes it into a file if asked to; one of the
/// two is all that is needed.
#[derive(Asset, TypePath, Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(default, deny_unknown_fields)]
pub struct RemoteSettings {
    /// The invitation, `farlight://HOST:PORT/#TOKEN.SHA256`; empty if `invite_file` is used. It
    /// contains a secret: don't ship it.
    pub invite: String,
    /// A file that holds the invitation, as the server's `--invite-file` writes it; empty if
    /// `invite` is used. It may appear later: the game waits for it.
    pub invite_file: String,
    /// What the server's log calls this game, up to 64 characters.
    pub name: String,
    /// Least milliseconds between two attempts to connect, 20 to 60 000.
    pub retry_min_ms: u32,
    /// Most milliseconds between two attempts, at least `retry_min_ms`, at most 600 000. Waits grow
    /// from the one to the other while there is no connection.
    pub retry_max_ms: u32,
    /// Seed of the random part of these waits; 0 takes another one every time.
    pub seed: u64,
}

impl Default for RemoteSettings {
    fn default() -> Self {
        Self {
            invite: String::new(),
            invite_file: String::new(),
            name: "a game".to_owned(),
            retry_min_ms: 200,
            retry_max_ms: 5000,
            seed: 0,
        }
    }
}

impl RemoteSettings {
    /// With the invitation that a server has printed.
    ///
    /// # Errors
    /// It is not an invitation.
    pub fn from_invitation(invitation: &str) -> Result<Self, InvitationError> {
        let invite = Invitation::from_str(invitation)?.to_string();
        Ok(Self { invite, ..Self::default() })
    }

    /// With the file into which a server writes its invitation. It need not be there yet.
    #[must_use]
    pub fn from_invite_file(path: impl AsRef<Path>) -> Self {
        let invite_file = path.as_ref().to_string_lossy().into_owned();
        Self { invite_file, ..Self::default() }
    }

    /// Reads `RemoteSettings(...)` from a RON file.
    ///
    /// # Errors
    /// The file can't be read, or holds something else; the error names file, line and field.
    pub fn read(path: impl AsRef<Path>) -> Result<Self, RonError> {
        let file = path.as_ref().display().to_string();
        match std::fs::read_to_string(path) {
            Ok(text) => parse_ron(&file, &text),
            Err(source) => Err(RonError::Io { file, source }),
        }
    }

    /// Another name in the server's log.
    #[must_use]
    pub fn with_name(mut self, name: impl Into<String>) -> Self {
        self.name = name.into();
        self
    }

    pub(crate) fn retry(&self) -> Retry {
        let min = Duration::from_millis(u64::from(self.retry_min_ms.max(1)));
        Retry { min, max: Duration::from_millis(u64::from(self.retry_max_ms)).max(min) }
    }

    pub(crate) fn seed(&self) -> u64 {
        if self.seed == 0 { RandomState::new().hash_one(0_u64) } else { self.seed }
    }

    /// Checks everything but where the invitation comes from.
    pub(crate) fn check_values(&self) -> Result<(), FieldProblem> {
        let problem = |field: &'static str, message: &str| Err(FieldProblem::new(field, message));
        if self.name.chars().count() > ClientHello::NAME_CHARS
            || self.name.contains(char::is_control)
        {
            return problem(
                "name",
                "must have up to 64 characters, none of them control characters",
            );
        }
        if !(20..=60_000).contains(&self.retry_min_ms) {
            return problem("retry_min_ms", "must be from 20 to 60000");
        }
        if !(self.retry_min_ms..=600_000).contains(&self.retry_max_ms) {
            return problem("retry_max_ms", "must be from retry_min_ms to 600000");
        }
        Ok(())
    }
}

impl RonSettings for RemoteSettings {
    const EXTENSIONS: &'static [&'static str] = &["remote.ron"];

    fn check(&self) -> Result<(), FieldProblem> {
        match (self.invite.is_empty(), self.invite_file.is_empty()) {
            (true, true) => {
                let message = "is missing, and so is invite_file: one of them says which server";
                return Err(FieldProblem::new("invite", message));
            }
            (false, false) => {
                return Err(FieldProblem::new("invite_file", "is set besides invite; which one?"));
            }
            (false, true) => {
                if let Err(error) = Invitation::from_str(&self.invite) {
                    return Err(FieldProblem::new("invite", error.to_string()));
                }
            }
            (true, false) => {}
        }
        self.check_values()
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn invitation() -> String {
        format!("farlight://localhost:4433/#{}.{}", "ab".repeat(16), "cd".repeat(32))
    }

    fn error(text: &str) -> String {
        parse_ron::<RemoteSettings>("a.remote.ron", text).unwrap_err().to_string()
    }

    #[test]
    fn files_hold_settings_and_errors_name_the_place() {
        let text = format!("RemoteSettings(\n    invite: \"{}\",\n)", invitation());
        let settings: RemoteSettings = parse_ron("a", &text).unwrap();
        assert_eq!(settings, RemoteSettings::from_invitation(&invitation()).unwrap());
        let settings: RemoteSettings = parse_ron("a", "(invite_file: \"a/b\")").unwrap();
        assert_eq!(settings, RemoteSettings::from_invite_file("a/b"));

        let missing = error("RemoteSettings()");
        assert!(missing.contains("invite:") && missing.contains("which server"), "{missing}");
        let cut = error(&text.replace("cd\",", "\","));
        assert!(cut.starts_with("a.remote.ron:2: invite:") && cut.contains("cut off"), "{cut}");
        let both = error(&text.replace(",\n)", ",\n    invite_file: \"x\",\n)"));
        assert!(both.starts_with("a.remote.ron:3: invite_file:"), "{both}");
        let range = error("(invite_file: \"x\", retry_min_ms: 1)");
        assert!(range.contains("retry_min_ms"), "{range}");
        assert!(error("(invite_file: \"x\", retry_max_ms: 100)").contains("retry_max_ms"));
        assert!(error("(invite_file: \"x\", name: \"a\\nb\")").contains("name"));
        assert!(error("(server: \"x\")").contains("server"));
    }

    #[test]
    fn what_cannot_be_read_says_which_file() {
        let error = RemoteSettings::read("/nowhere/a.remote.ron").unwrap_err().to_string();
        assert!(error.contains("/nowhere/a.remote.ron"), "{error}");
        assert!(RemoteSettings::from_invitation("farlight://host").is_err());
    }
}
