//! A client without a game: a session, its link, and the light that arrives.

#![allow(dead_code, reason = "not everyone who includes this file needs all of it")]

use std::{collections::BTreeMap, time::Duration};

use farlight_gi_solver::{
    atlas::PageId,
    scene::InstanceId,
    session::{Placement, SessionChange, SnapshotId, Tile},
};
use farlight_wire::{
    ClientConfig, ClientEvent, ClientSession, CloseCode, Closed, Limits, Link, LinkEvent, Token,
};
use glam::Vec3;

use crate::scene;

/// Drives a session over whatever link it has.
pub(crate) struct Client {
    pub(crate) session: ClientSession,
    pub(crate) link: Option<Box<dyn Link>>,
    /// Whether the link is open.
    pub(crate) open: bool,
    /// Why the last link ended.
    pub(crate) closed: Option<Closed>,
    /// Whether the server let it in over this link, and if so whether it still had the session.
    pub(crate) welcomed: Option<bool>,
    /// Messages that were sent and received.
    pub(crate) sent: u64,
    pub(crate) received: u64,
    pub(crate) light: Light,
    snapshot: SnapshotId,
}

/// Light as it arrived.
#[derive(Default)]
pub(crate) struct Light {
    /// Texels E / π by page, rows from the top.
    pub(crate) pages: BTreeMap<PageId, Vec<Vec3>>,
    /// Where each receiver lies.
    pub(crate) placements: BTreeMap<InstanceId, Placement>,
    /// The newest snapshot that it shows.
    pub(crate) snapshot: SnapshotId,
    /// Messages so far.
    pub(crate) messages: u64,
}

impl Client {
    pub(crate) fn new(name: &str, token: Token) -> Self {
        let session = ClientSession::new(ClientConfig {
            name: name.to_owned(),
            token,
            settings: scene::settings(),
            limits: Limits::default(),
        });
        Self::with(session)
    }

    pub(crate) fn with(session: ClientSession) -> Self {
        Self {
            session,
            link: None,
            open: false,
            closed: None,
            welcomed: None,
            sent: 0,
            received: 0,
            light: Light::default(),
            snapshot: SnapshotId::default(),
        }
    }

    /// Goes on over this link. The old one, if any, is cut without a word.
    pub(crate) fn use_link(&mut self, link: Box<dyn Link>) {
        self.cut();
        (self.closed, self.welcomed) = (None, None);
        self.link = Some(link);
    }

    /// Drops the link without a word.
    pub(crate) fn cut(&mut self) {
        if self.link.take().is_some() {
            self.session.disconnected();
        }
        self.open = false;
    }

    /// Says goodbye.
    pub(crate) fn close(&mut self) {
        if let Some(link) = &mut self.link {
            link.close(CloseCode::Done, "");
        }
        self.cut();
    }

    /// Changes the scene.
    pub(crate) fn submit(&mut self, now: Duration, changes: Vec<SessionChange>) {
        self.snapshot.0 += 1;
        self.session.submit(now, self.snapshot, changes);
    }

    /// Whether the light shows the newest scene and isn't black.
    pub(crate) fn is_lit(&self) -> bool {
        self.welcomed.is_some()
            && self.light.snapshot == self.snapshot
            && self.light.pages.values().flatten().any(|texel| texel.max_element() > 0.0)
    }

    /// Does what is to be done at `now`; when to be called again if nothing arrives.
    pub(crate) fn tick(&mut self, now: Duration) -> Option<Duration> {
        while let Some(event) = self.link.as_mut()?.poll() {
            match event {
                LinkEvent::Opened => {
                    self.open = true;
                    self.session.connected(now);
                }
                LinkEvent::Received(channel, message) => {
                    self.received += 1;
                    if let Err(error) = self.session.receive(now, channel, &message) {
                        panic!("the server sent nonsense: {error}");
                    }
                }
                LinkEvent::Sent(id) => self.session.sent(now, id),
                LinkEvent::Closed(closed) => {
                    self.closed = Some(closed);
                    self.cut();
                    return None;
                }
            }
            while let Some(event) = self.session.poll_event() {
                self.note(event);
            }
        }
        let link = self.link.as_mut()?;
        while let Some(transmit) = self.session.poll_transmit(now) {
            self.sent += 1;
            link.send(transmit);
        }
        self.session.next_timeout()
    }

    fn note(&mut self, event: ClientEvent) {
        match event {
            ClientEvent::Welcomed { resumed, .. } => {
                self.welcomed = Some(resumed);
                if !resumed {
                    // The server will arrange the pages anew.
                    self.light = Light::default();
                }
            }
            ClientEvent::Lighting { message, .. } => {
                self.light.messages += 1;
                self.light.snapshot = message.snapshot;
                message.placements.iter().for_each(|placement| self.light.place(placement));
                message.tiles.iter().for_each(|tile| self.light.paint(&tile.to_tile()));
            }
            ClientEvent::Notice(_) => {}
        }
    }
}

const EDGE: usize = 64;

impl Light {
    pub(crate) fn place(&mut self, placement: &Placement) {
        self.placements.insert(placement.instance, *placement);
    }

    pub(crate) fn paint(&mut self, tile: &Tile) {
        let page = self.pages.entry(tile.page).or_insert_with(|| vec![Vec3::ZERO; EDGE * EDGE]);
        for (y, row) in tile.texels.chunks(tile.rect.width as usize).enumerate() {
            let from = (tile.rect.y as usize + y) * EDGE + tile.rect.x as usize;
            page[from..from + row.len()].copy_from_slice(row);
        }
    }

    /// The texels of a receiver, rows from the top.
    pub(crate) fn texels(&self, placement: &Placement) -> Vec<Vec3> {
        let rect = placement.rect;
        let Some(page) = self.pages.get(&placement.page) else { return Vec::new() };
        let row = |y| {
            let from = y as usize * EDGE + rect.x as usize;
            page[from..from + rect.width as usize].iter().copied()
        };
        (rect.y..rect.y + rect.height).flat_map(row).collect()
    }
}
