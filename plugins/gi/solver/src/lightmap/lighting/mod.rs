//! Solves light for one state of the geometry, in slices.
//!
//! Two kinds of work alternate. *Growing* traces kept rays ([`Block`]). *Solving* answers for the
//! lights as they are: shadow rays where a light moved, then bounces between all patches through
//! few kept rays each, then one last gather through all kept rays at the texels and probes that are
//! shown. Noise of the few rays averages out in the last gather, whose every ray ends on another
//! patch.

mod grow;
mod output;
mod refine;
mod solve;

use std::sync::Arc;

use glam::{Vec3, Vec4};

use self::{refine::Refined, solve::Job};
use super::{
    bury::unbury,
    closed::is_closed,
    direct::Direct,
    fill::FillPlan,
    grids::GridState,
    patches::Patches,
    raster::MeshTexels,
    sky::{SkyTable, soft},
    transport::{Block, Buried},
};
use crate::{
    Scene, World,
    scene::{DirectSky, Sky},
};

/// Blocks that every patch has, not only texels that are shown (64 rays); bounces use these.
const LOW_BLOCKS: usize = 3;
/// Blocks that must be complete for a first answer (32 rays).
const FIRST_BLOCKS: usize = 2;

/// What bounds the work.
#[derive(Clone, Copy)]
pub(crate) struct Limits {
    pub rays_per_texel: u32,
    pub rays_per_probe: u32,
    pub ray_memory: usize,
    pub bounces: u32,
    pub seed: u32,
}

/// The state of light in a world.
pub(crate) struct Lighting {
    pub world: World,
    pub patches: Patches,
    pub grids: Vec<GridState>,
    pub direct: Direct,
    /// For each texel that is shown: irradiance from other surfaces and, unless it is left out, the
    /// sky; the best that is known, filtered where it is noisy. Buried texels hold nothing of worth.
    pub irradiance: Vec<Vec3>,
    /// Its standard error in luminance, as far as rays that disagree tell.
    pub error: Vec<f32>,
    /// How the texels of each receiver are spread over its rectangle.
    pub plans: Vec<FillPlan>,
    /// Kept rays traced so far, for measurements.
    pub traced: u64,
    /// Whether another solution for the same light would give the same.
    pub settled: bool,
    /// Solutions for the same light and rays only to let bounces come to the end.
    polishes: u32,
    limits: Limits,
    closed: Vec<bool>,
    near: f32,
    blocks: Vec<Block>,
    buried: Vec<Buried>,
    /// For each texel that is shown: whether it has a point in the open, before and after rays.
    open: Vec<bool>,
    valid: Vec<bool>,
    /// Receivers with buried texels.
    holes: Vec<usize>,
    /// For each texel that is shown: irradiance through its kept rays, with the sky unless it is left
    /// out.
    gathered: Vec<Vec3>,
    /// How far half of the rays behind a texel disagree with all, in luminance.
    spread: Vec<f32>,
    /// What rays that are not kept add while light is still.
    refined: Refined,
    /// For each texel that is shown: what an older state knew, and its standard error. Empty where
    /// light has changed since.
    held: Vec<(Vec3, f32)>,
    /// Whether there is a solution.
    answered: bool,
    /// The sky without detail that few rays would only make noise of.
    soft_sky: Sky,
    /// The same for kept rays.
    sky_table: SkyTable,
    /// Whether texels and probes show what arrives straight from the sky. Patches always reflect it.
    direct_sky: DirectSky,
    /// For each patch: irradiance straight from punctual lights and the sky.
    arriving: Vec<Vec3>,
    /// All radiance that lights and emission put into the scene, for guessing how bounces scale.
    source: Vec3,
    /// For each patch: irradiance straight from the sky.
    sky: Vec<Vec3>,
    /// For each texel that is shown: by how much the mean radiance of its last rays towards the sky
    /// differs from that of those before. Empty under a black sky.
    sky_halves: Vec<Vec3>,
    sky_stale: bool,
    /// For each patch: irradiance from other patches through its first rays.
    bounced: Vec<Vec3>,
    /// The largest of them.
    brightest: f32,
    /// Radiance that leaves each patch, shifted by one: entry 0 is black.
    table: Vec<Vec4>,
    job: Option<Job>,
}

impl Lighting {
    /// Nothing is traced yet. `receivers` are instances of the world with their texels, `texel` the
    /// edge of a texel in metres.
    pub(crate) fn new(
        world: World,
        receivers: Vec<(u32, Arc<MeshTexels>)>,
        texel: f32,
        limits: Limits,
    ) -> Self {
        let mut world = world;
        // Taken over together with the lights.
        world.sky = Sky::default();
        let closed = world.instances().iter().map(|i| is_closed(&i.mesh)).collect();
        let mut patches = Patches::new(&world, receivers, texel * 2.0);
        let open = unbury(&world, &mut patches, texel);
        let fronts = patches.fronts;
        let mut lighting = Self {
            world,
            grids: Vec::new(),
            direct: Direct::default(),
            irradiance: vec![Vec3::ZERO; fronts],
            error: vec![0.0; fronts],
            plans: Vec::new(),
            traced: 0,
            settled: true,
            polishes: 0,
            limits,
            closed,
            near: texel * 0.5,
            blocks: Vec::new(),
            buried: vec![Buried::default(); fronts],
            valid: open.clone(),
            open,
            holes: Vec::new(),
            gathered: vec![Vec3::ZERO; fronts],
            spread: vec![0.0; fronts],
            refined: Refined::default(),
            held: Vec::new(),
            answered: false,
            soft_sky: Sky::default(),
            sky_table: SkyTable::default(),
            direct_sky: DirectSky::default(),
            arriving: Vec::new(),
            source: Vec3::ZERO,
            sky: Vec::new(),
            sky_halves: Vec::new(),
            sky_stale: true,
            bounced: Vec::new(),
            brightest: 0.0,
            table: Vec::new(),
            job: None,
            patches,
        };
        lighting.plan();
        lighting
    }

    /// Takes lights and sky of a scene over; ask for a [`solve`](Self::start) afterwards.
    pub(crate) fn set_lights(&mut self, scene: &Scene) {
        let mut changed = self.direct.set_lights(&scene.lights);
        self.world.lights = scene.lights.values().copied().collect();
        if self.world.sky != scene.sky {
            self.soft_sky = soft(&scene.sky, &self.world.sky, &self.soft_sky);
            self.sky_table = SkyTable::new(&self.soft_sky);
            self.world.sky = scene.sky.clone();
            self.sky_stale = true;
            changed = true;
        }
        if self.direct_sky != scene.direct_sky {
            self.direct_sky = scene.direct_sky;
            changed = true;
        }
        if changed {
            self.held.clear();
        }
    }

    /// Takes materials over; `false` where geometry changes by them.
    pub(crate) fn refresh_materials(&mut self, scene: &Scene) -> bool {
        let same = self.world.refresh_materials(scene);
        if same {
            self.held.clear();
            self.patches.refresh_materials(&self.world);
        }
        same
    }

    /// Begins with what an older state of the same lights knew about the same texels: bounces converge
    /// sooner, and what is shown does not become worse.
    pub(crate) fn start_from(&mut self, old: &mut Self) {
        self.bounced.resize(self.patches.len(), Vec3::ZERO);
        self.source = old.source;
        self.refined.model_error = old.refined.model_error;
        std::mem::swap(&mut self.direct, &mut old.direct);
        self.direct.invalidate();
        self.world.sky = old.world.sky.clone();
        self.soft_sky = old.soft_sky.clone();
        std::mem::swap(&mut self.sky_table, &mut old.sky_table);
        self.direct_sky = old.direct_sky;
        self.held.resize(self.patches.fronts, (Vec3::ZERO, f32::INFINITY));
        for receiver in &self.patches.receivers {
            let id = self.world.instances()[receiver.instance as usize].id;
            let same = old.patches.receivers.iter().find(|r| {
                old.world.instances()[r.instance as usize].id == id
                    && Arc::ptr_eq(&r.texels, &receiver.texels)
            });
            let Some(same) = same else { continue };
            for i in 0..receiver.texels.len() {
                let (to, from) = (receiver.first as usize + i, same.first as usize + i);
                if let Some(bounced) = old.bounced.get(from) {
                    self.bounced[to] = *bounced;
                    if old.valid[from] && old.answered {
                        self.held[to] = (old.irradiance[from], old.error[from]);
                    }
                }
            }
        }
    }

    /// Kept rays a texel that the next solution can use.
    pub(crate) fn kept_rays(&self) -> u32 {
        self.complete_blocks().map(|b| b.count).sum()
    }

    /// Rays a texel behind what is shown.
    pub(crate) fn rays(&self) -> u32 {
        self.kept_rays() + self.refined.rays
    }

    /// Whether there are kept rays enough for a first answer.
    pub(crate) fn is_ready(&self) -> bool {
        let done = |b: &Block| b.origins() >= self.patches.len();
        self.blocks.len() >= FIRST_BLOCKS
            && self.blocks[..FIRST_BLOCKS].iter().all(done)
            && self.grids.iter().all(|g| g.rays() > 0)
    }

    fn complete_blocks(&self) -> impl Iterator<Item = &Block> {
        self.blocks.iter().filter(|b| b.origins() >= self.patches.fronts)
    }

    /// Whether a solution is being worked on.
    pub(crate) fn is_solving(&self) -> bool {
        self.job.is_some()
    }

    /// Begins a solution for the lights as they are.
    pub(crate) fn start(&mut self) {
        self.polishes = 0;
        self.job = Some(Job::Direct);
    }

    /// Begins one that takes the bounces of the last one to their end.
    pub(crate) fn polish(&mut self) {
        self.polishes += 1;
        self.job = Some(Job::Direct);
    }

    /// Whether a texel that is shown lies free, not inside of other geometry.
    pub(crate) fn is_valid(&self, texel: usize) -> bool {
        self.valid[texel]
    }
}

/// The middle value; `None` of nothing.
pub(crate) fn median(values: &mut [f32]) -> Option<f32> {
    let middle = values.len() / 2;
    (!values.is_empty()).then(|| *values.select_nth_unstable_by(middle, f32::total_cmp).1)
}

pub(crate) fn luminance(c: Vec3) -> f32 {
    c.dot(Vec3::new(0.2126, 0.7152, 0.0722))
}
