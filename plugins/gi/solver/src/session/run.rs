//! The session itself: what changed, and what is worked on next.

use std::{
    collections::{BTreeMap, BTreeSet, HashMap},
    sync::Arc,
};

use rayon::{ThreadPool, ThreadPoolBuilder};

use super::{
    GridId, LightingUpdate, ProbeGrid, Quality, SessionChange, SessionSettings, SnapshotId,
    place::Places,
    publish::{Shown, changed_grids},
};
use crate::{
    Scene, SceneChange, World,
    atlas::TexelRect,
    lightmap::{GridState, Lighting, Limits, MeshTexels},
    scene::{InstanceId, Mesh},
};

/// Patches that may be worked on in one step; a solution of more is spread over several.
const STEP: usize = 400_000;

/// Keeps the lighting of a changing scene solved.
pub struct Session {
    pub(super) settings: SessionSettings,
    pub(super) scene: Scene,
    snapshot: SnapshotId,
    /// The snapshot that the running solution is for.
    solving: SnapshotId,
    /// The newest snapshot that was answered.
    told: SnapshotId,
    wanted: BTreeSet<InstanceId>,
    grids: BTreeMap<GridId, ProbeGrid>,
    pub(super) places: Places,
    shown: Shown,
    refused: BTreeMap<InstanceId, Arc<str>>,
    refused_news: Vec<(InstanceId, Arc<str>)>,
    rasters: HashMap<(usize, u32, u32), (Arc<Mesh>, Arc<MeshTexels>)>,
    pub(super) lighting: Option<Lighting>,
    dirty: Dirty,
    /// A slice of growing is due before the next solution, so that light that never rests does not
    /// keep the rays few for ever.
    growth_due: bool,
    grown: bool,
    /// Whether the lighting has been shown since it was set up.
    answered: bool,
    told_converged: bool,
    pool: Option<ThreadPool>,
}

#[derive(Clone, Copy, Default)]
struct Dirty {
    geometry: bool,
    materials: bool,
    light: bool,
}

impl Session {
    /// A session with an empty scene.
    #[must_use]
    pub fn new(settings: SessionSettings) -> Self {
        let page_size = settings.page_size.clamp(16, 4096);
        let density = settings.texels_per_metre.clamp(1e-3, 1e4);
        let cores = std::thread::available_parallelism().map_or(1, usize::from);
        let threads =
            if settings.threads == 0 { cores.saturating_sub(1).max(1) } else { settings.threads };
        Self {
            places: Places::new(page_size, settings.max_pages, density),
            settings,
            scene: Scene::default(),
            snapshot: SnapshotId::default(),
            solving: SnapshotId::default(),
            told: SnapshotId::default(),
            wanted: BTreeSet::new(),
            grids: BTreeMap::new(),
            shown: Shown::default(),
            refused: BTreeMap::new(),
            refused_news: Vec::new(),
            rasters: HashMap::new(),
            lighting: None,
            dirty: Dirty::default(),
            growth_due: false,
            grown: true,
            answered: false,
            told_converged: true,
            // Without threads of its own the session works on those of the process.
            pool: ThreadPoolBuilder::new()
                .num_threads(threads)
                .thread_name(|i| format!("lightmap {i}"))
                .build()
                .ok(),
        }
    }

    /// Takes changes over. Cheap: the work is done by [`step`](Self::step).
    pub fn apply(&mut self, snapshot: SnapshotId, changes: Vec<SessionChange>) {
        self.snapshot = self.snapshot.max(snapshot);
        for change in changes {
            match change {
                SessionChange::Scene(change) => self.apply_to_scene(change),
                SessionChange::AddReceiver(id) => {
                    self.dirty.geometry |= self.wanted.insert(id);
                }
                SessionChange::RemoveReceiver(id) => {
                    self.dirty.geometry |= self.wanted.remove(&id);
                    self.refused.remove(&id);
                }
                SessionChange::SetGrid(id, grid) => {
                    self.dirty.geometry |= self.grids.insert(id, grid) != Some(grid);
                }
                SessionChange::RemoveGrid(id) => {
                    self.dirty.geometry |= self.grids.remove(&id).is_some();
                }
            }
        }
        let Dirty { geometry, materials, light } = self.dirty;
        if geometry || materials || light {
            self.told_converged = false;
        }
    }

    fn apply_to_scene(&mut self, change: SceneChange) {
        let scene = &self.scene;
        match &change {
            SceneChange::SetLight(id, light) => {
                self.dirty.light |= scene.lights.get(id) != Some(light);
            }
            SceneChange::RemoveLight(id) => self.dirty.light |= scene.lights.contains_key(id),
            SceneChange::SetSky(sky) => self.dirty.light |= scene.sky != *sky,
            SceneChange::SetDirectSky(direct) => self.dirty.light |= scene.direct_sky != *direct,
            SceneChange::SetMaterial(id, material) => {
                self.dirty.materials |= scene.materials.get(id) != Some(material);
            }
            SceneChange::SetTexture(id, texture) => {
                let same = scene.textures.get(id).is_some_and(|old| Arc::ptr_eq(old, texture));
                self.dirty.materials |= !same;
            }
            SceneChange::RemoveMaterial(_) | SceneChange::RemoveTexture(_) => {
                self.dirty.materials = true;
            }
            SceneChange::SetInstance(id, instance) => {
                self.dirty.geometry |= scene.instances.get(id) != Some(instance);
            }
            SceneChange::RemoveInstance(id) => {
                self.dirty.geometry |= scene.instances.contains_key(id);
            }
            SceneChange::SetMesh(id, mesh) => {
                let same = scene.meshes.get(id).is_some_and(|old| Arc::ptr_eq(old, mesh));
                self.dirty.geometry |= !same;
            }
            SceneChange::RemoveMesh(_) => self.dirty.geometry = true,
        }
        self.scene.apply(change);
    }

    /// Does one piece of work of a few milliseconds to some tens (setting up changed geometry takes
    /// longer in large scenes). Returns an update when there is something better to show.
    pub fn step(&mut self) -> Option<LightingUpdate> {
        match self.pool.take() {
            Some(pool) => {
                let update = pool.install(|| self.step_here());
                self.pool = Some(pool);
                update
            }
            None => self.step_here(),
        }
    }

    fn step_here(&mut self) -> Option<LightingUpdate> {
        // What was begun is finished first, or geometry that moves all the time would never be lit.
        // A scene without surfaces (probes that come before the meshes) never has an answer.
        let hopeless = |l: &Lighting| self.grown && !l.is_ready() && !l.is_solving();
        if self.dirty.geometry && (self.answered || self.lighting.as_ref().is_none_or(hopeless)) {
            self.set_up();
            return None;
        }
        if self.dirty.materials {
            self.dirty.materials = false;
            self.dirty.light = true;
            if let Some(lighting) = &mut self.lighting
                && !lighting.refresh_materials(&self.scene)
            {
                self.dirty.geometry = true;
            }
        }
        let Some(lighting) = &mut self.lighting else {
            // No surface and no probe has come yet; when one does, light is read anew.
            self.dirty.light = false;
            return self.tell_converged();
        };
        let solve = lighting.is_solving()
            || (self.dirty.light && lighting.is_ready() && (self.grown || !self.growth_due));
        if solve {
            if !lighting.is_solving() {
                self.dirty.light = false;
                self.solving = self.snapshot;
                lighting.set_lights(&self.scene);
                lighting.start();
            }
            let mut left = STEP;
            loop {
                if lighting.advance() {
                    self.growth_due = true;
                    return self.publish();
                }
                left = left.saturating_sub(lighting.patches.len().max(1));
                if left == 0 {
                    return None;
                }
            }
        }
        if !self.grown {
            self.growth_due = false;
            match lighting.grow() {
                Some(better) => self.dirty.light |= better,
                None => self.grown = true,
            }
            return None;
        }
        if !lighting.is_ready() {
            // Nothing in this scene can be lit.
            self.dirty.light = false;
            return self.tell_converged();
        }
        if !lighting.settled {
            lighting.polish();
            return None;
        }
        match lighting.refine(self.settings.converged_paths) {
            Some(true) => self.publish(),
            Some(false) => None,
            None => self.tell_converged(),
        }
    }

    /// Whether [`step`](Self::step) has nothing to do until something changes.
    #[must_use]
    pub fn is_idle(&self) -> bool {
        let Dirty { geometry, materials, light } = self.dirty;
        !(geometry || materials || light)
            && self
                .lighting
                .as_ref()
                .is_none_or(|l| self.grown && (l.settled || !l.is_ready()) && !l.is_solving())
            && self.told_converged
    }

    /// Sets the world up anew after geometry or receivers changed.
    fn set_up(&mut self) {
        let refused = self.places_now();
        for (id, why) in &refused {
            if self.refused.get(id) != Some(why) {
                self.refused_news.push((*id, why.clone()));
            }
        }
        self.refused = refused;
        let world = World::new(&self.scene);
        let mut receivers = Vec::new();
        let mut rasters = HashMap::new();
        for (index, instance) in world.instances().iter().enumerate() {
            let Some(place) = self.places.places.get(&instance.id) else { continue };
            let TexelRect { width, height, .. } = place.rect();
            let key = (Arc::as_ptr(&instance.mesh) as usize, width, height);
            // The mesh is kept beside its texels, so that its address stays its own.
            let entry = self.rasters.remove(&key).unwrap_or_else(|| {
                let texels = MeshTexels::new(&instance.mesh, width, height);
                (instance.mesh.clone(), Arc::new(texels))
            });
            receivers.push((index as u32, entry.1.clone()));
            rasters.insert(key, entry.clone());
            self.rasters.insert(key, entry);
        }
        self.rasters = rasters;
        let settings = &self.settings;
        let limits = Limits {
            rays_per_texel: settings.rays_per_texel.clamp(64, 8192),
            rays_per_probe: settings.rays_per_probe.clamp(64, 65536),
            ray_memory: settings.ray_memory,
            bounces: settings.bounces.max(1),
            seed: (settings.seed ^ (settings.seed >> 32)) as u32,
        };
        let mut lighting = Lighting::new(world, receivers, self.places.texel(), limits);
        let mut old = self.lighting.take();
        for (id, grid) in &self.grids {
            let known = old
                .as_mut()
                .and_then(|l| l.grids.iter().position(|g| g.id == *id && g.grid == *grid))
                .and_then(|i| old.as_mut().map(|l| l.grids.swap_remove(i)));
            let mut state = known.unwrap_or_else(|| GridState::new(*id, *grid));
            state.invalidate();
            lighting.grids.push(state);
        }
        if let Some(old) = &mut old {
            lighting.start_from(old);
        }
        lighting.set_lights(&self.scene);
        self.lighting = Some(lighting);
        self.dirty = Dirty { light: true, ..Dirty::default() };
        self.answered = false;
        self.grown = false;
        self.growth_due = true;
    }

    fn places_now(&mut self) -> BTreeMap<InstanceId, Arc<str>> {
        let before = self.places.places.clone();
        let refused = self.places.arrange(&self.scene, &self.wanted);
        for (id, place) in &self.places.places {
            if before.get(id) != Some(place) {
                self.shown.new_places.insert(*id);
            }
        }
        self.shown.retain(&self.places);
        refused
    }

    fn publish(&mut self) -> Option<LightingUpdate> {
        let lighting = self.lighting.as_mut()?;
        self.answered = true;
        let grids = changed_grids(lighting);
        let (placements, tiles) = self.shown.changed(lighting, &self.places);
        let refused = std::mem::take(&mut self.refused_news);
        // A snapshot is answered even if nothing looks different by it.
        let told = std::mem::replace(&mut self.told, self.solving) == self.solving;
        let nothing = placements.is_empty() && tiles.is_empty() && grids.is_empty();
        if told && nothing && refused.is_empty() {
            return None;
        }
        let quality = self.quality();
        Some(LightingUpdate { snapshot: self.solving, placements, refused, tiles, grids, quality })
    }

    fn quality(&self) -> Quality {
        let Some(lighting) = &self.lighting else { return Quality::default() };
        Quality {
            relative_error: lighting.relative_error(),
            rays_per_texel: lighting.rays(),
            converged: false,
        }
    }

    fn tell_converged(&mut self) -> Option<LightingUpdate> {
        if self.told_converged {
            return None;
        }
        self.told_converged = true;
        Some(LightingUpdate {
            snapshot: self.snapshot,
            placements: Vec::new(),
            refused: std::mem::take(&mut self.refused_news),
            tiles: Vec::new(),
            grids: Vec::new(),
            quality: Quality { converged: true, ..self.quality() },
        })
    }
}
