//! From tags on roots to a marker on each mesh.

use bevy::{ecs::entity::EntityHashSet, prelude::*};
use farlight_core::ShadowProxy;

use crate::{GiDynamic, GiScene, GiStatic, view::GiTwin};

/// Keeps [`GiStatic`] on the meshes whose nearest tag, upwards from themselves, is [`GiScene`].
///
/// Looks only at what changed: tags, parents and new meshes, and what hangs below them.
pub(crate) fn propagate_tags(
    mut commands: Commands,
    changed: Query<Entity, Or<(Added<GiScene>, Added<GiDynamic>, Changed<ChildOf>, Added<Mesh3d>)>>,
    mut removed: (
        RemovedComponents<GiScene>,
        RemovedComponents<GiDynamic>,
        RemovedComponents<ChildOf>,
    ),
    tags: Query<(Has<GiScene>, Has<GiDynamic>, Option<&ChildOf>)>,
    children: Query<&Children>,
    meshes: Query<Has<GiStatic>, (With<Mesh3d>, Without<GiTwin>, Without<ShadowProxy>)>,
    mut done: Local<EntityHashSet>,
    mut below: Local<Vec<(Entity, bool)>>,
) {
    done.clear();
    let removed =
        removed.0.read().chain(removed.1.read()).chain(removed.2.read()).collect::<Vec<_>>();
    for root in changed.iter().chain(removed) {
        if done.contains(&root) || !tags.contains(root) {
            continue;
        }
        below.push((root, is_static(root, &tags)));
        while let Some((entity, inherited)) = below.pop() {
            if !done.insert(entity) {
                continue;
            }
            let is_static = match tags.get(entity) {
                Ok((_, true, _)) => false,
                Ok((true, ..)) => true,
                _ => inherited,
            };
            if let Ok(marked) = meshes.get(entity)
                && marked != is_static
            {
                if is_static {
                    commands.entity(entity).try_insert(GiStatic);
                } else {
                    commands.entity(entity).try_remove::<GiStatic>();
                }
            }
            if let Ok(children) = children.get(entity) {
                below.extend(children.iter().map(|child| (child, is_static)));
            }
        }
    }
}

fn is_static(
    mut entity: Entity,
    tags: &Query<(Has<GiScene>, Has<GiDynamic>, Option<&ChildOf>)>,
) -> bool {
    // A hierarchy has no cycles, so this ends.
    loop {
        match tags.get(entity) {
            Ok((_, true, _)) => return false,
            Ok((true, ..)) => return true,
            Ok((.., Some(parent))) => entity = parent.parent(),
            _ => return false,
        }
    }
}
