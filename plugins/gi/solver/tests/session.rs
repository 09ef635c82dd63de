//! The session from outside: what comes in, what comes out.

mod common;

use std::{f32::consts::PI, sync::Arc};

use common::{Builder, set_light, settle, small, two_rooms};
use farlight_gi_solver::{
    SceneChange,
    estimate::{GatherSettings, no_progress},
    scene::{InstanceId, Sky, SkyImage},
    session::{GridId, ProbeGrid, Session, SessionChange, SessionSettings, SnapshotId, reference},
};
use glam::{Affine3A, Quat, UVec3, Vec3};

fn furnace(rho: f32, settings: SessionSettings) -> Session {
    let mut b = Builder::default();
    b.room(Vec3::ZERO, Vec3::new(2.0, 3.0, 4.0), [Vec3::splat(rho); 6], Vec3::ONE);
    let mut session = b.session(settings);
    settle(&mut session);
    session
}

#[test]
fn a_white_furnace_follows_the_series() {
    for (rho, bounces) in [(0.5_f32, 1), (0.5, 2), (0.8, 3), (0.5, 8)] {
        let session = furnace(rho, SessionSettings { bounces, ..small() });
        let expected: f32 = if bounces >= 6 {
            1.0 / (1.0 - rho)
        } else {
            (0..=bounces).map(|i| rho.powi(i as i32)).sum()
        };
        let texels = session.texels();
        assert!(texels.len() > 500);
        for texel in texels {
            let error = texel.value.x / expected - 1.0;
            assert!(error.abs() < 2e-3, "rho {rho}, {bounces} bounces: {texel:?}, {expected}");
        }
    }
}

#[test]
fn probes_of_a_furnace_see_the_same_from_all_sides() {
    let mut b = Builder::default();
    b.room(Vec3::ZERO, Vec3::splat(3.0), [Vec3::splat(0.5); 6], Vec3::ONE);
    b.changes.push(SessionChange::SetGrid(
        GridId(7),
        ProbeGrid {
            transform: Affine3A::from_scale_rotation_translation(
                Vec3::splat(2.0),
                Quat::IDENTITY,
                Vec3::splat(1.5),
            ),
            resolution: UVec3::new(2, 3, 4),
        },
    ));
    let mut session = b.session(small());
    let updates = settle(&mut session);
    let grid = updates.iter().flat_map(|u| &u.grids).next_back().expect("a grid update");
    assert_eq!((grid.grid, grid.resolution), (GridId(7), UVec3::new(2, 3, 4)));
    assert_eq!(grid.probes.len(), 24);
    for probe in &grid.probes {
        for normal in [Vec3::X, Vec3::NEG_Y, Vec3::Z] {
            let e = probe.irradiance(normal).x;
            assert!((e / (2.0 * PI) - 1.0).abs() < 0.02, "{e}");
        }
    }
}

#[test]
fn no_light_passes_a_wall() {
    let mut b = two_rooms(false);
    b.point_light(0, Vec3::new(2.0, 2.0, 2.0), Vec3::splat(30.0));
    let mut session = b.session(small());
    settle(&mut session);
    let (mut bright, mut dark) = (0, 0);
    for texel in session.texels() {
        if texel.position.x > 4.1 {
            assert_eq!(texel.value, Vec3::ZERO, "{texel:?}");
            dark += 1;
        } else {
            assert!(texel.value.min_element() > 0.0, "{texel:?}");
            bright += 1;
        }
    }
    assert!(bright > 500 && dark > 500);
}

#[test]
fn light_that_changes_traces_no_ray_again() {
    let mut b = two_rooms(true);
    b.point_light(0, Vec3::new(2.0, 2.0, 2.0), Vec3::splat(30.0));
    let mut session = b.session(small());
    settle(&mut session);
    let (traced, before) = (session.rays_traced(), session.texels());
    session.apply(SnapshotId(2), vec![set_light(0, Vec3::new(2.0, 2.0, 2.0), Vec3::splat(60.0))]);
    let updates = settle(&mut session);
    assert_eq!(session.rays_traced(), traced);
    assert_eq!(updates[0].snapshot, SnapshotId(2));
    for (new, old) in session.texels().iter().zip(&before) {
        assert!(
            (new.value - old.value * 2.0).abs().max_element()
                <= 4e-3 * old.value.max_element() + 1e-4
        );
    }
    session.apply(SnapshotId(3), vec![set_light(0, Vec3::new(1.0, 1.5, 3.0), Vec3::splat(60.0))]);
    assert!(!session.is_idle());
    let updates = settle(&mut session);
    // New patches may be met by nothing: no ray was traced.
    assert_eq!(session.rays_traced(), traced);
    assert!(updates.iter().any(|u| !u.tiles.is_empty()));
}

#[test]
fn a_still_scene_becomes_idle_and_says_so_once() {
    let mut b = two_rooms(true);
    b.point_light(0, Vec3::new(2.0, 2.0, 2.0), Vec3::splat(30.0));
    let mut session = b.session(small());
    let updates = settle(&mut session);
    assert_eq!(updates.iter().filter(|u| u.quality.converged).count(), 1);
    assert!(updates.last().is_some_and(|u| u.quality.converged));
    for _ in 0..50 {
        assert!(session.step().is_none());
    }
    // The same again is no change.
    session.apply(SnapshotId(2), vec![set_light(0, Vec3::new(2.0, 2.0, 2.0), Vec3::splat(30.0))]);
    assert!(session.is_idle() && session.step().is_none());
}

#[test]
fn results_repeat_and_do_not_depend_on_threads() {
    let run = |threads| {
        let mut b = two_rooms(true);
        b.point_light(0, Vec3::new(2.0, 2.0, 2.0), Vec3::splat(30.0));
        let mut session = b.session(SessionSettings { threads, ..small() });
        settle(&mut session);
        session.texels()
    };
    let one = run(1);
    assert_eq!(one, run(1));
    assert_eq!(one, run(3));
}

struct Row {
    value: f32,
    truth: f32,
    /// Standard errors of both together, and of the truth alone.
    errors: [f32; 2],
}

/// Luminance beside the path tracer's at texels of at least 1 % of the largest value.
fn against_reference(session: &Session, count: usize, paths: u32) -> Vec<Row> {
    let texels = session.texels();
    let chosen: Vec<_> = texels.iter().copied().step_by(texels.len() / count).collect();
    let settings = GatherSettings { paths, seed: 5 };
    let truth = reference(session.scene(), &chosen, &settings, no_progress()).unwrap();
    let y = |c: Vec3| c.dot(Vec3::new(0.2126, 0.7152, 0.0722));
    let rows = chosen.iter().zip(truth).map(|(t, r)| Row {
        value: y(t.value),
        truth: y(r.mean),
        errors: [t.error.hypot(y(r.se)), y(r.se)],
    });
    let brightest = rows.clone().map(|r| r.truth).fold(0.0, f32::max);
    rows.filter(|r| r.truth > 0.01 * brightest).collect()
}

fn median(values: impl Iterator<Item = f32>) -> f32 {
    let mut values: Vec<f32> = values.collect();
    values.sort_by(f32::total_cmp);
    values[values.len() / 2]
}

fn root_mean_square(values: impl ExactSizeIterator<Item = f32>) -> f32 {
    let count = values.len() as f32;
    (values.map(|v| v * v).sum::<f32>() / count).sqrt()
}

#[test]
fn texels_agree_with_the_path_tracer_and_errors_are_honest() {
    for (rays, paths) in [(64, 0), (256, 0), (256, 1024)] {
        let mut b = two_rooms(true);
        b.point_light(0, Vec3::new(2.0, 2.0, 1.2), Vec3::splat(30.0));
        let mut session =
            b.session(SessionSettings { rays_per_texel: rays, converged_paths: paths, ..small() });
        let updates = settle(&mut session);
        let told = updates.last().unwrap().quality.relative_error;
        let rows = against_reference(&session, 60, 8192);
        let real = median(rows.iter().map(|r| ((r.value - r.truth) / r.truth).abs()));
        let noise = 0.67 * median(rows.iter().map(|r| r.errors[1] / r.truth));
        let expected = told.hypot(noise);
        let z = root_mean_square(rows.iter().map(|r| (r.value - r.truth) / r.errors[0]));
        let signed =
            rows.iter().map(|r| (r.value - r.truth) / r.truth).sum::<f32>() / rows.len() as f32;
        let what = format!(
            "{rays} rays, {paths} paths: told {told}, expected {expected}, real {real}, \
             signed {signed}, z {z}"
        );
        println!("{what}");
        assert!(rows.len() > 40, "{what}");
        assert!(expected / real > 0.5 && expected / real < 2.0, "{what}");
        assert!(z > 0.5 && z < 1.7, "{what}");
        assert!(signed.abs() < 0.03, "{what}");
    }
}

#[test]
fn emissive_panels_and_skies_light_as_the_path_tracer_says() {
    let mut b = two_rooms(true);
    let panel = common::quad(Vec3::new(1.6, 2.0, 1.6), Vec3::X * 0.8, Vec3::Z * 0.8);
    b.add(panel, Vec3::splat(0.5), Vec3::new(30.0, 25.0, 20.0));
    let inside = b.session(SessionSettings { rays_per_texel: 1024, ..small() });
    // A board over a floor under a sky with a bright spot.
    let mut texels = vec![Vec3::splat(0.5); 256 * 128];
    for y in 20..26 {
        texels[y * 256 + 70..y * 256 + 76].fill(Vec3::new(300.0, 250.0, 200.0));
    }
    let image = Arc::new(SkyImage { width: 256, height: 128, texels });
    let sky = Sky::Image { image, rotation: Quat::IDENTITY, scale: 1.0 };
    let mut b = Builder::default();
    b.quad(Vec3::ZERO, Vec3::Z * 4.0, Vec3::X * 4.0, Vec3::splat(0.5));
    b.quad(Vec3::new(1.0, 1.0, 1.0), Vec3::Z * 2.0, Vec3::X * 2.0, Vec3::new(0.8, 0.2, 0.2));
    b.changes.push(SessionChange::Scene(SceneChange::SetSky(sky)));
    let outside = b.session(SessionSettings { rays_per_texel: 1024, ..small() });
    for (what, mut session) in [("panel", inside), ("sky", outside)] {
        settle(&mut session);
        let rows = against_reference(&session, 60, 8192);
        let signed =
            rows.iter().map(|r| (r.value - r.truth) / r.truth).sum::<f32>() / rows.len() as f32;
        let error = median(rows.iter().map(|r| ((r.value - r.truth) / r.truth).abs()));
        println!("{what}: {} texels, signed {signed}, median {error}", rows.len());
        // The sky's bright spot is blurred by six degrees, and with it the edge of the shadow.
        assert!(rows.len() > 30 && signed.abs() < 0.05 && error < 0.05);
    }
}

#[test]
fn probes_do_not_see_through_walls_and_those_inside_of_things_are_filled() {
    let mut b = two_rooms(false);
    b.point_light(0, Vec3::new(2.0, 2.0, 2.0), Vec3::splat(30.0));
    // A closed block in the bright room, around the probe at (2.5, 0.5, 2.5).
    let mut block = common::quad(Vec3::splat(0.0), Vec3::Y, Vec3::X);
    block.positions = (0..8)
        .map(|i| {
            Vec3::new(2.1, 0.1, 2.1)
                + 0.8 * Vec3::new((i & 1) as f32, (i >> 1 & 1) as f32, (i >> 2) as f32)
        })
        .collect();
    block.uv1.clear();
    block.triangles =
        [[0, 2, 3, 1], [4, 5, 7, 6], [0, 4, 6, 2], [1, 3, 7, 5], [0, 1, 5, 4], [2, 6, 7, 3]]
            .iter()
            .flat_map(|q| [[q[0], q[1], q[2]], [q[0], q[2], q[3]]])
            .collect();
    b.add(block, Vec3::splat(0.5), Vec3::ZERO);
    let grid = ProbeGrid {
        transform: Affine3A::from_scale_rotation_translation(
            Vec3::new(9.0, 3.0, 4.0),
            Quat::IDENTITY,
            Vec3::new(4.5, 1.5, 2.0),
        ),
        resolution: UVec3::new(9, 3, 4),
    };
    b.changes.push(SessionChange::SetGrid(GridId(1), grid));
    let mut session = b.session(small());
    let updates = settle(&mut session);
    let probes = &updates.iter().flat_map(|u| &u.grids).next_back().unwrap().probes;
    for z in 0..4 {
        for y in 0..3 {
            for x in 0..9 {
                let probe = probes[x + 9 * (y + 3 * z)].0[0];
                match x {
                    0..4 => assert!(probe.min_element() > 0.1, "{x} {y} {z}: {probe}"),
                    4..8 => assert_eq!(probe, Vec3::ZERO, "{x} {y} {z}"),
                    _ => {} // beside the rooms
                }
            }
        }
    }
}

/// Whoever drives a session sleeps while it is idle, so a scene in which nothing can be lit must
/// become idle too, and its snapshots are answered.
#[test]
fn scenes_without_anything_to_light_become_idle() {
    let light = || set_light(0, Vec3::ONE, Vec3::ONE);
    let grid = ProbeGrid { transform: Affine3A::IDENTITY, resolution: UVec3::splat(2) };
    let mut surfaces = Builder::default();
    surfaces.room(Vec3::ZERO, Vec3::ONE, [Vec3::ONE; 6], Vec3::ZERO);
    surfaces.changes.retain(|c| !matches!(c, SessionChange::AddReceiver(_)));
    surfaces.changes.push(light());
    let scenes = [
        vec![],
        vec![light()],
        vec![SessionChange::SetGrid(GridId(1), grid)],
        vec![SessionChange::SetGrid(GridId(1), grid), light()],
        vec![SessionChange::AddReceiver(InstanceId(7)), light()],
        surfaces.changes,
    ];
    for (i, changes) in scenes.into_iter().enumerate() {
        let mut session = Session::new(small());
        let empty = changes.is_empty();
        session.apply(SnapshotId(1), changes);
        let mut steps = 0;
        let mut answered = empty;
        while !session.is_idle() {
            answered |= session.step().is_some_and(|update| update.snapshot == SnapshotId(1));
            steps += 1;
            assert!(steps < 10_000, "scene {i} never becomes idle");
        }
        assert!(answered, "scene {i} is not answered");
    }
}
