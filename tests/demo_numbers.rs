//! The arithmetic behind the demo's report, its paths and its command line.

#![allow(dead_code, unreachable_pub, reason = "modules of the example, used in part")]

#[path = "../examples/common/room/args.rs"]
mod args;
#[path = "../examples/common/room/motion.rs"]
mod motion;
#[path = "../examples/common/program.rs"]
mod program;
#[path = "../examples/common/room/measured/stats.rs"]
mod stats;

use std::time::Duration;

use args::{Args, Mode, Server};
use bevy::math::Vec3;
use motion::ClosedPath;
use stats::{Written, quantile, relative_errors, step_times};

fn parse(line: &str) -> Result<Args, String> {
    Args::parse(line.split_whitespace().map(String::from), false)
}

fn parse_remote(line: &str) -> Result<Args, String> {
    Args::parse(line.split_whitespace().map(String::from), true)
}

#[test]
fn command_lines_are_read_or_refused_with_a_reason() {
    let args = parse("--headless --out d --frames 60 --size 160x90 --samples 64").unwrap();
    assert_eq!(args.mode, Mode::Headless { out: "d".into(), frames: Some(60) });
    assert_eq!((args.size, args.samples), ((160, 90), 64));
    assert_eq!(parse("").unwrap().mode, Mode::Window);
    assert_eq!(parse("--soak 5").unwrap().mode, Mode::Soak(Duration::from_secs(5)));
    assert_eq!(
        parse("--nonsense -h").unwrap_err(),
        "unknown argument --nonsense; --help lists them"
    );
    for (line, word) in [
        ("--headless", "--out"),
        ("--out d", "--headless"),
        ("--size 160", "WIDTHxHEIGHT"),
        ("--size 8x90", "--size 8"),
        ("--lightmap 100", "power of two"),
        ("--frames many", "--frames many"),
        ("--soak", "needs a value"),
        ("--soak 5 --out d", "--out"),
    ] {
        let message = parse(line).unwrap_err();
        assert!(message.contains(word), "{line}: {message}");
    }
}

#[test]
fn a_server_is_named_once_and_only_where_there_is_one() {
    let args = parse_remote("--server farlight://a:1/#b --size 160x90").unwrap();
    assert_eq!(args.server, Some(Server::Invitation("farlight://a:1/#b".into())));
    assert_eq!((args.mode, args.window), (Mode::Window, (160, 90)));
    let args = parse_remote("--headless --server-file invite --out d").unwrap();
    assert_eq!(args.server, Some(Server::File("invite".into())));
    assert_eq!(parse_remote("--help").unwrap().mode, Mode::Help);
    for (line, word) in [
        ("", "farlight serve"),
        ("--headless --out d", "--server INVITE"),
        ("--server", "needs a value"),
        ("--server a --server-file b", "one server"),
    ] {
        let message = parse_remote(line).unwrap_err();
        assert!(message.contains(word), "{line}: {message}");
    }
    assert!(parse("--server a").unwrap_err().contains("unknown argument --server"));
    let texts = [args::help("local_room", "", false), args::help("remote_room", "", true)];
    assert!(!texts[0].contains("--server") && texts[1].contains("--server-file"));
}

#[test]
fn a_path_is_travelled_at_constant_speed_and_closed() {
    let path = ClosedPath::ellipse(Vec3::Y, 2.0, 0.5);
    let steps = 1000;
    let step = path.length() / steps as f32;
    for i in 0..steps {
        let (a, b) = (path.at(i as f32 * step), path.at((i + 1) as f32 * step));
        // A chord is never longer than the way, and shorter only at the polyline's corners.
        assert!(a.distance(b) <= step * 1.001 && a.distance(b) > step * 0.98, "{i}");
    }
    assert!(path.at(0.0).distance(path.at(path.length())) < 1e-4);
    let there = ClosedPath::back_and_forth(&[Vec3::ZERO, Vec3::X, Vec3::new(1.0, 1.0, 0.0)]);
    assert!((there.length() - 4.0).abs() < 1e-6);
    assert!(there.at(1.5).distance(there.at(2.5)) < 1e-6);
    assert_eq!(ClosedPath::new(&[Vec3::X]).at(3.0), Vec3::X);
}

#[test]
fn quantiles_interpolate_and_dark_texels_have_no_relative_error() {
    assert_eq!(quantile(&[], 0.5), None);
    assert_eq!(quantile(&[3.0, 1.0, 2.0, 4.0], 0.5), Some(2.5));
    assert_eq!(quantile(&[3.0, 1.0, 2.0], 1.0), Some(3.0));
    let reference = [Vec3::splat(10.0), Vec3::new(1.0, 2.0, 1.0), Vec3::splat(0.05), Vec3::ZERO];
    let live = [Vec3::splat(11.0), Vec3::new(2.0, 1.0, 1.0), Vec3::splat(9.0), Vec3::ONE];
    let errors = relative_errors(&live, &reference);
    assert_eq!(errors.len(), 2, "{errors:?}");
    assert!((errors[0] - 0.1).abs() < 1e-6 && (errors[1] - 0.5).abs() < 1e-6);
}

#[test]
fn a_step_has_arrived_when_it_stays_arrived() {
    // Ten receivers go from 1 to 2; an eleventh texel hardly changes and is no receiver.
    let mut before = vec![Vec3::ONE; 10];
    let mut after = vec![Vec3::splat(2.0); 10];
    before.push(Vec3::ONE);
    after.push(Vec3::splat(1.05));
    let write = |at_ms: f32, knows: bool, values: [f32; 10]| Written {
        first_ms: at_ms - 1.0,
        at_ms,
        knows,
        texels: values.into_iter().chain([1.0]).map(Vec3::splat).collect(),
    };
    let mut half = [1.2; 10];
    half[..5].fill(1.95);
    let mut most = [1.95; 10];
    most[9] = 1.2;
    let writes = [
        write(10.0, false, [1.0; 10]),
        write(20.0, true, half),
        write(30.0, true, [1.5; 10]),
        write(40.0, true, half),
        write(50.0, true, most),
        write(60.0, true, [2.0; 10]),
    ];
    let times = step_times(&before, &after, &before, &writes);
    assert_eq!(times.receivers, 10);
    assert_eq!(times.first_texel_ms, Some(19.0));
    assert_eq!(times.median_receiver_90_ms, Some(40.0), "20 ms does not count: it was lost again");
    assert_eq!(times.receivers_90_ms, Some(50.0));
    assert_eq!(times.sum_90_ms, Some(60.0));
    // What is shown is 8 % too dark throughout: an error, not a delay.
    let dim: Vec<_> = before.iter().map(|v| *v * 0.92).collect();
    let late = [write(70.0, true, [1.84; 10])];
    assert_eq!(step_times(&before, &after, &dim, &late).median_receiver_90_ms, Some(70.0));
    let never = step_times(&before, &after, &before, &writes[..3]);
    assert_eq!(never.median_receiver_90_ms, None);
    assert_eq!(step_times(&before, &before, &before, &writes).receivers, 0);
}
