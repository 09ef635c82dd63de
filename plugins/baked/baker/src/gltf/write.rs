//! The lit scene.

use std::collections::{BTreeMap, HashMap};

use farlight_gi_solver::scene::MeshId;
use serde_json::{Value, json};

use super::{
    GltfError, Source, images, nodes,
    primitives::{self, Added},
    references,
    values::{extension, list, list_mut, number, remove_extension, set},
};
use crate::uv::SecondSet;

/// Writes a file as one self-contained `.glb` with new second UV sets.
///
/// `scale` is metres a unit of the file: if it is not 1, a node that scales is appended and takes over
/// the scene's roots, and the ranges of lights are multiplied (the engine does not scale them). Every
/// node with a mesh or a light gets `extras.farlight_node`, its index. The same input gives the same
/// bytes.
///
/// Strips, fans and triangles without an area become plain triangles where a primitive gets new
/// vertices. Indices of nodes, meshes, materials, textures, images, animations and skins stay. Accessors
/// and buffer views that nothing refers to are left out, unless there is an extension that could
/// refer to them in ways that are not known here.
///
/// # Errors
/// [`GltfError`] if a part of the file that must be copied can't be read.
pub fn write(
    source: &Source,
    sets: &BTreeMap<MeshId, SecondSet>,
    scale: f32,
) -> Result<Vec<u8>, GltfError> {
    if !(scale > 0.0 && scale.is_finite()) {
        return Err(GltfError::Scale(scale.to_string()));
    }
    let mut root = source.json.clone();
    let mut added = Added::default();
    primitives::rewrite(&mut root, source, sets, &mut added)?;
    images::embed(&mut root, source, &mut added)?;
    nodes::mark(&mut root);
    nodes::complete(&mut root);
    if scale != 1.0 {
        nodes::scale(&mut root, scale);
    }
    let views = match references::all_known(&root) {
        true => {
            references::sweep(&mut root, "accessors", references::accessors);
            references::sweep(&mut root, "bufferViews", references::views)
        }
        false => (0..list(&root, "bufferViews").len()).collect(),
    };
    let bin = pack(&mut root, source, &views, &added.data)?;
    plain_extensions(&mut root);
    glb(&root, bin)
}

/// Copies what views refer to into one buffer. `old` are the views' indices in the source; those
/// beyond its end were added.
fn pack(
    root: &mut Value,
    source: &Source,
    old: &[usize],
    added: &[Vec<u8>],
) -> Result<Vec<u8>, GltfError> {
    let own = list(&source.json, "bufferViews").len();
    let mut parts = Parts::find(source, old.iter().copied().filter(|&view| view < own))?;
    let mut bin = Vec::new();
    for (view, &index) in list_mut(root, "bufferViews").iter_mut().zip(old) {
        let start = match index.checked_sub(own) {
            Some(k) => append(&mut bin, added.get(k).map_or(&[], Vec::as_slice), 0)?,
            None => parts.copy(source, index, &mut bin)?,
        };
        set(view, "buffer", 0);
        set(view, "byteOffset", start);
        // Another copy of the same data.
        remove_extension(view, "EXT_meshopt_compression");
    }
    bin.resize(bin.len().next_multiple_of(4), 0);
    Ok(bin)
}

/// Appends bytes at a multiple of 4 plus `rest`; where they start.
fn append(bin: &mut Vec<u8>, bytes: &[u8], rest: usize) -> Result<usize, GltfError> {
    let start = bin.len().next_multiple_of(4) + rest;
    let end = start as u64 + bytes.len() as u64;
    if end > u64::from(u32::MAX) {
        return Err(GltfError::TooLarge { bytes: end });
    }
    bin.resize(start, 0);
    bin.extend_from_slice(bytes);
    Ok(start)
}

/// Parts of the source's buffers that views cover, each copied once however many views overlap in it.
struct Parts {
    /// Of each view: its part and the first byte in it.
    of_view: HashMap<usize, (usize, usize)>,
    parts: Vec<Part>,
}

struct Part {
    buffer: usize,
    start: usize,
    end: usize,
    /// Whether views start at different places of it, so that its alignment must stay.
    shared: bool,
    copied: Option<usize>,
}

impl Parts {
    fn find(source: &Source, views: impl Iterator<Item = usize>) -> Result<Self, GltfError> {
        let mut ranges = Vec::new();
        for index in views {
            let bytes = source.view(index).map_err(|what| GltfError::Damaged {
                place: format!("bufferViews[{index}]"),
                what,
            })?;
            let view = &list(&source.json, "bufferViews")[index];
            let start = number(view, "byteOffset").unwrap_or(0);
            let buffer = number(view, "buffer").unwrap_or(0);
            ranges.push((buffer, start, start + bytes.len(), index));
        }
        ranges.sort_unstable();
        let mut found = Self { of_view: HashMap::new(), parts: Vec::new() };
        for (buffer, start, end, index) in ranges {
            match found.parts.last_mut() {
                Some(part) if part.buffer == buffer && start < part.end => {
                    part.shared |= start != part.start;
                    part.end = part.end.max(end);
                }
                _ => found.parts.push(Part { buffer, start, end, shared: false, copied: None }),
            }
            let part = found.parts.len() - 1;
            found.of_view.insert(index, (part, start - found.parts[part].start));
        }
        Ok(found)
    }

    /// Where a view's bytes start, after copying them if they were not.
    fn copy(
        &mut self,
        source: &Source,
        view: usize,
        bin: &mut Vec<u8>,
    ) -> Result<usize, GltfError> {
        let Some(&(index, offset)) = self.of_view.get(&view) else { return Ok(0) };
        let part = &mut self.parts[index];
        let start = match part.copied {
            Some(start) => start,
            None => {
                let rest = if part.shared { part.start % 4 } else { 0 };
                append(bin, &source.package.buffers[part.buffer][part.start..part.end], rest)?
            }
        };
        part.copied = Some(start);
        Ok(start + offset)
    }
}

/// Takes extensions off the lists of those in use that are gone.
fn plain_extensions(root: &mut Value) {
    let draco = list(root, "meshes")
        .iter()
        .flat_map(|mesh| list(mesh, "primitives"))
        .any(|p| extension(p, "KHR_draco_mesh_compression").is_some());
    let gone = |name: &Value| match name.as_str() {
        Some("EXT_meshopt_compression") => true,
        Some("KHR_draco_mesh_compression") => !draco,
        _ => false,
    };
    for key in ["extensionsUsed", "extensionsRequired"] {
        if let Some(Value::Array(names)) = root.get_mut(key) {
            names.retain(|name| !gone(name));
        }
    }
}

/// Header and chunks.
fn glb(root: &Value, bin: Vec<u8>) -> Result<Vec<u8>, GltfError> {
    let mut root = root.clone();
    if let Some(object) = root.as_object_mut() {
        match bin.is_empty() {
            true => drop(object.remove("buffers")),
            false => drop(object.insert("buffers".into(), json!([{"byteLength": bin.len()}]))),
        }
        // The format has no empty lists.
        let empty = |value: &Value| value.as_array().is_some_and(Vec::is_empty);
        object.retain(|_, value| !empty(value));
    }
    root.sort_all_objects();
    let mut json = root.to_string().into_bytes();
    json.resize(json.len().next_multiple_of(4), b' ');
    let chunks = if bin.is_empty() { 1 } else { 2 };
    let bytes = 12 + 8 * chunks + json.len() as u64 + bin.len() as u64;
    let Ok(length) = u32::try_from(bytes) else { return Err(GltfError::TooLarge { bytes }) };
    let mut glb = Vec::with_capacity(length as usize);
    glb.extend(b"glTF\x02\0\0\0");
    glb.extend(length.to_le_bytes());
    for (tag, data) in [(b"JSON", json), (b"BIN\0", bin)] {
        if data.is_empty() {
            continue;
        }
        glb.extend((data.len() as u32).to_le_bytes());
        glb.extend(tag);
        glb.extend(data);
    }
    Ok(glb)
}
