//! The gallery: its walls and its teleport by themselves, and its tour as a person runs it without window
//! and headset, only smaller.

#![allow(unreachable_pub, reason = "the modules of the example read like a library's")]

#[path = "../examples/xr_gallery/building.rs"]
#[expect(dead_code, reason = "its shell is drawn by the example alone")]
mod building;
#[path = "../examples/xr_gallery/plan.rs"]
#[expect(dead_code, reason = "what stands there is made by the example alone")]
mod plan;
mod support;
#[path = "../examples/xr_gallery/teleport.rs"]
mod teleport;

use std::process::{Command, Output};

use bevy::prelude::*;
use plan::{ENTRANCE, Floor, HALL, OPENINGS, PERSON, RED, SPACES, STANDS, WINDOW};
use support::{
    example::{difference, load, program, words},
    headless::Picture,
};
use teleport::throw;

/// Directions all over the sphere.
fn directions(count: u32) -> impl Iterator<Item = Vec3> {
    (0..count).map(move |i| {
        let y = 1.0 - 2.0 * (i as f32 + 0.5) / count as f32;
        let turn = i as f32 * 2.399_963;
        let (sin, cos) = turn.sin_cos();
        Vec3::new(cos, 0.0, sin) * (1.0 - y * y).sqrt() + Vec3::Y * y
    })
}

#[test]
fn light_comes_in_by_skylight_and_window_alone() {
    let floor = Floor::default();
    let mut out = 0;
    for (_, room) in SPACES.iter().filter(|(space, _)| matches!(*space, HALL | RED | WINDOW)) {
        let from = room.min.midpoint(room.max);
        for along in directions(4000) {
            let mut last = None;
            for step in 0.. {
                let place = from + along * (step as f32 * 0.05);
                if floor.building.is_wall(place) {
                    break;
                }
                let Some(space) = floor.building.space(place) else {
                    assert_eq!(last, Some(OPENINGS), "from {from} along {along} at {place}");
                    out += 1;
                    break;
                };
                last = Some(space);
            }
        }
    }
    assert!(out > 100, "{out} of 12000 lead out");
}

#[test]
fn surfaces_cover_all_walls_and_share_their_corners() {
    let floor = Floor::default();
    let surfaces = floor.building.surfaces();
    let positions = |mesh: &Mesh| -> Vec<Vec3> {
        let values = mesh.attribute(Mesh::ATTRIBUTE_POSITION).unwrap().as_float3().unwrap();
        values.iter().copied().map(Vec3::from_array).collect()
    };
    let mut facing = Vec3::ZERO;
    for surface in &surfaces {
        let corners = positions(&surface.mesh);
        let indices: Vec<usize> = surface.mesh.indices().unwrap().iter().collect();
        let mut area = Vec3::ZERO;
        for triangle in indices.as_chunks::<3>().0 {
            let [a, b, c] = triangle.map(|i| corners[i]);
            let normal = 0.5 * (b - a).cross(c - a);
            assert!(normal.dot(surface.normal) > 0.0, "they face the room");
            area += normal;
        }
        facing += area;
        // A step from the surface is air, a step behind it is wall.
        for square in corners.as_chunks::<4>().0 {
            let middle = square.iter().sum::<Vec3>() / 4.0;
            assert_eq!(floor.building.space(middle + surface.normal * 1e-3), Some(surface.space));
            assert!(floor.building.is_wall(middle - surface.normal * 1e-3));
        }
    }
    // All areas that face one way and the other cancel but for what skylight and window leave open.
    let open = Vec3::new(2.2 * 1.8, 2.2 * 3.6, 0.0);
    let left = Vec3::new(facing.x, facing.y, facing.z);
    assert!((left.abs() - open).abs().max_element() < 1e-3, "{left} {open}");
}

/// Where a throw from the entrance lands.
fn landing(from: Vec3, along: Vec3) -> Option<Vec3> {
    throw(from, along, &Floor::default()).landing
}

#[test]
fn arcs_land_where_people_can_stand() {
    let floor = Floor::default();
    let hand = ENTRANCE + Vec3::new(-0.2, 1.2, -0.3);
    assert!(floor.carries(ENTRANCE));

    let ahead = throw(hand, Vec3::new(0.35, 0.1, -1.0), &floor);
    let there = ahead.landing.unwrap();
    assert!(there.y == 0.0 && there.z < ENTRANCE.z - 2.0 && floor.carries(there), "{there}");
    // The arc ends where it lands, and leads through nothing.
    assert!(ahead.points.last().unwrap().distance(there) < 0.02, "{:?}", ahead.points.last());
    assert!(ahead.points.iter().all(|point| !floor.blocks(*point)));

    assert_eq!(landing(hand, Vec3::new(0.0, 0.9, 1.0)), None, "into the wall behind");
    let below = landing(hand, Vec3::NEG_Y).unwrap();
    assert!(below.distance(hand.with_y(0.0)) < 0.3, "straight down");

    // Over the top of the round plinth: nobody stands on it.
    let plinth = STANDS[plan::ROUND];
    let above = plinth.top() + Vec3::Y;
    assert_eq!(landing(above, Vec3::NEG_Y), None);

    // Close to a wall one is put back so far that one has room.
    let near_wall = landing(Vec3::new(3.3, 1.2, 1.2), Vec3::new(1.0, -2.0, 0.0)).unwrap();
    assert!(near_wall.x <= 4.0 - PERSON && near_wall.x > 3.3, "{near_wall}");

    // Through the door into the red room, and not through the wall beside it.
    let red = landing(Vec3::new(2.8, 1.2, -0.5), Vec3::new(1.0, 0.05, 0.0)).unwrap();
    assert_eq!(floor.room(red + Vec3::Y * 0.1), Some(RED));
    assert_eq!(landing(Vec3::new(2.8, 1.2, 1.5), Vec3::new(1.0, 0.4, 0.0)), None);

    // Out of the window there is no floor.
    assert_eq!(landing(Vec3::new(-9.2, 1.5, -0.8), Vec3::new(-1.0, 0.3, 0.0)), None);
    // Nothing is aimed at by a hand in a wall, or by one that isn't tracked.
    assert_eq!(landing(Vec3::new(4.2, 1.2, 1.5), Vec3::NEG_Z), None);
    assert_eq!(landing(Vec3::NAN, Vec3::NEG_Z), None);
    assert_eq!(landing(hand, Vec3::ZERO), None);
}

#[test]
fn no_walk_leads_through_walls() {
    let floor = Floor::default();
    // A long step to the north ends before the plinth, one to the east before the wall.
    let north = floor.walk(Vec3::new(0.0, 0.0, 2.5), Vec3::new(0.0, 0.0, -5.0));
    assert!(north.z > STANDS[plan::ROUND].place.z + 0.55 + PERSON - 1e-3, "{north}");
    let east = floor.walk(Vec3::new(3.0, 0.0, 2.0), Vec3::new(4.0, 0.0, 0.0));
    assert!(east.x <= 4.0 - PERSON + 1e-3 && east.x > 3.5, "{east}");
    // Along the wall rather than nowhere; through the door into the next room.
    let along = floor.walk(Vec3::new(3.7, 0.0, 2.0), Vec3::new(1.0, 0.0, -1.0));
    assert!(along.z < 1.1, "{along}");
    let through = floor.walk(Vec3::new(3.0, 0.0, -0.5), Vec3::new(2.5, 0.0, 0.0));
    assert_eq!(floor.room(through + Vec3::Y), Some(RED));
    for direction in directions(64) {
        let there = floor.walk(ENTRANCE, direction * 30.0);
        assert!(floor.carries(there), "{there}");
    }
}

fn example(arguments: &[&str]) -> Output {
    Command::new(program("xr_gallery")).args(arguments).output().unwrap()
}

/// The numbers of the report's line that begins so.
fn numbers(report: &str, line: &str) -> Vec<f32> {
    let line = report.lines().find(|l| l.starts_with(line));
    let line = line.unwrap_or_else(|| panic!("no {line:?} in {report}"));
    line.split(|c: char| !c.is_ascii_digit() && c != '.' && c != '-')
        .filter_map(|word| word.parse().ok())
        .collect()
}

/// How far to the left, in pixels, a part of the left picture is found again in the right one: the shift
/// with the least difference.
fn disparity(
    left: &Picture,
    right: &Picture,
    rows: std::ops::Range<u32>,
    columns: std::ops::Range<u32>,
) -> i32 {
    let pixel = |picture: &Picture, x: i64, y: u32| {
        let x = x.clamp(0, i64::from(picture.width) - 1) as u32;
        picture.pixels[(y * picture.width + x) as usize].map(i64::from)
    };
    (0..=60)
        .min_by_key(|shift: &i32| {
            let mut sum = 0;
            for y in rows.clone() {
                for x in columns.clone() {
                    let a = pixel(left, i64::from(x), y);
                    let b = pixel(right, i64::from(x) - i64::from(*shift), y);
                    sum += (0..3).map(|c| (a[c] - b[c]).abs()).sum::<i64>();
                }
            }
            sum
        })
        .unwrap()
}

#[test]
fn a_tour_without_window_and_headset() {
    let out = support::scratch("xr_gallery");
    let _ = std::fs::remove_dir_all(&out);
    let run = example(&[
        "--headless",
        "--out",
        &out.display().to_string(),
        "--size",
        "240x136",
        "--texels",
        "3",
        "--paths",
        "64",
    ]);
    assert!(run.status.success(), "{}", words(&run));
    let report = words(&run);
    println!("{report}");
    let picture = |name: &str| load(out.join(format!("{name}.png")));

    // Light reaches the corner that no lamp shines into.
    let [full, direct] = [picture("corner"), picture("corner_direct")].map(|p| p.mean());
    assert!(full > 1.3 * direct && full > 20.0, "{full} {direct}");
    for name in ["hall", "red_room", "window_room", "skylight", "panel", "teleport"] {
        assert!(picture(name).mean() > 15.0, "{name} is dark");
    }
    // The lantern's light follows it.
    let lit = difference(&picture("window_room"), &picture("lantern_by_the_window"));
    assert!(lit > 3.0, "{lit}");
    let [far, off] = numbers(&report, "lantern:")[..] else { panic!("{report}") };
    assert!(far > 10.0 && off < 0.01, "{report}");

    // Who lets go stands on the marker.
    let [far, off] = numbers(&report, "teleport:")[..] else { panic!("{report}") };
    assert!(far > 1.5 && off < 0.01, "{report}");

    // The ray of a hand pressed a switch of the panel in the world.
    assert!(report.contains("panel: pressed"), "{report}");
    // What is near is farther to the left in the right eye's picture; what is far, less so. The round
    // plinth's edge is 2.2 m away, the painting on the wall behind it 4.7 m.
    let [left, right] = [picture("left"), picture("right")];
    assert!(difference(&left, &right) > 1.0);
    let [plinth, painting] =
        [(112..132), (45..75)].map(|rows| disparity(&left, &right, rows, 70..170));
    println!("{plinth} and {painting} pixels apart");
    // Eyes see by an eighth of their picture's half farther outwards: that is 29 pixels for what is at
    // infinity. 63 mm at 2.2 m are 3 more, at 4.7 m 1.5.
    assert!((31..=34).contains(&plinth) && (29..=31).contains(&painting), "{plinth} {painting}");
}

#[test]
fn a_wrong_command_line_is_refused() {
    for (arguments, word) in [
        (&["--texels", "0"][..], "--texels 0"),
        (&["--paths", "9"], "--paths 9"),
        (&["--size", "9x9"], "--size 9x9"),
        (&["--headless"], "--out"),
        (&["--out", "there"], "--headless"),
        (&["--xr", "perhaps"], "--xr perhaps"),
        (&["--server", "a", "--server-file", "b"], "one server"),
        (&["--moon"], "--moon"),
    ] {
        let run = example(arguments);
        assert_eq!(run.status.code(), Some(2), "{arguments:?}: {}", words(&run));
        assert!(words(&run).contains(word), "{arguments:?}: {}", words(&run));
    }
    let help = example(&["--help"]);
    assert!(help.status.success() && words(&help).contains("--server-file F"));
}
