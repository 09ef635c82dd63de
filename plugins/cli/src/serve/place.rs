//! Where the server is: addresses and folders.

use std::{
    net::{IpAddr, Ipv4Addr, Ipv6Addr, SocketAddr, UdpSocket},
    path::{Path, PathBuf},
};

use crate::error::CliError;

/// The port if none is given.
const PORT: u16 = 4433;

/// `ADDRESS:PORT`, `ADDRESS`, `:PORT`; `localhost` counts as an address.
pub(super) fn parse_listen(text: &str) -> Result<SocketAddr, String> {
    let text = match text.strip_prefix("localhost") {
        Some(rest) => format!("{}{rest}", Ipv4Addr::LOCALHOST),
        None => text.to_owned(),
    };
    if let Some(port) = text.strip_prefix(':').and_then(|port| port.parse().ok()) {
        return Ok((Ipv6Addr::UNSPECIFIED, port).into());
    }
    let bare = text.trim_start_matches('[').trim_end_matches(']');
    let address = bare.parse::<IpAddr>().map(|ip| (ip, PORT).into());
    text.parse().or(address).map_err(|_| {
        "needs ADDRESS:PORT, an address or :PORT, such as 192.168.0.7:4433, [::1]:4433, :4433"
            .to_owned()
    })
}

/// What the invitation names, and what to say about it.
#[derive(Debug, PartialEq, Eq)]
pub(super) struct Host {
    pub(super) name: String,
    pub(super) warning: Option<String>,
}

/// The name or address for the invitation of a server that listens on `listen`; `wanted` if it is
/// not empty.
pub(super) fn public_host(wanted: &str, listen: IpAddr) -> Host {
    host(wanted, listen, guess())
}

fn host(wanted: &str, listen: IpAddr, guess: Option<IpAddr>) -> Host {
    let is_local =
        |name: &str| name == "localhost" || name.parse::<IpAddr>().is_ok_and(|ip| ip.is_loopback());
    if !wanted.is_empty() {
        let unreachable = listen.is_loopback() && !is_local(wanted);
        let narrow = listen.is_unspecified() && is_local(wanted);
        let warning = if unreachable {
            Some(format!("the invitation names {wanted}, but only this machine can reach {listen}"))
        } else {
            narrow.then(|| {
                format!(
                    "the server listens on every address, but the invitation names {wanted} and is \
                     good for this machine alone"
                )
            })
        };
        return Host { name: wanted.to_owned(), warning };
    }
    if !listen.is_unspecified() {
        return Host { name: listen.to_string(), warning: None };
    }
    match guess {
        Some(address) => Host { name: address.to_string(), warning: None },
        None => Host {
            name: Ipv4Addr::LOCALHOST.to_string(),
            warning: Some(
                "this machine seems to be in no network, so the invitation is good for itself \
                 alone; --host NAME names another address"
                    .to_owned(),
            ),
        },
    }
}

/// The address from which this machine would reach others. Nothing is sent: connecting a UDP socket
/// only chooses a route.
fn guess() -> Option<IpAddr> {
    // Addresses for documentation, RFC 5737 and RFC 3849.
    let routes: [(IpAddr, IpAddr); 2] = [
        (Ipv4Addr::UNSPECIFIED.into(), Ipv4Addr::new(192, 0, 2, 1).into()),
        (Ipv6Addr::UNSPECIFIED.into(), Ipv6Addr::new(0x2001, 0xdb8, 0, 0, 0, 0, 0, 1).into()),
    ];
    routes.into_iter().find_map(|(from, to)| {
        let socket = UdpSocket::bind((from, 0)).ok()?;
        socket.connect((to, 9)).ok()?;
        let ip = socket.local_addr().ok()?.ip();
        (!ip.is_unspecified() && !ip.is_loopback()).then_some(ip)
    })
}

/// The folder of the server's identity: `wanted`, or one in the user's data folder.
pub(super) fn state_folder(wanted: &Path) -> Result<PathBuf, CliError> {
    if !wanted.as_os_str().is_empty() {
        return Ok(wanted.to_owned());
    }
    let variable = |name: &str| {
        // The specification of XDG_DATA_HOME says that relative paths are to be ignored.
        std::env::var_os(name).map(PathBuf::from).filter(|path| path.is_absolute())
    };
    let data = if cfg!(windows) {
        variable("APPDATA")
    } else {
        variable("XDG_DATA_HOME").or_else(|| Some(variable("HOME")?.join(".local/share")))
    };
    let missing = if cfg!(windows) { "APPDATA" } else { "HOME" };
    data.map(|data| data.join("farlight")).ok_or_else(|| {
        CliError::new(format!(
            "no folder for the server's identity: {missing} is not set; name one with --state DIR"
        ))
    })
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn addresses_to_listen_on() {
        let good = |text: &str| parse_listen(text).unwrap().to_string();
        assert_eq!(good("192.168.0.7:99"), "192.168.0.7:99");
        assert_eq!(good("[::1]:99"), "[::1]:99");
        assert_eq!(good("10.0.0.1"), "10.0.0.1:4433");
        assert_eq!(good("::1"), "[::1]:4433");
        assert_eq!(good("[::1]"), "[::1]:4433");
        assert_eq!(good(":0"), "[::]:0");
        assert_eq!(good("localhost:5"), "127.0.0.1:5");
        assert_eq!(good("localhost"), "127.0.0.1:4433");
        for bad in ["", "host:1", "1.2.3.4:65536", "1.2.3:4", ":x", "localhostx"] {
            assert!(parse_listen(bad).is_err(), "{bad}");
        }
    }

    #[test]
    fn invitations_name_what_clients_can_reach() {
        let [any, home, lan]: [IpAddr; 3] =
            ["::", "127.0.0.1", "192.168.0.7"].map(|ip| ip.parse().unwrap());
        let name = |wanted: &str, listen, guess| {
            let Host { name, warning } = host(wanted, listen, guess);
            (name, warning.is_some())
        };
        let is = |name: &str, warns| (name.to_owned(), warns);
        assert_eq!(name("", any, Some(lan)), is("192.168.0.7", false));
        assert_eq!(name("", any, None), is("127.0.0.1", true));
        assert_eq!(name("", home, Some(lan)), is("127.0.0.1", false));
        assert_eq!(name("", lan, None), is("192.168.0.7", false));
        assert_eq!(name("light.example.org", any, Some(lan)), is("light.example.org", false));
        assert_eq!(name("light.example.org", home, Some(lan)), is("light.example.org", true));
        assert_eq!(name("localhost", home, Some(lan)), is("localhost", false));
        assert_eq!(name("localhost", any, Some(lan)), is("localhost", true));
    }
}
