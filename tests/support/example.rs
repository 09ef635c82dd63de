//! Examples as a person runs them, and the pictures that they write.

use std::{
    path::{Path, PathBuf},
    process::Output,
};

use super::headless::Picture;

/// A built example, which lies beside the tests: `cargo test` builds both.
pub fn program(example: &str) -> PathBuf {
    let test = std::env::current_exe().unwrap();
    let folder = test.parent().and_then(Path::parent).unwrap();
    let name = format!("{example}{}", std::env::consts::EXE_SUFFIX);
    let program = folder.join("examples").join(name);
    assert!(
        program.exists(),
        "{} is missing: `cargo build --workspace --example {example}` makes it",
        program.display()
    );
    program
}

/// All that a run has written to the console.
pub fn words(output: &Output) -> String {
    let text = |bytes: &[u8]| String::from_utf8_lossy(bytes).into_owned();
    text(&output.stdout) + &text(&output.stderr)
}

/// A picture of the disk.
pub fn load(path: impl AsRef<Path>) -> Picture {
    let path = path.as_ref();
    let image = image::open(path).unwrap_or_else(|e| panic!("{}: {e}", path.display()));
    let image = image.into_rgb8();
    let pixels = image.pixels().map(|p| p.0).collect();
    Picture { width: image.width(), height: image.height(), pixels }
}

/// Mean difference a channel, 0..=255.
pub fn difference(a: &Picture, b: &Picture) -> f64 {
    assert_eq!((a.width, a.height), (b.width, b.height));
    let pairs = a.pixels.as_flattened().iter().zip(b.pixels.as_flattened());
    let sum: u64 = pairs.map(|(a, b)| u64::from(a.abs_diff(*b))).sum();
    sum as f64 / (a.pixels.len() * 3) as f64
}
