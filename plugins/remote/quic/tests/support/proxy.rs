//! A bad line: a UDP relay with delay, jitter, loss and outages, in real time.

use std::{
    collections::HashMap,
    net::SocketAddr,
    sync::{
        Arc, Mutex,
        atomic::{AtomicBool, AtomicU64, Ordering::Relaxed},
    },
    time::Duration,
};

use tokio::{
    net::UdpSocket,
    runtime::Runtime,
    sync::mpsc,
    task::JoinHandle,
    time::{Instant, sleep_until},
};

/// How bad the line is, each way.
#[derive(Clone, Copy, Debug, Default)]
pub(crate) struct Line {
    /// One way.
    pub(crate) delay: Duration,
    /// Added to the delay, evenly from 0 to this; packets overtake each other.
    pub(crate) jitter: Duration,
    /// Of packets, 0 to 1.
    pub(crate) loss: f64,
    /// Bytes a second; 0 for any number. What is more waits, 200 ms at most, or is lost.
    pub(crate) rate: u64,
    /// For losses and jitter.
    pub(crate) seed: u64,
}

/// A relay in front of a server.
pub(crate) struct Proxy {
    pub(crate) address: SocketAddr,
    down: Arc<AtomicBool>,
    pub(crate) passed: Arc<AtomicU64>,
    pub(crate) lost: Arc<AtomicU64>,
    task: JoinHandle<()>,
}

impl Proxy {
    pub(crate) fn new(runtime: &Runtime, server: SocketAddr, line: Line) -> Self {
        let socket = runtime.block_on(UdpSocket::bind(("127.0.0.1", 0))).unwrap();
        let address = socket.local_addr().unwrap();
        let down = Arc::new(AtomicBool::new(false));
        let (passed, lost) = (Arc::new(AtomicU64::new(0)), Arc::new(AtomicU64::new(0)));
        let wire = Wire {
            line,
            down: Arc::clone(&down),
            passed: Arc::clone(&passed),
            lost: Arc::clone(&lost),
            random: Arc::new(Mutex::new(line.seed.wrapping_mul(0x9e37_79b9_7f4a_7c15) | 1)),
        };
        let task = runtime.spawn(relay(Arc::new(socket), server, wire));
        Self { address, down, passed, lost, task }
    }

    /// Cuts the line, or mends it. What is on the way is lost as well.
    pub(crate) fn cut(&self, down: bool) {
        self.down.store(down, Relaxed);
    }
}

impl Drop for Proxy {
    fn drop(&mut self) {
        self.task.abort();
    }
}

#[derive(Clone)]
struct Wire {
    line: Line,
    down: Arc<AtomicBool>,
    passed: Arc<AtomicU64>,
    lost: Arc<AtomicU64>,
    random: Arc<Mutex<u64>>,
}

impl Wire {
    /// Evenly from 0 to 1.
    fn random(&self) -> f64 {
        let mut state = self.random.lock().unwrap();
        *state =
            state.wrapping_mul(6_364_136_223_846_793_005).wrapping_add(1_442_695_040_888_963_407);
        (*state >> 11) as f64 / (1_u64 << 53) as f64
    }
}

/// One direction: packets wait for their time.
fn lane(wire: Wire, from: Arc<UdpSocket>, to: SocketAddr) -> mpsc::UnboundedSender<Vec<u8>> {
    let (sender, mut packets) = mpsc::unbounded_channel::<Vec<u8>>();
    tokio::spawn(async move {
        let mut free = Instant::now();
        while let Some(packet) = packets.recv().await {
            if wire.down.load(Relaxed) || wire.random() < wire.line.loss {
                wire.lost.fetch_add(1, Relaxed);
                continue;
            }
            let now = Instant::now();
            free = free.max(now);
            if wire.line.rate > 0 {
                if free - now > Duration::from_millis(200) {
                    wire.lost.fetch_add(1, Relaxed);
                    continue;
                }
                free += Duration::from_secs_f64(packet.len() as f64 / wire.line.rate as f64);
            }
            let due = free + wire.line.delay + wire.line.jitter.mul_f64(wire.random());
            let (wire, from) = (wire.clone(), Arc::clone(&from));
            tokio::spawn(async move {
                sleep_until(due).await;
                if wire.down.load(Relaxed) {
                    wire.lost.fetch_add(1, Relaxed);
                    return;
                }
                wire.passed.fetch_add(1, Relaxed);
                let _ = from.send_to(&packet, to).await;
            });
        }
    });
    sender
}

async fn relay(front: Arc<UdpSocket>, server: SocketAddr, wire: Wire) {
    let mut clients: HashMap<SocketAddr, mpsc::UnboundedSender<Vec<u8>>> = HashMap::new();
    let mut buffer = vec![0; 65536];
    loop {
        let Ok((length, client)) = front.recv_from(&mut buffer).await else { continue };
        if let std::collections::hash_map::Entry::Vacant(entry) = clients.entry(client) {
            let back = Arc::new(UdpSocket::bind(("127.0.0.1", 0)).await.unwrap());
            let answers = lane(wire.clone(), Arc::clone(&front), client);
            let listening = Arc::clone(&back);
            tokio::spawn(async move {
                let mut buffer = vec![0; 65536];
                while let Ok((length, _)) = listening.recv_from(&mut buffer).await {
                    if answers.send(buffer[..length].to_vec()).is_err() {
                        return;
                    }
                }
            });
            entry.insert(lane(wire.clone(), back, server));
        }
        let _ = clients[&client].send(buffer[..length].to_vec());
    }
}

/// A relay for one client whose server can be exchanged.
pub(crate) struct Switch {
    pub(crate) address: SocketAddr,
    server: Arc<Mutex<SocketAddr>>,
    task: JoinHandle<()>,
}

impl Switch {
    pub(crate) fn new(runtime: &Runtime, server: SocketAddr) -> Self {
        let front = runtime.block_on(UdpSocket::bind(("127.0.0.1", 0))).unwrap();
        let address = front.local_addr().unwrap();
        let server = Arc::new(Mutex::new(server));
        let to = Arc::clone(&server);
        let task = runtime.spawn(async move {
            let back = UdpSocket::bind(("127.0.0.1", 0)).await.unwrap();
            let mut client = None;
            let (mut out, mut home) = (vec![0; 65536], vec![0; 65536]);
            loop {
                tokio::select! {
                    Ok((length, from)) = front.recv_from(&mut out) => {
                        client = Some(from);
                        let to = *to.lock().unwrap();
                        let _ = back.send_to(&out[..length], to).await;
                    }
                    Ok((length, from)) = back.recv_from(&mut home) => {
                        let current = from == *to.lock().unwrap();
                        if let Some(client) = client.filter(|_| current) {
                            let _ = front.send_to(&home[..length], client).await;
                        }
                    }
                }
            }
        });
        Self { address, server, task }
    }

    pub(crate) fn switch(&self, server: SocketAddr) {
        *self.server.lock().unwrap() = server;
    }
}

impl Drop for Switch {
    fn drop(&mut self) {
        self.task.abort();
    }
}
