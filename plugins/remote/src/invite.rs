//! From an invitation to a connector.

use std::{str::FromStr, sync::Arc};

use farlight_core::RonSettings;
use farlight_wire::{Connector, Invitation, Token};

use crate::RemoteSettings;

/// Why there is no connector.
#[derive(Debug)]
pub(crate) enum Wait {
    /// There may be one later.
    Later(Arc<str>),
    /// There won't be.
    Never(Arc<str>),
}

/// Reads the invitation that the settings name and makes a connector of it.
pub(crate) fn find(
    settings: &RemoteSettings,
    connector: impl Fn(&Invitation) -> Box<dyn Connector>,
) -> Result<(Box<dyn Connector>, Token), Wait> {
    if let Err(problem) = settings.check() {
        return Err(Wait::Never(format!("settings of the lighting server: {problem}").into()));
    }
    let invitation = if settings.invite_file.is_empty() {
        Invitation::from_str(&settings.invite).map_err(|e| Wait::Never(e.to_string().into()))?
    } else {
        let file = &settings.invite_file;
        let later = |why: String| Wait::Later(format!("waiting for {file}: {why}").into());
        let text = std::fs::read_to_string(file).map_err(|e| later(e.to_string()))?;
        Invitation::from_str(&text).map_err(|e| later(e.to_string()))?
    };
    Ok((connector(&invitation), invitation.token))
}

#[cfg(test)]
mod tests {
    use farlight_wire::simulated::Network;

    use super::*;

    fn look(settings: &RemoteSettings) -> Result<Token, Wait> {
        let connector = |_: &Invitation| Box::new(Network::new(1).connector()) as Box<_>;
        find(settings, connector).map(|(_, token)| token)
    }

    #[test]
    fn a_file_may_appear_later() {
        let folder = std::env::temp_dir().join(format!("farlight-invite-{}", std::process::id()));
        std::fs::create_dir_all(&folder).unwrap();
        let file = folder.join("invite");
        let settings = RemoteSettings::from_invite_file(&file);
        let Err(Wait::Later(why)) = look(&settings) else { panic!() };
        assert!(why.contains("invite"), "{why}");
        std::fs::write(&file, "farlight://loc").unwrap();
        assert!(matches!(look(&settings), Err(Wait::Later(_))), "half written");
        let text = format!("farlight://localhost:1/#{}.{}\n", "ab".repeat(16), "cd".repeat(32));
        std::fs::write(&file, text).unwrap();
        assert_eq!(look(&settings).unwrap(), Token([0xab; 16]));
        std::fs::remove_dir_all(&folder).unwrap();
    }

    #[test]
    fn settings_that_name_no_server_are_final() {
        let Err(Wait::Never(why)) = look(&RemoteSettings::default()) else { panic!() };
        assert!(why.contains("invite"), "{why}");
    }
}
