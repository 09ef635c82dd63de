//! Which meshes a tag covers.

use bevy::prelude::*;
use farlight::{gi::GiStatic, prelude::*};

use crate::Flat;

fn is_static(flat: &mut Flat, entity: Entity) -> bool {
    flat.app.update();
    flat.world().entity(entity).contains::<GiStatic>()
}

#[test]
fn a_tag_reaches_what_is_spawned_below_it_later() {
    let mut flat = Flat::new();
    let root = flat.world().spawn((GiScene, Transform::default(), Visibility::default())).id();
    flat.app.update();
    // As a glTF file does: first the nodes, frames later the meshes.
    let node =
        flat.world().spawn((Transform::default(), Visibility::default(), ChildOf(root))).id();
    flat.app.update();
    let mesh = flat.quad();
    assert!(!is_static(&mut flat, mesh));
    flat.world().entity_mut(mesh).insert(ChildOf(node));
    assert!(is_static(&mut flat, mesh));
    // The mesh component itself may come last.
    let bare =
        flat.world().spawn((Transform::default(), Visibility::default(), ChildOf(node))).id();
    assert!(!is_static(&mut flat, bare));
    let quad = flat.mesh(Rectangle::default());
    flat.world().entity_mut(bare).insert(Mesh3d(quad));
    assert!(is_static(&mut flat, bare));
}

#[test]
fn the_nearest_tag_counts() {
    let mut flat = Flat::new();
    let root = flat.world().spawn((GiScene, Transform::default(), Visibility::default())).id();
    let moving = flat.world().spawn((GiDynamic, Transform::default(), Visibility::default())).id();
    let (below, deep) = (flat.quad(), flat.quad());
    flat.world().entity_mut(moving).insert(ChildOf(root));
    flat.world().entity_mut(below).insert(ChildOf(moving));
    flat.world().entity_mut(deep).insert((ChildOf(moving), GiScene));
    assert!(!is_static(&mut flat, below));
    assert!(is_static(&mut flat, deep));
    flat.world().entity_mut(moving).remove::<GiDynamic>();
    assert!(is_static(&mut flat, below));
    flat.world().entity_mut(root).remove::<GiScene>();
    assert!(!is_static(&mut flat, below));
    assert!(is_static(&mut flat, deep));
}

#[test]
fn a_subtree_that_moves_to_another_parent_follows_its_tags() {
    let mut flat = Flat::new();
    let root = flat.world().spawn((GiScene, Transform::default(), Visibility::default())).id();
    let branch = flat.world().spawn((Transform::default(), Visibility::default())).id();
    let leaf = flat.quad();
    flat.world().entity_mut(leaf).insert(ChildOf(branch));
    assert!(!is_static(&mut flat, leaf));
    flat.world().entity_mut(branch).insert(ChildOf(root));
    assert!(is_static(&mut flat, leaf));
    flat.world().entity_mut(branch).remove::<ChildOf>();
    assert!(!is_static(&mut flat, leaf));
}
