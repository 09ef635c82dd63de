//! What the examples that time frames share: their options, and the time of a frame.

use std::{
    path::PathBuf,
    time::{Duration, Instant},
};

use bevy::{
    prelude::*,
    render::{render_resource::PollType, renderer::RenderDevice},
};
use farlight::core::process_cpu_time;
use serde::Serialize;

use super::headless::Headless;

/// Options of each of them.
pub struct FrameOptions {
    pub rounds: usize,
    pub fastest: bool,
    pub json: Option<PathBuf>,
    pub out: Option<PathBuf>,
}

impl FrameOptions {
    /// Nothing but frames that count.
    pub fn new(rounds: usize) -> Self {
        Self { rounds, fastest: false, json: None, out: None }
    }

    /// Takes an argument if it is one of these.
    pub fn take(
        &mut self,
        arg: &str,
        value: &mut dyn FnMut() -> Result<String, String>,
    ) -> Result<bool, String> {
        match arg {
            "--rounds" => {
                let text = value()?;
                let rounds = text.parse().ok().filter(|rounds| (1..=100_000).contains(rounds));
                self.rounds = rounds.ok_or(format!("--rounds: not '{text}'"))?;
            }
            "--fastest" => self.fastest = true,
            "--json" => self.json = Some(value()?.into()),
            "--out" => self.out = Some(value()?.into()),
            _ => return Ok(false),
        }
        Ok(true)
    }

    /// The time that counts, in milliseconds: the median, or the shortest with `--fastest`.
    pub fn counts(&self, mut times: Vec<Duration>) -> f64 {
        times.sort();
        times[if self.fastest { 0 } else { times.len() / 2 }].as_secs_f64() * 1e3
    }

    /// Writes the figures for programs, where that was asked for.
    pub fn write(&self, report: &impl Serialize) -> Result<(), String> {
        let Some(path) = &self.json else { return Ok(()) };
        let text = serde_json::to_string_pretty(report).map_err(|error| error.to_string())?;
        std::fs::write(path, text).map_err(|error| format!("{}: {error}", path.display()))
    }
}

/// `WIDTHxHEIGHT`.
pub fn size(text: &str) -> Result<UVec2, String> {
    let side = |text: &str| text.parse().ok().filter(|side| (16..=4096).contains(side));
    text.split_once('x')
        .and_then(|(width, height)| Some(UVec2::new(side(width)?, side(height)?)))
        .ok_or(format!("--size needs WIDTHxHEIGHT, 16 to 4096 a side, not '{text}'"))
}

/// What a frame takes.
pub struct FrameTime {
    /// Until the device has drawn it.
    pub wall: Duration,
    /// Of all threads; zero where the system doesn't say.
    pub cpu: Duration,
}

/// Draws a frame, to the end.
pub fn frame(headless: &mut Headless) -> Result<FrameTime, String> {
    let (start, cpu) = (Instant::now(), process_cpu_time().unwrap_or_default());
    headless.update()?;
    let device = headless.app.world().resource::<RenderDevice>();
    device.poll(PollType::wait_indefinitely()).map_err(|error| error.to_string())?;
    let cpu = process_cpu_time().unwrap_or_default().saturating_sub(cpu);
    Ok(FrameTime { wall: start.elapsed(), cpu })
}
