//! Taking clients.

use std::{
    collections::VecDeque,
    io,
    net::SocketAddr,
    path::PathBuf,
    sync::{Arc, Mutex, PoisonError},
    time::{Duration, SystemTime},
};

use farlight_wire::{CloseCode, Limits, Link, Listener, Wake};
use thiserror::Error;
use tokio::{
    sync::{OwnedSemaphorePermit, Semaphore},
    task::{AbortHandle, JoinSet},
    time::{MissedTickBehavior, interval, sleep, timeout},
};
use tracing::{debug, info, warn};
use wtransport::{
    Connection, Endpoint, RecvStream, SendStream, ServerConfig, VarInt,
    config::Ipv6DualStackConfig,
    endpoint::{IncomingSession, endpoint_side::Server},
};

use crate::{
    Authority, AuthorityError, Clock,
    network::Network,
    pump::{self, QuicLink},
    rotation::{Rotation, write_hashes},
    shared::{Shared, WakeSlot},
    transport,
};

/// How long a client may take from its first packet to its control stream.
const PATIENCE: Duration = Duration::from_secs(10);

/// Clients that are being let in at once. With more than half of it, new ones must first prove that
/// they are where they say (RFC 9000, 8.1).
const HANDSHAKES: usize = 64;

/// Clients that wait for [`Listener::accept`].
const WAITING: usize = 16;

/// What the clients of unfinished handshakes may send ahead, all together.
const EARLY_BYTES: u64 = 1 << 20;

/// How often the list of hashes is compared with the present certificates.
const HASHES: Duration = Duration::from_secs(60);

/// How long a goodbye may take to leave.
const LEAVE: Duration = Duration::from_millis(100);

/// What a listener is made with.
#[derive(Clone)]
pub struct ListenConfig {
    /// Where. Port 0 takes any that is free; `[::]` takes IPv4 too.
    pub address: SocketAddr,
    /// Who it is.
    pub authority: Arc<Authority>,
    /// Bounds of what it takes from clients.
    pub limits: Limits,
    /// Connections at once, with those of sessions that have not begun.
    pub connections: usize,
    /// A file that always has the hashes of the certificates of this week and the next, for browsers:
    /// `{"algorithm": "sha-256", "hashes": ["hexadecimal", ..]}`.
    pub hashes: Option<PathBuf>,
    /// Tells the time for certificates.
    pub clock: Clock,
}

impl ListenConfig {
    /// Up to 256 connections with the default limits, and no file of hashes.
    #[must_use]
    pub fn new(address: SocketAddr, authority: Arc<Authority>) -> Self {
        Self {
            address,
            authority,
            limits: Limits::default(),
            connections: 256,
            hashes: None,
            clock: Arc::new(SystemTime::now),
        }
    }
}

/// Why nothing can be listened to.
#[derive(Debug, Error)]
pub enum ListenError {
    /// The address can't be had.
    #[error("can't listen at {address}: {source}")]
    Address {
        /// Which.
        address: SocketAddr,
        /// Why.
        source: io::Error,
    },
    /// No certificates.
    #[error(transparent)]
    Authority(#[from] AuthorityError),
    /// The list of hashes can't be written.
    #[error("{}: {source}", path.display())]
    Hashes {
        /// Where to.
        path: PathBuf,
        /// Why.
        source: io::Error,
    },
    /// TLS can't be set up.
    #[error("can't set up TLS: {0}")]
    Tls(String),
    /// No thread.
    #[error("the network thread doesn't start: {0}")]
    Thread(io::Error),
}

/// Takes clients at an address. Accepted links live on when it is dropped. They wake whom the listener
/// wakes.
pub struct QuicListener {
    local: SocketAddr,
    rotation: Arc<Rotation>,
    queue: Arc<Queue>,
    tasks: Vec<AbortHandle>,
    _network: Arc<Network>,
}

/// Clients that wait to be accepted.
struct Queue {
    links: Mutex<VecDeque<(QuicLink, String)>>,
    wake: WakeSlot,
}

impl Queue {
    fn with<R>(&self, f: impl FnOnce(&mut VecDeque<(QuicLink, String)>) -> R) -> R {
        f(&mut self.links.lock().unwrap_or_else(PoisonError::into_inner))
    }
}

impl QuicListener {
    /// Begins to listen.
    ///
    /// # Errors
    /// See [`ListenError`].
    pub fn bind(config: ListenConfig) -> Result<Self, ListenError> {
        let network = Network::shared().map_err(ListenError::Thread)?;
        let clock = Arc::clone(&config.clock);
        let rotation = Arc::new(Rotation::new(Arc::clone(&config.authority), clock)?);
        if let Some(path) = &config.hashes {
            write_hashes(path, &rotation.hashes())
                .map_err(|source| ListenError::Hashes { path: path.clone(), source })?;
        }
        let address = |source| ListenError::Address { address: config.address, source };
        let endpoint = {
            let _inside = network.handle().enter();
            endpoint(&config, &rotation).map_err(|error| match error {
                Setup::Tls(error) => ListenError::Tls(error.to_string()),
                Setup::Address(source) => address(source),
            })?
        };
        let local = endpoint.local_addr().map_err(address)?;
        let wake = WakeSlot::new(Arc::new(|| {}));
        let queue = Arc::new(Queue { links: Mutex::default(), wake });
        info!("listening at {local}");
        let door = Door {
            network: Arc::downgrade(&network),
            queue: Arc::clone(&queue),
            limits: config.limits,
            connections: Arc::new(Semaphore::new(config.connections)),
        };
        let mut tasks = vec![network.handle().spawn(accept(endpoint, door)).abort_handle()];
        if let Some(path) = config.hashes {
            let writing = keep_hashes(path, Arc::clone(&rotation));
            tasks.push(network.handle().spawn(writing).abort_handle());
        }
        Ok(Self { local, rotation, queue, tasks, _network: network })
    }

    /// Where it listens.
    #[must_use]
    pub fn local_addr(&self) -> SocketAddr {
        self.local
    }

    /// SHA-256 of the certificates that are presented now and in the next period, for browsers.
    #[must_use]
    pub fn hashes(&self) -> [[u8; 32]; 2] {
        self.rotation.hashes()
    }
}

impl Listener for QuicListener {
    fn accept(&mut self) -> Option<(Box<dyn Link>, String)> {
        let (link, peer) = self.queue.with(VecDeque::pop_front)?;
        Some((Box::new(link), peer))
    }

    fn set_wake(&mut self, wake: Wake) {
        self.queue.wake.set(wake);
        // Something may have come before.
        self.queue.wake.call();
    }
}

impl Drop for QuicListener {
    fn drop(&mut self) {
        self.tasks.iter().for_each(AbortHandle::abort);
        self.queue.with(VecDeque::clear);
        info!("no longer listening at {}", self.local);
    }
}

enum Setup {
    Tls(rustls::Error),
    Address(io::Error),
}

fn endpoint(config: &ListenConfig, rotation: &Arc<Rotation>) -> Result<Endpoint<Server>, Setup> {
    let tls = transport::server_tls(Arc::clone(rotation)).map_err(Setup::Tls)?;
    let builder = ServerConfig::builder();
    let builder = match config.address {
        SocketAddr::V6(address) if address.ip().is_unspecified() => {
            builder.with_bind_address_v6(address, Ipv6DualStackConfig::Allow)
        }
        address => builder.with_bind_address(address),
    };
    let mut server =
        builder.with_custom_tls_and_transport(tls, transport::transport(false)).build();
    server
        .quic_config_mut()
        .max_incoming(HANDSHAKES)
        .incoming_buffer_size(EARLY_BYTES / HANDSHAKES as u64)
        .incoming_buffer_size_total(EARLY_BYTES);
    transport::remember(server.quic_endpoint_config_mut(), &config.authority);
    Endpoint::server(server).map_err(Setup::Address)
}

/// What it takes to let clients in.
#[derive(Clone)]
struct Door {
    network: std::sync::Weak<Network>,
    queue: Arc<Queue>,
    limits: Limits,
    connections: Arc<Semaphore>,
}

async fn accept(endpoint: Endpoint<Server>, door: Door) {
    let mut handshakes = JoinSet::new();
    loop {
        tokio::select! {
            incoming = endpoint.accept() => {
                while handshakes.try_join_next().is_some() {}
                // IPv4 addresses look like IPv6 ones at a socket for both.
                let mut peer = incoming.remote_address();
                peer.set_ip(peer.ip().to_canonical());
                if handshakes.len() >= HANDSHAKES {
                    debug!("{peer} is not let in: too many others are just coming in");
                    incoming.refuse();
                } else if handshakes.len() >= HANDSHAKES / 2 && !incoming.remote_address_validated() {
                    incoming.retry();
                } else if let Ok(place) = Arc::clone(&door.connections).try_acquire_owned() {
                    handshakes.spawn(welcome(incoming, peer, door.clone(), place));
                } else {
                    warn!("{peer} is not let in: there are too many connections");
                    incoming.refuse();
                }
            }
            Some(_) = handshakes.join_next() => {}
        }
    }
}

/// Lets one client in.
async fn welcome(
    incoming: IncomingSession,
    peer: SocketAddr,
    door: Door,
    place: OwnedSemaphorePermit,
) {
    match timeout(PATIENCE, shake_hands(incoming)).await {
        Ok(Ok((connection, control))) => admit(connection, control, peer, door, place),
        Ok(Err(why)) => debug!("{peer} did not get in: {why}"),
        Err(_) => debug!("{peer} did not get in: it took too long"),
    }
}

async fn shake_hands(
    incoming: IncomingSession,
) -> Result<(Connection, (SendStream, RecvStream)), String> {
    let request = incoming.await.map_err(|error| error.to_string())?;
    if request.path() != "/" {
        let path: String = request.path().escape_debug().take(64).collect();
        request.not_found().await;
        return Err(format!("it asks for {path}"));
    }
    let connection = request.accept().await.map_err(|error| error.to_string())?;
    let control = connection.accept_bi().await.map_err(|error| error.to_string())?;
    Ok((connection, control))
}

/// Puts a client into the queue, and moves its messages from now on.
fn admit(
    connection: Connection,
    control: (SendStream, RecvStream),
    peer: SocketAddr,
    door: Door,
    place: OwnedSemaphorePermit,
) {
    let Some(network) = door.network.upgrade() else { return };
    let shared = Shared::new(door.queue.wake.clone());
    let (link, mut commands) = QuicLink::new(Arc::clone(&shared));
    let queued = door.queue.with(|links| {
        let room = links.len() < WAITING;
        if room {
            links.push_back((link, peer.to_string()));
        }
        room
    });
    if !queued {
        warn!("{peer} is not let in: too many others wait");
        let code = VarInt::from_u32(CloseCode::Full.number());
        connection.close(code, b"too many clients wait");
        return;
    }
    info!("{peer} is connected");
    network.spawn(async move {
        let limits = door.limits;
        let closed =
            pump::run(&connection, control, &shared, &mut commands, Vec::new(), &limits).await;
        info!("{peer}: {closed}");
        shared.closed(closed);
        drop(place);
        sleep(LEAVE).await;
    });
    door.queue.wake.call();
}

/// Writes the list of hashes whenever it changes.
async fn keep_hashes(path: PathBuf, rotation: Arc<Rotation>) {
    let mut written = rotation.hashes();
    let mut ticks = interval(HASHES);
    ticks.set_missed_tick_behavior(MissedTickBehavior::Delay);
    loop {
        ticks.tick().await;
        let hashes = rotation.hashes();
        if hashes == written {
            continue;
        }
        match write_hashes(&path, &hashes) {
            Ok(()) => written = hashes,
            Err(error) => warn!("{}: {error}", path.display()),
        }
    }
}
