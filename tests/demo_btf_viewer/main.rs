//! The viewer of measured materials, as a person runs it without a window, only smaller.

mod actions;
#[path = "../../examples/btf_viewer/config.rs"]
#[expect(dead_code, unreachable_pub, reason = "shared with the example")]
mod config;
mod configuration;
#[path = "../../examples/btf_viewer/grab.rs"]
#[expect(unreachable_pub, reason = "shared with the example")]
mod grab;
mod motion;
#[path = "../support/mod.rs"]
mod support;
#[path = "../../examples/btf_viewer/viewpoint.rs"]
#[expect(unreachable_pub, dead_code, reason = "shared with the example")]
mod viewpoint;

use std::{
    process::{Command, Output},
    thread,
};

use farlight_btf_codec::synthetic;
use support::{
    example::{difference, load, program, words},
    headless::Picture,
};

fn viewer(arguments: &[&str]) -> Output {
    Command::new(program("btf_viewer")).args(arguments).output().unwrap()
}

/// A material file: bright, without a direction of its own.
fn material() -> String {
    let path = support::scratch("btf_viewer").join(format!("{:?}.fbtf", thread::current().id()));
    std::fs::create_dir_all(path.parent().unwrap()).unwrap();
    synthetic::lambert([0.8, 0.7, 0.5], [2, 2]).unwrap().write(&path).unwrap();
    path.display().to_string()
}

/// Runs a turntable of four pictures, 96 x 72, and checks what must hold for any of them.
fn turntable(name: &str, more: &[&str]) -> Vec<Picture> {
    let out = support::scratch("btf_viewer").join(name);
    let _ = std::fs::remove_dir_all(&out);
    let folder = out.display().to_string();
    let material = material();
    let arguments = ["--headless", "--out", &folder, "--frames", "4", "--size", "96x72"];
    let arguments = [&arguments[..], &["--material", &material]].concat();
    let run = viewer(&[&arguments[..], more].concat());
    assert!(run.status.success(), "{name}: {}", words(&run));
    let pictures: Vec<_> = (0..4).map(|i| load(out.join(format!("frame_{i:03}.png")))).collect();
    for picture in &pictures {
        assert_eq!((picture.width, picture.height), (96, 72));
        assert_eq!(picture.problem(), None);
    }
    let sheet = load(out.join("contact.png"));
    assert_eq!((sheet.width, sheet.height), (4 * 96, 72));
    pictures
}

#[test]
fn a_turn_shows_the_object_from_all_sides() {
    let pictures = turntable("bunny", &["--object", "bunny", "--environment", "none"]);
    // A quarter turn moves ears, tail and legs: a picture of the plinth alone would differ by 0.
    for i in 0..4 {
        let change = difference(&pictures[i], &pictures[(i + 1) % 4]);
        assert!(change > 1.0, "{i}: {change}");
    }
}

#[test]
fn every_light_lights_and_every_object_is_there() {
    let alone = ["--environment", "none", "--object", "sphere"];
    let dark = |rig| turntable(rig, &[&alone[..], &["--light", rig]].concat())[0].mean();
    let [point, five, sun, spot] = ["point", "five", "sun", "spot"].map(dark);
    // The background alone has a mean of 27.
    for (rig, mean) in [("point", point), ("five", five), ("sun", sun), ("spot", spot)] {
        assert!(mean > 32.0, "{rig}: {mean}");
    }
    let plain = ["--light", "none", "--environment", "interior", "--progressive", "off"];
    let objects = ["plane", "drape", "hippo"];
    let shown = objects.map(|object| {
        turntable(object, &[&plain[..], &["--object", object]].concat()).swap_remove(0)
    });
    for (i, a) in shown.iter().enumerate() {
        for b in &shown[..i] {
            assert!(difference(a, b) > 2.0, "{} looks like another", objects[i]);
        }
    }
}

#[test]
fn the_light_of_environments_is_refined_or_image_based() {
    let arguments = ["--light", "none", "--environment", "evening", "--object", "bunny"];
    let [refined, image_based] = ["on", "off"].map(|progressive| {
        let more = [&arguments[..], &["--progressive", progressive]].concat();
        turntable(progressive, &more).swap_remove(0)
    });
    let change = difference(&refined, &image_based);
    let (bright, other) = (refined.mean(), image_based.mean());
    println!("{change:.1} of 255 apart; mean {bright:.1} refined, {other:.1} image-based");
    assert!(change > 0.5, "no shadows");
    assert!((bright / other - 1.0).abs() < 0.25, "{bright} {other}");
}

#[test]
fn what_cannot_be_read_is_said() {
    let out = support::scratch("btf_viewer").join("errors").display().to_string();
    let headless = ["--headless", "--out", &out, "--frames", "1", "--size", "32x32"];
    let run = |more: &[&str]| viewer(&[&headless[..], more].concat());
    let damaged = support::scratch("damaged.fbtf");
    std::fs::write(&damaged, b"no material").unwrap();
    let damaged = damaged.display().to_string();
    let material = material();
    for option in ["--material", "--environment", "--object"] {
        let fine: &[&str] = if option == "--material" { &[] } else { &["--material", &material] };
        let output = run(&[&[option, &damaged], fine].concat());
        assert_eq!(output.status.code(), Some(1), "{option}: {}", words(&output));
        assert!(words(&output).contains("damaged"), "{option}: {}", words(&output));
    }
    let output = run(&["--object", "unicorn"]);
    assert!(words(&output).contains("unicorn") && words(&output).contains("hippo"));
    assert_eq!(viewer(&["--light", "moon"]).status.code(), Some(2));
    assert_eq!(viewer(&["--progressive", "maybe"]).status.code(), Some(2));
    assert_eq!(viewer(&["--headless"]).status.code(), Some(2));
    let help = viewer(&["--help"]);
    assert!(help.status.success() && words(&help).contains("--environment NAME"));
}
