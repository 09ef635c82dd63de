//! A client and a server session with a line between them that does as it is told.

use std::time::Duration;

use farlight_gi_solver::{
    Scene,
    atlas::{PageId, TexelRect},
    session::{
        GridId, GridUpdate, LightingUpdate, Quality, SessionChange, SessionSettings, SnapshotId,
        Tile,
    },
    sh::ShRgb,
};
use farlight_wire::{
    BlobStore, Channel, ClientConfig, ClientEvent, ClientHello, ClientSession, Limits,
    ServerConfig, ServerSession, Token, Transmit,
};
use glam::{UVec3, Vec3};

/// Edge of a lightmap page.
pub(crate) const EDGE: u32 = 64;

pub(crate) struct Pair {
    pub(crate) now: Duration,
    pub(crate) client: ClientSession,
    pub(crate) server: ServerSession,
    pub(crate) store: BlobStore,
    pub(crate) to_server: Vec<Transmit>,
    pub(crate) to_client: Vec<Transmit>,
    /// The scene as the server's solver would have it.
    pub(crate) solver: Scene,
    pub(crate) receivers: Vec<SessionChange>,
    /// Texels as the client shows them, and the newest snapshot that it says it shows.
    pub(crate) texels: Vec<[u16; 3]>,
    pub(crate) shown: SnapshotId,
    /// Probes as the client shows them.
    pub(crate) probes: Vec<[[u16; 3]; 9]>,
    /// Bytes of messages by channel that left the client since this was last reset.
    pub(crate) sent: [usize; 3],
    pub(crate) messages: usize,
    sessions: u8,
}

/// Resolution of the grid: more than one run.
pub(crate) const PROBES: UVec3 = UVec3::new(13, 11, 5);

/// Probes that differ from place to place and from time to time.
pub(crate) fn grid(time: f32) -> GridUpdate {
    let probe = |i: u32| {
        let mut probe = ShRgb::ZERO;
        let towards = Vec3::new((i as f32).sin(), (i as f32 * 0.7).cos(), (time * 0.1).sin());
        probe.add_direction(towards.normalize_or(Vec3::Y), Vec3::new(1.0, 0.5, 2.0) * time);
        probe
    };
    let probes = (0..PROBES.element_product()).map(probe).collect();
    GridUpdate { grid: GridId(4), resolution: PROBES, probes }
}

pub(crate) fn settings() -> SessionSettings {
    SessionSettings { page_size: EDGE, max_pages: 1, ..Default::default() }
}

impl Pair {
    pub(crate) fn new() -> Self {
        let config = ClientConfig {
            name: "test".into(),
            token: Token([1; 16]),
            settings: settings(),
            limits: Limits::default(),
        };
        Self {
            now: Duration::ZERO,
            client: ClientSession::new(config),
            server: server(0),
            store: BlobStore::new(0),
            to_server: Vec::new(),
            to_client: Vec::new(),
            solver: Scene::default(),
            receivers: Vec::new(),
            texels: vec![[0; 3]; (EDGE * EDGE) as usize],
            shown: SnapshotId::default(),
            probes: vec![[[0; 3]; 9]; PROBES.element_product() as usize],
            sent: [0; 3],
            messages: 0,
            sessions: 0,
        }
    }

    pub(crate) fn pass(&mut self, milliseconds: u64) {
        self.now += Duration::from_millis(milliseconds);
    }

    /// A new connection, to a server that has the session or not. What was on the line is lost.
    pub(crate) fn connect(&mut self, same_server: bool) {
        self.cut();
        if !same_server {
            self.sessions += 1;
            self.server = server(self.sessions);
            self.store = BlobStore::new(0);
            self.solver = Scene::default();
            self.receivers.clear();
        }
        self.client.connected(self.now);
        let hello = self.client.poll_transmit(self.now).expect("a greeting");
        let hello = ClientHello::read(hello.channel, &hello.message, &Limits::default()).unwrap();
        let resumed = hello.resume == Some(self.server.key());
        assert_eq!(hello.token, Token([1; 16]));
        self.server.attach(self.now, resumed);
    }

    pub(crate) fn cut(&mut self) {
        self.client.disconnected();
        self.server.detach();
        self.to_server.clear();
        self.to_client.clear();
    }

    /// Takes what both sides want to send.
    pub(crate) fn collect(&mut self) {
        while let Some(transmit) = self.client.poll_transmit(self.now) {
            self.client.sent(self.now, transmit.id);
            self.sent[transmit.channel.tag() as usize - 1] += transmit.message.len();
            self.messages += 1;
            self.to_server.push(transmit);
        }
        while let Some(transmit) = self.server.poll_transmit(self.now) {
            self.messages += 1;
            self.to_client.push(transmit);
        }
        while let Some(id) = self.server.poll_cancel() {
            self.to_client.retain(|t| t.id != id);
        }
    }

    /// Delivers the message at an index.
    pub(crate) fn deliver_to_server(&mut self, index: usize) {
        let Transmit { channel, message, .. } = self.to_server.remove(index);
        self.server.receive(self.now, channel, &message, &self.store).unwrap();
        while let Some((_, changes)) = self.server.take_changes() {
            for change in changes {
                match change {
                    SessionChange::Scene(change) => self.solver.apply(change),
                    other => self.receivers.push(other),
                }
            }
        }
    }

    pub(crate) fn deliver_to_client(&mut self, index: usize) {
        let Transmit { channel, message, .. } = self.to_client.remove(index);
        self.client.receive(self.now, channel, &message).unwrap();
        while let Some(event) = self.client.poll_event() {
            let ClientEvent::Lighting { message, .. } = event else { continue };
            assert!(message.snapshot >= self.shown, "snapshots don't go back");
            self.shown = message.snapshot;
            for run in message.grids {
                let first = run.first as usize;
                self.probes[first..first + run.probes.len()].copy_from_slice(&run.probes);
            }
            for tile in message.tiles {
                let TexelRect { x, y, width, .. } = tile.rect;
                for (i, texel) in tile.texels.iter().enumerate() {
                    let (column, row) = (i as u32 % width, i as u32 / width);
                    self.texels[((y + row) * EDGE + x + column) as usize] = *texel;
                }
            }
        }
    }

    /// The first message on the line that may be delivered now: control messages in order.
    pub(crate) fn is_next(line: &[Transmit], index: usize) -> bool {
        line[index].channel != Channel::Control
            || line[..index].iter().all(|t| t.channel != Channel::Control)
    }

    /// Delivers everything until both are silent.
    pub(crate) fn settle(&mut self) {
        for _ in 0..10_000 {
            self.collect();
            if self.to_server.is_empty() && self.to_client.is_empty() {
                return;
            }
            while !self.to_server.is_empty() {
                self.deliver_to_server(0);
            }
            while !self.to_client.is_empty() {
                self.deliver_to_client(0);
            }
        }
        panic!("they never fall silent");
    }
}

fn server(session: u8) -> ServerSession {
    ServerSession::new(Token([100 + session; 16]), settings(), ServerConfig::default())
}

/// An update of some tiles of 8 by 8 texels.
pub(crate) fn update(snapshot: u64, tiles: &[(u32, u32, f32)]) -> LightingUpdate {
    let tiles = tiles.iter().map(|&(column, row, value)| Tile {
        page: PageId(0),
        rect: TexelRect { x: column * 8, y: row * 8, width: 8, height: 8 },
        texels: vec![Vec3::splat(value); 64],
    });
    LightingUpdate {
        snapshot: SnapshotId(snapshot),
        placements: Vec::new(),
        refused: Vec::new(),
        tiles: tiles.collect(),
        grids: Vec::new(),
        quality: Quality::default(),
    }
}
