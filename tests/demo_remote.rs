//! The demo with a lighting server, as a person runs it, only shorter: two processes over loopback.

#[path = "remote_processes/server.rs"]
#[expect(dead_code, unreachable_pub, reason = "shared with the tests of the backend")]
mod server;
mod support;

use std::process::Command;

use server::ServerProcess;
use support::example::program;

#[test]
fn a_short_run_is_lit_by_the_server() {
    let folder = support::scratch("demo_remote");
    let _ = std::fs::remove_dir_all(&folder);
    let server = ServerProcess::start(&folder.join("server"), 0);
    let out = folder.join("pictures");
    let run = Command::new(program("remote_room"))
        .args(["--server", &server.invitation(), "--headless", "--frames", "24"])
        .args(["--size", "96x54", "--samples", "16", "--lightmap", "64", "--out"])
        .arg(&out)
        .output()
        .unwrap();
    let (stdout, stderr) =
        (String::from_utf8_lossy(&run.stdout), String::from_utf8_lossy(&run.stderr));
    assert!(run.status.success(), "{stdout}\n{stderr}\n{}", server.log());
    assert!(stdout.contains("first lit frame after the scene was sent"), "{stdout}");

    let text = std::fs::read_to_string(out.join("report.json")).unwrap();
    let report: serde_json::Value = serde_json::from_str(&text).unwrap();
    let number = |key: &str| {
        let value = report.pointer(key).and_then(serde_json::Value::as_f64);
        value.unwrap_or_else(|| panic!("{key} is missing in {text}"))
    };
    assert!(number("/network/moving/updates") >= 1.0, "{text}");
    assert!(number("/network/bytes_per_update") > 20.0, "{text}");
    assert!(number("/network/received_bytes_per_s") > 100.0, "{text}");
    // The scene is some hundred kilobytes of meshes and images.
    assert!(number("/network/start/sent_bytes") > 10_000.0, "{text}");
    for stage in ["extract", "send", "solve", "encode", "transfer", "decode", "upload", "whole"] {
        let (p50, p90) = (format!("/stages_ms/{stage}/p50"), format!("/stages_ms/{stage}/p90"));
        assert!(number(&p50) >= 0.0 && number(&p90) >= number(&p50), "{stage}: {text}");
    }
    assert!(number("/stages_ms/whole/samples") >= 1.0, "{text}");

    // The right third is a wall of the dark room: black without indirect light.
    let wall = |name: &str| {
        let picture = image::open(out.join(name)).unwrap().into_rgb8();
        let pixels = picture.enumerate_pixels().filter(|(x, ..)| *x > picture.width() * 2 / 3);
        let values: Vec<f64> = pixels.flat_map(|(_, _, p)| p.0.map(f64::from)).collect();
        values.iter().sum::<f64>() / values.len() as f64
    };
    let [direct, indirect] = ["direct-only.png", "indirect.png"].map(wall);
    assert!(direct < 5.0 && indirect > 20.0, "{direct} without, {indirect} with indirect light");
}

#[test]
fn a_server_must_be_named_and_be_one() {
    let fails = |arguments: &[&str]| {
        let run = Command::new(program("remote_room")).args(arguments).output().unwrap();
        (run.status.code(), String::from_utf8_lossy(&run.stderr).into_owned())
    };
    let (code, words) = fails(&["--headless", "--out", "x"]);
    assert!(code == Some(2) && words.contains("farlight serve"), "{words}");
    let (code, words) = fails(&["--headless", "--out", "x", "--server", "farlight://host"]);
    assert!(code == Some(1) && words.contains("--server:"), "{words}");
}
