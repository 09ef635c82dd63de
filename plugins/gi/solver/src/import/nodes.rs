//! The node hierarchy: instances and lights.

use std::{
    collections::{BTreeMap, btree_map::Entry},
    sync::Arc,
};

use glam::{Affine3A, Mat3A, Mat4, Quat, Vec3, Vec3A};
use gltf::json::{extensions::scene::khr_lights_punctual as khr, scene::Node, validation::Checked};

use super::{
    DEFAULT_MATERIAL, ImportOptions, ImportProblem, ImportedScene,
    container::File,
    error::{Warnings, label},
    geometry::{self, FARTHEST, GeometryBudget},
    material::Materials,
};
use crate::scene::{Instance, InstanceId, Light, LightId, LightKind, MaterialId, MeshId};

/// Default range of Bevy's glTF loader in metres.
const BEVY_RANGE: f32 = 20.0;

/// Walks the default scene into `imported`.
pub(super) fn read(
    file: &File<'_>,
    options: &ImportOptions,
    imported: &mut ImportedScene,
    warnings: &mut Warnings,
) -> Result<(), ImportProblem> {
    let nodes = world_transforms(file, options, warnings)?;
    let mut reader = Reader {
        file,
        options,
        budget: GeometryBudget::new(&options.limits),
        materials: Materials::new(file, &options.limits),
        meshes: BTreeMap::new(),
    };
    // In the order of the file, not of the hierarchy: lights are counted that way.
    for (index, transform) in nodes {
        let node = &file.root.nodes[index];
        let name = label("node", index, node.name.as_deref());
        if !transform.is_finite() {
            warnings.push(|| format!("{name}: its transform is not finite, it is left out"));
            continue;
        }
        reader.light(node, index, &name, &transform, imported, warnings)?;
        reader.mesh(node, index, &name, &transform, imported, warnings)?;
    }
    reader.materials.finish(&mut imported.scene);
    Ok(())
}

/// World transforms of the nodes of the default scene, by node index.
fn world_transforms(
    file: &File<'_>,
    options: &ImportOptions,
    warnings: &mut Warnings,
) -> Result<BTreeMap<usize, Affine3A>, ImportProblem> {
    let root = &file.root;
    let scene = match root.scene {
        Some(index) => Some(root.get(index).ok_or_else(|| {
            ImportProblem::Damaged(format!("the default scene {index} does not exist"))
        })?),
        None => root.scenes.first(),
    };
    let roots: Vec<usize> = match scene {
        Some(scene) => scene.nodes.iter().map(|node| node.value()).collect(),
        None => {
            // Without scenes everything is shown: the nodes that are nobody's children.
            let mut is_root = vec![true; root.nodes.len()];
            for child in root.nodes.iter().flat_map(|n| n.children.iter().flatten()) {
                if let Some(is_root) = is_root.get_mut(child.value()) {
                    *is_root = false;
                }
            }
            (0..root.nodes.len()).filter(|&i| is_root[i]).collect()
        }
    };
    let mut transforms = BTreeMap::new();
    let mut stack: Vec<_> = roots.into_iter().map(|i| (i, Affine3A::IDENTITY, 1)).collect();
    while let Some((index, parent, depth)) = stack.pop() {
        let Some(node) = root.nodes.get(index) else {
            return Err(ImportProblem::Damaged(format!(
                "node {index} does not exist (there are {})",
                root.nodes.len()
            )));
        };
        let limit = options.limits.depth;
        if depth > limit {
            let what = "levels of nodes";
            return Err(ImportProblem::Limit { what, found: depth, limit, field: "depth" });
        }
        let transform = parent * local_transform(node, options.scale);
        // Visiting each node once also breaks cycles.
        match transforms.entry(index) {
            Entry::Vacant(entry) => _ = entry.insert(transform),
            Entry::Occupied(_) => {
                warnings.push(|| {
                    let name = label("node", index, node.name.as_deref());
                    format!("{name} has two parents or is its own ancestor, it is taken once")
                });
                continue;
            }
        }
        stack.extend(
            node.children.iter().flatten().map(|child| (child.value(), transform, depth + 1)),
        );
    }
    Ok(transforms)
}

fn local_transform(node: &Node, scale: f32) -> Affine3A {
    let mut transform = match &node.matrix {
        Some(matrix) => Affine3A::from_mat4(Mat4::from_cols_array(matrix)),
        None => {
            let rotation = node.rotation.map_or(Quat::IDENTITY, |q| Quat::from_array(q.0));
            // Exporters write rotations that are a little off unit length.
            let rotation = match rotation.length_squared() {
                l if l.is_finite() && l > 1e-12 => rotation.normalize(),
                _ => Quat::IDENTITY,
            };
            Affine3A::from_scale_rotation_translation(
                node.scale.map_or(Vec3::ONE, Vec3::from),
                rotation,
                node.translation.map_or(Vec3::ZERO, Vec3::from),
            )
        }
    };
    transform.translation *= scale;
    transform
}

struct Reader<'a> {
    file: &'a File<'a>,
    options: &'a ImportOptions,
    budget: GeometryBudget<'a>,
    materials: Materials<'a>,
    /// Meshes that were read, with their bounds; `None` for those that are left out.
    meshes: BTreeMap<MeshId, Option<Read>>,
}

#[derive(Clone, Copy)]
struct Read {
    triangles: u64,
    bounds: [Vec3; 2],
}

impl Reader<'_> {
    fn light(
        &self,
        node: &Node,
        index: usize,
        name: &str,
        transform: &Affine3A,
        imported: &mut ImportedScene,
        warnings: &mut Warnings,
    ) -> Result<(), ImportProblem> {
        let Some(reference) = node.extensions.as_ref().and_then(|e| e.khr_lights_punctual.as_ref())
        else {
            return Ok(());
        };
        let lights =
            self.file.root.extensions.as_ref().and_then(|e| {
                e.khr_lights_punctual.as_ref().map(|lights| lights.lights.as_slice())
            });
        let Some(light) = lights.unwrap_or_default().get(reference.light.value()) else {
            return Err(ImportProblem::Damaged(format!(
                "{name} names light {}, but there are {}",
                reference.light,
                lights.map_or(0, <[_]>::len)
            )));
        };
        let kind = match light.type_ {
            Checked::Valid(khr::Type::Directional) => LightKind::Directional,
            Checked::Valid(khr::Type::Point) => LightKind::Point,
            Checked::Valid(khr::Type::Spot) => {
                let spot = light.spot.clone().unwrap_or_default();
                let half_turn = std::f32::consts::FRAC_PI_2;
                let outer = spot.outer_cone_angle.clamp(1e-3, half_turn);
                let inner = spot.inner_cone_angle.clamp(0.0, outer - 1e-4);
                LightKind::Spot { inner_angle: inner, outer_angle: outer }
            }
            Checked::Invalid => {
                warnings.push(|| format!("{name}: its light has an unknown type, left out"));
                return Ok(());
            }
        };
        let intensity = Vec3::from(light.color) * light.intensity;
        let direction = transform.transform_vector3(-Vec3::Z).normalize_or_zero();
        if !(intensity.is_finite() && intensity.min_element() >= 0.0) {
            warnings.push(|| format!("{name}: its light has no usable intensity, left out"));
            return Ok(());
        }
        if direction == Vec3::ZERO && kind != LightKind::Point {
            warnings.push(|| format!("{name}: its light has no direction, left out"));
            return Ok(());
        }
        let range = match light.range {
            _ if !self.options.range_window => f32::INFINITY,
            Some(range) if range > 0.0 => range * self.options.scale,
            _ => BEVY_RANGE,
        };
        let id = LightId(index as u64);
        let position = transform.translation.into();
        imported.scene.lights.insert(id, Light { kind, position, direction, intensity, range });
        imported.light_ids.push(id);
        Ok(())
    }

    fn mesh(
        &mut self,
        node: &Node,
        index: usize,
        name: &str,
        transform: &Affine3A,
        imported: &mut ImportedScene,
        warnings: &mut Warnings,
    ) -> Result<(), ImportProblem> {
        let Some(mesh_index) = node.mesh else { return Ok(()) };
        let Some(mesh) = self.file.root.get(mesh_index) else {
            return Err(ImportProblem::Damaged(format!(
                "{name} names mesh {mesh_index}, but there are {}",
                self.file.root.meshes.len()
            )));
        };
        if node.skin.is_some() {
            warnings.push(|| format!("{name} is skinned: it is taken in its rest pose"));
        }
        let flat = Mat3A::determinant(&transform.matrix3);
        if flat == 0.0 || !flat.is_finite() {
            warnings.push(|| format!("{name} is scaled to nothing, its mesh is left out"));
            return Ok(());
        }
        for (p, primitive) in mesh.primitives.iter().enumerate() {
            let id = |high: usize| (high as u64) << 32 | p as u64;
            let mesh_id = MeshId(id(mesh_index.value()));
            let material = primitive.material.map(|m| m.value());
            let read = match self.meshes.get(&mesh_id) {
                Some(read) => *read,
                None => {
                    let place = label("mesh", mesh_index.value(), mesh.name.as_deref());
                    let place = format!("{place}, primitive {p}");
                    let uv_set = self.materials.uv_set(material);
                    let read = geometry::read(
                        self.file,
                        &place,
                        primitive,
                        uv_set,
                        self.options.scale,
                        &mut self.budget,
                        warnings,
                    )?
                    .map(|geometry::Primitive { mesh, vertices }| {
                        if let Some(vertices) = vertices {
                            imported.file_vertices.insert(mesh_id, vertices.into());
                        }
                        let read = Read {
                            triangles: mesh.triangles.len() as u64,
                            bounds: bounds(&mesh.positions),
                        };
                        imported.scene.meshes.insert(mesh_id, Arc::new(mesh));
                        read
                    });
                    self.meshes.insert(mesh_id, read);
                    read
                }
            };
            let Some(read) = read else { continue };
            if !fits(transform, read.bounds) {
                warnings.push(|| format!("{name} is farther than {FARTHEST:e} m, it is left out"));
                continue;
            }
            self.budget.take_triangles(read.triangles)?;
            self.materials.need(material, warnings)?;
            let instance = InstanceId(id(index));
            imported.scene.instances.insert(
                instance,
                Instance {
                    mesh: mesh_id,
                    material: material.map_or(DEFAULT_MATERIAL, |m| MaterialId(m as u64)),
                    transform: *transform,
                },
            );
            let several =
                if mesh.primitives.len() > 1 { format!(", primitive {p}") } else { String::new() };
            imported.instance_names.insert(instance, format!("{name}{several}"));
        }
        Ok(())
    }
}

fn bounds(positions: &[Vec3]) -> [Vec3; 2] {
    positions
        .iter()
        .fold([Vec3::INFINITY, Vec3::NEG_INFINITY], |[low, high], &p| [low.min(p), high.max(p)])
}

/// Whether a transformed box stays where f32 can compute.
fn fits(transform: &Affine3A, [low, high]: [Vec3; 2]) -> bool {
    let (low, high) = (Vec3A::from(low), Vec3A::from(high));
    let center = transform.transform_point3a((low + high) * 0.5);
    let half = (high - low) * 0.5;
    let m = transform.matrix3;
    let reach = m.x_axis.abs() * half.x + m.y_axis.abs() * half.y + m.z_axis.abs() * half.z;
    geometry::is_usable(&(center.abs() + reach).into())
}
