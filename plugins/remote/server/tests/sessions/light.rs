//! Light that went over a network beside light that did not.

use farlight_gi_solver::session::{Session, SnapshotId};
use glam::Vec3;

use crate::{
    client::{Client, Light},
    scene,
};

/// What a session without a network makes of a room.
fn local(size: f32) -> Light {
    let mut light = Light::default();
    let mut session = Session::new(scene::settings());
    session.apply(SnapshotId(1), scene::room(size));
    while !session.is_idle() {
        let Some(update) = session.step() else { continue };
        update.placements.iter().for_each(|placement| light.place(placement));
        update.tiles.iter().for_each(|tile| light.paint(tile));
    }
    light
}

/// The light that arrived is what a session on the spot gives.
#[track_caller]
pub(crate) fn assert_like_local(client: &Client, size: f32) {
    let local = local(size);
    assert_eq!(client.light.placements.len(), 6);
    for (id, placement) in &client.light.placements {
        // Where it lies depends on the order in which meshes arrive.
        let found = client.light.texels(placement);
        let expected = local.texels(&local.placements[id]);
        assert!(found.len() > 100 && found.len() == expected.len(), "{placement:?}");
        let mean = |texels: &[Vec3]| texels.iter().sum::<Vec3>() / texels.len() as f32;
        let (brightness, difference) = (mean(&expected), mean(&found) - mean(&expected));
        assert!(brightness.min_element() > 0.1, "{id:?}: {brightness}");
        assert!(difference.abs().cmplt(brightness * 2e-3).all(), "{id:?}: {difference}");
        for (a, b) in found.iter().zip(&expected) {
            // Changes of 0.3 % need not be sent, and half floats round by 2^-11.
            let allowed = 0.01 * b.abs() + 1e-3 * brightness;
            assert!((*a - *b).abs().cmple(allowed).all(), "{id:?}: {a} {b}");
        }
    }
}
