//! Interpolation between directions on the hemisphere.

use std::f32::consts::{FRAC_PI_2, PI, TAU};

use glam::Vec3;

use super::Direction;

/// Elevations that differ by less are one ring: 0.05 degrees.
const SAME: f32 = 0.05 * PI / 180.0;
/// Samples that certainly have a weight where directions are scattered.
const NEAREST: usize = 4;
/// How much farther than the last of these a sample may be and still have a weight.
const REACH: f32 = 1.25;

/// Weights of samples for any direction: continuous, and exactly 1 at a sample. Beyond the outermost
/// sample the direction counts as that far from the normal.
#[derive(Clone, Debug)]
pub(super) struct Hemisphere {
    arrangement: Arrangement,
    /// Elevation of the outermost sample.
    outermost: f32,
}

#[derive(Clone, Debug)]
enum Arrangement {
    /// Linear between rings, and along each ring between its samples.
    Rings(Vec<Ring>),
    /// By inverse distance within a reach (Franke and Nielson, *Smooth interpolation of large sets
    /// of scattered data*, International Journal for Numerical Methods in Engineering 15, 1980):
    /// weights ((r - d) / (r d))^2, where r is a little more than the distance of the fourth
    /// nearest sample.
    Scattered(Vec<Vec3>),
}

/// Samples of one elevation.
#[derive(Clone, Debug)]
struct Ring {
    theta: f32,
    /// Azimuth and number of each, sorted.
    samples: Vec<(f32, u32)>,
}

impl Hemisphere {
    /// Of directions above the horizon, at least one.
    pub(super) fn new(directions: &[Direction]) -> Self {
        let outermost = directions.iter().map(Direction::theta).fold(0.0, f32::max);
        let arrangement = match rings(directions) {
            Some(rings) => Arrangement::Rings(rings),
            None => Arrangement::Scattered(directions.iter().map(Direction::vector).collect()),
        };
        Self { arrangement, outermost }
    }

    /// How many rings the samples form, if they do.
    pub(super) fn ring_count(&self) -> Option<usize> {
        match &self.arrangement {
            Arrangement::Rings(rings) => Some(rings.len()),
            Arrangement::Scattered(_) => None,
        }
    }

    /// How much less light arrives than from the outermost sample, if the direction is beyond it.
    pub(super) fn falloff(&self, theta: f32) -> f32 {
        if theta > self.outermost {
            // At the horizon the cosine of 90 degrees is not quite 0.
            if theta >= FRAC_PI_2 { 0.0 } else { theta.cos() / self.outermost.cos() }
        } else {
            1.0
        }
    }

    /// Calls `weight` with each sample that matters and its share; shares sum to 1.
    pub(super) fn weights(&self, theta: f32, phi: f32, mut weight: impl FnMut(u32, f32)) {
        let theta = theta.clamp(0.0, self.outermost);
        match &self.arrangement {
            Arrangement::Rings(rings) => between_rings(rings, theta, phi, &mut weight),
            Arrangement::Scattered(samples) => {
                let direction = Direction::from_radians(theta, phi).vector();
                scattered(samples, direction, &mut weight);
            }
        }
    }
}

/// Rings, if all samples but those at the pole lie in rings without large gaps.
fn rings(directions: &[Direction]) -> Option<Vec<Ring>> {
    let mut order: Vec<u32> = (0..directions.len() as u32).collect();
    let theta = |sample: u32| directions[sample as usize].theta();
    order.sort_by(|a, b| theta(*a).total_cmp(&theta(*b)));
    let mut rings: Vec<Ring> = Vec::new();
    for sample in order {
        let place = (directions[sample as usize].phi(), sample);
        match rings.last_mut() {
            Some(ring) if theta(sample) - ring.theta < SAME => ring.samples.push(place),
            _ => rings.push(Ring { theta: theta(sample), samples: vec![place] }),
        }
    }
    for ring in &mut rings {
        ring.samples.sort_by(|a, b| a.0.total_cmp(&b.0));
        let ends = (ring.samples.first()?.0, ring.samples.last()?.0);
        let gaps = ring.samples.windows(2).map(|two| two[1].0 - two[0].0);
        let widest = gaps.fold(ends.0 + TAU - ends.1, f32::max);
        let pole = ring.theta < SAME && ring.samples.len() == 1;
        if !pole && widest > 0.51 * TAU {
            return None;
        }
    }
    Some(rings)
}

fn between_rings(rings: &[Ring], theta: f32, phi: f32, weight: &mut impl FnMut(u32, f32)) {
    let above = rings.partition_point(|ring| ring.theta <= theta);
    let Some(upper) = rings.get(above) else {
        if let Some(last) = rings.last() {
            along(last, phi, 1.0, weight);
        }
        return;
    };
    match above.checked_sub(1).and_then(|below| rings.get(below)) {
        Some(lower) => {
            let share = (theta - lower.theta) / (upper.theta - lower.theta);
            along(lower, phi, 1.0 - share, weight);
            along(upper, phi, share, weight);
        }
        // No sample at the pole: the mean of the first ring stands there.
        None => {
            let share = theta / upper.theta;
            let each = (1.0 - share) / upper.samples.len() as f32;
            upper.samples.iter().for_each(|(_, sample)| weight(*sample, each));
            along(upper, phi, share, weight);
        }
    }
}

/// Linear between two samples of a ring.
fn along(ring: &Ring, phi: f32, total: f32, weight: &mut impl FnMut(u32, f32)) {
    let count = ring.samples.len();
    if total == 0.0 || count == 0 {
        return;
    }
    let phi = phi.rem_euclid(TAU);
    let behind = ring.samples.partition_point(|(sample, _)| *sample <= phi);
    let (low, high) = ((behind + count - 1) % count, behind % count);
    let (from, first) = ring.samples[low];
    let (to, second) = ring.samples[high];
    let gap = (to - from).rem_euclid(TAU);
    let share = if gap > 0.0 { ((phi - from).rem_euclid(TAU) / gap).clamp(0.0, 1.0) } else { 0.0 };
    for (sample, share) in [(first, 1.0 - share), (second, share)] {
        if share > 0.0 {
            weight(sample, total * share);
        }
    }
}

fn scattered(samples: &[Vec3], direction: Vec3, weight: &mut impl FnMut(u32, f32)) {
    // The distances of the nearest ones, sorted.
    let mut nearest = [f32::INFINITY; NEAREST];
    for (number, sample) in (0..).zip(samples) {
        let distance = sample.distance(direction);
        if distance < 1e-6 {
            return weight(number, 1.0);
        }
        let place = nearest.partition_point(|other| *other <= distance);
        if place < NEAREST {
            nearest[place..].rotate_right(1);
            nearest[place] = distance;
        }
    }
    // Fewer samples than that all have a weight; chords are at most 2.
    let reach = REACH * nearest[NEAREST - 1].min(2.0);
    let share = |sample: &Vec3| {
        let distance = sample.distance(direction);
        if distance < reach { ((reach - distance) / (reach * distance)).powi(2) } else { 0.0 }
    };
    let sum: f32 = samples.iter().map(share).sum();
    for (number, sample) in (0..).zip(samples) {
        let share = share(sample);
        if share > 0.0 {
            weight(number, share / sum);
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn directions(degrees: &[(f64, f64)]) -> Vec<Direction> {
        degrees.iter().map(|(theta, phi)| Direction::from_degrees(*theta, *phi)).collect()
    }

    /// The 81 directions of the Bonn measurements.
    pub(crate) fn grid() -> Vec<Direction> {
        let mut all = vec![(0.0, 0.0)];
        for (ring, count) in [(1, 6), (2, 12), (3, 18), (4, 20), (5, 24)] {
            all.extend(
                (0..count)
                    .map(|k| (15.0 * f64::from(ring), f64::from(k) * 360.0 / f64::from(count))),
            );
        }
        directions(&all)
    }

    fn weights(hemisphere: &Hemisphere, direction: Direction, count: usize) -> Vec<f32> {
        let mut all = vec![0.0; count];
        hemisphere.weights(direction.theta(), direction.phi(), |sample, weight| {
            all[sample as usize] += weight;
        });
        all
    }

    fn arrangements() -> [(Vec<Direction>, Option<usize>); 5] {
        [
            (grid(), Some(6)),
            // No pole.
            (grid()[1..].to_vec(), Some(5)),
            // Along a spiral.
            (
                directions(
                    &(0..40)
                        .map(|k| (f64::from(k) * 2.0, f64::from(k) * 137.5))
                        .collect::<Vec<_>>(),
                ),
                None,
            ),
            (directions(&[(20.0, 0.0), (30.0, 100.0), (80.0, 250.0)]), None),
            (directions(&[(0.0, 0.0)]), Some(1)),
        ]
    }

    #[test]
    fn weights_are_shares_and_exact_at_samples() {
        for (samples, rings) in arrangements() {
            let hemisphere = Hemisphere::new(&samples);
            assert_eq!(hemisphere.ring_count(), rings);
            for (number, sample) in samples.iter().enumerate() {
                let found = weights(&hemisphere, *sample, samples.len());
                assert_eq!(found[number], 1.0, "{sample:?}");
            }
            for step in 0..2000 {
                let direction =
                    Direction::from_degrees(f64::from(step % 91), f64::from(step) * 1.7);
                let found = weights(&hemisphere, direction, samples.len());
                assert!((found.iter().sum::<f32>() - 1.0).abs() < 1e-5, "{direction:?}");
                assert!(found.iter().all(|weight| *weight >= 0.0));
            }
        }
    }

    #[test]
    fn weights_are_continuous() {
        for (samples, _) in arrangements() {
            let hemisphere = Hemisphere::new(&samples);
            // Round the hemisphere on a path that crosses rings, the azimuth 0 and the pole.
            let at = |step: i32| {
                let turn = f64::from(step) * 2e-5;
                Direction::from_degrees((89.0 * (turn * 7.3).sin()).abs(), 360.0 * turn)
            };
            let mut before = weights(&hemisphere, at(0), samples.len());
            for step in 1..100_000 {
                let now = weights(&hemisphere, at(step), samples.len());
                let jump = before.iter().zip(&now).map(|(a, b)| (a - b).abs()).fold(0.0, f32::max);
                // A step is 0.013 degrees, where near samples are 2 degrees apart.
                assert!(jump < 0.02, "{jump} at {:?}", at(step));
                before = now;
            }
        }
    }

    #[test]
    fn light_falls_to_nothing_at_the_horizon() {
        let hemisphere = Hemisphere::new(&grid());
        assert_eq!(hemisphere.falloff(75_f32.to_radians()), 1.0);
        assert!((hemisphere.falloff(80_f32.to_radians()) - 0.6709).abs() < 1e-3);
        assert_eq!(hemisphere.falloff(FRAC_PI_2), 0.0);
    }
}
