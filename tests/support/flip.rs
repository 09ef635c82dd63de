//! Pictures compared with committed references by FLIP (Andersson et al. 2020, "FLIP: A Difference
//! Evaluator for Alternating Images").

use std::path::{Path, PathBuf};

use super::headless::Picture;

/// The largest FLIP differences that pass; 0 is equal, 1 is as different as can be.
#[derive(Clone, Copy, Debug)]
pub struct Limits {
    /// Mean over all pixels.
    pub mean: f32,
    /// 95th percentile over all pixels.
    pub p95: f32,
}

/// Compares a picture with `tests/references/<name>.png`.
///
/// A missing reference is a failure. With `FARLIGHT_BLESS=1` the reference is written anew instead.
/// On a failure the picture and the difference are left in the target folder.
///
/// # Panics
/// If the picture differs from the reference by more than the limits, or there is no reference.
pub fn assert_matches(picture: &Picture, name: &str, limits: Limits, adapter: &str) {
    let reference = reference_path(name);
    if std::env::var_os("FARLIGHT_BLESS").is_some_and(|v| v == "1") {
        picture.save(&reference).unwrap();
        println!("blessed {}", reference.display());
        return;
    }
    let actual = super::scratch(&format!("{name}.actual.png"));
    let expected = match image::open(&reference) {
        Ok(image) => image.into_rgb8(),
        Err(error) => {
            picture.save(&actual).unwrap();
            panic!(
                "no reference {}: {error}; the picture is {}; look at it, then set FARLIGHT_BLESS=1",
                reference.display(),
                actual.display()
            );
        }
    };
    assert_eq!(
        (expected.width(), expected.height()),
        (picture.width, picture.height),
        "{name}: the size differs from the reference's"
    );
    let (map, differences) = difference(&expected, picture);
    let (mean, p95) = (mean(&differences), percentile(&differences, 0.95));
    println!("{name}: FLIP mean {mean:.4}, 95th percentile {p95:.4} ({adapter})");
    if mean > limits.mean || p95 > limits.p95 {
        let folder = super::scratch(&format!("{name}.difference.png"));
        picture.save(&actual).unwrap();
        map.save(&folder).unwrap();
        panic!(
            "{name} on {adapter}: FLIP mean {mean:.4} (limit {}), 95th percentile {p95:.4} (limit {}); \
             picture {}, difference {}",
            limits.mean,
            limits.p95,
            actual.display(),
            folder.display()
        );
    }
}

/// FLIP of each pixel of two pictures.
pub struct Difference(Vec<f32>);

impl Difference {
    /// Mean over all pixels.
    pub fn mean(&self) -> f32 {
        mean(&self.0)
    }

    /// The value that `fraction` of the pixels do not exceed.
    pub fn percentile(&self, fraction: f32) -> f32 {
        percentile(&self.0, fraction)
    }
}

/// How different two pictures of the same size are.
///
/// # Panics
/// If their sizes differ.
pub fn between(expected: &Picture, actual: &Picture) -> Difference {
    assert_eq!((expected.width, expected.height), (actual.width, actual.height));
    let expected = image::RgbImage::from_raw(
        expected.width,
        expected.height,
        expected.pixels.as_flattened().to_vec(),
    );
    Difference(difference(&expected.expect("three bytes a pixel"), actual).1)
}

fn reference_path(name: &str) -> PathBuf {
    Path::new(env!("CARGO_MANIFEST_DIR")).join("tests/references").join(format!("{name}.png"))
}

/// The difference as a picture (magma colours) and as one number a pixel.
fn difference(expected: &image::RgbImage, picture: &Picture) -> (Picture, Vec<f32>) {
    let (width, height) = (picture.width, picture.height);
    let test = picture.pixels.as_flattened();
    let error = nv_flip::flip(
        nv_flip::FlipImageRgb8::with_data(width, height, expected),
        nv_flip::FlipImageRgb8::with_data(width, height, test),
        nv_flip::DEFAULT_PIXELS_PER_DEGREE,
    );
    let colours = error.apply_color_lut(&nv_flip::magma_lut()).to_vec();
    let pixels = colours.chunks_exact(3).map(|p| [p[0], p[1], p[2]]).collect();
    (Picture { width, height, pixels }, error.to_vec())
}

fn mean(values: &[f32]) -> f32 {
    values.iter().sum::<f32>() / values.len() as f32
}

fn percentile(values: &[f32], fraction: f32) -> f32 {
    let mut sorted = values.to_vec();
    sorted.sort_by(f32::total_cmp);
    sorted[((sorted.len() - 1) as f32 * fraction).round() as usize]
}

#[test]
fn equal_pictures_do_not_differ_and_others_do() {
    let pixels: Vec<_> =
        (0..32 * 32u32).map(|i| [(i % 32 * 8) as u8, (i / 32 * 8) as u8, 90]).collect();
    let picture = Picture { width: 32, height: 32, pixels };
    let flat: Vec<u8> = picture.pixels.as_flattened().to_vec();
    let same = image::RgbImage::from_raw(32, 32, flat.clone()).unwrap();
    assert!(difference(&same, &picture).1.iter().all(|&d| d == 0.0));
    let other = image::RgbImage::from_raw(32, 32, flat.iter().map(|v| 255 - v).collect()).unwrap();
    assert!(mean(&difference(&other, &picture).1) > 0.2);
}
