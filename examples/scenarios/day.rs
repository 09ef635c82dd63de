//! Which scenarios make up which hour.

use bevy::prelude::*;
use farlight::prelude::*;

/// First and last hour.
pub const HOURS: [f32; 2] = [6.0, 22.0];

/// Hours a second.
const SPEED: f32 = 0.8;

/// What time it is.
#[derive(Resource, Clone, Copy, Debug)]
pub struct Day {
    /// Hours since midnight.
    pub hour: f32,
    /// Whether time stands still.
    pub paused: bool,
    /// Whether the lamp is on; by the hour if nobody says.
    pub lamp: Option<bool>,
}

impl Default for Day {
    fn default() -> Self {
        Self { hour: 9.0, paused: false, lamp: None }
    }
}

/// Hour, and how much of morning, noon and evening there is.
const SUN: [(f32, [f32; 3]); 5] = [
    (5.5, [0.0, 0.0, 0.0]),
    (8.0, [1.0, 0.0, 0.0]),
    (12.5, [0.0, 1.0, 0.0]),
    (18.0, [0.0, 0.0, 1.0]),
    (20.5, [0.0, 0.0, 0.0]),
];

/// Hour, and exposure of the camera as EV100: eyes get used to the dark.
const EYES: [(f32, [f32; 1]); 5] =
    [(5.5, [4.5]), (8.0, [9.6]), (12.5, [10.6]), (18.0, [9.2]), (20.5, [4.5])];

/// Hour, and how bright the lamp is.
const LAMP: [(f32, [f32; 1]); 4] = [(6.5, [1.0]), (7.0, [0.0]), (18.5, [0.0]), (19.0, [1.0])];

impl Day {
    /// The scenarios' weights. The sun's sum to 1 in daylight: a mean of states. The lamp was baked alone:
    /// its light is added, as bright as it is.
    pub fn weights(&self) -> ScenarioWeights {
        let [morning, noon, evening] = at(&SUN, self.hour);
        let [by_itself] = at(&LAMP, self.hour);
        let lamp = self.lamp.map_or(by_itself, |on| f32::from(u8::from(on)));
        [("morning", morning), ("noon", noon), ("evening", evening), ("lamp", lamp)]
            .into_iter()
            .collect()
    }

    /// The camera's exposure.
    pub fn ev100(&self) -> f32 {
        at(&EYES, self.hour)[0]
    }
}

/// Between the two nearest rows of a table.
fn at<const N: usize>(table: &[(f32, [f32; N])], hour: f32) -> [f32; N] {
    let next = table.iter().position(|(at, _)| *at > hour).unwrap_or(table.len());
    let row = |index: usize| table[index.min(table.len() - 1)];
    let ((from, a), (to, b)) = (row(next.saturating_sub(1)), row(next));
    let t = if to > from { ((hour - from) / (to - from)).clamp(0.0, 1.0) } else { 0.0 };
    std::array::from_fn(|i| a[i] + (b[i] - a[i]) * t)
}

/// Lets time pass, there and back.
pub fn pass(time: Res<Time>, mut day: ResMut<Day>, mut back: Local<bool>) {
    if day.paused {
        return;
    }
    let step = SPEED * time.delta_secs();
    day.hour += if *back { -step } else { step };
    *back = match day.hour {
        hour if hour >= HOURS[1] => true,
        hour if hour <= HOURS[0] => false,
        _ => *back,
    };
    day.hour = day.hour.clamp(HOURS[0], HOURS[1]);
}
