//! The configuration file.

use bevy::{asset::Asset, prelude::*, reflect::TypePath};
use farlight::core::{FieldProblem, RonSettings};
use serde::Deserialize;

#[path = "config_defaults.rs"]
mod defaults;

/// What is shown, how, and where pictures go: `assets/config/btf_viewer.ron`. Every field may be left
/// out; an unknown one is an error. Paths are relative to the folder `assets`, or absolute.
///
/// What the configuration of the thesis's viewer (Schiller 2022, appendix C) has and this one has under
/// another name, or does not need:
///
/// | there | here |
/// |---|---|
/// | `cu-threads-per-block`, `ocl-threads-per-block`, `ocl-kernels-path` | nothing to set: a material is decoded in the fragment shader, on every graphics API |
/// | `btf-cubemap-folder` | nothing: angles are computed, not looked up |
/// | `use-vr` | `xr.mode`, and no need for it: a headset that is there is used |
/// | `use-vr-native-res`, `vr-fb-width`, `vr-fb-height` | `xr.resolution_scale`: the headset knows its own size |
/// | `fb-width`, `fb-height` | `window` |
/// | `fb-min-scale-factor`, `fb-max-scale-factor` | `resolution` |
/// | `envmap-exposure` | `brightness` of an environment |
#[derive(Asset, TypePath, Clone, Debug, PartialEq, Deserialize)]
#[serde(default, deny_unknown_fields)]
pub struct Viewer {
    /// Width and height of the window in logical pixels, 64 to 16384. Read at the start.
    pub window: (u32, u32),
    /// How finely the window's picture is drawn.
    pub resolution: Resolution,
    /// What is behind the object where no environment is shown: sRGB, 0 to 255 each.
    pub background: (u8, u8, u8),
    /// Where the camera stands at the start.
    pub camera: CameraPlace,
    /// The folder for screenshots, relative to where the program was started.
    pub screenshots: String,
    /// Factor on the size of all objects, 0.01 to 100. At 1 an object is about two metres large: it
    /// fits an upright cylinder of radius 1.3 and height 1.9.
    pub base_scale: f32,
    /// Moves all objects, metres.
    pub base_offset: (f32, f32, f32),
    /// Objects to choose from, at least one.
    pub models: Vec<Model>,
    /// Materials to choose from.
    pub materials: Vec<Material>,
    /// Environments to choose from; "none" comes by itself.
    pub environments: Vec<Environment>,
    /// How environments give their light.
    pub progressive: Progressive,
    /// Lamps.
    pub light: Light,
    /// Exposure value at ISO 100, -10 to 25; one more is half as bright.
    pub exposure: f32,
    /// Bindings of keys, gamepads and controllers: a file of `ControlsSettings`. Empty is the suite's
    /// own. What a person binds in the panel goes over it.
    pub controls: String,
    /// Headsets. Read at the start.
    pub xr: Headset,
    /// What is shown first.
    pub start: Start,
}

/// Headsets, by OpenXR.
#[derive(Clone, Copy, Debug, PartialEq, Deserialize)]
#[serde(default, deny_unknown_fields)]
pub struct Headset {
    /// Whether one is used.
    pub mode: HeadsetMode,
    /// Pixels along each edge of an eye's picture, as a part of what the headset asks for, 0.25 to 2.
    pub resolution_scale: f32,
    /// Height of the object's middle above the floor in metres, 0 to 5.
    pub height: f32,
    /// Metres from where you stand to the object's middle, 0 to 10.
    pub distance: f32,
    /// How large objects are: metres, of the height of the cylinder that they fit, 0.01 to 10.
    /// `None` is life size, where a unit of the file is a metre.
    pub size: Option<f32>,
}

/// Whether a headset is used.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Deserialize)]
pub enum HeadsetMode {
    /// If there is one.
    #[default]
    Auto,
    /// Without one the program ends and says why.
    On,
    /// Never.
    Off,
}

/// Pixels drawn for a pixel of the window, along each edge: 0.1 to 4. Like everything it can be changed
/// by keys, between least and greatest.
#[derive(Clone, Copy, Debug, PartialEq, Deserialize)]
#[serde(default, deny_unknown_fields)]
pub struct Resolution {
    /// The coarsest.
    pub least: f32,
    /// At the start.
    pub scale: f32,
    /// The finest; above 1 the picture is smoothed.
    pub greatest: f32,
}

/// Where a camera stands.
#[derive(Clone, Copy, Debug, PartialEq, Deserialize)]
#[serde(default, deny_unknown_fields)]
pub struct CameraPlace {
    /// Metres from the object's middle; the object faces +z.
    pub position: (f32, f32, f32),
    /// Vertical field of view in degrees, 1 to 150.
    pub field_of_view: f32,
}

/// An object.
#[derive(Clone, Debug, PartialEq, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Model {
    /// What it is called on screen and on the command line.
    pub name: String,
    /// Its form.
    pub shape: Shape,
    /// How many metres of surface one unit of the first UV set is, more than 0: cloth keeps its size.
    /// Without effect on sphere and plane, which know.
    #[serde(default = "one")]
    pub uv_metres: f32,
    /// Turn about the vertical axis in degrees.
    #[serde(default)]
    pub turn: f32,
}

/// The form of an object.
#[derive(Clone, Debug, PartialEq, Deserialize)]
#[serde(deny_unknown_fields)]
pub enum Shape {
    /// A ball of 20 cm.
    Sphere,
    /// A flat square of 20 cm, upright, facing +z.
    Plane,
    /// A glTF file. Surfaces with a material named `btf` show the measured material; if there are
    /// none, all do.
    File(String),
}

/// A measured material.
#[derive(Clone, Debug, PartialEq, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Material {
    /// What it is called on screen and on the command line.
    pub name: String,
    /// A `.fbtf` file, a BTFbase binary or a BTFbase folder.
    pub path: String,
    /// Width and height of its picture in metres, more than 0. By default what the file says, or
    /// 0.4 mm a texel.
    #[serde(default)]
    pub size: Option<(f32, f32)>,
    /// Factor on the reflected light, 0 to 100.
    #[serde(default = "one")]
    pub gain: f32,
}

/// A picture of the light round the object.
#[derive(Clone, Debug, PartialEq, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Environment {
    /// What it is called on screen and on the command line.
    pub name: String,
    /// An equirectangular picture, an angular map or a cube map: `.hdr`, `.exr`, `.ktx2`.
    pub path: String,
    /// How many cd/m² a value of 1 is, 0 to 1 million.
    #[serde(default = "thousand")]
    pub brightness: f32,
    /// Turn about the vertical axis in degrees.
    #[serde(default)]
    pub turn: f32,
}

/// How environments give their light.
#[derive(Clone, Copy, Debug, PartialEq, Deserialize)]
#[serde(default, deny_unknown_fields)]
pub struct Progressive {
    /// Whether it is refined from frame to frame by directional lights, with shadows. Else it is Bevy's
    /// image-based light: at once, without shadows.
    pub on: bool,
    /// Directional lights that stand for an environment, 1 to 4096.
    pub lights: u32,
    /// How many of them shine in a frame, 1 to 10.
    pub per_frame: u32,
    /// Whether they cast shadows.
    pub shadows: bool,
}

/// Lamps.
#[derive(Clone, Copy, Debug, PartialEq, Deserialize)]
#[serde(default, deny_unknown_fields)]
pub struct Light {
    /// What the key light gives at the object's middle, in lux.
    pub illuminance: f32,
    /// Where it comes from: degrees to the right of +z, seen from above, and above the horizon.
    pub direction: (f32, f32),
}

/// Which lamps are on.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Deserialize, Reflect)]
pub enum Rig {
    /// None: the environment alone.
    None,
    /// One point light, three metres away.
    Point,
    /// Five point lights round the object, tinted.
    Five,
    /// A directional light.
    Sun,
    /// A spot light.
    Spot,
}

/// What is shown first; names as in the lists. A name that is not there is an error.
#[derive(Clone, Debug, PartialEq, Eq, Deserialize)]
#[serde(default, deny_unknown_fields)]
pub struct Start {
    /// An object's name; empty is the first.
    pub object: String,
    /// A material's name; empty is the first.
    pub material: String,
    /// Lamps.
    pub light: Rig,
    /// An environment's name; empty is none.
    pub environment: String,
    /// Whether the environment is seen behind the object.
    pub backdrop: bool,
    /// Whether the object stands on a floor.
    pub floor: bool,
}

fn one() -> f32 {
    1.0
}

fn thousand() -> f32 {
    1000.0
}

impl Rig {
    /// All, in the order of the key.
    pub const ALL: [Self; 5] = [Self::Point, Self::Five, Self::Sun, Self::Spot, Self::None];

    /// For people.
    pub fn label(self) -> &'static str {
        match self {
            Self::None => "none",
            Self::Point => "one point light",
            Self::Five => "five point lights",
            Self::Sun => "sun",
            Self::Spot => "spot light",
        }
    }

    /// As on the command line.
    pub fn name(self) -> &'static str {
        match self {
            Self::None => "none",
            Self::Point => "point",
            Self::Five => "five",
            Self::Sun => "sun",
            Self::Spot => "spot",
        }
    }
}

impl RonSettings for Viewer {
    const EXTENSIONS: &'static [&'static str] = &["btf_viewer.ron", "viewer.ron"];

    fn check(&self) -> Result<(), FieldProblem> {
        let within = |field: &str, value: f32, low: f32, high: f32| {
            if (low..=high).contains(&value) {
                return Ok(());
            }
            Err(FieldProblem::new(field, format!("{value} is not between {low} and {high}")))
        };
        let sides = [self.window.0, self.window.1];
        if !sides.iter().all(|side| (64..=16384).contains(side)) {
            return Err(FieldProblem::new("window", "sides have 64 to 16384 pixels"));
        }
        let Resolution { least, scale, greatest } = self.resolution;
        within("resolution.least", least, 0.1, 4.0)?;
        within("resolution.greatest", greatest, least, 4.0)?;
        within("resolution.scale", scale, least, greatest)?;
        within("camera.field_of_view", self.camera.field_of_view, 1.0, 150.0)?;
        let place = Vec3::from(self.camera.position);
        within("camera.position", place.length(), 0.2, 30.0)?;
        within("base_scale", self.base_scale, 0.01, 100.0)?;
        within("base_offset", Vec3::from(self.base_offset).length(), 0.0, 1e4)?;
        within("exposure", self.exposure, -10.0, 25.0)?;
        let Progressive { lights, per_frame, .. } = self.progressive;
        within("progressive.lights", lights as f32, 1.0, 4096.0)?;
        within("progressive.per_frame", per_frame as f32, 1.0, 10.0)?;
        within("light.illuminance", self.light.illuminance, 0.0, 1e6)?;
        within("light.direction", self.light.direction.1, -90.0, 90.0)?;
        within("xr.resolution_scale", self.xr.resolution_scale, 0.25, 2.0)?;
        within("xr.height", self.xr.height, 0.0, 5.0)?;
        within("xr.distance", self.xr.distance, 0.0, 10.0)?;
        within("xr.size", self.xr.size.unwrap_or(1.0), 0.01, 10.0)?;
        if self.models.is_empty() {
            return Err(FieldProblem::new("models", "at least one is needed"));
        }
        for (at, model) in self.models.iter().enumerate() {
            within(&format!("models[{at}].uv_metres"), model.uv_metres, 1e-6, 1e6)?;
        }
        for (at, material) in self.materials.iter().enumerate() {
            within(&format!("materials[{at}].gain"), material.gain, 0.0, 100.0)?;
            if let Some((width, height)) = material.size {
                within(&format!("materials[{at}].size"), width.min(height), 1e-6, 1e3)?;
            }
        }
        for (at, environment) in self.environments.iter().enumerate() {
            let field = format!("environments[{at}].brightness");
            within(&field, environment.brightness, 0.0, 1e6)?;
        }
        let Start { object, material, environment, .. } = &self.start;
        let listed = |field: &str, name: &str, names: &mut dyn Iterator<Item = &String>| {
            let names: Vec<_> = names.map(String::as_str).collect();
            if name.is_empty() || names.contains(&name) {
                return Ok(());
            }
            Err(FieldProblem::new(field, format!("{name:?} is none of {}", names.join(", "))))
        };
        listed("start.object", object, &mut self.models.iter().map(|m| &m.name))?;
        listed("start.material", material, &mut self.materials.iter().map(|m| &m.name))?;
        listed("start.environment", environment, &mut self.environments.iter().map(|e| &e.name))
    }
}
