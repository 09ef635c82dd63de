//! What one client does between coming and going.

use std::{
    fmt,
    io::{BufRead as _, BufReader},
    process::{Command, Stdio},
    sync::{
        Arc,
        mpsc::{Receiver, SyncSender, sync_channel},
    },
    time::{Duration, Instant},
};

use farlight_quic::QuicConnector;
use farlight_wire::{
    Channel, CloseCode, Closed, Connector, Invitation, Limits, Token, Transmit, TransmitId, Wake,
};
use glam::Vec3;

use crate::{client::Client, scene};

/// How long anything may take; the machine may be busy.
const PATIENCE: Duration = Duration::from_secs(60);

/// What a process that is to be killed says when it has light.
const LIT: &str = "lit";

/// Kinds of visits.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Visit {
    /// Gets light and says goodbye.
    Polite,
    /// Gets light and closes its connection without a goodbye of its own.
    Dropped,
    /// A process of its own that gets light and is killed.
    Killed,
    /// Gets light, loses its connection, comes back and gets other light.
    Resumed,
    /// Leaves while it sends a large mesh.
    Torn,
    /// Doesn't know the token.
    Stranger,
    /// Sends garbage once it is in.
    Garbage,
}

impl Visit {
    pub(crate) const ALL: [Self; 7] = [
        Self::Polite,
        Self::Dropped,
        Self::Killed,
        Self::Resumed,
        Self::Torn,
        Self::Stranger,
        Self::Garbage,
    ];
}

/// Connects one client after the other.
pub(crate) struct Visitor {
    invitation: Invitation,
    connector: QuicConnector,
    token: Token,
    random: u64,
    start: Instant,
    wake: SyncSender<()>,
    woken: Receiver<()>,
}

impl Visitor {
    pub(crate) fn new(invitation: &Invitation, seed: u64) -> Self {
        let (wake, woken) = sync_channel(1);
        Self {
            invitation: invitation.clone(),
            connector: QuicConnector::new(invitation),
            token: invitation.token,
            random: seed.wrapping_mul(0x9e37_79b9_7f4a_7c15) | 1,
            start: Instant::now(),
            wake,
            woken,
        }
    }

    /// Makes a visit; how long light took each time, in seconds.
    pub(crate) fn visit(&mut self, visit: Visit) -> Result<Vec<f32>, String> {
        if visit == Visit::Killed {
            return self.kill().map(|()| Vec::new());
        }
        let end = Instant::now() + PATIENCE;
        loop {
            match self.try_visit(visit) {
                // Sessions of those who left without a word fill the server; it will have room.
                Err(End::Closed(Closed::Goodbye(CloseCode::Full, _))) if Instant::now() < end => {
                    std::thread::sleep(Duration::from_millis(200));
                }
                outcome => return outcome.map_err(|end| end.to_string()),
            }
        }
    }

    fn try_visit(&mut self, visit: Visit) -> Result<Vec<f32>, End> {
        let token = if visit == Visit::Stranger { Token([0; 16]) } else { self.token };
        let mut client = self.begin(token, &format!("{visit:?}"));
        let mut times = Vec::new();
        match visit {
            Visit::Polite | Visit::Dropped | Visit::Resumed => {
                times.push(self.light(&mut client)?);
                match visit {
                    Visit::Polite => client.close(),
                    Visit::Dropped => client.cut(),
                    _ => {
                        client.cut();
                        let lamp = scene::lamp(Vec3::new(1.0, 1.0, 1.0), 20.0);
                        client.submit(self.start.elapsed(), vec![lamp]);
                        self.connect(&mut client);
                        times.push(self.light(&mut client)?);
                        client.close();
                    }
                }
            }
            Visit::Torn => {
                let seed = (self.random() * 1e6) as u32;
                client.submit(self.start.elapsed(), scene::ground(150, seed).collect());
                // Some part of it, another one each time.
                let messages = 5 + (self.random() * 20.0) as u64;
                self.run(&mut client, |c| c.sent >= messages || c.is_lit())?;
                client.cut();
            }
            Visit::Stranger => match self.run(&mut client, |_| false) {
                Err(End::Closed(Closed::Goodbye(CloseCode::Unauthorized, _))) => {}
                other => return Err(End::Odd(format!("a wrong token: {other:?}"))),
            },
            // Not here: it takes a process.
            Visit::Killed => {}
            Visit::Garbage => {
                self.run(&mut client, |c| c.welcomed.is_some())?;
                for i in 0..20 {
                    self.send_garbage(&mut client, i);
                }
                match self.run(&mut client, |_| false) {
                    Err(End::Closed(Closed::Goodbye(
                        CloseCode::Protocol | CloseCode::Limit,
                        _,
                    ))) => {}
                    other => return Err(End::Odd(format!("garbage: {other:?}"))),
                }
            }
        }
        Ok(times)
    }

    fn connect(&mut self, client: &mut Client) {
        let sender = self.wake.clone();
        let wake: Wake = Arc::new(move || {
            // A full channel wakes as well.
            let _ = sender.try_send(());
        });
        client.use_link(self.connector.connect(&Limits::default(), wake));
    }

    /// Starts this program as a client, and kills it once it has light.
    fn kill(&mut self) -> Result<(), String> {
        let program = std::env::current_exe().map_err(|e| e.to_string())?;
        let mut command = Command::new(program);
        command.arg(self.invitation.to_string()).args(["--victim", "1"]).stdout(Stdio::piped());
        let mut child = command.spawn().map_err(|e| e.to_string())?;
        let mut line = String::new();
        if let Some(output) = child.stdout.take() {
            let _ = BufReader::new(output).read_line(&mut line);
        }
        let _ = child.kill();
        let _ = child.wait();
        if line.trim() == LIT { Ok(()) } else { Err(format!("the process said {line:?}")) }
    }

    /// The process that is killed: gets light, says so, and waits for its end.
    pub(crate) fn be_killed(&mut self) -> Result<(), String> {
        let end = Instant::now() + PATIENCE;
        loop {
            let mut client = self.begin(self.token, "Killed");
            match self.light(&mut client) {
                Ok(_) => {
                    println!("{LIT}");
                    return match self.run(&mut client, |_| false) {
                        Err(End::Late) => Err("nobody killed it".to_owned()),
                        other => Err(format!("{other:?}")),
                    };
                }
                Err(End::Closed(Closed::Goodbye(CloseCode::Full, _))) if Instant::now() < end => {
                    std::thread::sleep(Duration::from_millis(200));
                }
                Err(end) => return Err(end.to_string()),
            }
        }
    }

    /// A client that has submitted its scene.
    fn begin(&mut self, token: Token, name: &str) -> Client {
        let mut client = Client::new(name, token);
        self.connect(&mut client);
        let size = 2.0 + 3.0 * self.random();
        client.submit(self.start.elapsed(), scene::room(size));
        client
    }

    /// Waits for light of the newest scene.
    fn light(&mut self, client: &mut Client) -> Result<f32, End> {
        let start = Instant::now();
        self.run(client, Client::is_lit)?;
        Ok(start.elapsed().as_secs_f32())
    }

    fn run(&mut self, client: &mut Client, done: impl Fn(&Client) -> bool) -> Result<(), End> {
        let end = Instant::now() + PATIENCE;
        loop {
            let next = client.tick(self.start.elapsed());
            if done(client) {
                return Ok(());
            }
            if let Some(closed) = client.closed.take() {
                return Err(End::Closed(closed));
            }
            if Instant::now() >= end {
                return Err(End::Late);
            }
            let wait = next.map_or(PATIENCE, |next| next.saturating_sub(self.start.elapsed()));
            // A timeout is as good as a message.
            let _ = self.woken.recv_timeout(wait.min(Duration::from_secs(1)));
        }
    }

    /// A message of a kind that exists, with nonsense in it.
    fn send_garbage(&mut self, client: &mut Client, i: u64) {
        let mut message = vec![10 + (i % 4) as u8, 0];
        message.extend((0..i * 13).map(|_| (self.random() * 256.0) as u8));
        let id = TransmitId(1 << 40 | i);
        let channel = if i % 5 == 4 { Channel::Bulk } else { Channel::Control };
        if let Some(link) = &mut client.link {
            link.send(Transmit { id, channel, message });
        }
    }

    /// 0 to 1.
    fn random(&mut self) -> f32 {
        // xorshift64, Marsaglia 2003
        self.random ^= self.random << 13;
        self.random ^= self.random >> 7;
        self.random ^= self.random << 17;
        (self.random >> 40) as f32 / (1_u64 << 24) as f32
    }
}

/// Why something did not come to pass.
#[derive(Debug)]
enum End {
    Closed(Closed),
    Late,
    /// An answer that should have been another.
    Odd(String),
}

impl fmt::Display for End {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::Closed(closed) => closed.fmt(f),
            Self::Late => write!(f, "nothing after {} s", PATIENCE.as_secs()),
            Self::Odd(what) => f.write_str(what),
        }
    }
}
