//! Values from vectors against those of the scalar specification.

use std::f32::consts::{FRAC_PI_2, PI, TAU};
use std::path::PathBuf;

use farlight_btf_codec::{
    Angles, Backend, Btf, ColourSpace, Info, Query, References, Rules, Samples, Scaled,
    SliceAngles, Tables, read,
};
use glam::Vec3;

/// Numbers from 0 to 1 that look random (Weyl's sequence through a multiplicative hash).
struct Numbers(u32);

impl Numbers {
    fn next(&mut self) -> f32 {
        self.0 = self.0.wrapping_add(0x9e37_79b9);
        let mut x = self.0;
        x = (x ^ x >> 16).wrapping_mul(0x21f0_aaad);
        x = (x ^ x >> 15).wrapping_mul(0x735a_2d97);
        ((x ^ x >> 15) >> 8) as f32 / (1 << 24) as f32
    }

    fn below(&mut self, count: usize) -> u32 {
        (self.next() * count as f32) as u32
    }
}

/// Code-books full of random entries; `counts` are azimuths, elevations, alphas and betas.
fn made(counts: [usize; 4], in_sine: bool, colour_space: ColourSpace) -> Btf {
    let [phi, theta, alpha, beta] = counts;
    let mut numbers = Numbers(7);
    let mut scaled = |columns: usize, rows: usize, below: usize, low: f32, high: f32| Scaled {
        columns,
        index: (0..columns * rows).map(|_| numbers.below(below)).collect(),
        scale: (0..columns * rows).map(|_| low + (high - low) * numbers.next()).collect(),
        range: None,
    };
    let texels = scaled(5, 3, 6, 0.9, 1.1);
    let azimuths = scaled(phi, 6, 9, 0.95, 1.05);
    let elevations = scaled(theta, 9, 13, 0.5, 1.5);
    let luminances = scaled(alpha, 8, 21, 200.0, 1500.0);
    let mut numbers = Numbers(8);
    let mut references = |columns: usize, rows: usize, below: usize| References {
        columns,
        index: (0..columns * rows).map(|_| numbers.below(below)).collect(),
    };
    let slices = references(2, 13, 7);
    let chromas = references(alpha, 7, 5);
    let colour_rows = references(beta, 5, 4);
    let mut numbers = Numbers(9);
    let mut samples = |columns: usize, rows: usize, low: f32, high: f32| Samples {
        columns,
        value: (0..columns * rows).map(|_| low + (high - low) * numbers.next()).collect(),
        range: None,
    };
    let shapes = samples(beta, 21, 0.02, 0.3);
    let colours = samples(2, 4, 100.0, 150.0);
    let tables = Tables {
        colour_space,
        beta_uniform_in_sine: in_sine,
        texels,
        azimuths,
        elevations,
        slices,
        luminances,
        shapes,
        chromas,
        colour_rows,
        colours,
    };
    Btf::new(Info::default(), 5, &tables).unwrap()
}

/// Random queries, then every combination of angles where something begins or ends.
fn queries() -> Vec<Query> {
    let mut numbers = Numbers(1);
    let mut queries: Vec<Query> = (0..5_000)
        .map(|_| Query {
            x: (numbers.next() * 600.0) as i32 - 300,
            y: (numbers.next() * 600.0) as i32 - 300,
            angles: Angles {
                theta_i: numbers.next().acos(),
                phi_i: (numbers.next() - 0.5) * 2.0 * TAU,
                theta_v: numbers.next().acos(),
                phi_v: (numbers.next() - 0.5) * 2.0 * TAU,
            },
        })
        .collect();
    let thetas = [0.0, 1e-4, 0.3, FRAC_PI_2 / 2.0, FRAC_PI_2 - 0.003, FRAC_PI_2, 1.6, -0.1];
    let phis = [0.0, 1e-4, FRAC_PI_2, PI, -PI, 1.5 * PI, TAU - 1e-4, TAU, -0.7];
    for theta_i in thetas {
        for phi_i in phis {
            for theta_v in thetas {
                for phi_v in phis {
                    let angles = Angles { theta_i, phi_i, theta_v, phi_v };
                    queries.push(Query { x: 1, y: 2, angles });
                }
            }
        }
    }
    queries
}

/// The specification, at angles moved by what 32 bits resolve; how far its values are apart says how
/// far off a value may be.
fn spread(btf: &Btf, query: &Query, rules: Rules) -> (Vec3, f32) {
    let at = |theta: f32, phi: f32| {
        let mut angles = query.angles;
        angles.theta_i += theta;
        angles.phi_i += phi;
        angles.theta_i =
            if angles.theta_i > FRAC_PI_2 { query.angles.theta_i } else { angles.theta_i };
        btf.evaluate(query.x, query.y, angles, rules)
    };
    let value = at(0.0, 0.0);
    // Two units in the last place of an angle of 2 pi.
    let step = 1e-6;
    let moved = [at(step, 0.0), at(-step, 0.0), at(0.0, step), at(0.0, -step)];
    let far = moved.iter().map(|other| (*other - value).abs().max_element()).fold(0.0, f32::max);
    (value, far)
}

fn compare(name: &str, btf: &Btf) {
    let queries = queries();
    let mut values = vec![Vec3::NAN; queries.len()];
    let rules = [Rules::COMPATIBLE, Rules::SHADING, Rules::default()];
    for backend in Backend::available() {
        for rules in rules {
            btf.evaluate_batch_on(backend, &queries, rules, &mut values);
            let (mut worst, mut sum, mut loose) = (0.0_f32, 0.0, 0);
            for (query, value) in queries.iter().zip(&values) {
                let (expected, spread) = spread(btf, query, rules);
                let error = (*value - expected).abs().max_element();
                // What rounding does to a sum of values up to 300 and more, and to the angles.
                let limit = 2e-5 * expected.max_element() + 1e-3 + 4.0 * spread;
                assert!(
                    error <= limit,
                    "{name}, {backend:?}, {rules:?}: {query:?}: {value} instead of {expected}, {error} > {limit}"
                );
                worst = worst.max(error);
                sum += error;
                loose += usize::from(error > 0.01);
            }
            println!(
                "{name} {backend:?}: worst {worst:.5}, mean {:.6}, {loose} of {} above 0.01",
                sum / queries.len() as f32,
                queries.len()
            );
        }
    }
}

#[test]
fn vectors_agree_with_the_specification_on_made_tables() {
    for counts in [[16, 7, 11, 11], [1, 3, 2, 5], [3, 2, 4, 2], [5, 4, 17, 3], [2, 19, 33, 64]] {
        for in_sine in [true, false] {
            let name = format!("{counts:?} in sine {in_sine}");
            compare(&name, &made(counts, in_sine, ColourSpace::YCbCr));
        }
    }
}

#[test]
fn hdr_materials_have_an_answer_on_every_backend() {
    compare("HDR", &made([4, 3, 5, 5], true, ColourSpace::LogLuv { factor: 8.0 }));
}

#[test]
fn vectors_agree_with_the_specification_on_measured_tables() {
    let Some(data) = std::env::var_os("FARLIGHT_TEST_DATA") else {
        println!("SKIPPED: FARLIGHT_TEST_DATA is not set");
        return;
    };
    let data = PathBuf::from(data).join("btfbase");
    for name in ["alu", "corduroy", "wallpaper"] {
        let file = data.join(name).join("binary.btf");
        compare(name, &read::read_binary(&file, &read::Options::default()).unwrap());
    }
}

#[test]
fn many_lights_of_one_view_agree_with_one_at_a_time() {
    let materials = [
        made([16, 7, 11, 11], true, ColourSpace::YCbCr),
        made([3, 2, 4, 2], false, ColourSpace::YCbCr),
        made([4, 3, 5, 5], true, ColourSpace::LogLuv { factor: 8.0 }),
    ];
    for btf in materials {
        let slices = btf.view_slices(2, 1, 0.7, 2.0);
        let mut numbers = Numbers(3);
        let lights: Vec<SliceAngles> = (0..1003)
            .map(|_| SliceAngles::new(numbers.next().acos(), numbers.next() * TAU, false))
            .collect();
        let mut values = vec![Vec3::NAN; lights.len()];
        for backend in Backend::available() {
            btf.evaluate_lights_on(backend, &slices, &lights, Rules::SHADING, &mut values);
            for (light, value) in lights.iter().zip(&values) {
                let expected = btf.evaluate_slices(&slices, *light, Rules::SHADING);
                let error = (*value - expected).abs().max_element();
                // The angles are the same; only sums round.
                assert!(error <= 2e-5 * expected.max_element() + 1e-3, "{value} {expected}");
            }
        }
    }
}

#[test]
fn any_number_of_queries_is_answered_and_no_more() {
    let btf = made([16, 7, 11, 11], true, ColourSpace::YCbCr);
    let queries = queries();
    for backend in Backend::available() {
        for count in (0..40).chain([1000]) {
            let mut values = vec![Vec3::NAN; count];
            btf.evaluate_batch_on(backend, &queries[..count], Rules::SHADING, &mut values);
            assert!(values.iter().all(|value| value.is_finite()), "{backend:?}, {count}");
        }
        let bad = [f32::NAN, f32::INFINITY, f32::NEG_INFINITY, 1e30, -1e30];
        for bad in bad {
            let angles = Angles { theta_i: 0.5, phi_i: bad, theta_v: 0.5, phi_v: bad };
            let query = Query { x: i32::MIN, y: i32::MAX, angles };
            // Any value will do, but it must come without a crash.
            let mut values = [Vec3::ZERO];
            btf.evaluate_batch_on(backend, &[query], Rules::SHADING, &mut values);
            let angles = Angles { theta_i: f32::NAN, phi_i: 0.0, theta_v: bad, phi_v: 0.0 };
            btf.evaluate_batch_on(
                backend,
                &[Query { angles, ..query }],
                Rules::SHADING,
                &mut values,
            );
            assert_eq!(values[0], Vec3::ZERO, "no direction above the horizon: black");
        }
    }
}
