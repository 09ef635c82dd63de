//! Which entities of a spawned scene are which nodes and primitives of its glTF file.

use bevy::{
    ecs::system::SystemParam, gltf::GltfExtras, platform::collections::HashMap, prelude::*,
};
use serde::Deserialize;

use crate::{BakedLighting, BakedPart};

/// What the baker notes on each node with a mesh or a light.
#[derive(Deserialize)]
struct Extras {
    farlight_node: Option<u32>,
}

/// What hangs below a root.
#[derive(Default)]
pub(crate) struct Found {
    /// Meshes by node and primitive; several where a part of the scene was copied.
    pub(crate) primitives: HashMap<(u32, u32), Vec<(Entity, AssetId<Mesh>)>>,
    /// Lights by node.
    pub(crate) lights: HashMap<u32, Vec<Entity>>,
    /// Meshes, whether or not their node is known.
    pub(crate) meshes: usize,
}

/// The hierarchy.
#[derive(SystemParam)]
pub(crate) struct Tree<'w, 's> {
    rows: Query<
        'w,
        's,
        (Option<&'static Children>, Option<&'static GltfExtras>, Option<&'static Mesh3d>),
        Without<BakedPart>,
    >,
    lights: Query<'w, 's, (), Or<(With<PointLight>, With<SpotLight>, With<DirectionalLight>)>>,
    roots: Query<'w, 's, (), With<BakedLighting>>,
    server: Res<'w, AssetServer>,
}

impl Tree<'_, '_> {
    /// Looks at everything below `root`, other roots left out.
    pub(crate) fn find(&self, root: Entity) -> Found {
        let mut found = Found::default();
        // An entity, the node that it belongs to, and which of the node's meshes it would be.
        let mut below = vec![(root, None, 0)];
        while let Some((entity, parent, order)) = below.pop() {
            if entity != root && self.roots.contains(entity) {
                continue;
            }
            let Ok((children, extras, mesh)) = self.rows.get(entity) else { continue };
            let own = extras.and_then(|extras| node(&extras.value));
            let node = own.or(parent);
            if let Some(mesh) = mesh {
                found.meshes += 1;
                if let Some(node) = node {
                    let primitive = self.primitive(mesh).unwrap_or(order);
                    let key = (node, primitive);
                    found.primitives.entry(key).or_default().push((entity, mesh.id()));
                }
            }
            if let Some(node) = node
                && self.lights.contains(entity)
            {
                found.lights.entry(node).or_default().push(entity);
            }
            // What hangs below is the node's own (primitives, lights), or another node, or a thing of the
            // game's: which it is, its depth says. Bevy puts primitives and lights right below nodes.
            let mut order = 0;
            for child in children.into_iter().flatten() {
                below.push((*child, own, order));
                order += u32::from(self.rows.get(*child).is_ok_and(|(.., mesh)| mesh.is_some()));
            }
        }
        found
    }

    /// The index in the label that Bevy's loader gives: `Mesh3/Primitive1`.
    fn primitive(&self, mesh: &Mesh3d) -> Option<u32> {
        let path = self.server.get_path(mesh.id())?;
        path.label()?.split_once("/Primitive")?.1.parse().ok()
    }
}

fn node(extras: &str) -> Option<u32> {
    serde_json::from_str::<Extras>(extras).ok()?.farlight_node
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn extras_may_hold_anything_else() {
        assert_eq!(node(r#"{"farlight_node": 7, "game": {"door": true}}"#), Some(7));
        for other in ["", "7", "[]", r#"{"door": 1}"#, r#"{"farlight_node": -1}"#] {
            assert_eq!(node(other), None, "{other}");
        }
    }
}
