//! The game's file of bindings, and the user's own changes that go over it.

use std::{
    collections::BTreeMap,
    fs, io,
    path::{Path, PathBuf},
};

use bevy::{
    asset::AssetLoadFailedEvent,
    prelude::*,
    tasks::{IoTaskPool, Task, futures::check_ready},
};
use farlight_bindings::{
    ActionBindings, ActionInfo, Bindings, Device, FileError, MAX_FILE, Preset, Sensitivity,
    Severity,
};
use ron::{Options, extensions::Extensions};
use serde::{Deserialize, de::IgnoredAny};

use crate::{
    ControlsInForce, ControlsStatus,
    file::{ControlsFile, ControlsFileError, parse},
    read::ActionEntities,
};

/// What the user has changed: fields that are set go over those of the game's file.
#[derive(Clone, Debug, Default, PartialEq)]
pub(crate) struct Changes {
    preset: Option<Preset>,
    invert_zoom: Option<bool>,
    invert_look: Option<bool>,
    sensitivity: Option<Sensitivity>,
    bindings: BTreeMap<String, ActionBindings>,
}

/// Which fields a file sets.
#[derive(Deserialize)]
#[serde(rename = "ControlsSettings", default)]
#[derive(Default)]
struct Fields {
    preset: Option<Preset>,
    invert_zoom: Option<bool>,
    invert_look: Option<bool>,
    sensitivity: Option<Sensitivity>,
    #[serde(rename = "bindings")]
    _bindings: Option<IgnoredAny>,
}

impl Changes {
    /// What makes `now` of `base`.
    fn between(base: &Bindings, now: &Bindings, actions: &[ActionInfo]) -> Self {
        fn changed<T: PartialEq + Clone>(base: &T, now: &T) -> Option<T> {
            (base != now).then(|| now.clone())
        }
        let mut bindings = BTreeMap::new();
        let with_preset = Bindings { preset: now.preset, ..base.clone() };
        for info in actions {
            let mut own = ActionBindings::default();
            for device in Device::ALL {
                let list = now.of(info.name, device);
                if list != with_preset.of(info.name, device) {
                    *own.own_mut(device) = Some(list);
                }
            }
            if own != ActionBindings::default() {
                bindings.insert(info.name.to_owned(), own);
            }
        }
        Self {
            preset: changed(&base.preset, &now.preset),
            invert_zoom: changed(&base.invert_zoom, &now.invert_zoom),
            invert_look: changed(&base.invert_look, &now.invert_look),
            sensitivity: changed(&base.sensitivity, &now.sensitivity),
            bindings,
        }
    }

    /// `base` with these changes.
    fn over(&self, base: &Bindings) -> Bindings {
        let mut all = base.clone();
        all.preset = self.preset.unwrap_or(all.preset);
        all.invert_zoom = self.invert_zoom.unwrap_or(all.invert_zoom);
        all.invert_look = self.invert_look.unwrap_or(all.invert_look);
        all.sensitivity = self.sensitivity.unwrap_or(all.sensitivity);
        for (name, own) in &self.bindings {
            for device in Device::ALL {
                if let Some(list) = own.own(device) {
                    all.set(name, device, list.clone());
                }
            }
        }
        all
    }

    fn read(file: &ControlsFile) -> Result<Self, ControlsFileError> {
        let options = Options::default().with_default_extension(Extensions::IMPLICIT_SOME);
        let fields: Fields = options.from_str(&file.text).map_err(|error| {
            let error = FileError::new(&file.text, &error);
            ControlsFileError::Text { file: file.file.clone(), error }
        })?;
        let Fields { preset, invert_zoom, invert_look, sensitivity, .. } = fields;
        // Somebody may have written it who says more shortly what we say device by device.
        let mut bindings = BTreeMap::new();
        for name in file.bindings.bindings.keys().chain(&file.bindings.unused) {
            let mut own = ActionBindings::default();
            for device in Device::ALL {
                let chosen = file.bindings.chosen(name, device).cloned();
                let none = file.bindings.is_unused(name).then(Vec::new);
                *own.own_mut(device) = chosen.or(none);
            }
            bindings.insert(name.clone(), own);
        }
        Ok(Self { preset, invert_zoom, invert_look, sensitivity, bindings })
    }

    fn write(&self) -> Result<String, String> {
        let mut text = String::from(
            "// Your own controls: they go over those of the game. Written by the game; remove the file to\n\
             // have everything as it was.\nControlsSettings(\n",
        );
        let mut line = |name: &str, value: Option<String>| {
            if let Some(value) = value {
                text += &format!("    {name}: {value},\n");
            }
        };
        line("preset", self.preset.map(|preset| format!("{preset:?}")));
        line("invert_zoom", self.invert_zoom.map(|on| on.to_string()));
        line("invert_look", self.invert_look.map(|on| on.to_string()));
        line("sensitivity", self.sensitivity.map(|factor| format!("{:?}", factor.0)));
        let pretty = ron::ser::PrettyConfig::new().depth_limit(3);
        let bindings = ron::ser::to_string_pretty(&self.bindings, pretty);
        let bindings = bindings.map_err(|error| error.to_string())?;
        line("bindings", Some(bindings.replace('\n', "\n    ")));
        text += ")\n";
        // What can't be read again must not be written.
        match Bindings::from_ron(&text) {
            Ok(_) => Ok(text),
            Err(error) => Err(error.to_string()),
        }
    }
}

/// Where bindings come from.
#[derive(Resource, Default)]
pub(crate) struct Layers {
    handle: Option<Handle<ControlsFile>>,
    /// The game's file, or the defaults.
    base: Bindings,
    /// What the user has changed, as it was last applied.
    user: Changes,
    path: Option<PathBuf>,
    /// It has to be written.
    save: bool,
    saving: Option<Task<Result<(), String>>>,
    /// What is wrong with the game's file, with the user's.
    problems: [Vec<String>; 2],
}

impl Layers {
    /// Writes the user's changes, soon.
    pub(crate) fn save(&mut self) {
        self.save = true;
    }

    /// Whether something is being written, or has to be.
    pub(crate) fn is_saving(&self) -> bool {
        self.save || self.saving.is_some()
    }

    /// What counts where the user has changed nothing.
    pub(crate) fn base(&self) -> &Bindings {
        &self.base
    }
}

/// Starts to load the game's file and reads the user's.
pub(crate) fn open(world: &mut World, file: Option<&str>, user_file: Option<PathBuf>) {
    let mut layers = Layers { path: user_file.clone(), ..default() };
    if let Some(file) = file {
        match world.get_resource::<AssetServer>() {
            Some(server) => layers.handle = Some(server.load(file.to_owned())),
            None => warn!("{file}: controls are not loaded, the app has no AssetPlugin"),
        }
    }
    let mut in_force = world.get_resource_or_init::<ControlsInForce>();
    if let Some(path) = &user_file {
        match read_user(path) {
            Ok(changes) => layers.user = changes,
            Err(problem) => {
                warn!("{problem}");
                layers.problems[1] = vec![problem];
            }
        }
        if layers.user != Changes::default() {
            in_force.bindings = layers.user.over(&in_force.bindings);
        }
    }
    let mut status = world.get_resource_or_init::<ControlsStatus>();
    status.problems = layers.problems.concat();
    status.user_file = user_file;
    world.insert_resource(layers);
}

/// Reads the user's file. One that is damaged is put aside, not lost.
fn read_user(path: &Path) -> Result<Changes, String> {
    let name = path.display().to_string();
    let long = fs::metadata(path).is_ok_and(|data| data.len() > MAX_FILE as u64);
    let bytes = match fs::read(path) {
        _ if long => Vec::from("// too long"),
        Ok(bytes) => bytes,
        Err(error) if error.kind() == io::ErrorKind::NotFound => return Ok(Changes::default()),
        Err(error) => return Err(format!("{name}: {error}")),
    };
    parse(&name, bytes).and_then(|file| Changes::read(&file)).map_err(|error| {
        let mut aside = path.as_os_str().to_owned();
        aside.push(".damaged");
        match fs::rename(path, &aside) {
            Ok(()) => format!("{error}; it is kept as {}", Path::new(&aside).display()),
            Err(_) => error.to_string(),
        }
    })
}

/// Writes a file so that there is always a whole one.
fn write_user(path: &Path, text: &str) -> Result<(), String> {
    let write = || {
        if let Some(folder) = path.parent() {
            fs::create_dir_all(folder)?;
        }
        let mut new = path.as_os_str().to_owned();
        new.push(format!(".{}.new", std::process::id()));
        fs::write(&new, text)?;
        fs::rename(&new, path)
    };
    write().map_err(|error: io::Error| format!("{}: {error}", path.display()))
}

/// Where the user's file of this program is by default: in the folder for configuration.
pub(crate) fn default_user_file() -> Option<PathBuf> {
    let program = std::env::current_exe().ok()?;
    Some(dirs::config_dir()?.join(program.file_stem()?).join("controls.ron"))
}

/// Applies the game's file when it has been loaded or has changed.
pub(crate) fn follow_file(
    mut events: MessageReader<AssetEvent<ControlsFile>>,
    mut failures: MessageReader<AssetLoadFailedEvent<ControlsFile>>,
    files: Res<Assets<ControlsFile>>,
    entities: Res<ActionEntities>,
    mut layers: ResMut<Layers>,
    mut in_force: ResMut<ControlsInForce>,
    mut status: ResMut<ControlsStatus>,
) {
    let Some(handle) = layers.handle.as_ref().map(Handle::id) else { return };
    // The asset server has logged it.
    if let Some(failure) = failures.read().filter(|failure| failure.id == handle).last() {
        layers.problems[0] = vec![failure.error.to_string()];
        status.problems = layers.problems.concat();
    }
    let loaded = events.read().any(|event| {
        matches!(event, AssetEvent::Added { id } | AssetEvent::Modified { id } if *id == handle)
    });
    let Some(file) = files.get(handle).filter(|_| loaded) else { return };
    let actions: Vec<_> = entities.all.iter().map(|action| action.info).collect();
    let mut told = Vec::new();
    let mut refused = false;
    for problem in file.bindings.check(&actions) {
        let place = problem.place(&file.text);
        let place = place.map(|(line, column)| format!(":{line}:{column}")).unwrap_or_default();
        let text = format!("{}{place}: {problem}", file.file);
        match problem.severity {
            Severity::Error => {
                refused = true;
                error!("{text}");
            }
            Severity::Warning => warn!("{text}"),
            Severity::Note => continue,
        }
        told.push(text);
    }
    if refused {
        told.push(format!("{}: the bindings before stay in force", file.file));
    } else if file.bindings != layers.base {
        layers.user = Changes::between(&layers.base, &in_force.bindings, &actions);
        layers.base = file.bindings.clone();
        in_force.bindings = layers.user.over(&layers.base);
        info!("{}: controls loaded", file.file);
    }
    layers.problems[0] = told;
    status.problems = layers.problems.concat();
}

/// Names conflicts, after bindings have changed.
pub(crate) fn check(
    in_force: Res<ControlsInForce>,
    entities: Res<ActionEntities>,
    mut status: ResMut<ControlsStatus>,
) {
    let infos = entities.all.iter().map(|action| action.info);
    status.added = infos.filter(|info| farlight_bindings::action(info.name).is_none()).collect();
    let mut conflicts = Vec::new();
    for device in Device::ALL {
        conflicts.extend(in_force.bindings.conflicts(device, &status.added));
    }
    for conflict in conflicts.iter().filter(|conflict| !status.conflicts.contains(conflict)) {
        warn!("controls: {conflict}");
    }
    status.conflicts = conflicts;
    status.revision += 1;
}

/// Writes the user's file outside of frames.
pub(crate) fn save(
    mut layers: ResMut<Layers>,
    in_force: Res<ControlsInForce>,
    entities: Res<ActionEntities>,
    mut status: ResMut<ControlsStatus>,
) {
    if let Some(task) = &mut layers.saving {
        let Some(result) = check_ready(task) else { return };
        layers.saving = None;
        layers.problems[1] = result.err().into_iter().collect();
        for problem in &layers.problems[1] {
            warn!("controls are not saved: {problem}");
        }
        status.problems = layers.problems.concat();
    }
    if !layers.save {
        return;
    }
    layers.save = false;
    let Some(path) = layers.path.clone() else { return };
    let actions: Vec<_> = entities.all.iter().map(|action| action.info).collect();
    let text = Changes::between(&layers.base, &in_force.bindings, &actions).write();
    layers.saving = Some(IoTaskPool::get().spawn(async move { write_user(&path, &text?) }));
}

#[cfg(test)]
mod tests {
    use farlight_bindings::ACTIONS;

    use super::*;

    fn bindings(text: &str) -> Bindings {
        Bindings::from_ron(text).unwrap()
    }

    #[test]
    fn changes_come_back_as_they_were() {
        let base = bindings(
            "ControlsSettings(invert_zoom: true, bindings: {\"menu\": (keyboard_mouse: [\"F2\"])})",
        );
        let mut now = base.clone();
        now.invert_zoom = false;
        now.sensitivity = Sensitivity(1.5);
        now.set("menu", Device::KeyboardMouse, vec!["KeyM".parse().unwrap()]);
        now.set("orbit", Device::Gamepad, vec!["RightStick".parse().unwrap()]);
        now.set("quit", Device::Gamepad, Vec::new());
        let changes = Changes::between(&base, &now, ACTIONS);
        let text = changes.write().unwrap();
        let file = parse("user", text.clone().into_bytes()).unwrap();
        assert_eq!(Changes::read(&file).unwrap(), changes, "{text}");
        let again = changes.over(&base);
        for info in ACTIONS {
            for device in Device::ALL {
                assert_eq!(again.of(info.name, device), now.of(info.name, device), "{info}");
            }
        }
        assert_eq!((again.invert_zoom, again.sensitivity), (false, Sensitivity(1.5)));
        // What the user left alone follows the game's file.
        let other = bindings("ControlsSettings(invert_look: true)");
        assert!(changes.over(&other).invert_look);
        assert_eq!(Changes::between(&base, &base, ACTIONS), Changes::default());
    }

    #[test]
    fn a_file_by_hand_may_speak_of_all_devices() {
        let text =
            "ControlsSettings(unused: [\"pan\"], bindings: {\"menu\": (xr: [\"Left.Menu\"])})";
        let file = parse("user", text.into()).unwrap();
        let now = Changes::read(&file).unwrap().over(&Bindings::default());
        for device in Device::ALL {
            assert_eq!(now.of("pan", device), [], "{device}");
            let menu = match device {
                Device::Xr(_) => bindings(text).of("menu", device),
                _ => Bindings::default().of("menu", device),
            };
            assert_eq!(now.of("menu", device), menu, "{device}");
        }
    }

    #[test]
    fn a_damaged_file_is_put_aside() {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("controls.ron");
        assert_eq!(read_user(&path), Ok(Changes::default()));
        fs::write(&path, "ControlsSettings(\n  invert_zom: true,\n)").unwrap();
        let problem = read_user(&path).unwrap_err();
        assert!(problem.contains("controls.ron:2:") && problem.contains(".damaged"), "{problem}");
        assert!(!path.exists() && folder.path().join("controls.ron.damaged").exists());
        let text = Changes { invert_zoom: Some(true), ..default() }.write().unwrap();
        write_user(&folder.path().join("new/controls.ron"), &text).unwrap();
        let read = read_user(&folder.path().join("new/controls.ron")).unwrap();
        assert_eq!(read.invert_zoom, Some(true));
    }
}
