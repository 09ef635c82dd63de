//! The example of environment light, as a person runs it without a window, only smaller.

mod support;

use std::{
    path::PathBuf,
    process::{Command, Output},
};

use support::{
    example::{difference, load, program, words},
    headless::Picture,
};

fn example(arguments: &[&str]) -> Output {
    Command::new(program("progressive_environment")).args(arguments).output().unwrap()
}

/// One of the strip's pictures.
fn piece(strip: &Picture, index: u32, width: u32) -> Picture {
    let from = (index * width) as usize;
    let rows = strip.pixels.chunks_exact(strip.width as usize);
    let pixels = rows.flat_map(|row| row[from..from + width as usize].to_vec()).collect();
    Picture { width, height: strip.height, pixels }
}

fn folder(name: &str) -> PathBuf {
    let out = support::scratch("progressive_environment").join(name);
    let _ = std::fs::remove_dir_all(&out);
    out
}

#[test]
fn pictures_become_better_and_stay_so_in_motion() {
    let out = folder("pictures");
    let run = example(
        &[
            &["--headless", "--out", &out.display().to_string(), "--size", "160x90"][..],
            &["--environment", "evening", "--lights", "200", "--per-frame", "5"],
        ]
        .concat(),
    );
    assert!(run.status.success(), "{}", words(&run));
    let picture = |name: &str| load(out.join(name));
    let refined = picture("evening-refined.png");
    assert_eq!((refined.width, refined.height), (160, 90));
    assert_eq!(refined.problem(), None);

    // A strip of 1, 5, 20 and 40 frames: all 200 lights are in the last one.
    let strip = picture("refining.png");
    let apart = [0, 1, 2, 3].map(|i| difference(&piece(&strip, i, 160), &refined));
    println!("1, 5, 20, 40 frames are {apart:.2?} of 255 from the refined picture");
    assert!(apart[0] > apart[1] && apart[1] > apart[2] && apart[2] > apart[3], "{apart:?}");
    assert!(apart[3] < 1.5 && apart[0] > 2.0, "{apart:?}");

    // Swaying moves the picture by less than a pixel or two, and must not lose its light.
    let sway = picture("sway.png");
    let (still, moved) = (refined.mean(), sway.mean());
    println!("mean {still:.1} at rest, {moved:.1} in motion");
    assert!((moved / still - 1.0).abs() < 0.05, "{still} {moved}");

    // Image-based light has no shadows, but about the same light elsewhere.
    let image_based = picture("evening-image-based.png");
    assert!(difference(&image_based, &refined) > 1.0);
    assert!((image_based.mean() / still - 1.0).abs() < 0.3, "{} {still}", image_based.mean());
    assert_eq!(picture("dots.png").problem(), None);
}

#[test]
fn a_turn_is_recorded() {
    let out = folder("turn");
    let run = example(
        &[
            &["--headless", "--out", &out.display().to_string(), "--size", "96x54"][..],
            &["--turntable", "2", "--environment", "sky", "--lights", "8", "--no-shadows"],
        ]
        .concat(),
    );
    assert!(run.status.success(), "{}", words(&run));
    let [front, back] = [0, 1].map(|i| load(out.join(format!("turn_{i:03}.png"))));
    assert!(difference(&front, &back) > 5.0, "the other side is another picture");
}

#[test]
fn a_wrong_command_line_is_refused() {
    for (arguments, word) in [
        (&["--lights", "5000"][..], "--lights 5000"),
        (&["--per-frame", "11"], "--per-frame 11"),
        (&["--method", "magic"], "magic"),
        (&["--environment", "moon"], "overcast"),
        (&["--size", "9x9"], "--size 9x9"),
        (&["--headless"], "--out"),
        (&["--turntable", "3"], "--headless"),
    ] {
        let run = example(arguments);
        assert_eq!(run.status.code(), Some(2), "{arguments:?}: {}", words(&run));
        assert!(words(&run).contains(word), "{arguments:?}: {}", words(&run));
    }
    let damaged = support::scratch("damaged.hdr");
    std::fs::write(&damaged, b"no light").unwrap();
    let out = folder("damaged").display().to_string();
    let arguments = ["--headless", "--out", &out, "--environment", &damaged.display().to_string()];
    let run = example(&[&arguments[..], &["--size", "32x32"]].concat());
    assert_eq!(run.status.code(), Some(1), "{}", words(&run));
    assert!(words(&run).contains("damaged"), "{}", words(&run));
    let help = example(&["--help"]);
    assert!(help.status.success() && words(&help).contains("--turntable N"));
}
