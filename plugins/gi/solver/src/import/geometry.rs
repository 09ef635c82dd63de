//! Primitives into meshes: topology, attributes, repairs.

use glam::{Vec2, Vec3};
use gltf::json::{
    self, Index,
    mesh::{Mode, Semantic},
    validation::Checked,
};

use super::{
    ImportLimits, ImportProblem,
    accessor::{self, Indices},
    container::File,
    error::Warnings,
};
use crate::scene::Mesh;

/// Positions beyond this (metres) overflow in products of f32; no scene is that large.
pub(super) const FARTHEST: f32 = 1e9;

/// What may still be read.
pub(super) struct GeometryBudget<'a> {
    limits: &'a ImportLimits,
    triangles: u64,
    vertices: u64,
}

impl<'a> GeometryBudget<'a> {
    pub(super) fn new(limits: &'a ImportLimits) -> Self {
        Self { limits, triangles: 0, vertices: 0 }
    }

    pub(super) fn take_triangles(&mut self, count: u64) -> Result<(), ImportProblem> {
        self.triangles = self.triangles.saturating_add(count);
        let (found, limit) = (self.triangles, self.limits.triangles);
        let what = "triangles (each counted once an instance)";
        if found > limit {
            return Err(ImportProblem::Limit { what, found, limit, field: "triangles" });
        }
        Ok(())
    }

    fn take_vertices(&mut self, count: u64) -> Result<(), ImportProblem> {
        self.vertices = self.vertices.saturating_add(count);
        let (found, limit) = (self.vertices, self.limits.vertices.min(u64::from(u32::MAX)));
        if found > limit {
            return Err(ImportProblem::Limit { what: "vertices", found, limit, field: "vertices" });
        }
        Ok(())
    }
}

/// A primitive that was read.
pub(super) struct Primitive {
    pub mesh: Mesh,
    /// The vertex in the file of each vertex of the mesh; `None` if they are the same.
    pub vertices: Option<Vec<u32>>,
}

/// Reads a primitive; `None` (with a warning) if there is nothing to light in it. `uv_set` is the
/// texture coordinate set of its material. Triangles are counted by the caller, an instance at a
/// time, but never more are built than the limit allows.
pub(super) fn read(
    file: &File<'_>,
    place: &str,
    primitive: &json::mesh::Primitive,
    uv_set: u32,
    scale: f32,
    budget: &mut GeometryBudget<'_>,
    warnings: &mut Warnings,
) -> Result<Option<Primitive>, ImportProblem> {
    let fail = |attribute: &str, what: String| ImportProblem::Primitive {
        place: format!("{place}{attribute}"),
        what,
    };
    let Checked::Valid(mode) = primitive.mode else {
        return Err(fail("", "the primitive mode is unknown".into()));
    };
    if !matches!(mode, Mode::Triangles | Mode::TriangleStrip | Mode::TriangleFan) {
        warnings.push(|| format!("{place}: {mode:?} have no surface, they are left out"));
        return Ok(None);
    }
    let attribute = |semantic| primitive.attributes.get(&Checked::Valid(semantic)).copied();
    let Some(positions) = attribute(Semantic::Positions) else {
        warnings.push(|| format!("{place} has no POSITION, it is left out"));
        return Ok(None);
    };
    let vertices = accessor::count(file, positions).map_err(|what| fail(", POSITION", what))?;
    budget.take_vertices(vertices)?;
    let mut mesh = Mesh {
        positions: accessor::floats::<3>(file, positions)
            .map_err(|what| fail(", POSITION", what))?
            .into_iter()
            .map(|p| Vec3::from(p) * scale)
            .collect(),
        ..Default::default()
    };
    mesh.triangles = triangles(file, place, primitive, mode, &mesh.positions, budget, warnings)?;
    if mesh.triangles.is_empty() {
        warnings.push(|| format!("{place} has no triangles with an area, it is left out"));
        return Ok(None);
    }

    let checked = |semantic: Semantic, index: Index<json::Accessor>| {
        let name = format!(", {}", semantic.to_string());
        let found = accessor::count(file, index).map_err(|what| fail(&name, what))?;
        if found == vertices {
            return Ok(name);
        }
        Err(fail(&name, format!("{found} values for {vertices} positions")))
    };
    if let Some(index) = attribute(Semantic::Normals) {
        let name = checked(Semantic::Normals, index)?;
        let normals = accessor::floats::<3>(file, index).map_err(|what| fail(&name, what))?;
        mesh.normals = normals.into_iter().map(|n| Vec3::from(n).normalize_or_zero()).collect();
    }
    let uvs = |set| {
        let semantic = Semantic::TexCoords(set);
        let Some(index) = attribute(semantic.clone()) else {
            return Ok::<_, ImportProblem>(Vec::new());
        };
        let name = checked(semantic, index)?;
        let uvs = accessor::floats::<2>(file, index).map_err(|what| fail(&name, what))?;
        Ok(uvs.into_iter().map(Vec2::from).collect())
    };
    mesh.uv0 = uvs(uv_set)?;
    mesh.uv1 = uvs(1)?;
    let vertices = drop_unused_vertices(&mut mesh);
    repair(&mut mesh, place, uv_set, warnings);
    Ok(Some(Primitive { mesh, vertices }))
}

/// Triangles that have an area and only finite positions.
fn triangles(
    file: &File<'_>,
    place: &str,
    primitive: &json::mesh::Primitive,
    mode: Mode,
    positions: &[Vec3],
    budget: &GeometryBudget<'_>,
    warnings: &mut Warnings,
) -> Result<Vec<[u32; 3]>, ImportProblem> {
    let fail = |what| ImportProblem::Primitive { place: format!("{place}, indices"), what };
    let corners = match primitive.indices {
        Some(index) => accessor::count(file, index).map_err(fail)?,
        None => positions.len() as u64,
    };
    let count = match mode {
        Mode::Triangles => corners / 3,
        _ => corners.saturating_sub(2),
    };
    let limit = budget.limits.triangles;
    if count > limit {
        let what = "triangles in one primitive";
        return Err(ImportProblem::Limit { what, found: count, limit, field: "triangles" });
    }
    if mode == Mode::Triangles && corners % 3 != 0 {
        warnings.push(|| format!("{place}: {corners} corners are no multiple of 3"));
    }
    let indices = match primitive.indices {
        Some(index) => accessor::indices(file, index).map_err(fail)?,
        None => Indices::Implicit(positions.len()),
    };
    debug_assert_eq!(indices.len() as u64, corners);
    let (mut not_finite, mut no_area) = (0_u64, 0_u64);
    let mut triangles = Vec::with_capacity(count as usize);
    for t in 0..count as usize {
        let places = match mode {
            Mode::Triangles => [3 * t, 3 * t + 1, 3 * t + 2],
            // Every second triangle of a strip is turned round.
            Mode::TriangleStrip if t % 2 == 1 => [t + 1, t, t + 2],
            Mode::TriangleStrip => [t, t + 1, t + 2],
            _ => [0, t + 1, t + 2],
        };
        let triangle = places.map(|i| indices.get(i));
        if let Some(index) = triangle.iter().find(|&&i| i as usize >= positions.len()) {
            return Err(fail(format!(
                "triangle {t} names vertex {index}, but there are {}",
                positions.len()
            )));
        }
        let [a, b, c] = triangle.map(|i| positions[i as usize]);
        if ![a, b, c].iter().all(is_usable) {
            not_finite += 1;
        } else if (b - a).cross(c - a).normalize_or_zero() != Vec3::ZERO {
            triangles.push(triangle);
        } else if mode == Mode::Triangles {
            // In strips and fans they are the usual way to begin anew.
            no_area += 1;
        }
    }
    if not_finite > 0 {
        warnings.push(|| {
            format!(
                "{place}: {not_finite} of {count} triangles have a corner that is not a number or \
                 farther than {FARTHEST:e} m, they are left out"
            )
        });
    }
    if no_area > 0 {
        warnings.push(|| {
            format!("{place}: {no_area} of {count} triangles have no area, they are left out")
        });
    }
    Ok(triangles)
}

/// Whether f32 can compute with a position.
pub(super) fn is_usable(p: &Vec3) -> bool {
    p.is_finite() && p.abs().max_element() <= FARTHEST
}

/// Primitives often share one vertex list, and vertices of dropped triangles may be NaN. Returns which
/// were kept, if not all.
fn drop_unused_vertices(mesh: &mut Mesh) -> Option<Vec<u32>> {
    const UNUSED: u32 = u32::MAX;
    let mut place = vec![UNUSED; mesh.positions.len()];
    for &i in mesh.triangles.as_flattened() {
        place[i as usize] = 0;
    }
    let mut used = 0;
    for place in &mut place {
        if *place != UNUSED {
            *place = used;
            used += 1;
        }
    }
    if used as usize == place.len() {
        return None;
    }
    for i in mesh.triangles.as_flattened_mut() {
        *i = place[*i as usize];
    }
    fn keep<T>(values: &mut Vec<T>, place: &[u32]) {
        let mut i = 0;
        values.retain(|_| {
            i += 1;
            place[i - 1] != UNUSED
        });
        values.shrink_to_fit();
    }
    keep(&mut mesh.positions, &place);
    keep(&mut mesh.normals, &place);
    keep(&mut mesh.uv0, &place);
    keep(&mut mesh.uv1, &place);
    Some((0..place.len() as u32).filter(|&i| place[i as usize] != UNUSED).collect())
}

/// Replaces normals that are not directions, drops UV sets that are not numbers.
fn repair(mesh: &mut Mesh, place: &str, uv_set: u32, warnings: &mut Warnings) {
    let broken = |normal: &Vec3| !(normal.is_finite() && *normal != Vec3::ZERO);
    let count = mesh.normals.iter().filter(|n| broken(n)).count();
    if count > 0 {
        warnings.push(|| {
            format!("{place}: {count} normals are no directions, they are made from the faces")
        });
        let mut sums = vec![Vec3::ZERO; mesh.positions.len()];
        for triangle in &mesh.triangles {
            let [a, b, c] = triangle.map(|i| mesh.positions[i as usize]);
            let normal = (b - a).cross(c - a).normalize_or_zero();
            for &i in triangle {
                sums[i as usize] += normal;
            }
        }
        for (normal, sum) in mesh.normals.iter_mut().zip(sums) {
            if broken(normal) {
                *normal = sum.try_normalize().unwrap_or(Vec3::Y);
            }
        }
    }
    for (uvs, set) in [(&mut mesh.uv0, uv_set), (&mut mesh.uv1, 1)] {
        if uvs.iter().any(|uv| !uv.is_finite()) {
            warnings.push(|| {
                format!("{place}: TEXCOORD_{set} holds values that are no numbers, it is left out")
            });
            uvs.clear();
        }
    }
}
