//! Connecting to a server by an invitation.

use std::{
    collections::VecDeque,
    future::Future,
    net::{IpAddr, Ipv4Addr, Ipv6Addr, SocketAddr},
    pin::Pin as Boxed,
    sync::Arc,
    time::Duration,
};

use farlight_wire::{Closed, Connector, Invitation, Limits, Link, Wake};
use tokio::{
    sync::mpsc::UnboundedReceiver,
    task::{AbortHandle, JoinSet},
    time::{sleep, timeout},
};
use tracing::{debug, info};
use wtransport::{
    ClientConfig, Connection, Endpoint, RecvStream, SendStream,
    config::{DnsLookupFuture, DnsResolver},
    endpoint::endpoint_side::Client,
    error::{ConnectingError, ConnectionError},
};

use crate::{
    Pin, SERVER_NAME,
    end::{closed, goodbye},
    network::Network,
    pump::{self, Command, QuicLink},
    shared::{Shared, WakeSlot},
    transport,
};

/// How long connecting may take.
const PATIENCE: Duration = Duration::from_secs(6);

/// How long one address is tried alone before the next one too.
const STAGGER: Duration = Duration::from_millis(250);

/// The first packets of an attempt are sent again at growing intervals. When a line or a server comes back
/// after a while a new attempt is faster, so one begins so often.
const AGAIN: Duration = Duration::from_millis(600);

/// Attempts at once; beyond that the oldest ends.
const ATTEMPTS: usize = 6;

/// Addresses of a name that are tried.
const ADDRESSES: usize = 4;

/// How long the goodbye of a connection may take to leave.
const LEAVE: Duration = Duration::from_secs(1);

/// Makes links to the server that an invitation names. The server must prove that it is of the
/// invitation's authority. The invitation's token is not used here: the session sends it.
pub struct QuicConnector {
    host: String,
    port: u16,
    authority: [u8; 32],
}

impl QuicConnector {
    /// Connects to the server of an invitation.
    #[must_use]
    pub fn new(invitation: &Invitation) -> Self {
        let Invitation { host, port, authority, .. } = invitation;
        Self { host: host.clone(), port: *port, authority: *authority }
    }
}

impl Connector for QuicConnector {
    fn connect(&mut self, limits: &Limits, wake: Wake) -> Box<dyn Link> {
        let shared = Shared::new(WakeSlot::new(wake));
        let (link, commands) = QuicLink::new(Arc::clone(&shared));
        let server = Server {
            host: self.host.clone(),
            port: self.port,
            authority: self.authority,
            name: self.peer(),
        };
        match Network::shared() {
            Ok(network) => network.spawn(client(server, *limits, shared, commands)),
            Err(error) => {
                let why = format!("the network thread doesn't start: {error}");
                shared.closed(Closed::Lost(why.into()));
            }
        }
        Box::new(link)
    }

    fn peer(&self) -> String {
        if self.host.contains(':') {
            return format!("[{}]:{}", self.host, self.port);
        }
        format!("{}:{}", self.host, self.port)
    }
}

struct Server {
    host: String,
    port: u16,
    authority: [u8; 32],
    name: String,
}

/// The whole life of a client's connection.
async fn client(
    server: Server,
    limits: Limits,
    shared: Arc<Shared>,
    mut commands: UnboundedReceiver<Command>,
) {
    let connecting = timeout(PATIENCE, connect(&server));
    let mut early = Vec::new();
    let connected = tokio::select! {
        connected = connecting => connected.unwrap_or_else(|_| {
            Err(Closed::Lost(format!("no answer from {}", server.name).into()))
        }),
        // The session has thought better of it.
        closed = changed_its_mind(&mut commands, &mut early) => Err(closed),
    };
    match connected {
        Ok(Connected { endpoint, connection, control }) => {
            info!("connected to {} ({})", server.name, connection.remote_address());
            let closed =
                pump::run(&connection, control, &shared, &mut commands, early, &limits).await;
            info!("{}: {closed}", server.name);
            shared.closed(closed);
            drop(connection);
            let _ = timeout(LEAVE, endpoint.wait_idle()).await;
        }
        Err(closed) => {
            // Whoever asked for the link decides whether this is news: attempts come and go.
            debug!("{}: {closed}", server.name);
            shared.closed(closed);
        }
    }
}

/// Waits until the link is closed or dropped; collects what it wants to send.
async fn changed_its_mind(
    commands: &mut UnboundedReceiver<Command>,
    early: &mut Vec<Command>,
) -> Closed {
    use farlight_wire::CloseCode;
    loop {
        match commands.recv().await {
            Some(Command::Close(code, reason)) => return Closed::Goodbye(code, reason.into()),
            None => return Closed::Goodbye(CloseCode::Done, "".into()),
            Some(command) => early.push(command),
        }
    }
}

struct Connected {
    endpoint: Endpoint<Client>,
    connection: Connection,
    control: (SendStream, RecvStream),
}

/// Tries the server's addresses, one a little after the other and then again, until one answers.
async fn connect(server: &Server) -> Result<Connected, Closed> {
    let addresses = resolve(server).await?;
    let mut attempts = JoinSet::new();
    let mut handles = VecDeque::new();
    let mut failed = None;
    let mut next = 0;
    loop {
        let wait = if next == 0 {
            Duration::ZERO
        } else if next < addresses.len() {
            STAGGER
        } else {
            AGAIN / addresses.len() as u32
        };
        // Refused everywhere: no need to wait.
        if attempts.is_empty()
            && next >= addresses.len()
            && let Some(closed) = failed
        {
            return Err(closed);
        }
        tokio::select! {
            Some(attempt) = attempts.join_next() => match attempt {
                Ok(Ok(connected)) => return Ok(connected),
                Ok(Err(untrusted @ Closed::Untrusted(_))) => return Err(untrusted),
                Ok(Err(closed)) => failed = Some(closed),
                Err(_) => {}
            },
            () = sleep(wait) => {
                if handles.len() == ATTEMPTS
                    && let Some(oldest) = handles.pop_front()
                {
                    AbortHandle::abort(&oldest);
                }
                let address = addresses[next % addresses.len()];
                debug!("connecting to {} at {address}", server.name);
                handles.push_back(attempts.spawn(attempt(address, server.authority)));
                next += 1;
            }
        }
    }
}

async fn resolve(server: &Server) -> Result<Vec<SocketAddr>, Closed> {
    if let Ok(ip) = server.host.parse::<IpAddr>() {
        return Ok(vec![SocketAddr::new(ip, server.port)]);
    }
    let lost = |why: String| Closed::Lost(why.into());
    // Also addresses with a zone, which have brackets there.
    let found = tokio::net::lookup_host(server.name.as_str()).await;
    let found = found.map_err(|error| lost(format!("{} can't be found: {error}", server.host)))?;
    let mut addresses = Vec::new();
    for address in found {
        if addresses.len() < ADDRESSES && !addresses.contains(&address) {
            addresses.push(address);
        }
    }
    if addresses.is_empty() {
        return Err(lost(format!("{} has no address", server.host)));
    }
    Ok(addresses)
}

async fn attempt(address: SocketAddr, authority: [u8; 32]) -> Result<Connected, Closed> {
    let lost = |error: &dyn std::fmt::Display| Closed::Lost(error.to_string().into());
    let pin = Arc::new(Pin::new(authority));
    let tls = transport::client_tls(Arc::clone(&pin)).map_err(|error| lost(&error))?;
    let local: IpAddr = match address {
        SocketAddr::V4(_) => Ipv4Addr::UNSPECIFIED.into(),
        SocketAddr::V6(_) => Ipv6Addr::UNSPECIFIED.into(),
    };
    let config = ClientConfig::builder()
        .with_bind_address(SocketAddr::new(local, 0))
        .with_custom_tls_and_transport(tls, transport::transport(true))
        .dns_resolver(Known(address))
        .build();
    let endpoint = Endpoint::client(config).map_err(|error| lost(&error))?;
    // The name that certificates have; where it is, `Known` says.
    let url = format!("https://{SERVER_NAME}:{}/", address.port());
    let connection = match endpoint.connect(url).await {
        Ok(connection) => connection,
        Err(error) => {
            return Err(match (pin.take_refusal(), error) {
                (Some(refusal), _) => Closed::Untrusted(refusal.to_string().into()),
                (None, ConnectingError::SessionRejected) => {
                    lost(&"the server doesn't take the request; is it a lighting server?")
                }
                (None, ConnectingError::ConnectionError(error)) => connecting(&error),
                (None, error) => lost(&error),
            });
        }
    };
    let opening = async { connection.open_bi().await.ok()?.await.ok() };
    let Some(control) = opening.await else {
        return Err(match connection.quic_connection().close_reason() {
            Some(error) => closed(&error),
            None => lost(&"the control stream can't be opened"),
        });
    };
    Ok(Connected { endpoint, connection, control })
}

/// Why a connection was not made.
fn connecting(error: &ConnectionError) -> Closed {
    match error {
        ConnectionError::TimedOut => Closed::Lost("no answer".into()),
        ConnectionError::ApplicationClosed(close) => {
            goodbye(close.code().into_inner(), close.reason())
        }
        ConnectionError::ConnectionClosed(close) => Closed::Lost(close.to_string().into()),
        other => Closed::Lost(other.to_string().into()),
    }
}

/// Knows one address whatever the name.
#[derive(Debug)]
struct Known(SocketAddr);

impl DnsResolver for Known {
    fn resolve(&self, _host: &str) -> Boxed<Box<dyn DnsLookupFuture>> {
        let address = self.0;
        let found: Boxed<Box<dyn DnsLookupFuture>> = Box::pin(found(address));
        found
    }
}

fn found(address: SocketAddr) -> impl Future<Output = std::io::Result<Option<SocketAddr>>> + Send {
    std::future::ready(Ok(Some(address)))
}
