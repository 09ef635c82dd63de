//! Queries into vectors, and vectors into values.

use std::f32::consts::{FRAC_PI_2, PI};

use glam::Vec3;

use super::kernel::{Shared, Slices};
use super::lanes::{Avx2, Avx512, Float, Lanes, MOST, Words, Work};
use crate::{Backend, Btf, ColourSpace, Layout, Query, Rules, SliceAngles, ViewSlices};

/// Whether it was possible.
pub(super) fn evaluate(
    btf: &Btf,
    backend: Backend,
    queries: &[Query],
    rules: Rules,
    values: &mut [Vec3],
) -> bool {
    on(backend, btf, rules, Queries { queries, values })
}

/// Whether it was possible.
pub(super) fn evaluate_lights(
    btf: &Btf,
    backend: Backend,
    slices: &ViewSlices,
    lights: &[SliceAngles],
    rules: Rules,
    values: &mut [Vec3],
) -> bool {
    on(backend, btf, rules, Lights { slices, lights, values })
}

/// Does `task` on the backend, if the processor has it and the material allows it.
fn on(backend: Backend, btf: &Btf, rules: Rules, task: impl Task) -> bool {
    if backend == Backend::Scalar || btf.colour_space() != ColourSpace::YCbCr {
        return false;
    }
    let layout = btf.layout();
    let intervals = intervals(layout);
    let (Some(words), Some(intervals)) = (Words::new(btf.words()), Words::new(&intervals)) else {
        return false;
    };
    let work = Prepared { layout, words, intervals, rules, task };
    match backend {
        Backend::Scalar => return false,
        Backend::Avx2 => match Avx2::new() {
            Some(lanes) => lanes.run(work),
            None => return false,
        },
        Backend::Avx512 => match Avx512::new() {
            Some(lanes) => lanes.run(work),
            None => return false,
        },
    }
    true
}

/// What is to be evaluated; `run` must be inlined.
trait Task {
    fn run<L: Lanes>(self, shared: Shared<'_, L>);
}

struct Prepared<'a, T> {
    layout: &'a Layout,
    words: Words<'a>,
    intervals: Words<'a>,
    rules: Rules,
    task: T,
}

impl<T: Task> Work for Prepared<'_, T> {
    #[inline(always)]
    fn run<L: Lanes>(self, lanes: L) {
        let Self { layout, words, intervals, rules, task } = self;
        task.run(Shared { lanes, layout, words, intervals, rules });
    }
}

/// For each interval of beta where it begins, and 1 over its length, as bits.
fn intervals(layout: &Layout) -> Vec<u32> {
    let last = layout.beta_count - 1;
    let angle = |sample: u32| {
        let part = sample as f32 / last as f32;
        if layout.flags & Layout::BETA_IN_SINE != 0 {
            let half = last as f32 * 0.5;
            (sample as f32 / half - 1.0).clamp(-1.0, 1.0).asin()
        } else {
            PI * part - FRAC_PI_2
        }
    };
    let interval = |low| [angle(low), 1.0 / (angle(low + 1) - angle(low))];
    (0..last).flat_map(interval).map(f32::to_bits).collect()
}

struct Queries<'a> {
    queries: &'a [Query],
    values: &'a mut [Vec3],
}

impl Task for Queries<'_> {
    #[inline(always)]
    fn run<L: Lanes>(self, shared: Shared<'_, L>) {
        let Shared { lanes, layout, .. } = shared;
        let mut texel = [0; MOST];
        let mut angles = [[0.0; MOST]; 4];
        let mut result = [[0.0; MOST]; 3];
        for (queries, values) in self.queries.chunks(L::COUNT).zip(self.values.chunks_mut(L::COUNT))
        {
            // Lanes without a query keep an older one.
            for (lane, query) in queries.iter().enumerate() {
                let [x, y] = [wrap(query.x, layout.columns), wrap(query.y, layout.rows)];
                texel[lane] = y * layout.columns + x;
                angles[0][lane] = query.angles.theta_i;
                angles[1][lane] = query.angles.phi_i - query.angles.phi_v;
                angles[2][lane] = query.angles.theta_v;
                angles[3][lane] = query.angles.phi_v;
            }
            let [theta_i, difference, theta_v, phi_v] = angles.each_ref().map(|a| lanes.load(a));
            let slices = shared.view(lanes.load_int(&texel), theta_v, phi_v);
            let light = shared.light_of_angles(theta_i, difference);
            let horizon = lanes.float(FRAC_PI_2);
            let above = theta_i.at_most(horizon) & theta_v.at_most(horizon);
            for (channel, to) in shared.value(&slices, &light).into_iter().zip(&mut result) {
                lanes.store(channel.select(above, lanes.float(0.0)), to);
            }
            for (lane, value) in values.iter_mut().enumerate() {
                *value = Vec3::new(result[0][lane], result[1][lane], result[2][lane]);
            }
        }
    }
}

struct Lights<'a> {
    slices: &'a ViewSlices,
    lights: &'a [SliceAngles],
    values: &'a mut [Vec3],
}

impl Task for Lights<'_> {
    #[inline(always)]
    fn run<L: Lanes>(self, shared: Shared<'_, L>) {
        let lanes = shared.lanes;
        let slices = Slices {
            luminances: self.slices.luminances.map(|row| lanes.int(row)),
            chromas: self.slices.chromas.map(|row| lanes.int(row)),
            weights: self.slices.weights.map(|weight| lanes.float(weight)),
        };
        let mut angles = [[0.0; MOST]; 3];
        let mut result = [[0.0; MOST]; 3];
        for (lights, values) in self.lights.chunks(L::COUNT).zip(self.values.chunks_mut(L::COUNT)) {
            // Lanes without a light keep an older one.
            for (lane, light) in lights.iter().enumerate() {
                angles[0][lane] = light.alpha;
                angles[1][lane] = light.beta;
                angles[2][lane] = light.sin_beta;
            }
            let [alpha, beta, sin_beta] = angles.each_ref().map(|a| lanes.load(a));
            let light = shared.light(alpha, beta, sin_beta);
            for (channel, to) in shared.value(&slices, &light).into_iter().zip(&mut result) {
                lanes.store(channel, to);
            }
            for (lane, value) in values.iter_mut().enumerate() {
                *value = Vec3::new(result[0][lane], result[1][lane], result[2][lane]);
            }
        }
    }
}

/// `at` reduced to what is below `count`; mostly it is.
#[inline(always)]
fn wrap(at: i32, count: u32) -> u32 {
    if (at as u32) < count { at as u32 } else { at.rem_euclid(count as i32) as u32 }
}
