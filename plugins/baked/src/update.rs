//! The systems: what changed, and what follows from it.

use bevy::{
    asset::{AssetLoadError, LoadState},
    ecs::{entity::EntityHashMap, system::SystemParam},
    gltf::GltfExtras,
    pbr::Lightmap,
    prelude::*,
    world_serialization::WorldAssetRoot,
};
use farlight_core::{LeftOut, LightingChanged, TextureUploads};

use crate::{
    BakedLighting, BakedManifest, BakedState, BakedStatus,
    blend::{self, Blends},
    find::{Found, Tree},
    lights::{LightQueries, Plan},
    root::{Fingerprints, Materials, Root},
    textures::Textures,
    volumes,
};

/// All roots.
#[derive(Resource, Default)]
pub(crate) struct Roots(EntityHashMap<Root>);

/// What may make a root look again.
type Grown = Or<(Added<GltfExtras>, Changed<Mesh3d>, Changed<ChildOf>)>;

/// Notes which roots must be looked at.
pub(crate) fn notice(
    mut roots: ResMut<Roots>,
    changed: Query<(Entity, &BakedLighting), Changed<BakedLighting>>,
    grown: Query<Entity, Grown>,
    mut lost: RemovedComponents<Lightmap>,
    mut manifests: MessageReader<AssetEvent<BakedManifest>>,
    mut meshes: MessageReader<AssetEvent<Mesh>>,
    mut prints: ResMut<Fingerprints>,
    parents: Query<&ChildOf>,
) {
    let roots = &mut roots.bypass_change_detection().0;
    for (entity, lighting) in &changed {
        let root = roots.entry(entity).or_insert_with(|| Root::new(entity));
        root.reweighed = true;
        let options =
            (lighting.manifest.id(), [lighting.bicubic, lighting.dimmable, lighting.solid_backs]);
        root.dirty |= root.options != options;
        root.reloaded |= root.options.0 != options.0;
        root.options = options;
    }
    if roots.is_empty() {
        lost.clear();
        manifests.clear();
        meshes.clear();
        return;
    }
    for event in manifests.read() {
        let (id, modified) = match event {
            AssetEvent::Added { id } => (*id, false),
            AssetEvent::Modified { id } => (*id, true),
            _ => continue,
        };
        for root in roots.values_mut().filter(|root| root.options.0 == id) {
            root.dirty = true;
            root.reloaded |= modified;
        }
    }
    for event in meshes.read() {
        if let AssetEvent::Modified { id } | AssetEvent::Removed { id } = event
            && !prints.is_empty()
        {
            prints.forget(*id);
            // Which meshes are whose is found anew.
            roots.values_mut().for_each(|root| root.dirty = true);
        }
    }
    for entity in lost.read() {
        roots.values_mut().for_each(|root| root.lost(entity));
    }
    for entity in &grown {
        for root in roots.values_mut() {
            root.dirty |= root.is_lit(entity);
        }
        let mut above = Some(entity);
        while let Some(entity) = above {
            if let Some(root) = roots.get_mut(&entity) {
                root.dirty = true;
            }
            above = parents.get(entity).ok().map(ChildOf::parent);
        }
    }
}

/// Assets and the scene.
#[derive(SystemParam)]
pub(crate) struct Sources<'w, 's> {
    manifests: Res<'w, Assets<BakedManifest>>,
    meshes: Res<'w, Assets<Mesh>>,
    images: ResMut<'w, Assets<Image>>,
    server: Res<'w, AssetServer>,
    scenes: Query<'w, 's, &'static WorldAssetRoot>,
    tree: Tree<'w, 's>,
}

impl Sources<'_, '_> {
    /// Why the scene of a root will never come, if so.
    fn scene_problem(&self, root: Entity) -> Option<String> {
        let scene = self.scenes.get(root).ok()?;
        match self.server.get_load_state(scene.0.id()) {
            Some(LoadState::Failed(error)) => Some(first_line(&error)),
            _ => None,
        }
    }
}

/// What follows it in errors of assets is where in the engine they happened.
fn first_line(error: &AssetLoadError) -> String {
    error.to_string().lines().next().unwrap_or_default().to_owned()
}

/// Lights what must be.
pub(crate) fn update(
    mut commands: Commands,
    mut roots: ResMut<Roots>,
    mut sources: Sources,
    lighting: Query<&BakedLighting>,
    mut removed: RemovedComponents<BakedLighting>,
    mut prints: ResMut<Fingerprints>,
    (mut materials, lightmapped): (Materials, Query<(), With<Lightmap>>),
    mut lights: LightQueries,
    (blends, uploads): (Res<Blends>, Res<TextureUploads>),
    mut status: ResMut<BakedStatus>,
    mut changed: MessageWriter<LightingChanged>,
) {
    let roots = &mut roots.bypass_change_detection().0;
    let mut another = false;
    for entity in removed.read().filter(|entity| !lighting.contains(*entity)) {
        if let Some(mut root) = roots.remove(&entity) {
            another = true;
            root.unlight(&mut commands, &mut materials);
            root.volumes.drain(..).for_each(|volume| commands.entity(volume).try_despawn());
            if let Some(textures) = root.textures.take() {
                textures.forget(None, &blends);
            }
            std::mem::take(&mut root.lights).remove(&mut commands, &mut lights);
        }
    }
    for (&entity, root) in roots.iter_mut() {
        let Ok(lighting) = lighting.get(entity) else { continue };
        let mut todo = Todo {
            lighting,
            sources: &mut sources,
            blends: &blends,
            commands: &mut commands,
            lights: &mut lights,
        };
        if std::mem::take(&mut root.reweighed) && !root.dirty {
            another = true;
            root.dirty = !todo.reweigh(root);
        }
        if std::mem::take(&mut root.dirty) {
            another = true;
            todo.look(root, &mut prints, &mut materials);
        }
        if root.status.state == BakedState::Loading
            && let Some(problem) = todo.sources.scene_problem(entity)
        {
            another = true;
            root.fail(problem);
        }
        let waiting = root.textures.as_ref().is_some_and(|textures| textures.are_waiting(&blends));
        if root.is_arriving() && !waiting {
            another |= root.arrive(&mut commands, &lightmapped, &mut materials);
        }
        root.status.receivers = root.receivers();
        if root.status.state == BakedState::Loading && root.is_done() {
            another = true;
            root.status.state = BakedState::Lit;
            tell(&root.status);
        }
    }
    blend::blend_here(&blends, status.blending, &sources.images, &uploads);

    let (waiting, done) = blends.progress();
    if waiting > 0 || done != status.blends {
        changed.write_default();
    }
    if done != status.blends {
        status.blends = done;
    }
    if another {
        status.roots = roots.values().map(|root| root.status.clone()).collect();
        status.roots.sort_by_key(|root| root.entity);
    }
}

fn tell(status: &crate::BakedRoot) {
    let (lit, missing) = (status.receivers, status.left_out.len());
    info!("{}: {lit} meshes are lit by baked light, {missing} are not", status.entity);
    for LeftOut { entity, reason } in &status.left_out {
        warn!("{entity}: {reason}");
    }
}

/// What a root's light is made of.
struct Todo<'a, 'sw, 'ss, 'cw, 'cs, 'lw, 'ls> {
    lighting: &'a BakedLighting,
    sources: &'a mut Sources<'sw, 'ss>,
    blends: &'a Blends,
    commands: &'a mut Commands<'cw, 'cs>,
    lights: &'a mut LightQueries<'lw, 'ls>,
}

impl Todo<'_, '_, '_, '_, '_, '_, '_> {
    /// Gives scenarios other weights, and nothing else: this may happen in every frame. Answers whether
    /// that was enough.
    fn reweigh(&mut self, root: &mut Root) -> bool {
        let manifest = self.sources.manifests.get(self.lighting.manifest.id());
        let (Some(manifest), Some(textures)) = (manifest, &root.textures) else { return false };
        let (weights, problems) = self.lighting.scenarios.resolve(manifest.scenario_names());
        root.status.problems = problems;
        if weights == root.weights {
            return true;
        }
        if !textures.blended || root.reloaded {
            return false;
        }
        textures.blend(&weights, self.blends);
        let plan = Plan::new(manifest, &weights);
        root.lights.apply(&plan, root.status.entity, false, self.commands, self.lights);
        root.status.lights = root.lights.len();
        root.take_weights(weights, manifest);
        true
    }

    /// Looks at a root from the beginning; what is right already stays.
    fn look(&mut self, root: &mut Root, prints: &mut Fingerprints, materials: &mut Materials) {
        let Self { lighting, sources, blends, commands, lights } = self;
        let entity = root.status.entity;
        let id = lighting.manifest.id();
        let Some(manifest) = sources.manifests.get(id) else {
            return match sources.server.get_load_state(id) {
                Some(LoadState::Failed(error)) => root.fail(first_line(&error)),
                _ => root.wait(),
            };
        };

        let (weights, problems) = lighting.scenarios.resolve(manifest.scenario_names());
        let plain = weights.len() == 1 && weights[0] == 1.0;
        let was_blended = root.textures.as_ref().is_some_and(|textures| textures.blended);
        // Once blended, always: going back would cost a frame without lightmaps.
        let blend = !plain || lighting.dimmable || was_blended;
        let mut anew = false;
        if root.reloaded || blend != was_blended || root.textures.is_none() {
            let (server, images) = (&sources.server, &mut sources.images);
            let old = root.textures.as_ref();
            let Some(textures) = Textures::take(manifest, blend, old, server, images) else {
                return root.wait();
            };
            if let Some(old) = old {
                old.forget(Some(&textures), blends);
            }
            root.textures = Some(textures);
            root.reloaded = false;
            anew = true;
        }
        if let Some(textures) = &root.textures
            && (anew || root.weights != weights)
        {
            textures.blend(&weights, blends);
        }
        root.take_weights(weights, manifest);

        let mut found = sources.tree.find(entity);
        let plan = Plan::new(manifest, &root.weights);
        root.lights.found = std::mem::take(&mut found.lights);
        root.lights.apply(&plan, entity, anew, commands, lights);
        let mut left_out = Vec::new();
        if anew {
            root.volumes.drain(..).for_each(|volume| commands.entity(volume).try_despawn());
        }
        let spawn = root.volumes.is_empty();
        for (index, volume) in manifest.volumes.iter().enumerate() {
            let shown = root.textures.as_ref().and_then(|textures| textures.volumes.get(index));
            let Some(shown) = shown else { break };
            if let Some(problem) = &shown.problem {
                let reason = format!("probe volume {index} is left out: {problem}").into();
                left_out.push(LeftOut { entity, reason });
            } else if spawn {
                root.volumes.push(volumes::spawn(volume, shown, entity, commands));
            }
        }

        let status = &mut root.status;
        status.problems = problems;
        status.complete = manifest.complete;
        status.volumes = root.volumes.len();
        status.lights = root.lights.len();
        status.texture_bytes = root.textures.as_ref().map_or(0, |textures| textures.bytes);
        if found.primitives.is_empty() && !manifest.receivers.is_empty() {
            status.left_out = left_out;
            root.unlight(commands, materials);
            // What is spawned later is noticed.
            status_without_scene(root, &found, manifest);
            return;
        }
        let places = root.places(lighting, manifest, &found, &sources.meshes, prints);
        let Some((places, missing)) = places else { return root.wait() };
        left_out.extend(missing);
        root.status.left_out = left_out;
        root.want(places, commands, materials);
    }
}

fn status_without_scene(root: &mut Root, found: &Found, manifest: &BakedManifest) {
    if found.meshes == 0 {
        root.status.state = BakedState::Loading;
        return;
    }
    root.fail(format!(
        "no mesh of the scene says which node it is (extras.farlight_node): load {}, which the bake \
         wrote, and not the file that it read",
        manifest.scene
    ));
}
