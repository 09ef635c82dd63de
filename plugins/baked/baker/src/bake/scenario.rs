//! The light of one scenario.

use std::{
    cell::OnceCell,
    time::{Duration, Instant},
};

use farlight_baked_format::{
    Fingerprint, exr, ktx2,
    manifest::{self, Direct, Page},
    name,
};
use farlight_gi_solver::{
    Scene, World,
    bake::{DirectLight, Gathered, Gatherer, GathererSettings, denoise, direct, pages, volume},
    scene::{DirectSky, LightKind},
    session::ProbeGrid,
    sh::ShRgb,
};
use glam::Vec3;

use super::{
    geometry::{Rest, stopped},
    kind,
    plan::Plan,
};
use crate::{
    BakeError, BakeOptions, Effort,
    observer::{Stage, Work},
    store::{Cache, Folder, Key, Record},
};

/// Rays of a pass, over all texels: a few seconds of work at most, so that stopping loses little.
const PASS: usize = 8_000_000;

/// Gives what gathers light: it is made when it is first needed, for some changes (which files are written, whether
/// noise is filtered) need no new light. `None` if it was stopped.
type Prepare<'a, 'g> = &'a dyn Fn() -> Option<&'g Gatherer<'g>>;

/// What the light of one scenario is made from.
pub(super) struct Scenario<'a> {
    pub(super) options: &'a BakeOptions,
    pub(super) plan: &'a Plan,
    pub(super) geometry: &'a Rest,
    pub(super) folder: &'a Folder,
    pub(super) cache: &'a Cache<'a>,
    pub(super) work: &'a Work<'a>,
}

/// A scenario that was baked, now or before.
pub(super) struct Baked {
    pub(super) scenario: manifest::Scenario,
    /// Whether it has all the rays that were asked for.
    pub(super) complete: bool,
    /// Whether an earlier bake made it.
    pub(super) recalled: bool,
}

/// When a bake with a time limit has to be at which point.
pub(super) struct Deadline {
    end: Option<Instant>,
    /// What each scenario needs after its last pass.
    after: Duration,
}

impl Deadline {
    pub(super) fn new(options: &BakeOptions, work: &Work<'_>, texels: usize) -> Self {
        let Effort::Time(time) = options.effort else {
            return Self { end: None, after: Duration::ZERO };
        };
        // Measured on two cores; this machine may be slower, or busy.
        let seconds = texels as f64 * if options.denoise { 3.4e-5 } else { 4e-6 };
        let seconds = 0.1 + seconds * 2.0 / rayon::current_num_threads() as f64;
        let after = Duration::from_secs_f64(seconds * work.pace());
        Self { end: Some(work.start + time), after }
    }

    /// When the passes of the next of `left` scenarios must end.
    pub(super) fn share(&self, left: u32) -> Option<Instant> {
        let now = Instant::now();
        let end = self.end?;
        let rest = end.saturating_duration_since(now) / left.max(1);
        Some(now + rest.saturating_sub(self.after))
    }
}

impl Scenario<'_> {
    /// Bakes, or takes what is there. `None` if it was stopped before there was any light.
    pub(super) fn bake(
        &self,
        world: &mut World,
        scene: &Scene,
        end: Option<Instant>,
    ) -> Result<Option<Baked>, BakeError> {
        if let Some(baked) = self.recall() {
            return Ok(Some(baked));
        }
        self.light(world, scene);
        let Some(direct) = self.direct(world) else { return Ok(None) };
        let layout = &self.geometry.layout;
        let settings = GathererSettings {
            seed: self.options.seed,
            bounces: self.options.bounces,
            direct_sky: DirectSky::Included,
        };
        let prepared = OnceCell::new();
        let prepare = || {
            let gatherer = prepared.get_or_init(|| {
                let running = self.work.begin(Stage::Exchange, &self.plan.name, 0);
                Gatherer::new(world, layout, settings, &|_| running.tick(0))
            });
            gatherer.as_ref()
        };
        let Some(volumes) = self.volumes(world, &prepare)? else { return Ok(None) };
        let (gathered, complete) = self.gather(&prepare, end);
        if gathered.rays == 0 {
            return Ok(None);
        }
        if self.work.outdated() {
            return Err(stopped(self.work));
        }
        let relative_error = gathered.relative_error(layout);
        let pages = self.pages(&gathered, &direct)?;
        let record = Record { pages, volumes, rays: gathered.rays, relative_error };
        self.cache.set_record(kind::LAST, self.last_key(), &record);
        if complete {
            self.cache.set_record(kind::DONE, self.done_key(), &record);
        }
        Ok(Some(Baked { scenario: self.entry(&record), complete, recalled: false }))
    }

    /// What an earlier bake made from the same inputs with the same effort, if it is there.
    pub(super) fn recall(&self) -> Option<Baked> {
        self.recorded(kind::DONE, self.done_key(), true)
    }

    /// What the last bake made from the same inputs with another effort, if it is there.
    pub(super) fn last(&self) -> Option<Baked> {
        self.recorded(kind::LAST, self.last_key(), false)
    }

    fn recorded(&self, kind: &str, key: Fingerprint, complete: bool) -> Option<Baked> {
        self.keep();
        let record = self.cache.record(kind, key)?;
        let each = if self.options.exr { 2 } else { 1 };
        let whole = record.pages.len() == each * self.geometry.layout.page_count as usize
            && record.volumes.len() == self.geometry.volumes.len()
            && record.pages.iter().chain(&record.volumes).all(|file| self.folder.is_intact(file));
        whole.then(|| Baked { scenario: self.entry(&record), complete, recalled: true })
    }

    /// Keeps what a later bake can go on from.
    fn keep(&self) {
        self.cache.keep(kind::GATHER, self.gather_key());
        self.cache.keep(kind::DIRECT, self.direct_key());
        self.cache.keep(kind::LAST, self.last_key());
        for grid in &self.geometry.volumes {
            self.cache.keep(kind::PROBES, self.probes_key(grid));
        }
    }

    /// Puts this scenario's lights, sky and emission into the world.
    fn light(&self, world: &mut World, scene: &Scene) {
        let mut scene = scene.clone();
        for (id, emission) in &self.plan.emission {
            if let Some(material) = scene.materials.get_mut(id) {
                material.emissive = *emission;
            }
        }
        // Materials keep their kind of alpha, so instances neither come nor go.
        let _ = world.refresh_materials(&scene);
        world.lights = self.plan.lights.iter().map(|light| light.light).collect();
        world.sky = self.plan.sky.clone();
    }

    fn gather_key(&self) -> Fingerprint {
        let mut key = Key::new("gather");
        key.print(self.geometry.print).number(self.options.seed).number(self.options.bounces);
        self.plan.hash(&mut key);
        key.finish()
    }

    fn direct_key(&self) -> Fingerprint {
        let mut key = Key::new("direct");
        key.print(self.geometry.print);
        self.plan.hash_direct(&mut key);
        key.finish()
    }

    /// Of everything but the effort.
    fn last_key(&self) -> Fingerprint {
        let mut key = Key::new("last");
        key.print(self.gather_key()).print(self.direct_key()).text(&self.plan.name);
        key.number(self.options.denoise).number(self.options.exr);
        for grid in &self.geometry.volumes {
            hash_grid(grid, &mut key);
        }
        key.finish()
    }

    fn done_key(&self) -> Fingerprint {
        let mut key = Key::new("done");
        key.print(self.last_key());
        match self.options.effort {
            Effort::Rays(rays) => key.number(rays),
            Effort::Time(time) => key.text("time").number(time.as_millis() as u64),
        };
        key.finish()
    }

    fn probes_key(&self, grid: &ProbeGrid) -> Fingerprint {
        let mut key = Key::new("probes");
        key.print(self.gather_key()).text(&self.plan.name);
        hash_grid(grid, &mut key);
        key.number(self.options.effort.probe_paths()).finish()
    }

    /// Direct light of the texels, of those lights that the lightmap shows. `None` if stopped.
    fn direct(&self, world: &World) -> Option<Vec<Vec3>> {
        let layout = &self.geometry.layout;
        let lights: Vec<DirectLight> = self
            .plan
            .lights
            .iter()
            .filter(|light| light.direct == Direct::Baked)
            .map(|light| DirectLight { light: light.light, radius: light.radius })
            .collect();
        if lights.is_empty() {
            return Some(vec![Vec3::ZERO; layout.len()]);
        }
        let key = self.direct_key();
        let running = self.work.begin(Stage::Direct, &self.plan.name, layout.len() as u64);
        if let Some(kept) = self.cache.load(kind::DIRECT, key).and_then(|bytes| vectors(&bytes))
            && kept.len() == layout.len()
        {
            return Some(kept);
        }
        let light = direct(world, layout, &lights, &|texels| running.tick(texels))?;
        self.cache.store(kind::DIRECT, key, &bytes_of(&light));
        Some(light)
    }

    /// Gather passes until there are enough, or the time is up, or somebody stops the work. Returns also
    /// whether there are enough.
    fn gather<'g>(&self, prepare: Prepare<'_, 'g>, end: Option<Instant>) -> (Gathered, bool) {
        let layout = &self.geometry.layout;
        let most = self.options.effort.most_rays();
        let key = self.gather_key();
        let mut gathered = self
            .cache
            .load(kind::GATHER, key)
            .and_then(|bytes| Gathered::from_bytes(layout, &bytes).ok())
            .unwrap_or_else(|| Gathered::new(layout));
        let gatherer = if gathered.rays < most { prepare() } else { None };
        let texels = layout.len() as u64;
        let mut running = self.work.begin(Stage::Gather, &self.plan.name, texels * u64::from(most));
        if gathered.rays > 0 {
            running.skip(texels * u64::from(gathered.rays));
        }
        if let Some(end) = end {
            running.until(end);
        }
        // The same steps whenever it begins: so the sums are the same, too.
        let step = pass_size(layout.len());
        let (mut saved, mut saved_rays) = (Instant::now(), gathered.rays);
        let mut longest = Duration::ZERO;
        while gathered.rays < most
            && let Some(gatherer) = gatherer
        {
            let start = Instant::now();
            if end.is_some_and(|end| start + longest > end) && gathered.rays > 0 {
                break;
            }
            let rays = step.min(most - gathered.rays);
            if gatherer.pass(&mut gathered, rays, &|rays| running.tick(rays)).is_none() {
                break;
            }
            longest = longest.max(start.elapsed());
            if saved.elapsed() >= self.options.save_every {
                self.cache.store(kind::GATHER, key, &gathered.to_bytes());
                (saved, saved_rays) = (Instant::now(), gathered.rays);
            }
        }
        if gathered.rays != saved_rays {
            self.cache.store(kind::GATHER, key, &gathered.to_bytes());
        }
        let complete = gathered.rays >= most || (end.is_some() && !self.work.stopped());
        (gathered, complete)
    }

    /// Filters noise and writes the pages. Returns the names of the files.
    fn pages(&self, gathered: &Gathered, direct: &[Vec3]) -> Result<Vec<String>, BakeError> {
        let layout = &self.geometry.layout;
        let mut light: Vec<Vec3> = if self.options.denoise {
            let _running = self.work.begin(Stage::Denoise, &self.plan.name, 0);
            denoise(layout, gathered)
        } else {
            (0..layout.len()).map(|i| gathered.irradiance(i)).collect()
        };
        for (light, direct) in light.iter_mut().zip(direct) {
            *light += *direct;
        }
        let pages = pages(layout, &light);
        let running = self.work.begin(Stage::Write, &self.plan.name, pages.len() as u64);
        let size = layout.page_size;
        let mut files = Vec::new();
        for (i, page) in pages.iter().enumerate() {
            let part = format!("{}.{i}", name::part(&self.plan.name));
            files.push(self.folder.add(&part, "ktx2", &ktx2::lightmap_page(size, size, page))?);
            if self.options.exr {
                let picture = exr::write(size, size, page).map_err(|error| BakeError::Io {
                    path: self.folder.at(&part),
                    doing: "encoded",
                    source: std::io::Error::other(error),
                })?;
                files.push(self.folder.add(&part, "exr", &picture)?);
            }
            let _ = running.tick(1);
        }
        Ok(files)
    }

    /// Gathers and writes the probes. `None` if stopped.
    fn volumes<'g>(
        &self,
        world: &World,
        prepare: Prepare<'_, 'g>,
    ) -> Result<Option<Vec<String>>, BakeError> {
        let mut names = Vec::new();
        for (i, grid) in self.geometry.volumes.iter().enumerate() {
            let key = self.probes_key(grid);
            let known = self.cache.record(kind::PROBES, key).and_then(|record| {
                let file = record.volumes.first()?.clone();
                self.folder.is_intact(&file).then_some(file)
            });
            if let Some(file) = known {
                names.push(file);
                continue;
            }
            let paths = self.options.effort.probe_paths();
            let all = u64::from(grid.resolution.element_product()) * u64::from(paths);
            let Some(gatherer) = prepare() else { return Ok(None) };
            let running = self.work.begin(Stage::Probes, &self.plan.name, all);
            let light = volume(world, gatherer, grid, paths, &|paths| running.tick(paths));
            let Some(light) = light else { return Ok(None) };
            let cubes: Vec<[Vec3; 6]> = light.iter().map(ShRgb::ambient_cube).collect();
            let part = format!("{}.volume{i}", name::part(&self.plan.name));
            let file = self.folder.add(&part, "ktx2", &ktx2::volume(grid.resolution, &cubes))?;
            let record = Record { volumes: vec![file.clone()], ..Record::default() };
            self.cache.set_record(kind::PROBES, key, &record);
            names.push(file);
        }
        Ok(Some(names))
    }

    /// The scenario in the manifest.
    fn entry(&self, record: &Record) -> manifest::Scenario {
        let pages = match self.options.exr {
            true => record
                .pages
                .chunks_exact(2)
                .map(|pair| Page { ktx2: pair[0].clone(), exr: pair[1].clone() })
                .collect(),
            false => record
                .pages
                .iter()
                .map(|file| Page { ktx2: file.clone(), exr: String::new() })
                .collect(),
        };
        let lights = self.plan.lights.iter().map(|planned| {
            let light = &planned.light;
            let directional = light.kind == LightKind::Directional;
            let position = if directional { Vec3::ZERO } else { light.position };
            let direction =
                if light.kind == LightKind::Point { Vec3::ZERO } else { light.direction };
            manifest::Light {
                node: planned.node,
                name: planned.name.clone(),
                direct: planned.direct,
                kind: match light.kind {
                    LightKind::Point => manifest::LightKind::Point,
                    LightKind::Directional => manifest::LightKind::Directional,
                    LightKind::Spot { inner_angle, outer_angle } => {
                        manifest::LightKind::Spot { inner: inner_angle, outer: outer_angle }
                    }
                },
                position: position.into(),
                direction: direction.into(),
                intensity: light.intensity.into(),
                range: if directional || !light.range.is_finite() { 0.0 } else { light.range },
                radius: planned.radius,
            }
        });
        manifest::Scenario {
            name: self.plan.name.clone(),
            pages,
            volumes: record.volumes.clone(),
            lights: lights.collect(),
            sky: self.plan.constant_sky().into(),
            samples: record.rays,
            relative_error: record.relative_error,
        }
    }
}

fn hash_grid(grid: &ProbeGrid, key: &mut Key) {
    key.floats(&grid.transform.to_cols_array());
    for n in grid.resolution.to_array() {
        key.number(n);
    }
}

/// Rays a texel of a pass: a power of two, so that each pass is a whole set of directions.
fn pass_size(texels: usize) -> u32 {
    let rays = (PASS / texels.max(1)).clamp(8, 64) as u32;
    1 << rays.ilog2()
}

fn bytes_of(vectors: &[Vec3]) -> Vec<u8> {
    vectors.iter().flat_map(|v| v.to_array()).flat_map(f32::to_le_bytes).collect()
}

fn vectors(bytes: &[u8]) -> Option<Vec<Vec3>> {
    let (chunks, rest) = bytes.as_chunks::<12>();
    let float = |b: &[u8]| f32::from_le_bytes([b[0], b[1], b[2], b[3]]);
    let vectors: Vec<Vec3> =
        chunks.iter().map(|c| Vec3::new(float(&c[..4]), float(&c[4..8]), float(&c[8..]))).collect();
    (rest.is_empty() && vectors.iter().all(|v| v.is_finite())).then_some(vectors)
}
