//! Primitives with new vertices.

use std::{collections::BTreeMap, sync::Arc};

use farlight_gi_solver::{import::split_id, scene::MeshId, unwrap::Unwrapped};
use serde_json::{Map, Value, json};

use super::{
    GltfError, Source,
    elements::{Component, Elements},
    values::{list, list_mut, number, push, remove_extension, set},
};
use crate::uv::SecondSet;

const ARRAY_BUFFER: u32 = 34962;
const ELEMENT_ARRAY_BUFFER: u32 = 34963;

/// Data of buffer views that were added, in their order.
#[derive(Default)]
pub(super) struct Added {
    pub(super) data: Vec<Vec<u8>>,
    bytes: u64,
}

impl Added {
    /// Makes room for bytes that come.
    fn reserve(&mut self, bytes: u64) -> Result<(), GltfError> {
        self.bytes = self.bytes.saturating_add(bytes);
        if self.bytes > u64::from(u32::MAX) {
            return Err(GltfError::TooLarge { bytes: self.bytes });
        }
        Ok(())
    }

    /// Adds a buffer view; its index.
    pub(super) fn view(
        &mut self,
        root: &mut Value,
        mut view: Value,
        data: Vec<u8>,
    ) -> Result<usize, GltfError> {
        self.reserve(data.len() as u64)?;
        set(&mut view, "byteLength", data.len());
        self.data.push(data);
        Ok(push(root, "bufferViews", view))
    }
}

/// Gives primitives the vertices and the second UV sets of `sets`.
pub(super) fn rewrite(
    root: &mut Value,
    source: &Source,
    sets: &BTreeMap<MeshId, SecondSet>,
    added: &mut Added,
) -> Result<(), GltfError> {
    for (id, second) in sets {
        let Some(unwrapped) = second.set.unwrapped() else { continue };
        let [mesh, index] = split_id(id.0).map(|i| i as usize);
        let place = format!("meshes[{mesh}].primitives[{index}]");
        let damaged = |what: String| GltfError::Damaged { place: place.clone(), what };
        let meshes = list(&source.json, "meshes");
        let Some(old) = meshes.get(mesh).and_then(|m| list(m, "primitives").get(index)) else {
            return Err(damaged("it does not exist".into()));
        };
        let mut work = Work {
            source,
            added: &mut *added,
            root: &mut *root,
            place: &place,
            vertices: Vec::new(),
            count: 0,
        };
        work.find_vertices(old, unwrapped, second.vertices.as_ref())?;
        let new = work.primitive(old, unwrapped)?;
        let mesh = list_mut(root, "meshes").get_mut(mesh);
        if let Some(primitive) = mesh.and_then(|m| list_mut(m, "primitives").get_mut(index)) {
            *primitive = new;
        }
    }
    Ok(())
}

struct Work<'a> {
    source: &'a Source,
    added: &'a mut Added,
    root: &'a mut Value,
    place: &'a str,
    /// The vertex in the file of each new vertex.
    vertices: Vec<usize>,
    /// Vertices in the file.
    count: usize,
}

impl Work<'_> {
    fn damaged(&self, attribute: &str, what: String) -> GltfError {
        GltfError::Damaged { place: format!("{}{attribute}", self.place), what }
    }

    fn find_vertices(
        &mut self,
        old: &Value,
        unwrapped: &Unwrapped,
        kept: Option<&Arc<[u32]>>,
    ) -> Result<(), GltfError> {
        let fail = |work: &Self, what: &str| Err(work.damaged(".attributes.POSITION", what.into()));
        let Some(positions) = old.get("attributes").and_then(|a| number(a, "POSITION")) else {
            return fail(self, "it is missing");
        };
        let positions = Elements::find(self.source, positions);
        self.count = positions.map_err(|what| self.damaged(".attributes.POSITION", what))?.count;
        self.vertices = Vec::with_capacity(unwrapped.source.len());
        for &vertex in &unwrapped.source {
            let vertex = match kept {
                Some(kept) => kept.get(vertex as usize).copied(),
                None => Some(vertex),
            };
            match vertex.map(|vertex| vertex as usize).filter(|&vertex| vertex < self.count) {
                Some(vertex) => self.vertices.push(vertex),
                None => return fail(self, "the second UV set was made for another file"),
            }
        }
        let count = self.vertices.len();
        let fits = unwrapped.uv1.len() == count
            && unwrapped.triangles.as_flattened().iter().all(|&i| (i as usize) < count);
        if fits { Ok(()) } else { fail(self, "the second UV set does not fit its own vertices") }
    }

    fn primitive(&mut self, old: &Value, unwrapped: &Unwrapped) -> Result<Value, GltfError> {
        let mut new = old.clone();
        if !self.same_vertices(old, unwrapped)? {
            let Some(object) = new.as_object_mut() else { return Ok(new) };
            object.remove("mode");
            let empty = Map::new();
            let attributes = old.get("attributes").and_then(Value::as_object).unwrap_or(&empty);
            object.insert("attributes".into(), self.gather_all(attributes, ".attributes.")?);
            if let Some(targets) = old.get("targets").and_then(Value::as_array) {
                let gather = |(t, target): (usize, &Value)| {
                    let target = target.as_object().unwrap_or(&empty);
                    self.gather_all(target, &format!(".targets[{t}]."))
                };
                let targets: Result<_, _> = targets.iter().enumerate().map(gather).collect();
                object.insert("targets".into(), Value::Array(targets?));
            }
            object.insert("indices".into(), self.indices(&unwrapped.triangles)?.into());
        }
        // Compressed copies of the old attributes.
        remove_extension(&mut new, "KHR_draco_mesh_compression");
        let uv = unwrapped.uv1.iter().flat_map(|uv| [uv.x, uv.y]).flat_map(f32::to_le_bytes);
        let view = json!({"buffer": 0, "target": ARRAY_BUFFER});
        let view = self.added.view(self.root, view, uv.collect())?;
        let accessor = json!({"bufferView": view, "componentType": 5126, "type": "VEC2",
            "count": unwrapped.uv1.len()});
        let accessor = Value::from(push(self.root, "accessors", accessor));
        if let Some(attributes) = new.get_mut("attributes").and_then(Value::as_object_mut) {
            // Sets are counted from 0 without a gap.
            attributes.entry("TEXCOORD_0").or_insert_with(|| accessor.clone());
            attributes.insert("TEXCOORD_1".into(), accessor);
        }
        Ok(new)
    }

    /// Whether only the second UV set is new.
    fn same_vertices(&self, old: &Value, unwrapped: &Unwrapped) -> Result<bool, GltfError> {
        let triangles = matches!(number(old, "mode"), None | Some(4));
        let same = self.vertices.len() == self.count
            && self.vertices.iter().enumerate().all(|(i, &vertex)| i == vertex);
        if !(triangles && same) {
            return Ok(false);
        }
        let wanted = unwrapped.triangles.as_flattened();
        let Some(indices) = number(old, "indices") else {
            return Ok(wanted.iter().enumerate().all(|(i, &index)| i as u32 == index)
                && wanted.len() == self.count);
        };
        let indices =
            Elements::find(self.source, indices).map_err(|what| self.damaged(".indices", what))?;
        let index = |i: usize| indices.component.read(indices.get(i)) as u32;
        Ok(indices.count == wanted.len()
            && wanted.iter().enumerate().all(|(i, &wanted)| index(i) == wanted))
    }

    fn gather_all(
        &mut self,
        attributes: &Map<String, Value>,
        place: &str,
    ) -> Result<Value, GltfError> {
        let mut new = Map::new();
        for (name, index) in attributes {
            // The old set and what animates it.
            if name == "TEXCOORD_1" {
                continue;
            }
            let index = index.as_u64().map_or(usize::MAX, |index| index as usize);
            let accessor = self.gather(index, name).map_err(|error| {
                error.unwrap_or_else(|what| self.damaged(&format!("{place}{name}"), what))
            })?;
            new.insert(name.clone(), accessor.into());
        }
        Ok(Value::Object(new))
    }

    /// Adds an accessor with an attribute of the new vertices.
    fn gather(&mut self, index: usize, name: &str) -> Result<usize, Problem> {
        let elements = Elements::find(self.source, index)?;
        if elements.count != self.count {
            return Err(Problem::Here(format!(
                "{} values for {} positions",
                elements.count, self.count
            )));
        }
        // Attributes of vertices are aligned to 4 bytes.
        let stride = elements.size.next_multiple_of(4);
        let bytes = stride as u64 * self.vertices.len() as u64;
        if bytes > u64::from(u32::MAX) {
            return Err(GltfError::TooLarge { bytes }.into());
        }
        let mut data = Vec::with_capacity(bytes as usize);
        for &vertex in &self.vertices {
            data.extend_from_slice(elements.get(vertex));
            data.resize(data.len().next_multiple_of(4), 0);
        }
        let mut accessor = list(&self.source.json, "accessors")[index].clone();
        let bounded = name == "POSITION" || accessor.get("min").or(accessor.get("max")).is_some();
        if let Some(object) = accessor.as_object_mut() {
            for key in ["byteOffset", "sparse", "min", "max"] {
                object.remove(key);
            }
        }
        if bounded {
            let [min, max] = bounds(&elements, &data, stride);
            set(&mut accessor, "min", min);
            set(&mut accessor, "max", max);
        }
        let mut view = json!({"buffer": 0, "target": ARRAY_BUFFER});
        if stride != elements.size {
            set(&mut view, "byteStride", stride);
        }
        set(&mut accessor, "bufferView", self.added.view(self.root, view, data)?);
        set(&mut accessor, "count", self.vertices.len());
        Ok(push(self.root, "accessors", accessor))
    }

    fn indices(&mut self, triangles: &[[u32; 3]]) -> Result<usize, GltfError> {
        let indices = triangles.as_flattened();
        // The largest number of a type restarts strips.
        let short = self.vertices.len() <= usize::from(u16::MAX);
        let data: Vec<u8> = match short {
            true => indices.iter().flat_map(|&i| (i as u16).to_le_bytes()).collect(),
            false => indices.iter().flat_map(|i| i.to_le_bytes()).collect(),
        };
        let view = json!({"buffer": 0, "target": ELEMENT_ARRAY_BUFFER});
        let view = self.added.view(self.root, view, data)?;
        let component = if short { 5123 } else { 5125 };
        let accessor = json!({"bufferView": view, "componentType": component, "type": "SCALAR",
            "count": indices.len()});
        Ok(push(self.root, "accessors", accessor))
    }
}

/// What is wrong: with the place that is being read, or with the whole.
enum Problem {
    Here(String),
    Whole(GltfError),
}

impl Problem {
    fn unwrap_or_else(self, here: impl FnOnce(String) -> GltfError) -> GltfError {
        match self {
            Self::Here(what) => here(what),
            Self::Whole(error) => error,
        }
    }
}

impl From<String> for Problem {
    fn from(what: String) -> Self {
        Self::Here(what)
    }
}

impl From<GltfError> for Problem {
    fn from(error: GltfError) -> Self {
        Self::Whole(error)
    }
}

/// Smallest and largest components as they are stored.
fn bounds(elements: &Elements<'_>, data: &[u8], stride: usize) -> [Value; 2] {
    let mut low = vec![f64::INFINITY; elements.components];
    let mut high = vec![f64::NEG_INFINITY; elements.components];
    let size = elements.component.size();
    for element in data.chunks_exact(stride.max(1)) {
        for k in 0..elements.components {
            let value = elements.component.read(element.get(k * size..).unwrap_or_default());
            if value.is_finite() {
                low[k] = low[k].min(value);
                high[k] = high[k].max(value);
            }
        }
    }
    let whole = elements.component != Component::F32;
    [low, high].map(|values| {
        let number = |v: f64| match (v.is_finite(), whole) {
            (false, _) => Value::from(0),
            (true, true) => Value::from(v as i64),
            (true, false) => Value::from(v),
        };
        values.into_iter().map(number).collect()
    })
}
