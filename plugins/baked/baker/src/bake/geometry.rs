//! What all scenarios share: second UV sets, and where every texel lies.

use std::collections::BTreeMap;

use farlight_baked_format::{
    Fingerprint,
    manifest::{LeftOut, Receiver},
};
use farlight_gi_solver::{
    Scene, World,
    bake::{Density, Layout, LayoutSettings},
    import::{ImportedScene, split_id},
    scene::{AlphaMode, InstanceId, Mesh, MeshId},
    session::ProbeGrid,
};
use glam::{Affine3A, Vec3};

use super::{input::Input, plan::Plan, probes};
use crate::{
    BakeError, BakeOptions, Effort, Texels,
    gltf::write,
    observer::{Stage, Step, Work},
    store::{Cache, Key},
    uv::{SecondSet, UvOptions, UvSet, apply, second_sets},
};

/// Texels a metre of a standard bake.
const STANDARD: f32 = 16.0;
/// Texels between charts: what bilinear lookups need.
const PADDING: u32 = 2;
/// How much of a page charts cover about, for the first guess of a density.
const COVERAGE: f32 = 0.5;
/// Instances get rectangles with edges of at least this part of those of the mesh's largest instance.
const SMALLEST: f32 = 0.5;
/// Second UV sets are made anew for another density where that differs by more than this factor: gutters
/// are texels.
const ANEW: f32 = 1.1;

/// What all scenarios share, and the world that they light in turn.
pub(super) struct Geometry {
    pub(super) world: World,
    pub(super) rest: Rest,
}

/// What all scenarios share.
pub(super) struct Rest {
    pub(super) layout: Layout,
    /// The lit scene.
    pub(super) glb: Vec<u8>,
    pub(super) receivers: Vec<Receiver>,
    pub(super) left_out: Vec<LeftOut>,
    pub(super) volumes: Vec<ProbeGrid>,
    /// Of all that light meets, and of the layout.
    pub(super) print: Fingerprint,
}

impl std::ops::Deref for Geometry {
    type Target = Rest;

    fn deref(&self) -> &Rest {
        &self.rest
    }
}

/// Pages of one size.
#[derive(Clone, Copy, Debug)]
struct Pages {
    size: u32,
    most: u32,
}

impl Geometry {
    /// Prepares a scene, whose meshes get their second UV sets.
    pub(super) fn new<'a>(
        options: &BakeOptions,
        input: &Input,
        imported: &mut ImportedScene,
        cache: &Cache<'_>,
        work: &'a Work<'a>,
    ) -> Result<Self, BakeError> {
        let file = options.scene.display().to_string();
        let (receivers, mut refused) = candidates(input, &imported.scene);
        let area = surface(&imported.scene, &receivers);
        if receivers.is_empty() || area <= 0.0 {
            let why =
                refused.values().next().cloned().unwrap_or_else(|| {
                    "there are no triangles in the file's default scene".to_owned()
                });
            return Err(BakeError::NothingToLight { file, why });
        }
        let original = imported.clone();
        let density = match options.texels {
            Texels::Standard => STANDARD,
            Texels::PerMetre(density) => density,
            Texels::Page(size) => size as f32 * (COVERAGE / area).sqrt(),
        };
        // A standard bake is as coarse as four full pages make it.
        let most = 2048.0 * (COVERAGE / area).sqrt();
        let mut density = match options.texels {
            Texels::Standard => density.min(most),
            _ => density,
        };
        let mut anew = 0;
        let (sets, world, layout) = loop {
            let sets = {
                let running = work.begin(Stage::Unwrap, "", original.scene.meshes.len() as u64);
                let uv = UvOptions {
                    texels_per_metre: density,
                    padding: PADDING,
                    max_texels: largest_page(options).saturating_sub(2),
                };
                let done = std::sync::atomic::AtomicUsize::new(0);
                let progress = |meshes: usize, _of: usize| {
                    let before = done.fetch_max(meshes, std::sync::atomic::Ordering::Relaxed);
                    running.tick(meshes.saturating_sub(before) as u64).is_continue()
                };
                let sets = second_sets(&original, &input.source, &uv, cache, &progress);
                sets.map_err(|_| stopped(work))?
            };
            *imported = original.clone();
            apply(imported, &sets);
            let running = work.begin(Stage::Layout, "", 1);
            let world = World::new(&imported.scene);
            let sized = enlarge_small(&imported.scene);
            let layout = lay_out(options, &sized, &world, &receivers, density, work)?;
            let _ = running.tick(1);
            let ratio = layout.texels_per_metre / density;
            if anew == 2 || (1.0 / ANEW..=ANEW).contains(&ratio) || layout.is_empty() {
                break (sets, world, layout);
            }
            anew += 1;
            density = layout.texels_per_metre;
        };
        if layout.is_empty() {
            let why =
                no_set(&sets).or_else(|| layout.refused.first().map(|(_, why)| why.to_string()));
            let why = why.unwrap_or_else(|| "no primitive has a surface".to_owned());
            return Err(BakeError::NothingToLight { file, why });
        }
        if let Texels::PerMetre(wanted) = options.texels
            && layout.texels_per_metre < wanted * 0.99
        {
            work.warn(format!(
                "{wanted} texels a metre don't fit into {} pages of {size} x {size}: the scene gets {}",
                layout.page_count,
                layout.texels_per_metre,
                size = layout.page_size,
            ));
        }
        for (id, why) in &layout.refused {
            let mesh = imported.scene.instances.get(id).map(|instance| instance.mesh);
            let reason = match mesh.and_then(|mesh| sets.get(&mesh)) {
                Some(SecondSet { set: UvSet::None { reason }, .. }) => reason.clone(),
                _ => why.to_string(),
            };
            refused.insert(*id, reason);
        }
        let glb = write(&input.source, &sets, options.scale)
            .map_err(|problem| BakeError::Gltf { file, problem })?;
        let volumes = probes::grids(options, &layout);
        let mut rest = Rest {
            glb,
            receivers: placed(input, imported, &layout),
            left_out: refused.iter().map(|(id, reason)| left_out(input, *id, reason)).collect(),
            volumes,
            print: Fingerprint::default(),
            layout,
        };
        rest.print = rest.hash(&imported.scene);
        Ok(Self { world, rest })
    }

    /// What is to be done now, with guesses of the time on two cores.
    pub(super) fn steps(&self, options: &BakeOptions, plans: &[Plan]) -> Vec<Step> {
        let texels = self.layout.len() as f64;
        let probes: u32 = self.volumes.iter().map(|grid| grid.resolution.element_product()).sum();
        let rays = match options.effort {
            Effort::Rays(rays) => f64::from(rays),
            // Told by its end.
            Effort::Time(_) => 0.0,
        };
        let threads = rayon::current_num_threads() as f64;
        let mut steps = Vec::new();
        for plan in plans {
            let mut step = |stage, seconds: f64| {
                steps.push(Step::new(stage, &plan.name, seconds * 2.0 / threads));
            };
            step(Stage::Direct, texels * 1e-5 * plan.lights.len() as f64);
            step(Stage::Exchange, 2.0 + texels * 1e-5);
            let paths = f64::from(options.effort.probe_paths());
            step(Stage::Probes, f64::from(probes) * paths * 1.2e-6);
            step(Stage::Gather, texels * rays * 1.2e-6);
            step(Stage::Denoise, if options.denoise { texels * 3e-5 } else { 0.0 });
            step(Stage::Write, texels * 1e-6 + 0.1);
        }
        steps
    }
}

impl Rest {
    /// How much of the pages charts cover.
    pub(super) fn coverage(&self) -> f32 {
        let layout = &self.layout;
        let all = u64::from(layout.page_size).pow(2) * u64::from(layout.page_count);
        layout.len() as f32 / all.max(1) as f32
    }

    /// Of everything that the light of all scenarios depends on.
    fn hash(&self, scene: &Scene) -> Fingerprint {
        let mut key = Key::new("geometry");
        for (id, mesh) in &scene.meshes {
            key.number(id.0).number(mesh.triangles.len() as u64);
            hash_mesh(mesh, &mut key);
        }
        for (id, texture) in &scene.textures {
            key.number(id.0).number(texture.width).number(texture.srgb);
            key.bytes(texture.texels.as_flattened());
        }
        for (id, material) in &scene.materials {
            key.number(id.0).floats(&material.base_color.to_array()).vector(material.emissive);
            for texture in [material.base_color_texture, material.emissive_texture] {
                key.number(texture.map_or(u64::MAX, |id| id.0));
            }
            match material.alpha_mode {
                AlphaMode::Opaque => key.number(0_u32),
                AlphaMode::Mask(cutoff) => key.number(1_u32).float(cutoff),
                AlphaMode::Blend => key.number(2_u32),
            };
            key.number(material.double_sided).floats(&material.uv_transform.to_cols_array());
        }
        for (id, instance) in &scene.instances {
            key.number(id.0).number(instance.mesh.0).number(instance.material.0);
            key.floats(&instance.transform.to_cols_array());
        }
        let layout = &self.layout;
        key.number(layout.page_size).number(layout.page_count).float(layout.texels_per_metre);
        for place in &layout.placements {
            let rect = place.rect;
            key.number(place.instance.0).number(place.page.0).number(rect.x).number(rect.y);
            key.number(rect.width).number(rect.height);
        }
        key.number(layout.len() as u64).finish()
    }
}

fn hash_mesh(mesh: &Mesh, key: &mut Key) {
    // Whole slices at once would need their bytes; this is fast enough.
    for triangle in &mesh.triangles {
        triangle.iter().for_each(|&i| _ = key.number(i));
    }
    mesh.positions.iter().chain(&mesh.normals).for_each(|v| _ = key.vector(*v));
    for set in [&mesh.uv0, &mesh.uv1] {
        key.number(set.len() as u64);
        set.iter().for_each(|uv| _ = key.float(uv.x).float(uv.y));
    }
}

/// What a cancelled part means.
pub(super) fn stopped(work: &Work<'_>) -> BakeError {
    if work.outdated() { BakeError::Outdated } else { BakeError::Stopped }
}

/// Instances that may get a lightmap, and why others don't.
fn candidates(input: &Input, scene: &Scene) -> (Vec<InstanceId>, BTreeMap<InstanceId, String>) {
    let mut refused = BTreeMap::new();
    let mut receivers = Vec::new();
    for (&id, instance) in &scene.instances {
        let [node, _] = split_id(id.0);
        let blended = scene
            .materials
            .get(&instance.material)
            .is_some_and(|material| material.alpha_mode == AlphaMode::Blend);
        if input.is_skinned(node) {
            let why = "it is skinned and moves: probes light it";
            refused.insert(id, why.to_owned());
        } else if blended {
            refused.insert(id, "its material is blended".to_owned());
        } else {
            receivers.push(id);
        }
    }
    (receivers, refused)
}

/// Surface of instances in square metres.
fn surface(scene: &Scene, instances: &[InstanceId]) -> f32 {
    let mut area = 0.0;
    for instance in instances.iter().filter_map(|id| scene.instances.get(id)) {
        let Some(mesh) = scene.meshes.get(&instance.mesh) else { continue };
        for triangle in &mesh.triangles {
            let [a, b, c] =
                triangle.map(|i| mesh.positions.get(i as usize).copied().unwrap_or_default());
            let [u, v] = [b - a, c - a].map(|edge| instance.transform.transform_vector3(edge));
            let half = u.cross(v).length() * 0.5;
            area += if half.is_finite() { f64::from(half) } else { 0.0 };
        }
    }
    area as f32
}

/// A scene for the sizes of rectangles: instances that are much smaller than the largest of the same mesh,
/// whose gutters are made for that one, get more texels than their size asks for.
fn enlarge_small(scene: &Scene) -> Scene {
    let mut largest: BTreeMap<MeshId, f32> = BTreeMap::new();
    let areas: BTreeMap<InstanceId, f32> =
        scene.instances.keys().map(|&id| (id, surface(scene, &[id]))).collect();
    for (id, instance) in &scene.instances {
        let most = largest.entry(instance.mesh).or_default();
        *most = most.max(areas[id]);
    }
    let mut scene = scene.clone();
    for (id, instance) in &mut scene.instances {
        let (area, most) = (areas[id], largest[&instance.mesh]);
        let factor = SMALLEST * (most / area).sqrt();
        if factor.is_finite() && factor > 1.0 {
            instance.transform.matrix3 *= factor;
        }
    }
    scene
}

/// Edge of the largest page that the options allow.
fn largest_page(options: &BakeOptions) -> u32 {
    match options.texels {
        Texels::Standard => 1024,
        Texels::PerMetre(_) => 4096,
        Texels::Page(size) => size,
    }
}

/// Lays texels out on pages that are no larger and no more than needed.
fn lay_out(
    options: &BakeOptions,
    scene: &Scene,
    world: &World,
    receivers: &[InstanceId],
    density: f32,
    work: &Work<'_>,
) -> Result<Layout, BakeError> {
    let sizes: Vec<Pages> = match options.texels {
        Texels::Page(size) => vec![Pages { size, most: 1 }],
        Texels::Standard => vec![64, 128, 256, 512, 1024]
            .into_iter()
            .map(|size| Pages { size, most: 1 })
            .chain([Pages { size: 1024, most: 4 }])
            .collect(),
        Texels::PerMetre(_) => [64, 128, 256, 512, 1024]
            .into_iter()
            .map(|size| Pages { size, most: 1 })
            .chain([(1024, 4), (2048, 4), (4096, 8)].map(|(size, most)| Pages { size, most }))
            .collect(),
    };
    let texels = surface(scene, receivers) * density * density;
    let last = sizes.len() - 1;
    for (i, pages) in sizes.into_iter().enumerate() {
        let capacity = (pages.size * pages.size) as f32 * pages.most as f32;
        // What can't fit is not tried, nor what would have to be packed without a gap.
        if i < last && texels > capacity * 0.95 {
            continue;
        }
        if work.stopped() {
            return Err(stopped(work));
        }
        let settings = LayoutSettings {
            page_size: pages.size,
            max_pages: pages.most,
            density: match options.texels {
                Texels::Page(_) => Density::Fit,
                _ => Density::TexelsPerMetre(density),
            },
        };
        let layout = Layout::new(scene, world, receivers.iter().copied(), &settings);
        if i == last || layout.texels_per_metre >= density * 0.999 {
            return Ok(layout);
        }
    }
    Err(stopped(work))
}

fn no_set(sets: &BTreeMap<MeshId, SecondSet>) -> Option<String> {
    sets.values().find_map(|second| match &second.set {
        UvSet::None { reason } => Some(reason.clone()),
        _ => None,
    })
}

fn placed(input: &Input, imported: &ImportedScene, layout: &Layout) -> Vec<Receiver> {
    let mut prints: BTreeMap<MeshId, Fingerprint> = BTreeMap::new();
    let scene = &imported.scene;
    let mut receivers: Vec<Receiver> = layout
        .placements
        .iter()
        .filter_map(|place| {
            let mesh = scene.instances.get(&place.instance)?.mesh;
            let uv1 = &scene.meshes.get(&mesh)?.uv1;
            let uv = *prints.entry(mesh).or_insert_with(|| Fingerprint::of_uv(uv1.iter().copied()));
            let [node, primitive] = split_id(place.instance.0);
            let rect = place.rect;
            Some(Receiver {
                node,
                primitive,
                name: input.node_name(node).to_owned(),
                page: place.page.0,
                rect: [rect.x, rect.y, rect.width, rect.height],
                uv,
            })
        })
        .collect();
    receivers.sort_by_key(|receiver| (receiver.node, receiver.primitive));
    receivers
}

fn left_out(input: &Input, id: InstanceId, reason: &str) -> LeftOut {
    let [node, primitive] = split_id(id.0);
    LeftOut { node, primitive, name: input.node_name(node).to_owned(), reason: reason.to_owned() }
}

/// The box around all receivers.
pub(super) fn bounds(layout: &Layout) -> [Vec3; 2] {
    layout.texels().fold([Vec3::INFINITY, Vec3::NEG_INFINITY], |[low, high], texel| {
        [low.min(texel.position), high.max(texel.position)]
    })
}

/// The transform of the unit cube to a box.
pub(super) fn unit_cube_to(low: Vec3, high: Vec3) -> Affine3A {
    Affine3A::from_scale_rotation_translation(high - low, glam::Quat::IDENTITY, (low + high) * 0.5)
}
