//! Which lights shine together: groups that light a surface about as all lights do.
//!
//! A frame shows one group. The more its light differs from that of the whole set, the more a
//! picture flickers that can't rest, and the longer a new one takes to look right. So lights are
//! exchanged between groups until the irradiance of each, on surfaces that face any way, is near its
//! share of the whole; and groups follow each other so that what one has too much, the next have too
//! little.

use std::sync::Arc;

use bevy::prelude::*;
use farlight_environment::EnvironmentLight;

/// Exchanges that are tried for each light.
const TRIES: usize = 24;
/// Ways that surfaces face: the faces, edges and corners of a cube.
const NORMALS: usize = 26;
/// How much of what was shown is still to be made up for, from group to group.
const MEMORY: f32 = 0.9;

type Share = [f32; NORMALS];

/// The lights in the order in which they shine.
#[derive(Resource, Default)]
pub(crate) struct Arranged {
    from: Option<(Arc<[EnvironmentLight]>, usize)>,
    lights: Arc<[EnvironmentLight]>,
}

impl Arranged {
    /// Whether the lights of this set, in so many groups, are what was arranged last.
    pub(crate) fn is_of(&self, set: &Arc<[EnvironmentLight]>, cycle: usize) -> bool {
        self.from.as_ref().is_some_and(|(of, n)| Arc::ptr_eq(of, set) && *n == cycle)
    }

    /// Arranges the lights of a set; `cycle` is the number of groups, of which each has the places
    /// from `i * lights / cycle` on.
    pub(crate) fn arrange(&mut self, set: &Arc<[EnvironmentLight]>, cycle: usize) {
        self.lights = arrange(set, cycle).into();
        self.from = Some((set.clone(), cycle));
    }

    /// The lights as they were arranged last.
    pub(crate) fn lights(&self) -> &Arc<[EnvironmentLight]> {
        &self.lights
    }
}

fn arrange(set: &[EnvironmentLight], cycle: usize) -> Vec<EnvironmentLight> {
    if cycle < 2 || cycle >= set.len() {
        return set.to_vec();
    }
    let shares = shares(set);
    let edge = |group: usize| group * set.len() / cycle;
    let mut members: Vec<Vec<usize>> =
        (0..cycle).map(|g| (edge(g)..edge(g + 1)).collect()).collect();
    // What each group has too much: its share of the whole is as large as its number of lights.
    let mut excess: Vec<Share> = members
        .iter()
        .map(|group| {
            let fair = group.len() as f32 / set.len() as f32;
            group.iter().fold([-fair; NORMALS], |sum, light| plus(&sum, &shares[*light], 1.0))
        })
        .collect();
    exchange(&mut members, &mut excess, &shares);
    let order = order(&excess, edge, &members);
    order.into_iter().flat_map(|group| members[group].iter().map(|light| set[*light])).collect()
}

/// For each light, its part of the whole irradiance, for each normal.
fn shares(set: &[EnvironmentLight]) -> Vec<Share> {
    let cube = (-1..=1).flat_map(|x| (-1..=1).flat_map(move |y| (-1..=1).map(move |z| (x, y, z))));
    let normals: Vec<Vec3> = cube
        .filter(|n| *n != (0, 0, 0))
        .map(|(x, y, z)| Vec3::new(x as f32, y as f32, z as f32).normalize())
        .collect();
    let on = |light: &EnvironmentLight, normal: Vec3| {
        light.irradiance.element_sum() * light.direction.dot(normal).max(0.0)
    };
    let totals: Vec<f32> =
        normals.iter().map(|n| set.iter().map(|light| on(light, *n)).sum()).collect();
    // Surfaces that see little of the light matter less.
    let least = 0.1 * totals.iter().fold(0.0, |most: f32, total| most.max(*total));
    set.iter()
        .map(|light| {
            std::array::from_fn(|i| {
                let total = totals[i].max(least);
                if total > 0.0 { on(light, normals[i]) / total } else { 0.0 }
            })
        })
        .collect()
}

/// Exchanges lights of two groups wherever that brings both nearer to their shares.
fn exchange(members: &mut [Vec<usize>], excess: &mut [Share], shares: &[Share]) {
    let cycle = members.len();
    let mut chance = 0x9e37_79b9_7f4a_7c15_u64;
    let mut below = |end: usize| {
        chance ^= chance << 13;
        chance ^= chance >> 7;
        chance ^= chance << 17;
        (chance >> 33) as usize % end
    };
    for _ in 0..TRIES * shares.len() {
        let (a, b) = (below(cycle), below(cycle));
        if a == b || members[a].is_empty() || members[b].is_empty() {
            continue;
        }
        let (i, j) = (below(members[a].len()), below(members[b].len()));
        let (one, other) = (&shares[members[a][i]], &shares[members[b][j]]);
        let new_a = plus(&plus(&excess[a], one, -1.0), other, 1.0);
        let new_b = plus(&plus(&excess[b], other, -1.0), one, 1.0);
        if square(&new_a) + square(&new_b) < square(&excess[a]) + square(&excess[b]) {
            (excess[a], excess[b]) = (new_a, new_b);
            let light = members[a][i];
            members[a][i] = std::mem::replace(&mut members[b][j], light);
        }
    }
}

/// Groups one after the other, so that each makes up for those before. Groups of another size keep
/// the places that are theirs.
fn order(excess: &[Share], edge: impl Fn(usize) -> usize, members: &[Vec<usize>]) -> Vec<usize> {
    let mut left: Vec<usize> = (0..excess.len()).collect();
    let mut debt = [0.0; NORMALS];
    (0..excess.len())
        .map(|place| {
            let size = edge(place + 1) - edge(place);
            let fits = left.iter().enumerate().filter(|(_, group)| members[**group].len() == size);
            let best = fits.min_by(|(_, a), (_, b)| {
                let after = |group: usize| square(&plus(&debt, &excess[group], 1.0));
                after(**a).total_cmp(&after(**b))
            });
            let group = left.swap_remove(best.map_or(0, |(at, _)| at));
            debt = plus(&debt, &excess[group], 1.0).map(|d| d * MEMORY);
            group
        })
        .collect()
}

fn plus(a: &Share, b: &Share, times: f32) -> Share {
    std::array::from_fn(|i| a[i] + times * b[i])
}

fn square(a: &Share) -> f32 {
    a.iter().map(|v| v * v).sum()
}

#[cfg(test)]
mod tests {
    use super::*;
    use farlight_environment::{Environment, LightRequest};

    fn sky() -> Environment {
        let texels = (0..64 * 32).map(|i| {
            let (x, y) = (i % 64, i / 64);
            let sun = if (x, y) == (20, 8) { 900.0 } else { 0.0 };
            let ground = if y >= 16 { 0.2 } else { 1.0 };
            Vec3::new(ground, ground, 1.3 * ground) + Vec3::splat(sun)
        });
        Environment::from_equirect(64, 32, texels.collect()).unwrap()
    }

    /// Mean squared difference of the groups from the whole, relative, over normals.
    fn unevenness(lights: &[EnvironmentLight], cycle: usize) -> f32 {
        let shares = shares(lights);
        let edge = |group: usize| group * lights.len() / cycle;
        let of = |group: usize| {
            let range = edge(group)..edge(group + 1);
            let fair = range.len() as f32 / lights.len() as f32;
            let sum = shares[range].iter().fold([0.0; NORMALS], |sum, s| plus(&sum, s, 1.0));
            sum.iter().map(|s| (s / fair - 1.0).powi(2)).sum::<f32>() / NORMALS as f32
        };
        (0..cycle).map(of).sum::<f32>() / cycle as f32
    }

    #[test]
    fn groups_are_more_even_than_runs_and_lose_no_light() {
        for (count, cycle) in [(200, 40), (203, 41), (64, 8), (7, 3), (5, 5), (1, 1)] {
            let set: Arc<[_]> = sky().lights(&LightRequest { count, ..default() }).into();
            let mut arranged = Arranged::default();
            arranged.arrange(&set, cycle);
            assert!(arranged.is_of(&set, cycle) && !arranged.is_of(&set, cycle + 1));
            let lights = arranged.lights();
            let key = |l: &EnvironmentLight| {
                (l.direction.to_array().map(f32::to_bits), l.irradiance.x.to_bits())
            };
            let mut all: Vec<_> = lights.iter().map(key).collect();
            let mut expected: Vec<_> = set.iter().map(key).collect();
            all.sort_unstable();
            expected.sort_unstable();
            assert_eq!(all, expected);
            let (before, after) = (unevenness(&set, cycle), unevenness(lights, cycle));
            println!(
                "{count} lights in {cycle} groups: {:.3} from {:.3}",
                after.sqrt(),
                before.sqrt()
            );
            assert!(after <= before, "{count} {cycle}");
            if count == 200 {
                assert!(after < 0.5 * before, "{before} {after}");
            }
        }
    }
}
