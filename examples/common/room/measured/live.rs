//! Runs the app frame by frame at a steady rate and watches what is written.

use std::time::{Duration, Instant};

use bevy::{
    ecs::message::{MessageCursor, Messages},
    prelude::*,
};
use farlight::prelude::*;
use farlight_gi_solver::{Scene, session::SnapshotId};

use super::{
    headless::Headless,
    motion::Traveller,
    record::Log,
    scene::{Ball, Lamp},
    stages::Collected,
};

/// The app while it is measured.
pub struct Live {
    /// The app.
    pub headless: Headless,
    /// What goes to and comes from the solver.
    pub log: Log,
    /// Time from frame to frame that is aimed for.
    pub pace: Duration,
    /// Times from frame to frame in milliseconds.
    pub frame_ms: Vec<f32>,
    /// Times of frames and of stages.
    pub collected: Collected,
    /// Keep the texels of every write in `writes`.
    pub keep_texels: bool,
    /// Writes since this was last emptied.
    pub writes: Vec<Write>,
    last_frame: Instant,
    cursor: MessageCursor<GiUpdated>,
    pending: Vec<Pending>,
    /// Instants asked for with [`Live::remember`], in that order.
    pub instants: Vec<Moment>,
}

/// What a frame showed is asked for, and not known yet.
struct Pending {
    at: Instant,
    frame: usize,
    scene: Scene,
}

/// An update that is in the textures.
pub struct Write {
    /// The newest snapshot that it shows.
    pub snapshot: SnapshotId,
    /// When its first texels were written.
    pub first: Instant,
    /// When all were.
    pub all: Instant,
    /// All pages after it, one after the other; empty unless asked for.
    pub texels: Vec<Vec3>,
}

/// What a frame showed, and the scene of that frame.
pub struct Moment {
    /// The scene.
    pub scene: Scene,
    /// All pages, one after the other.
    pub texels: Vec<Vec3>,
}

impl Live {
    /// Watches `headless`, whose backend is recorded in `log`.
    pub fn new(headless: Headless, log: Log, pace: Duration) -> Self {
        Self {
            headless,
            log,
            pace,
            frame_ms: Vec::new(),
            collected: Collected::default(),
            keep_texels: false,
            writes: Vec::new(),
            last_frame: Instant::now(),
            cursor: MessageCursor::default(),
            pending: Vec::new(),
            instants: Vec::new(),
        }
    }

    /// Runs one frame, no sooner than the pace allows.
    pub fn frame(&mut self) -> Result<(), String> {
        std::thread::sleep(self.pace.saturating_sub(self.last_frame.elapsed()));
        self.frame_ms.push(self.last_frame.elapsed().as_secs_f32() * 1e3);
        self.last_frame = Instant::now();
        self.headless.update()?;
        self.take_writes();
        Ok(())
    }

    /// Runs frames for a while, at least one.
    pub fn run(&mut self, time: Duration) -> Result<(), String> {
        let start = Instant::now();
        loop {
            self.frame()?;
            if start.elapsed() >= time {
                return Ok(());
            }
        }
    }

    /// Remembers what the last frame showed. It is known one or two frames later.
    pub fn remember(&mut self) {
        let (at, frame) = (Instant::now(), self.frame_ms.len());
        self.pending.push(Pending { at, frame, scene: self.log.lock().scene.clone() });
    }

    /// Changes the lamp's travelling.
    pub fn lamp(&mut self, change: impl FnMut(Mut<Traveller>)) {
        let world = self.headless.app.world_mut();
        let mut lamps = world.query_filtered::<&mut Traveller, With<Lamp>>();
        lamps.iter_mut(world).for_each(change);
    }

    /// Changes the ball's travelling.
    pub fn ball(&mut self, change: impl FnMut(Mut<Traveller>)) {
        let world = self.headless.app.world_mut();
        let mut balls = world.query_filtered::<&mut Traveller, With<Ball>>();
        balls.iter_mut(world).for_each(change);
    }

    /// Switches the camera's multisampling on or off.
    pub fn smooth_edges(&mut self, on: bool) -> Result<(), String> {
        let world = self.headless.app.world_mut();
        let mut cameras = world.query_filtered::<&mut Msaa, With<Camera3d>>();
        let msaa = if on { Msaa::Sample4 } else { Msaa::Off };
        for mut camera in cameras.iter_mut(world) {
            *camera = msaa;
        }
        self.frame()
    }

    /// Takes the times since the last call out of the plugin's status; see [`Collected::take`].
    pub fn collect(&mut self, moving: bool) {
        let mut status = self.headless.app.world_mut().resource_mut::<GiStatus>();
        self.collected.take(&mut status.timings, moving);
    }

    /// How the plugin is doing.
    pub fn status_mut(&mut self) -> Mut<'_, GiStatus> {
        self.headless.app.world_mut().resource_mut()
    }

    /// Multiplies the lamp's intensity.
    pub fn scale_lamp(&mut self, factor: f32) {
        let world = self.headless.app.world_mut();
        let mut lamps = world.query_filtered::<&mut PointLight, With<Lamp>>();
        lamps.iter_mut(world).for_each(|mut lamp| lamp.intensity *= factor);
    }

    /// Takes over what the plugin says was written, in order, and answers [`Live::remember`].
    fn take_writes(&mut self) {
        let messages = self.headless.app.world().resource::<Messages<GiUpdated>>();
        let updates: Vec<GiUpdated> = self.cursor.read(messages).copied().collect();
        let mut state = self.log.lock();
        // Writes of the last frame are told in this one: what is pending was asked before.
        for update in updates {
            while self.pending.first().is_some_and(|p| p.at < update.all_written) {
                let scene = self.pending.remove(0).scene;
                self.instants.push(Moment { scene, texels: state.pages.concat() });
            }
            state.confirm_written();
            self.writes.push(Write {
                snapshot: update.snapshot,
                first: update.first_write,
                all: update.all_written,
                texels: if self.keep_texels { state.pages.concat() } else { Vec::new() },
            });
        }
        while self.pending.first().is_some_and(|p| p.frame + 2 <= self.frame_ms.len()) {
            let scene = self.pending.remove(0).scene;
            self.instants.push(Moment { scene, texels: state.pages.concat() });
        }
    }

    /// Runs the two frames after which everything that was asked for is known.
    pub fn flush(&mut self) -> Result<(), String> {
        self.frame()?;
        self.frame()
    }
}
