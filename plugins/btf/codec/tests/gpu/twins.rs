//! The shader against its specification, [`Btf::evaluate`].

use farlight_btf_codec::gpu::{Gpu, GpuEvaluator};
use farlight_btf_codec::{Angles, Btf, ColourSpace, Query, Rules, SliceAngles};
use glam::Vec3;

use crate::made::{Counts, made, queries};

/// Compares; the difference may be `relative` of a value, or of 1/4 of a typical one.
fn compare(gpu: &Gpu, btf: &Btf, queries: &[Query], rules: Rules, relative: f32, what: &str) {
    let evaluator = GpuEvaluator::new(gpu, btf, rules).unwrap();
    let values = evaluator.evaluate(queries).unwrap();
    assert_eq!(values.len(), queries.len());
    let expected: Vec<Vec3> =
        queries.iter().map(|q| btf.evaluate(q.x, q.y, q.angles, rules)).collect();
    let lit = expected.iter().filter(|value| **value != Vec3::ZERO).count();
    assert!(2 * lit > queries.len(), "{what}: {lit} of {} are lit", queries.len());
    let typical = expected.iter().map(|value| value.element_sum() / 3.0).sum::<f32>() / lit as f32;
    let mut worst = 0.0_f32;
    for ((query, value), expected) in queries.iter().zip(values).zip(expected) {
        let Angles { theta_i, phi_i, phi_v, .. } = query.angles;
        let light = SliceAngles::new(theta_i, phi_i - phi_v, false);
        // Beside the axis across the view a rounding of the direction turns alpha far.
        let slack = 1.0 + 0.03 / light.beta.cos().max(1e-6);
        let error = (value - expected).abs() / (expected.abs().max(Vec3::splat(0.25 * typical)));
        let error = error.max_element() / slack;
        worst = worst.max(error);
        assert!(error <= relative, "{what}: {query:?}: {value} instead of {expected}");
    }
    println!("{what}: worst {worst:.1e} of the value; typical {typical:.1}");
}

fn every_rule() -> impl Iterator<Item = Rules> {
    (0..8).map(|set| Rules {
        half_end_slope: set & 1 != 0,
        guard_beta_pole: set & 2 != 0,
        linear: set & 4 != 0,
    })
}

const COUNTS: [Counts; 5] = [
    Counts { phi: 16, theta: 7, alpha: 11, beta: 11 },
    Counts { phi: 1, theta: 3, alpha: 4, beta: 5 },
    Counts { phi: 5, theta: 2, alpha: 2, beta: 2 },
    Counts { phi: 2, theta: 4, alpha: 7, beta: 3 },
    Counts { phi: 9, theta: 10, alpha: 6, beta: 8 },
];

#[test]
fn random_queries_on_any_sample_counts_and_rules() {
    let Some(gpu) = crate::gpu() else { return };
    for (seed, counts) in (1..).zip(COUNTS) {
        for sine in [true, false] {
            let btf = made(counts, ColourSpace::YCbCr, sine, seed);
            for rules in every_rule() {
                let count = if rules == Rules::SHADING { 100_000 } else { 10_000 };
                let what = format!("{counts:?}, sine {sine}, {rules:?}");
                // Angles to 1e-6 rad, times some 50 that random tables change in a radian.
                compare(&gpu, &btf, &queries(count, seed), rules, 1e-4, &what);
            }
        }
    }
}

#[test]
fn hdr() {
    let Some(gpu) = crate::gpu() else { return };
    for linear in [true, false] {
        let colour_space = ColourSpace::LogLuv { factor: 3.5 };
        let btf = made(COUNTS[0], colour_space, true, 7);
        let rules = Rules { linear, ..Rules::SHADING };
        // Powers and exponentials are the driver's: Vulkan promises 5 digits, lavapipe keeps 4.
        compare(&gpu, &btf, &queries(20_000, 7), rules, 1e-3, &format!("HDR, linear {linear}"));
    }
}

#[test]
fn more_queries_than_fit_at_once_and_none() {
    let Some(gpu) = crate::gpu() else { return };
    let btf = made(COUNTS[3], ColourSpace::YCbCr, true, 3);
    let evaluator = GpuEvaluator::new(&gpu, &btf, Rules::SHADING).unwrap();
    assert!(evaluator.evaluate(&[]).unwrap().is_empty());
    let queries = queries(600_000, 3);
    let values = evaluator.evaluate(&queries).unwrap();
    for (query, value) in queries.iter().zip(&values).step_by(997) {
        let expected = btf.evaluate(query.x, query.y, query.angles, Rules::SHADING);
        assert!((*value - expected).abs().max_element() < 0.5, "{query:?}: {value} {expected}");
    }
    assert_eq!(values.len(), queries.len());
}

#[test]
fn anything_may_be_asked() {
    let Some(gpu) = crate::gpu() else { return };
    let btf = made(COUNTS[4], ColourSpace::YCbCr, true, 4);
    let evaluator = GpuEvaluator::new(&gpu, &btf, Rules::SHADING).unwrap();
    let odd = [f32::NAN, f32::INFINITY, f32::NEG_INFINITY, f32::MAX, -1e9, 1e-42, 0.0, 1.0];
    let mut queries = Vec::new();
    for at in 0..odd.len().pow(4) {
        let pick = |place: u32| odd[at / odd.len().pow(place) % odd.len()];
        let angles = Angles { theta_i: pick(0), phi_i: pick(1), theta_v: pick(2), phi_v: pick(3) };
        let edge = [i32::MIN, i32::MAX, -1, 0][at % 4];
        queries.push(Query { x: edge, y: edge, angles });
    }
    for (query, value) in queries.iter().zip(evaluator.evaluate(&queries).unwrap()) {
        assert!(value.is_finite() && value.min_element() >= 0.0, "{query:?}: {value}");
        assert!(value.max_element() < 2000.0, "{query:?}: {value}");
        if !query.angles.above() {
            assert_eq!(value, Vec3::ZERO, "{query:?}");
        }
    }
}
