//! The compressor on materials with a formula: errors within what was asked, everywhere the same.

use std::ops::{ControlFlow, Range};

use farlight_btf_codec::compress::{Compressed, Grid, Quality, Settings, TexelSource, compress};
use farlight_btf_codec::{Angles, BtfError, Info, Rules, srgb_encode};
use glam::Vec3;

/// A material by formula: linear values of a texel under directions.
struct Formula<F> {
    size: [u32; 2],
    grid: Grid,
    band: u32,
    loaded: Vec<Range<u32>>,
    value: F,
}

impl<F: Fn(u32, u32, Angles) -> Vec3 + Sync> Formula<F> {
    fn new(size: [u32; 2], grid: Grid, value: F) -> Self {
        Self { size, grid, band: size[1], loaded: Vec::new(), value }
    }

    fn sample(&self, x: u32, y: u32, angles: Angles) -> Vec3 {
        255.0 * (self.value)(x, y, angles).map(srgb_encode)
    }
}

impl<F: Fn(u32, u32, Angles) -> Vec3 + Sync> TexelSource for Formula<F> {
    fn size(&self) -> [u32; 2] {
        self.size
    }

    fn grid(&self) -> Grid {
        self.grid
    }

    fn band(&self) -> u32 {
        self.band
    }

    fn load(&mut self, rows: Range<u32>) -> Result<(), BtfError> {
        self.loaded.push(rows);
        Ok(())
    }

    fn texel(&self, x: u32, y: u32, samples: &mut [[f32; 3]]) {
        assert!(self.loaded.last().is_some_and(|rows| rows.contains(&y)), "row {y}");
        let grid = self.grid;
        for (phi, theta, alpha, beta) in directions(&grid) {
            let value = self.sample(x, y, grid.angles(phi, theta, alpha, beta));
            samples[grid.index(phi, theta, alpha, beta)] = value.into();
        }
    }
}

fn directions(grid: &Grid) -> impl Iterator<Item = (usize, usize, usize, usize)> + use<> {
    let grid = *grid;
    (0..grid.samples()).map(move |at| {
        let (beta, rest) = (at % grid.beta, at / grid.beta);
        let (alpha, rest) = (rest % grid.alpha, rest / grid.alpha);
        (rest / grid.theta, rest % grid.theta, alpha, beta)
    })
}

fn settings(error: f32) -> Settings {
    Settings { quality: Quality::Error(error), ..Settings::default() }
}

fn finished(source: &mut dyn TexelSource, settings: &Settings) -> Compressed {
    let progress = &mut |_| ControlFlow::Continue(());
    compress(source, settings, progress).expect("a sound source").expect("not stopped")
}

/// Compresses, then asks the evaluator for every sample: root mean square of the worst texel.
fn check<F: Fn(u32, u32, Angles) -> Vec3 + Sync>(mut source: Formula<F>, error: f32) -> Compressed {
    let found = finished(&mut source, &settings(error));
    println!("{:?}, {:.1} dB, 1 : {:.0}", found.report, found.report.psnr(), found.report.ratio());
    let btf = found.clone().into_btf(Info::default()).unwrap();
    assert_eq!(btf.size(), source.size);
    let mut worst = 0.0_f32;
    for y in 0..source.size[1] {
        for x in 0..source.size[0] {
            let mut sum = 0.0;
            for (phi, theta, alpha, beta) in directions(&source.grid) {
                // At the poles, all angles alpha are one direction.
                if beta % (source.grid.beta - 1) == 0 {
                    continue;
                }
                let angles = source.grid.angles(phi, theta, alpha, beta);
                let value = btf.evaluate(x as i32, y as i32, angles, Rules::SHADING);
                sum += (value - source.sample(x, y, angles)).length_squared();
            }
            let count = 3 * source.grid.samples() * (source.grid.beta - 2) / source.grid.beta;
            worst = worst.max((sum / count as f32).sqrt());
        }
    }
    // Packing rounds scales to 2^-12 of their range and shapes to 2^-16; where the poles are not
    // counted the rest may have all of the error.
    let rest = (source.grid.beta as f32 / (source.grid.beta - 2) as f32).sqrt();
    assert!(worst <= rest * error * 1.02 + 0.05, "{worst} where {error} was asked for");
    assert!(found.report.worst_texel <= error, "{:?}", found.report);
    assert!(found.report.error <= found.report.worst_texel);
    found
}

fn lambert(_x: u32, _y: u32, angles: Angles) -> Vec3 {
    Vec3::splat(angles.theta_i.cos().max(0.0))
}

/// Coloured, with a highlight whose width and direction change from texel to texel.
fn phong(x: u32, y: u32, angles: Angles) -> Vec3 {
    let direction = |theta: f32, phi: f32| {
        Vec3::new(theta.sin() * phi.cos(), theta.sin() * phi.sin(), theta.cos())
    };
    let light = direction(angles.theta_i, angles.phi_i);
    let view = direction(angles.theta_v, angles.phi_v);
    let normal = Vec3::new(0.3 * (x as f32).sin(), 0.3 * (y as f32 * 0.7).cos(), 1.0).normalize();
    let mirror = 2.0 * normal.dot(light) * normal - light;
    let lobe = 0.5 * mirror.dot(view).max(0.0).powf(4.0 + (x % 4) as f32 * 4.0);
    let albedo = Vec3::new(0.6, 0.1 + 0.05 * (y % 5) as f32, 0.2);
    (albedo * normal.dot(light).max(0.0) + lobe) * light.z.max(0.0)
}

fn noise(x: u32, y: u32, angles: Angles) -> Vec3 {
    let bits = |channel: u32| {
        let words = [angles.theta_i, angles.phi_i, angles.theta_v, angles.phi_v].map(f32::to_bits);
        let mut hash = 0x9e37_79b9_u32 ^ channel;
        for word in words.into_iter().chain([x, y]) {
            hash = (hash ^ word).wrapping_mul(0x85eb_ca6b);
            hash ^= hash >> 15;
        }
        hash as f32 / u32::MAX as f32
    };
    Vec3::new(bits(0), bits(1), bits(2))
}

const SMALL: Grid = Grid { phi: 8, theta: 4, alpha: 7, beta: 9, beta_uniform_in_sine: true };

#[test]
fn a_white_lambertian_surface_becomes_a_handful_of_rows() {
    let found = check(Formula::new([8, 8], Grid::default(), lambert), 1.0);
    assert!(found.tables.azimuths.rows() == 1, "{}", found.tables.azimuths.rows());
    assert!(found.report.bytes < 4000, "{}", found.report.bytes);
}

#[test]
fn highlights_keep_the_error_that_is_asked_for() {
    for error in [3.0, 8.0] {
        check(Formula::new([6, 6], Grid::default(), phong), error);
    }
    for grid in [
        Grid { beta_uniform_in_sine: false, ..SMALL },
        Grid { phi: 1, theta: 2, alpha: 2, beta: 33, beta_uniform_in_sine: true },
    ] {
        check(Formula::new([5, 7], grid, phong), 3.0);
    }
}

#[test]
fn noise_grows_the_tables_and_not_the_error() {
    check(Formula::new([4, 3], SMALL, noise), 5.0);
}

#[test]
fn a_larger_error_makes_smaller_tables() {
    let size = |error| {
        let mut source = Formula::new([10, 10], SMALL, phong);
        finished(&mut source, &settings(error)).report.bytes
    };
    let sizes = [2.0, 6.0, 18.0].map(size);
    assert!(sizes[0] > sizes[1] && sizes[1] > sizes[2], "{sizes:?}");
}

#[test]
fn a_size_can_be_asked_for() {
    let bytes = 20_000;
    let mut source = Formula::new([16, 16], SMALL, phong);
    let quality = Settings { quality: Quality::Bytes(bytes), passes: 1 };
    let found = finished(&mut source, &quality);
    assert!(found.report.bytes <= bytes, "{:?}", found.report);
    let too_small = Settings { quality: Quality::Bytes(100), passes: 1 };
    assert!(compress(&mut source, &too_small, &mut |_| ControlFlow::Continue(())).is_err());
}

#[test]
fn threads_do_not_change_the_result() {
    let with = |threads| {
        let pool = rayon::ThreadPoolBuilder::new().num_threads(threads).build().unwrap();
        pool.install(|| finished(&mut Formula::new([12, 12], SMALL, phong), &settings(3.0)).tables)
    };
    assert!(with(1) == with(3));
}

#[test]
fn bands_are_loaded_in_order_for_each_pass() {
    let mut source = Formula::new([4, 7], SMALL, phong);
    source.band = 3;
    finished(&mut source, &Settings { quality: Quality::Error(4.0), passes: 2 });
    assert_eq!(source.loaded, [0..3, 3..6, 6..7, 0..3, 3..6, 6..7]);
}

#[test]
fn progress_grows_and_can_stop_it() {
    let mut source = Formula::new([16, 16], SMALL, phong);
    let mut heard = Vec::new();
    let found = compress(&mut source, &settings(4.0), &mut |done| {
        heard.push(done);
        ControlFlow::Continue(())
    });
    assert!(found.unwrap().is_some());
    assert!(heard.is_sorted() && heard.last() == Some(&1.0), "{heard:?}");
    let found = compress(&mut source, &settings(4.0), &mut |_| ControlFlow::Break(()));
    assert!(found.unwrap().is_none());
}

#[test]
fn what_can_not_be_compressed_is_an_error() {
    let refused = |size, grid, settings: Settings| {
        let mut source = Formula::new(size, grid, lambert);
        compress(&mut source, &settings, &mut |_| ControlFlow::Continue(())).is_err()
    };
    assert!(refused([0, 4], SMALL, settings(1.0)));
    assert!(refused([4, 4], Grid { theta: 1, ..SMALL }, settings(1.0)));
    assert!(refused([4, 4], Grid { alpha: 1024, beta: 1024, ..SMALL }, settings(1.0)));
    assert!(refused([4, 4], SMALL, settings(0.0)));
    assert!(refused([4, 4], SMALL, settings(f32::NAN)));
    assert!(refused([4, 4], SMALL, Settings { passes: 0, ..settings(1.0) }));
    let mut source = Formula::new([2, 2], SMALL, |_, _, _| Vec3::splat(f32::NAN));
    assert!(compress(&mut source, &settings(1.0), &mut |_| ControlFlow::Continue(())).is_err());
}
