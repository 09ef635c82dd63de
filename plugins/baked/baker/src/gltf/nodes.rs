//! Nodes that can be found again, and a scene in metres.

use std::collections::BTreeMap;

use serde_json::{Value, json};

use super::values::{extension, extension_mut, list, list_mut, push, set};

const LIGHTS: &str = "KHR_lights_punctual";

/// Writes the index of each node with a mesh or a light into its `extras`.
pub(super) fn mark(root: &mut Value) {
    for (index, node) in list_mut(root, "nodes").iter_mut().enumerate() {
        if node.get("mesh").is_none() && extension(node, LIGHTS).is_none() {
            continue;
        }
        let Some(object) = node.as_object_mut() else { continue };
        let extras = object.entry("extras").or_insert(Value::Null);
        match extras {
            Value::Object(extras) => drop(extras.insert("farlight_node".into(), index.into())),
            Value::Null => *extras = json!({"farlight_node": index}),
            _ => *extras = json!({"value": extras.take(), "farlight_node": index}),
        }
    }
}

/// Gives a file without scenes one: all nodes that are nobody's children, as the importer reads it.
pub(super) fn complete(root: &mut Value) {
    let nodes = list(root, "nodes");
    if !list(root, "scenes").is_empty() || nodes.is_empty() {
        return;
    }
    let mut is_root = vec![true; nodes.len()];
    for child in nodes.iter().flat_map(|node| list(node, "children")) {
        if let Some(is_root) = child.as_u64().and_then(|i| is_root.get_mut(i as usize)) {
            *is_root = false;
        }
    }
    let roots: Vec<usize> = (0..nodes.len()).filter(|&i| is_root[i]).collect();
    if !roots.is_empty() {
        set(root, "scenes", json!([{"nodes": roots}]));
        set(root, "scene", 0);
    }
}

/// Puts the roots of all scenes under new nodes that scale. A node has one parent, so roots that several
/// scenes share get a node of their own. Ranges of lights are lengths that nodes don't scale.
pub(super) fn scale(root: &mut Value, scale: f32) {
    let mut groups: BTreeMap<Vec<usize>, Vec<u64>> = BTreeMap::new();
    let mut scenes: BTreeMap<u64, Vec<usize>> = BTreeMap::new();
    for (s, scene) in list(root, "scenes").iter().enumerate() {
        for node in list(scene, "nodes").iter().filter_map(Value::as_u64) {
            let scenes = scenes.entry(node).or_default();
            if scenes.last() != Some(&s) {
                scenes.push(s);
            }
        }
    }
    // In the order of the scenes' lists, which engines may keep.
    for scene in list(root, "scenes") {
        for node in list(scene, "nodes").iter().filter_map(Value::as_u64) {
            if let Some(scenes) = scenes.remove(&node) {
                groups.entry(scenes).or_default().push(node);
            }
        }
    }
    for scene in list_mut(root, "scenes") {
        if !list(scene, "nodes").is_empty() {
            set(scene, "nodes", json!([]));
        }
    }
    for (scenes, roots) in groups {
        let node = json!({"name": "metres", "scale": [scale, scale, scale], "children": roots});
        let node = push(root, "nodes", node);
        for s in scenes {
            if let Some(Value::Array(nodes)) =
                list_mut(root, "scenes").get_mut(s).and_then(|scene| scene.get_mut("nodes"))
            {
                nodes.push(node.into());
            }
        }
    }
    if let Some(lights) = extension_mut(root, LIGHTS) {
        for light in list_mut(lights, "lights") {
            if let Some(range) = light.get("range").and_then(Value::as_f64) {
                set(light, "range", range as f32 * scale);
            }
        }
    }
}
