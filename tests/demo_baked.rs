//! The examples of baked light as a person runs them, only smaller.

mod support;

use std::{path::PathBuf, process::Command};

use support::{
    example::{load, program, words},
    headless::Picture,
};

fn run(example: &str, out: &str, more: &[&str]) -> PathBuf {
    let out = support::scratch(out);
    let _ = std::fs::remove_dir_all(&out);
    let size = ["--headless", "--size", "160x90", "--out"];
    let run = Command::new(program(example)).args(size).arg(&out).args(more).output().unwrap();
    assert!(run.status.success(), "{}", words(&run));
    out
}

/// Mean of each channel.
fn mean(picture: &Picture) -> [f64; 3] {
    assert_eq!(picture.problem(), None);
    let mut sum = [0.0; 3];
    for pixel in &picture.pixels {
        (0..3).for_each(|c| sum[c] += f64::from(pixel[c]));
    }
    sum.map(|sum| sum / picture.pixels.len() as f64)
}

#[test]
fn a_day_is_bright_at_noon_and_warm_in_the_evening() {
    let out = run("scenarios", "scenarios", &["--pictures", "3"]);
    let [morning, afternoon, night] =
        [0, 1, 2].map(|index| mean(&load(out.join(format!("day_{index:02}.png")))));
    let warmth = |[r, _, b]: [f64; 3]| r / b;
    let light = |[r, g, b]: [f64; 3]| r + g + b;
    assert!(light(afternoon) > 1.2 * light(night), "{afternoon:?}, {night:?}");
    assert!(warmth(night) > 1.2 * warmth(afternoon), "{night:?}, {afternoon:?}");
    assert!(light(morning) > 30.0, "{morning:?}");
    let strip = load(out.join("strip.png"));
    assert_eq!((strip.width, strip.height), (480, 90));
}

#[test]
fn a_manifest_is_shown_in_all_its_scenarios() {
    let out = run("baked", "baked_example", &[]);
    for scenario in ["morning", "noon", "evening", "lamp"] {
        let picture = load(out.join(format!("{scenario}.png")));
        assert_eq!((picture.width, picture.height), (160, 90));
        // At the exposure of noon the lamp alone is dark.
        assert!(scenario == "lamp" || picture.problem().is_none(), "{scenario}");
    }
}

#[test]
fn wrong_command_lines_are_refused() {
    for (example, arguments) in
        [("baked", ["--eye", "1,2"]), ("scenarios", ["--pictures", "0"]), ("baked", ["--out", "x"])]
    {
        let run = Command::new(program(example)).args(arguments).output().unwrap();
        assert_eq!(run.status.code(), Some(2), "{}", words(&run));
    }
    let help = Command::new(program("scenarios")).arg("--help").output().unwrap();
    assert!(help.status.success() && words(&help).contains("strip.png"));
}

#[test]
fn a_manifest_that_is_not_there_is_an_error() {
    let out = support::scratch("baked_missing");
    let run = Command::new(program("baked"))
        .args(["no/such.baked.ron", "--headless", "--out"])
        .arg(&out)
        .output()
        .unwrap();
    assert_eq!(run.status.code(), Some(1));
    assert!(words(&run).contains("such.baked.ron"), "{}", words(&run));
}
