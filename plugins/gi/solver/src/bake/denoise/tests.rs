//! The filter on floors made by hand.

use glam::Vec3;

use super::{Halves, LayoutTexel, filter};
use crate::{atlas::PageId, scene::InstanceId};

const SPACING: f32 = 0.1;

/// A floor of `width * height` texels from a place in the world and on the page.
fn floor(world: Vec3, page: [u32; 2], [width, height]: [u32; 2], chart: u32) -> Vec<LayoutTexel> {
    let texels = (0..height).flat_map(|y| (0..width).map(move |x| [x, y]));
    texels
        .map(|[x, y]| LayoutTexel {
            instance: InstanceId(1),
            page: PageId(0),
            x: page[0] + x,
            y: page[1] + y,
            chart,
            position: world + Vec3::new(x as f32 + 0.5, 0.0, y as f32 + 0.5) * SPACING,
            normal: Vec3::Y,
            geometric: Vec3::Y,
            open: true,
        })
        .collect()
}

/// Random numbers from 0 to 1 (PCG's multiplier; the high bits are good).
struct Random(u64);

impl Random {
    fn next(&mut self) -> f32 {
        self.0 = self.0.wrapping_mul(6_364_136_223_846_793_005).wrapping_add(1_442_695_040_888_963);
        (self.0 >> 40) as f32 / (1_u64 << 24) as f32
    }

    /// Normally distributed, near enough.
    fn normal(&mut self) -> f32 {
        (0..12).map(|_| self.next()).sum::<f32>() - 6.0
    }
}

/// Both halves of a truth with a relative standard error of `noise` in their mean.
fn noisy(truth: &[f32], noise: f32, seed: u64) -> Halves {
    let mut random = Random(seed);
    let mut half = || -> Vec<Vec3> {
        let sigma = noise * std::f32::consts::SQRT_2;
        truth.iter().map(|t| Vec3::splat(t * (1.0 + sigma * random.normal()))).collect()
    };
    [half(), half()]
}

fn mean(halves: &Halves) -> Vec<f32> {
    halves[0].iter().zip(&halves[1]).map(|(a, b)| (a.y + b.y) * 0.5).collect()
}

fn run(texels: &[LayoutTexel], halves: &Halves) -> Vec<f32> {
    filter(texels, SPACING, halves.clone()).into_iter().map(|v| v.y).collect()
}

/// Root of the mean squared relative error.
fn error(values: &[f32], truth: &[f32]) -> f32 {
    let sum: f32 = values.iter().zip(truth).map(|(v, t)| (v / t - 1.0).powi(2)).sum();
    (sum / truth.len() as f32).sqrt()
}

/// A truth over the columns and rows of the texels.
fn over(texels: &[LayoutTexel], f: impl Fn(f32, f32) -> f32) -> Vec<f32> {
    texels.iter().map(|t| f(t.x as f32, t.y as f32)).collect()
}

fn column_mean(texels: &[LayoutTexel], values: &[f32], x: u32) -> f32 {
    let column: Vec<f32> =
        texels.iter().zip(values).filter(|(t, _)| t.x == x).map(|(_, v)| *v).collect();
    column.iter().sum::<f32>() / column.len() as f32
}

#[test]
fn smooth_light_loses_its_noise() {
    let texels = floor(Vec3::ZERO, [0, 0], [48, 48], 0);
    let truth = over(&texels, |x, y| 1.0 + (x * 0.1).sin() * 0.4 + y * 0.01);
    let halves = noisy(&truth, 0.2, 1);
    let (before, after) = (error(&mean(&halves), &truth), error(&run(&texels, &halves), &truth));
    assert!(after * 6.0 < before, "{before} -> {after}");
}

#[test]
fn a_hard_edge_stays_hard() {
    let texels = floor(Vec3::ZERO, [0, 0], [32, 32], 0);
    let truth = over(&texels, |x, _| if x < 16.0 { 1.0 } else { 3.0 });
    let values = run(&texels, &noisy(&truth, 0.1, 2));
    for (x, expected) in [(14, 1.0), (15, 1.0), (16, 3.0), (17, 3.0)] {
        let found = column_mean(&texels, &values, x);
        assert!((found / expected - 1.0).abs() < 0.04, "column {x}: {found}, {expected}");
    }
}

#[test]
fn an_edge_of_colour_alone_stays_hard() {
    let texels = floor(Vec3::ZERO, [0, 0], [32, 32], 0);
    let halves = noisy(&vec![1.0; texels.len()], 0.05, 3).map(|half| {
        // Red and blue of equal luminance.
        let colour = |x| if x < 16 { Vec3::new(3.0, 1.0, 1.0) } else { Vec3::new(1.0, 1.0, 6.9) };
        half.iter().zip(&texels).map(|(v, t)| *v * colour(t.x)).collect()
    });
    let values = filter(&texels, SPACING, halves);
    for (value, texel) in values.iter().zip(&texels) {
        let red = if texel.x < 16 { 3.0 } else { 1.0 };
        assert!((value.x / red - 1.0).abs() < 0.15, "column {}: {value}", texel.x);
    }
}

/// What a box leaves where it touches a floor.
#[test]
fn a_thin_dark_line_stays_dark() {
    let texels = floor(Vec3::ZERO, [0, 0], [33, 33], 0);
    let truth = over(&texels, |x, _| if x == 16.0 { 0.3 } else { 1.0 });
    let values = run(&texels, &noisy(&truth, 0.05, 4));
    for (x, expected) in [(15, 1.0), (16, 0.3), (17, 1.0)] {
        let found = column_mean(&texels, &values, x);
        assert!((found / expected - 1.0).abs() < 0.04, "column {x}: {found}, {expected}");
    }
}

#[test]
fn charts_that_meet_on_the_page_alone_do_not_mix() {
    let mut texels = floor(Vec3::ZERO, [0, 0], [16, 32], 0);
    texels.extend(floor(Vec3::X * 50.0, [16, 0], [16, 32], 1));
    let truth = over(&texels, |x, _| if x < 16.0 { 1.0 } else { 0.0 });
    let values = run(&texels, &noisy(&truth, 0.3, 5));
    assert!(values.iter().zip(&texels).all(|(v, t)| if t.x < 16 { *v > 0.5 } else { *v == 0.0 }));
}

#[test]
fn nothing_passes_a_wall_that_stands_on_a_floor() {
    let mut texels = floor(Vec3::ZERO, [0, 0], [32, 32], 0);
    for texel in &mut texels {
        texel.open = !(15..18).contains(&texel.x);
    }
    let truth = over(&texels, |x, _| if x < 16.0 { 1.0 } else { 0.95 });
    let halves = noisy(&truth, 0.3, 6);
    let values = run(&texels, &halves);
    // The same without the other side.
    let left: Vec<usize> = (0..texels.len()).filter(|&i| texels[i].x < 15).collect();
    let alone: Vec<LayoutTexel> = left.iter().map(|&i| texels[i]).collect();
    let halves = halves.map(|half| left.iter().map(|&i| half[i]).collect());
    for (&i, value) in left.iter().zip(run(&alone, &halves)) {
        assert!((values[i] - value).abs() < 1e-3, "{} {value}", values[i]);
    }
}

#[test]
fn a_border_between_charts_of_one_surface_does_not_show() {
    let whole = floor(Vec3::ZERO, [0, 0], [32, 32], 0);
    let truth = over(&whole, |x, y| 1.0 + x * 0.02 + y * 0.01);
    let halves = noisy(&truth, 0.2, 7);
    let mut cut = whole.clone();
    for texel in cut.iter_mut().filter(|t| t.x >= 16) {
        (texel.chart, texel.x) = (1, texel.x + 100);
    }
    for (a, b) in run(&whole, &halves).into_iter().zip(run(&cut, &halves)) {
        assert!((a - b).abs() < 1e-3, "{a} {b}");
    }
}

#[test]
fn what_has_converged_stays() {
    let texels = floor(Vec3::ZERO, [0, 0], [32, 32], 0);
    let mut random = Random(8);
    let pattern: Vec<f32> = texels.iter().map(|_| 1.0 + random.next()).collect();
    for (a, b) in run(&texels, &noisy(&pattern, 0.0, 1)).into_iter().zip(&pattern) {
        assert!((a - b).abs() < 1e-4, "{a} {b}");
    }
    let truths = [
        pattern,
        over(&texels, |x, y| 1.0 + (x * 0.7).sin() * (y * 0.5).cos() * 0.6),
        over(&texels, |x, _| if x < 16.0 { 1.0 } else { 1.01 }),
    ];
    for truth in truths {
        let halves = noisy(&truth, 0.001, 9);
        let (before, after) =
            (error(&mean(&halves), &truth), error(&run(&texels, &halves), &truth));
        assert!(after < before * 1.3, "{before} -> {after}");
    }
}

#[test]
fn no_light_is_lost_and_lone_outliers_go() {
    let texels = floor(Vec3::ZERO, [0, 0], [64, 64], 0);
    let truth = over(&texels, |x, _| 1.0 + x * 0.05);
    let mut random = Random(10);
    // Skewed noise, as paths have it.
    let mut half = || -> Vec<Vec3> {
        truth.iter().map(|t| Vec3::splat(-t * (1.0 - random.next()).ln())).collect()
    };
    let mut halves = [half(), half()];
    halves[0][64 * 20 + 20] = Vec3::splat(400.0);
    halves[1][64 * 40 + 50] = Vec3::splat(700.0);
    let (before, values) = (mean(&halves), run(&texels, &halves));
    let (sum_before, sum) = (before.iter().sum::<f32>(), values.iter().sum::<f32>());
    assert!((sum / sum_before - 1.0).abs() < 0.005, "{sum_before} -> {sum}");
    for (i, value) in values.iter().enumerate() {
        assert!(*value < truth[i] * 6.0, "{value} instead of {} at {:?}", truth[i], texels[i]);
    }
}

#[test]
fn nothing_hostile_gives_what_is_not_a_number() {
    let whole = floor(Vec3::ZERO, [0, 0], [12, 12], 0);
    let values = |v: f32| [0, 1].map(|_| vec![Vec3::splat(v); whole.len()]);
    let mut closed = whole.clone();
    closed.iter_mut().for_each(|t| t.open = false);
    let mut odd = whole.clone();
    odd[3].position = Vec3::NAN;
    odd[5].normal = Vec3::ZERO;
    odd[6].geometric = Vec3::NAN;
    odd[7].position = Vec3::splat(f32::MAX);
    odd[9].position = odd[10].position;
    let mut wild = values(1.0);
    wild[0][40] = Vec3::splat(1e38);
    wild[1][41] = Vec3::new(0.0, -1e30, 1e-40);
    wild[0][42] = Vec3::ZERO;
    let cases = [
        (&whole, values(0.0)),
        (&whole, values(f32::MAX / 4.0)),
        (&whole, values(f32::MIN_POSITIVE)),
        (&whole, wild.clone()),
        (&closed, values(2.0)),
        (&odd, noisy(&vec![1.0; odd.len()], 0.3, 11)),
    ];
    for (texels, halves) in cases {
        for spacing in [SPACING, 1e-6, 1e6] {
            let out = filter(texels, spacing, halves.clone());
            assert!(out.iter().all(|v| v.is_finite()), "{spacing}");
        }
    }
    assert_eq!(filter(&closed, SPACING, values(2.0)), vec![Vec3::splat(2.0); closed.len()]);
    assert_eq!(
        filter(&whole[..1], SPACING, [vec![Vec3::ONE], vec![Vec3::ZERO]]),
        [Vec3::splat(0.5)]
    );
    assert!(filter(&[], SPACING, [vec![], vec![]]).is_empty());
    // What is not finite is left where it is.
    wild[0][40] = Vec3::INFINITY;
    let out = filter(&whole, SPACING, wild);
    assert_eq!(out.iter().filter(|v| !v.is_finite()).count(), 1);
}

#[test]
fn results_do_not_depend_on_the_number_of_threads() {
    let texels = floor(Vec3::ZERO, [0, 0], [40, 40], 0);
    let halves = noisy(&vec![1.0; texels.len()], 0.3, 12);
    let with = |threads| {
        let pool = rayon::ThreadPoolBuilder::new().num_threads(threads).build().unwrap();
        pool.install(|| run(&texels, &halves))
    };
    assert_eq!(with(1), with(3));
}
