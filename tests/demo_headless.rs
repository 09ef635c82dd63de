//! The demo itself, as a person runs it, only shorter.

mod support;

use std::process::Command;

use support::{
    example::{load, program},
    headless::Picture,
};

/// Mean brightness of the right third: a wall of the dark room that no lamp shines on.
fn dark_room(picture: &Picture) -> f64 {
    let width = picture.width as usize;
    let rows = picture.pixels.chunks_exact(width);
    let pixels: Vec<_> = rows.flat_map(|row| row[width - width / 3..].iter().copied()).collect();
    Picture { width: width as u32 / 3, height: picture.height, pixels }.mean()
}

#[test]
fn a_short_run_writes_pictures_and_a_report() {
    let out = support::scratch("demo");
    let _ = std::fs::remove_dir_all(&out);
    let run = Command::new(program("local_room"))
        .args(["--headless", "--frames", "24", "--size", "96x54", "--samples", "64"])
        .args(["--lightmap", "64", "--out"])
        .arg(&out)
        .output()
        .unwrap();
    let (stdout, stderr) =
        (String::from_utf8_lossy(&run.stdout), String::from_utf8_lossy(&run.stderr));
    assert!(run.status.success(), "{stdout}\n{stderr}");
    assert!(stdout.contains("90 % at the median receiver"), "{stdout}");

    let text = std::fs::read_to_string(out.join("report.json")).unwrap();
    let report: serde_json::Value = serde_json::from_str(&text).unwrap();
    for key in [
        "/adapter",
        "/updates_per_s",
        "/first_light_ms",
        "/step_first_texel_ms",
        "/step_90_ms",
        "/step_90_of_receivers_ms",
        "/error_moving/median",
        "/error_moving/p95",
        "/error_after_stop/median",
        "/system_cpu_ms/p99",
        "/system_wall_ms/p99",
        "/definitions/step_90_ms",
    ] {
        assert!(report.pointer(key).is_some(), "{key} is missing in {text}");
    }
    let number = |key: &str| report.pointer(key).and_then(serde_json::Value::as_f64);
    assert!(number("/lightmap_lit_texels") > Some(500.0), "{text}");
    assert!(number("/steps") >= Some(1.0), "{text}");
    // No claim about quality at these few samples: only that it is a lightmap of this scene.
    assert!(number("/error_picture/median") < Some(0.6), "{text}");

    let [direct, indirect, reference, lightmap] =
        ["direct-only", "indirect", "reference", "lightmap"]
            .map(|name| load(out.join(format!("{name}.png"))));
    for picture in [&direct, &indirect, &reference, &lightmap] {
        assert_eq!((picture.width, picture.height), (96, 54));
        assert_eq!(picture.problem(), None);
    }
    let [d, i, r] = [&direct, &indirect, &reference].map(dark_room);
    assert!(i > 20.0 && d < 5.0, "the dark room is lit: {i} with, {d} without indirect light");
    assert!((i - r).abs() < 0.25 * r, "as bright as the reference: {i}, {r}");
}

#[test]
fn a_wrong_command_line_is_refused() {
    let run = Command::new(program("local_room")).args(["--size", "huge"]).output().unwrap();
    assert_eq!(run.status.code(), Some(2));
    assert!(String::from_utf8_lossy(&run.stderr).contains("--size huge"));
    let help = Command::new(program("local_room")).arg("--help").output().unwrap();
    assert!(help.status.success());
    assert!(String::from_utf8_lossy(&help.stdout).contains("report.json"));
}
