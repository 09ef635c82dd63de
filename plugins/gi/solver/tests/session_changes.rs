//! Geometry, materials and receivers that change under a session.

mod common;

use std::{collections::BTreeMap, ops::ControlFlow, sync::Arc};

use common::{Builder, quad, set_light, settle, small, two_rooms};
use farlight_gi_solver::{
    SceneChange,
    atlas::TexelRect,
    lightmap::LightmapSolver,
    scene::{Instance, InstanceId, Material, MaterialId, MeshId},
    session::{LightingUpdate, Session, SessionChange, SessionSettings, SnapshotId, TexelPoint},
};
use glam::{Affine3A, Vec3};

fn lit_rooms() -> Session {
    let mut b = two_rooms(true);
    b.point_light(0, Vec3::new(2.0, 2.0, 1.2), Vec3::splat(30.0));
    b.session(small())
}

/// Median of the relative difference between two states of the same texels.
fn difference(a: &[TexelPoint], b: &[TexelPoint]) -> f32 {
    assert_eq!(a.len(), b.len());
    let mut values: Vec<f32> = a
        .iter()
        .zip(b)
        .map(|(a, b)| (a.value - b.value).length() / b.value.length().max(1e-3))
        .collect();
    values.sort_by(f32::total_cmp);
    values[values.len() / 2]
}

#[test]
fn a_door_that_closes_leaves_the_dark_room_black() {
    let mut session = lit_rooms();
    settle(&mut session);
    let before = session.texels();
    let dark = |texels: &[TexelPoint]| {
        texels.iter().filter(|t| t.position.x > 4.15).map(|t| t.value.x).fold(0.0, f32::max)
    };
    assert!(dark(&before) > 0.01);
    // A board in the doorway, without a lightmap of its own.
    let mut board = quad(Vec3::new(4.1, -0.1, 1.4), Vec3::Y * 2.2, Vec3::Z * 1.2);
    board.uv1.clear();
    let add = |id: u64| {
        [
            SceneChange::SetMesh(MeshId(id), Arc::new(board.clone())),
            SceneChange::SetInstance(
                InstanceId(id),
                Instance {
                    mesh: MeshId(id),
                    material: MaterialId(0),
                    transform: Affine3A::IDENTITY,
                },
            ),
        ]
        .map(SessionChange::Scene)
        .to_vec()
    };
    session.apply(SnapshotId(2), add(900));
    let updates = settle(&mut session);
    assert!(updates.iter().all(|u| u.placements.is_empty()), "nothing moved in the atlas");
    assert!(dark(&session.texels()) < 1e-4, "{}", dark(&session.texels()));
    // And open again: as it was.
    session.apply(
        SnapshotId(3),
        vec![SessionChange::Scene(SceneChange::RemoveInstance(InstanceId(900)))],
    );
    settle(&mut session);
    assert!(difference(&session.texels(), &before) < 0.03);
}

#[test]
fn a_change_far_away_does_not_make_what_is_shown_worse() {
    let mut session = lit_rooms();
    settle(&mut session);
    let before = session.texels();
    // A small board outside of the rooms changes nothing that the texels see.
    let mut board = quad(Vec3::new(-5.0, 0.0, 0.0), Vec3::X, Vec3::Y);
    board.uv1.clear();
    let mut b = Builder::starting_at(900);
    b.add(board, Vec3::splat(0.5), Vec3::ZERO);
    session.apply(SnapshotId(2), b.changes);
    let mut worst = 0.0_f32;
    while !session.is_idle() {
        if session.step().is_some() {
            worst = worst.max(difference(&session.texels(), &before));
        }
    }
    assert!(worst < 0.004, "32 rays must not be shown in place of 256: {worst}");
}

#[test]
fn materials_change_without_new_rays() {
    let mut session = lit_rooms();
    settle(&mut session);
    let (rays, before) = (session.rays_traced(), session.texels());
    let paint = |session: &mut Session, snapshot, albedo: Vec3| {
        let changes = (0..40)
            .map(|id| {
                let material = Material { base_color: albedo.extend(1.0), ..Default::default() };
                SessionChange::Scene(SceneChange::SetMaterial(MaterialId(id), material))
            })
            .collect();
        session.apply(SnapshotId(snapshot), changes);
        settle(session);
    };
    paint(&mut session, 2, Vec3::new(0.0, 0.5, 0.0));
    assert_eq!(session.rays_traced(), rays);
    for texel in session.texels() {
        assert!(texel.value.x == 0.0 && texel.value.z == 0.0, "{texel:?}");
    }
    assert!(difference(&session.texels(), &before) > 0.1);
    // The same as a session that never knew another colour.
    let mut fresh = lit_rooms();
    paint(&mut fresh, 1, Vec3::new(0.0, 0.5, 0.0));
    assert!(difference(&session.texels(), &fresh.texels()) < 2e-3);
}

/// A page of tiles.
fn pages(updates: &[LightingUpdate], size: u32) -> BTreeMap<u32, Vec<Option<Vec3>>> {
    let mut pages = BTreeMap::new();
    for tile in updates.iter().flat_map(|u| &u.tiles) {
        assert_eq!(tile.texels.len(), tile.rect.area());
        let page: &mut Vec<Option<Vec3>> =
            pages.entry(tile.page.0).or_insert_with(|| vec![None; (size * size) as usize]);
        for (i, texel) in tile.texels.iter().enumerate() {
            let (x, y) = (i as u32 % tile.rect.width, i as u32 / tile.rect.width);
            page[((tile.rect.y + y) * size + tile.rect.x + x) as usize] = Some(*texel);
        }
    }
    pages
}

#[test]
fn tiles_cover_every_placement_and_a_border_around_it() {
    let mut session = lit_rooms();
    let updates = settle(&mut session);
    let pages = pages(&updates, 128);
    let placements: Vec<_> = updates.iter().flat_map(|u| &u.placements).collect();
    assert_eq!(placements.len(), 20);
    for (i, p) in placements.iter().enumerate() {
        let grown = TexelRect {
            x: p.rect.x - 1,
            y: p.rect.y - 1,
            width: p.rect.width + 2,
            height: p.rect.height + 2,
        };
        for other in &placements[..i] {
            assert!(other.page != p.page || !other.rect.overlaps(&grown));
        }
        for y in grown.y..grown.y + grown.height {
            for x in grown.x..grown.x + grown.width {
                let texel = pages[&p.page.0][(y * 128 + x) as usize].expect("written");
                assert!(texel.is_finite() && texel.min_element() >= 0.0);
            }
        }
    }
    // What the tiles say is what the texels are.
    for texel in session.texels() {
        let shown = pages[&texel.page.0][(texel.y * 128 + texel.x) as usize].unwrap();
        assert!((shown - texel.value).abs().max_element() <= 0.004 * shown.max_element() + 1e-3);
    }
}

#[test]
fn receivers_come_and_go_and_their_room_is_used_again() {
    let mut session = lit_rooms();
    settle(&mut session);
    let count = session.texels().len();
    for round in 0..5 {
        session
            .apply(SnapshotId(2 + round * 2), vec![SessionChange::RemoveReceiver(InstanceId(0))]);
        settle(&mut session);
        assert!(session.texels().iter().all(|t| t.instance != InstanceId(0)));
        session.apply(SnapshotId(3 + round * 2), vec![SessionChange::AddReceiver(InstanceId(0))]);
        let updates = settle(&mut session);
        let placed: Vec<_> = updates.iter().flat_map(|u| &u.placements).collect();
        assert!(placed.len() == 1 && placed[0].instance == InstanceId(0));
        assert_eq!(session.texels().len(), count);
    }
}

#[test]
fn what_cannot_be_a_receiver_is_refused_with_a_reason() {
    let mut b = Builder::default();
    b.room(Vec3::ZERO, Vec3::splat(2.0), [Vec3::splat(0.5); 6], Vec3::ZERO);
    let mut bare = quad(Vec3::splat(0.5), Vec3::X, Vec3::Z);
    bare.uv1.clear();
    let bare = b.add(bare, Vec3::ONE, Vec3::ZERO);
    let mut flat = quad(Vec3::splat(0.5), Vec3::X, Vec3::Z);
    flat.uv1.fill(glam::Vec2::splat(0.5));
    let flat = b.add(flat, Vec3::ONE, Vec3::ZERO);
    b.changes.push(SessionChange::AddReceiver(bare));
    b.changes.push(SessionChange::AddReceiver(InstanceId(12345)));
    let mut session = b.session(small());
    let refused: BTreeMap<_, _> =
        settle(&mut session).into_iter().flat_map(|u| u.refused).collect();
    assert_eq!(refused.len(), 3);
    assert!(refused[&bare].contains("second UV"));
    assert!(refused[&flat].contains("no area"));
    assert!(refused[&InstanceId(12345)].contains("no such instance"));
}

#[test]
fn full_pages_lower_the_density_until_everything_fits() {
    let mut b = two_rooms(true);
    b.point_light(0, Vec3::new(2.0, 2.0, 1.2), Vec3::splat(30.0));
    let settings = SessionSettings { page_size: 64, texels_per_metre: 100.0, ..small() };
    let mut session = b.session(settings);
    let updates = settle(&mut session);
    assert!(updates.iter().all(|u| u.refused.is_empty()));
    let placed: Vec<_> = updates.iter().flat_map(|u| &u.placements).collect();
    assert_eq!(placed.len(), 20);
    let area: usize = placed.iter().map(|p| p.rect.area()).sum();
    assert!(area > 64 * 64 / 2, "the page is used: {area}");
}

#[test]
fn more_receivers_than_room_are_refused_at_last() {
    let mut b = Builder::default();
    for i in 0..300 {
        b.quad(Vec3::X * 2.0 * i as f32, Vec3::Z, Vec3::X, Vec3::ONE);
    }
    let settings = SessionSettings { page_size: 64, rays_per_texel: 64, ..small() };
    let mut session = b.session(settings);
    let updates = settle(&mut session);
    let placed = updates.iter().map(|u| u.placements.len()).sum::<usize>();
    let refused: Vec<_> = updates.iter().flat_map(|u| &u.refused).collect();
    assert_eq!((placed, refused.len()), (256, 44), "16 x 16 rectangles of 4 x 4 texels");
    assert!(refused.iter().all(|(_, why)| why.contains("full")));
}

#[test]
fn both_sides_of_a_board_reflect() {
    // A board between light and receiver: lit from above, its upper side lights the ceiling, its
    // lower side is lit by the floor and lights it in turn.
    let run = |albedo| {
        let mut b = Builder::default();
        b.room(Vec3::ZERO, Vec3::new(4.0, 3.0, 4.0), [Vec3::splat(0.5); 6], Vec3::ZERO);
        let board = b.quad(Vec3::new(1.0, 1.0, 1.0), Vec3::Z * 2.0, Vec3::X * 2.0, albedo);
        b.point_light(0, Vec3::new(2.0, 2.0, 2.0), Vec3::splat(20.0));
        let mut session = b.session(SessionSettings { bounces: 8, ..small() });
        settle(&mut session);
        let mean = |f: &dyn Fn(&TexelPoint) -> bool| {
            let texels: Vec<_> = session.texels().into_iter().filter(|t| f(t)).collect();
            texels.iter().map(|t| t.value).sum::<Vec3>() / texels.len() as f32
        };
        let under = |t: &TexelPoint| {
            t.instance == InstanceId(0) && (t.position - Vec3::new(2.0, 0.0, 2.0)).length() < 0.8
        };
        let above = |t: &TexelPoint| {
            t.instance == InstanceId(1) && (t.position - Vec3::new(2.0, 3.0, 2.0)).length() < 0.8
        };
        assert!(mean(&|t| t.instance == board).min_element() > 0.0);
        (mean(&under), mean(&above))
    };
    let (black, white) = (run(Vec3::ZERO), run(Vec3::new(0.0, 0.9, 0.0)));
    assert!(white.0.y > 1.05 * black.0.y, "the lower side: {} {}", white.0, black.0);
    assert!(white.1.y > 2.0 * black.1.y, "the upper side: {} {}", white.1, black.1);
    assert!((white.1.x / black.1.x - 1.0).abs() < 0.02, "it is green");
}

#[test]
fn light_that_never_rests_is_answered_every_time_and_rays_grow_nevertheless() {
    let mut session = lit_rooms();
    let (mut answers, mut rays) = (0, 0);
    for frame in 0..120 {
        let position = Vec3::new(2.0, 2.0, 1.2 + 0.01 * frame as f32);
        session.apply(SnapshotId(frame + 2), vec![set_light(0, position, Vec3::splat(30.0))]);
        for _ in 0..2 {
            if let Some(update) = session.step() {
                answers += 1;
                rays = update.quality.rays_per_texel;
            }
        }
    }
    assert!(answers > 90, "{answers}");
    assert_eq!(rays, 256);
}

#[test]
fn a_bake_tells_its_progress_and_can_be_stopped() {
    let session = lit_rooms();
    let scene = session.scene().clone();
    let solver = LightmapSolver::new(SessionSettings { converged_paths: 512, ..small() })
        .receivers(scene.instances.keys().copied());
    let mut parts = Vec::new();
    let lightmap = solver
        .solve(&scene, &mut |part| {
            parts.push(part);
            ControlFlow::Continue(())
        })
        .expect("not stopped");
    assert!(parts.windows(2).all(|w| w[0] <= w[1]) && parts.last().is_some_and(|p| *p > 0.4));
    assert_eq!((lightmap.pages.len(), lightmap.placements.len()), (1, 20));
    assert!(lightmap.quality.converged && lightmap.quality.rays_per_texel == 512);
    assert!(lightmap.pages[0].iter().any(|t| t.x > 0.1));
    let mut calls = 0;
    let stopped = solver.solve(&scene, &mut |_| {
        calls += 1;
        if calls == 3 { ControlFlow::Break(()) } else { ControlFlow::Continue(()) }
    });
    assert!(stopped.is_none() && calls == 3);
}
