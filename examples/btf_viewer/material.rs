//! The measured material: read in a thread, read again when its file changes, worn by the object.

use std::{
    collections::HashMap,
    path::Path,
    sync::Arc,
    time::{Duration, SystemTime},
};

use bevy::{
    prelude::*,
    tasks::{AsyncComputeTaskPool, Task, futures::check_ready},
    time::common_conditions::on_timer,
};
use farlight::prelude::*;
use farlight_btf_codec::{Btf, read};

use super::{
    config::Material,
    object::Surface,
    shown::{Evaluation, MaterialShown, Shown},
    state::{self, Config, Problems},
};

/// Metres a texel where neither file nor configuration says it.
const TEXEL: f32 = 0.0004;

/// A material's data.
#[derive(Default)]
struct Entry {
    reading: Option<Task<Result<Btf, String>>>,
    ready: Option<(Handle<BtfAsset>, About)>,
    problem: Option<String>,
    written: Option<SystemTime>,
}

/// What is told about a material.
#[derive(Clone, Debug, PartialEq)]
pub struct About {
    /// Texels along width and height.
    pub texels: [u32; 2],
    /// Bytes of its tables.
    pub bytes: usize,
    /// Metres of its picture, if the file says it.
    pub size: Option<[f32; 2]>,
    /// Seconds that reading took.
    pub seconds: f32,
}

/// All materials that were shown, by path.
#[derive(Resource, Default)]
pub struct Materials(HashMap<String, Entry>);

impl Materials {
    /// Whether something is being read.
    pub fn busy(&self) -> bool {
        self.0.values().any(|entry| entry.reading.is_some())
    }

    /// What is known of a material.
    pub fn about(&self, material: &Material) -> Option<&About> {
        let entry = self.0.get(&material.path)?;
        entry.ready.as_ref().map(|(_, about)| about)
    }
}

/// Systems, in their order.
pub fn plugin(app: &mut App) {
    app.init_resource::<Materials>().add_systems(
        Update,
        (watch.run_if(on_timer(Duration::from_secs(1))), (load, dress).chain()),
    );
}

/// Reads a file or a folder.
fn open(path: &Path) -> Result<Btf, String> {
    match read::open(path, &read::Options::default()) {
        Ok(read::Material::Tables(btf)) => Ok(btf),
        Ok(read::Material::Images(_)) => Err(format!(
            "{}: measured pictures; `farlight btf import` makes a material of them",
            path.display()
        )),
        Err(error) => Err(error.to_string()),
    }
}

fn begin(path: &str) -> Entry {
    let path = state::on_disk(path);
    let written = state::written(&path);
    let reading = AsyncComputeTaskPool::get().spawn(async move { open(&path) });
    Entry { reading: Some(reading), written, ..Entry::default() }
}

/// Reads materials again whose files have changed.
fn watch(mut materials: ResMut<Materials>) {
    for (path, entry) in &mut materials.0 {
        let written = state::written(&state::on_disk(path));
        if entry.reading.is_none() && written.is_some() && written != entry.written {
            let again = begin(path);
            (entry.reading, entry.written) = (again.reading, again.written);
        }
    }
}

/// Begins to read the chosen material and takes what is done.
fn load(
    time: Res<Time<Real>>,
    config: Res<Config>,
    shown: Res<Shown>,
    mut materials: ResMut<Materials>,
    mut assets: ResMut<Assets<BtfAsset>>,
    mut problems: ResMut<Problems>,
    mut since: Local<HashMap<String, f32>>,
) {
    let now = time.elapsed_secs();
    for (path, entry) in &mut materials.0 {
        let since = *since.entry(path.clone()).or_insert(now);
        let Some(result) = entry.reading.as_mut().and_then(check_ready) else { continue };
        entry.reading = None;
        match result {
            Ok(btf) => {
                let about = About {
                    texels: btf.size(),
                    bytes: size_of_val(btf.words()),
                    size: btf.info().size,
                    seconds: now - since,
                };
                info!("{path}: {about:?}");
                entry.problem = None;
                let handle = match &entry.ready {
                    Some((handle, _)) => {
                        let handle = handle.clone();
                        if let Err(error) = assets.insert(&handle, BtfAsset(Arc::new(btf))) {
                            entry.problem = Some(error.to_string());
                        }
                        handle
                    }
                    None => assets.add(BtfAsset(Arc::new(btf))),
                };
                entry.ready = Some((handle, about));
            }
            // What was read before stays.
            Err(message) => {
                error!("{message}");
                entry.problem = Some(message);
            }
        }
    }
    let Some(chosen) = config.0.materials.get(shown.material.choice) else { return };
    let entry = materials.0.entry(chosen.path.clone()).or_insert_with(|| begin(&chosen.path));
    if problems.material != entry.problem {
        problems.material.clone_from(&entry.problem);
    }
}

/// Width and height of the material's picture in metres.
pub fn size(material: &Material, about: &About) -> Vec2 {
    let texels = Vec2::from(about.texels.map(|n| n as f32));
    let told = about.size.map_or(texels * TEXEL, Vec2::from);
    material.size.map_or(told, Vec2::from)
}

/// Puts the material onto the object's surfaces, as soon as it is there.
fn dress(
    mut commands: Commands,
    config: Res<Config>,
    shown: Res<Shown>,
    materials: Res<Materials>,
    mut looks: ResMut<Assets<BtfMaterial>>,
    surfaces: Query<(Entity, &Surface, Option<&MeshMaterial3d<BtfMaterial>>)>,
) {
    let Some(chosen) = config.0.materials.get(shown.material.choice) else { return };
    let entry = materials.0.get(&chosen.path);
    let Some((btf, about)) = entry.and_then(|entry| entry.ready.as_ref()) else { return };
    for (entity, surface, worn) in &surfaces {
        let repeat = surface.uv_metres / (size(chosen, about) * shown.material.size);
        let look = look(&shown.material, btf, repeat, chosen.gain);
        let Some(worn) = worn else {
            commands
                .entity(entity)
                .remove::<MeshMaterial3d<StandardMaterial>>()
                .insert(MeshMaterial3d(looks.add(look)));
            continue;
        };
        let same = looks.get(worn).is_some_and(|old| {
            old.btf == look.btf
                && old.repeat == look.repeat
                && old.gain == look.gain
                && old.filter == look.filter
                && old.coarseness == look.coarseness
        });
        if !same && let Some(mut old) = looks.get_mut(worn) {
            *old = look;
        }
    }
}

/// The material as it is to be evaluated.
fn look(shown: &MaterialShown, btf: &Handle<BtfAsset>, repeat: Vec2, gain: f32) -> BtfMaterial {
    BtfMaterial {
        repeat,
        gain: gain * shown.gain,
        filter: match shown.evaluation {
            Evaluation::Nearest => BtfFilter::Nearest,
            Evaluation::Smooth | Evaluation::Full => BtfFilter::Bilinear,
        },
        coarseness: match shown.evaluation {
            Evaluation::Full if shown.halvings == 0.0 => BtfMaterial::WHOLE_PICTURE,
            _ => shown.halvings,
        },
        ..BtfMaterial::new(btf.clone())
    }
}
