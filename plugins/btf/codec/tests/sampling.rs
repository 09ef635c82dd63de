//! Albedo, and drawing directions of light.

use std::f32::consts::{FRAC_PI_2, PI};
use std::path::PathBuf;

use farlight_btf_codec::{
    Angles, Btf, LightSampler, Rules, SliceAngles, ViewFrame, read, synthetic,
};
use farlight_gi_solver::sampling::{Rng, cosine_hemisphere, sobol_owen_4d, uniform_sphere};
use glam::{DVec3, Vec3};

/// A glossy measured material, or a word that the test was skipped.
fn alu() -> Option<Btf> {
    measured("alu")
}

/// A measured material, or a word that the test was skipped.
fn measured(name: &str) -> Option<Btf> {
    let Some(data) = std::env::var_os("FARLIGHT_TEST_DATA") else {
        println!("SKIPPED: FARLIGHT_TEST_DATA is not set");
        return None;
    };
    let file = PathBuf::from(data).join("btfbase").join(name).join("binary.btf");
    Some(read::read_binary(&file, &read::Options::default()).unwrap())
}

fn lambert(albedo: [f32; 3]) -> Btf {
    synthetic::lambert(albedo, [1, 1]).unwrap()
}

fn light(alpha: f32, sin_beta: f32) -> SliceAngles {
    SliceAngles { beta: sin_beta.asin(), sin_beta, alpha }
}

/// Both measured and by formula, from three views.
fn samplers() -> Vec<(String, Btf, LightSampler)> {
    let mut all = vec![("Lambert", lambert([0.8, 0.4, 0.1]))];
    all.extend(alu().map(|btf| ("alu", btf)));
    all.into_iter()
        .flat_map(|(name, btf)| {
            [0.0_f32, 40.0, 85.0].map(|theta| {
                let sampler =
                    LightSampler::new(&btf, &btf.view_slices(3, 5, theta.to_radians(), 1.0));
                (format!("{name} at {theta} degrees"), btf.clone(), sampler)
            })
        })
        .collect()
}

/// Midpoints of a fine grid over (alpha, sine), and the area round each.
fn grid(steps: usize) -> (impl Iterator<Item = SliceAngles>, f64) {
    let part = move |at: usize| (at as f32 + 0.5) / steps as f32;
    let points = (0..steps * steps)
        .map(move |at| light(PI * part(at / steps) - FRAC_PI_2, 2.0 * part(at % steps) - 1.0));
    (points, 2.0 * std::f64::consts::PI / (steps * steps) as f64)
}

#[test]
fn the_density_integrates_to_one() {
    for (name, _, sampler) in samplers() {
        let (points, area) = grid(1000);
        let sum: f64 = points.map(|light| f64::from(sampler.pdf(light)) * area).sum();
        // The grid is fine beside the tables' intervals.
        assert!((sum - 1.0).abs() < 1e-3, "{name}: {sum}");
    }
}

#[test]
fn directions_are_drawn_with_their_density() {
    const BINS: usize = 16;
    const COUNT: usize = 200_000;
    for (name, _, sampler) in samplers() {
        let mut rng = Rng::new(5, 0);
        let mut found = vec![0_u32; BINS * BINS];
        let bin = |light: SliceAngles| {
            let at = |part: f32| ((part * BINS as f32) as usize).min(BINS - 1);
            at((light.alpha + FRAC_PI_2) / PI) * BINS + at((light.sin_beta + 1.0) / 2.0)
        };
        for _ in 0..COUNT {
            let sample = sampler.sample(rng.next_2d());
            let pdf = sampler.pdf(sample.light);
            assert!((sample.pdf - pdf).abs() <= 1e-3 * pdf, "{name}: {sample:?}, {pdf}");
            found[bin(sample.light)] += 1;
        }
        let mut expected = vec![0.0_f64; BINS * BINS];
        let (points, area) = grid(40 * BINS);
        for light in points {
            expected[bin(light)] += f64::from(sampler.pdf(light)) * area * COUNT as f64;
        }
        let chi: f64 = (found.iter().zip(&expected))
            .map(|(found, expected)| (f64::from(*found) - expected).powi(2) / expected)
            .sum();
        // Mean and spread of the distribution with that many degrees of freedom; five sigma.
        let freedom = (BINS * BINS - 1) as f64;
        println!("{name}: chi square {chi:.0} of {freedom}");
        assert!((chi - freedom).abs() < 5.0 * (2.0 * freedom).sqrt(), "{name}: {chi}");
    }
}

#[test]
fn frames_lead_to_the_tables_and_back() {
    let mut rng = Rng::new(6, 0);
    let btf = lambert([0.5; 3]);
    for _ in 0..1000 {
        let [mut view, mut light] = [(); 2].map(|()| uniform_sphere(rng.next_2d().into()));
        view.z = view.z.abs();
        light.z = light.z.abs();
        let frame = ViewFrame::new(view);
        let angles = frame.slice_angles(light);
        assert!(frame.direction(angles).distance(light) < 1e-5, "{view} {light}");
        let given = Angles::from_directions(light, view);
        let same = SliceAngles::new(given.theta_i, given.phi_i - given.phi_v, false);
        assert!((angles.sin_beta - same.sin_beta).abs() < 1e-5, "{view} {light}");
        let slices = btf.view_slices(0, 0, given.theta_v, frame.phi());
        let value = btf.evaluate_slices(&slices, angles, Rules::SHADING);
        let expected = btf.evaluate(0, 0, given, Rules::SHADING);
        // Lambert's value is steep at the horizon.
        assert!((value - expected).abs().max_element() < 0.1, "{value} {expected}");
    }
}

#[test]
fn a_lambertian_material_has_its_albedo() {
    let albedo = [0.8, 0.4, 0.1];
    let btf = lambert(albedo);
    for theta in [0.0_f32, 50.0, 90.0] {
        for found in [btf.albedo(0, 0, theta.to_radians(), 2.0), btf.mean_albedo(theta, 2.0, 9)] {
            let off = (found.value - Vec3::from(albedo)).abs().max_element();
            // The material itself is exact to 0.2 % of its brightest channel.
            assert!(off < 0.002 * 0.8, "{found:?}");
            assert!(found.error < 0.001 && found.conserves_energy(), "{found:?}");
        }
    }
    assert!(btf.albedo(0, 0, 0.3, 0.0).conserves_energy());
}

/// Mean and variance of one sample's estimate of the albedo.
fn estimate(btf: &Btf, theta_v: f32, draw: impl Fn([f32; 2]) -> (SliceAngles, f32)) -> [f64; 2] {
    let slices = btf.view_slices(7, 9, theta_v, 0.0);
    let count = 1 << 14;
    let (mut sum, mut squares) = (DVec3::ZERO, DVec3::ZERO);
    for at in 0..count {
        let [a, b, ..] = sobol_owen_4d(at, 3);
        let (light, pdf) = draw([a, b]);
        let value = btf.evaluate_slices(&slices, light, Rules::SHADING);
        let term = (btf.colour_space().to_linear(value) / (PI * pdf)).as_dvec3();
        sum += term;
        squares += term * term;
    }
    let mean = sum / f64::from(count);
    [mean.y, (squares / f64::from(count) - mean * mean).y]
}

#[test]
fn drawing_by_the_material_beats_drawing_by_the_cosine() {
    let Some(btf) = alu() else { return };
    for theta in [20.0_f32, 50.0, 75.0] {
        let theta = theta.to_radians();
        let albedo = btf.albedo(7, 9, theta, 0.0);
        let sampler = LightSampler::new(&btf, &btf.view_slices(7, 9, theta, 0.0));
        let by_material = estimate(&btf, theta, |u| {
            let sample = sampler.sample(u);
            (sample.light, sample.pdf)
        });
        let frame = ViewFrame::new(Vec3::X);
        let by_cosine = estimate(&btf, theta, |u| {
            let direction = cosine_hemisphere(u.into());
            (frame.slice_angles(direction), (direction.z / PI).max(1e-9))
        });
        println!(
            "alu at {:.0} degrees: albedo {:.4} +- {:.4}; variance {:.5} by the material, {:.5} by the cosine",
            theta.to_degrees(),
            albedo.value.y,
            albedo.error,
            by_material[1],
            by_cosine[1]
        );
        // Quasi-random points do better than one over the root of their number.
        let limit =
            |variance: f64| 4.0 * (variance / f64::from(1 << 14)).sqrt() + f64::from(albedo.error);
        for [mean, variance] in [by_material, by_cosine] {
            assert!(
                (mean - f64::from(albedo.value.y)).abs() < limit(variance),
                "{mean} {albedo:?}"
            );
        }
        assert!(by_material[1] < 0.25 * by_cosine[1], "{by_material:?} {by_cosine:?}");
    }
}

/// No measured material gives back more light than it gets: a word about each.
#[test]
fn albedos_of_measured_materials_are_sensible() {
    for name in ["alu", "corduroy", "wallpaper"] {
        let Some(btf) = measured(name) else { return };
        for theta in [0.0_f32, 30.0, 60.0, 80.0] {
            let albedo = btf.mean_albedo(theta.to_radians(), 0.3, 256);
            println!("{name} from {theta} degrees: {albedo:?}");
            assert!(albedo.value.min_element() > 0.0 && albedo.error < 0.03, "{albedo:?}");
            assert!(albedo.conserves_energy(), "{albedo:?}");
        }
    }
}
