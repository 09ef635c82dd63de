//! Where the time goes between a change of the scene and its light, stage by stage.

use std::time::Duration;

use farlight::{core::TimeWindow, gi::GiTimings};
use serde::Serialize;

use super::stats::quantile;

/// Names of the stages, in the order in which an update passes them, and the whole way.
pub const STAGES: [&str; 8] =
    ["extract", "send", "solve", "encode", "transfer", "decode", "upload", "whole"];

/// Times of frames and updates in milliseconds, taken out of the plugin's status.
#[derive(Clone, Debug, Default)]
pub struct Collected {
    /// CPU time of the plugin's systems, every frame.
    pub frame_cpu: Vec<f32>,
    /// The same in wall time.
    pub frame_wall: Vec<f32>,
    /// Times of each of [`STAGES`] while the light moved.
    stages: [Vec<f32>; STAGES.len()],
}

/// Middle and tail of a stage's times.
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize)]
pub struct Stage {
    /// Half of them are below.
    pub p50: f32,
    /// 90 % are below.
    pub p90: f32,
    /// How many there are.
    pub samples: usize,
}

impl Collected {
    /// Takes over what has been measured since the last call and forgets it there. The stages are
    /// kept if `moving`: at rest, updates wait for nothing and nobody waits for them.
    pub fn take(&mut self, timings: &mut GiTimings, moving: bool) {
        self.frame_cpu.extend(timings.frame.cpu.iter().map(ms));
        self.frame_wall.extend(timings.frame.wall.iter().map(ms));
        if moving {
            let windows: [&TimeWindow; STAGES.len()] = [
                &timings.extract.wall,
                &timings.send,
                &timings.solve,
                &timings.encode,
                &timings.transfer,
                &timings.decode,
                &timings.upload.wall,
                &timings.latency,
            ];
            for (stage, window) in self.stages.iter_mut().zip(windows) {
                stage.extend(window.iter().map(ms));
            }
        }
        timings.clear();
    }

    /// Order statistics of every stage.
    pub fn stages(&self) -> [(&'static str, Stage); STAGES.len()] {
        std::array::from_fn(|i| {
            let times = &self.stages[i];
            let at = |q| quantile(times, q).unwrap_or(0.0);
            (STAGES[i], Stage { p50: at(0.5), p90: at(0.9), samples: times.len() })
        })
    }
}

fn ms(time: Duration) -> f32 {
    time.as_secs_f32() * 1e3
}
