//! What is shown: one resource that actions, the panel and the configuration change.

use bevy::prelude::*;
use farlight::panel::field::{Hidden, Label, Step, Unit};

use super::config::{Rig, Viewer};

/// What is shown, and how.
#[derive(Resource, Reflect, Clone, Debug, PartialEq)]
#[reflect(Resource, Clone, Debug, PartialEq)]
pub struct Shown {
    /// The measured material.
    pub material: MaterialShown,
    /// What wears it.
    pub object: ObjectShown,
    /// Environment and lamps.
    pub light: LightShown,
    /// How it is drawn.
    pub picture: PictureShown,
}

/// A material of the list.
#[derive(Reflect, Clone, Debug, PartialEq)]
#[reflect(Clone, Debug, PartialEq)]
pub struct MaterialShown {
    /// Its place in the list; without materials nothing is there.
    #[reflect(@Hidden)]
    pub choice: usize,
    /// How texels become a picture.
    pub evaluation: Evaluation,
    /// How often the picture's resolution is halved.
    #[reflect(@0.0..=MOST_COARSE, @Step(1.0), @Label("Resolution halved"), @Unit("times"))]
    pub halvings: f32,
    /// Factor on the size of its picture.
    #[reflect(@0.01..=100.0_f32)]
    pub size: f32,
    /// Factor on the reflected light.
    #[reflect(@0.01..=100.0_f32)]
    pub gain: f32,
}

/// How a measured material is evaluated. (The viewer of the thesis had GLSL, CUDA and OpenCL on the
/// same keys; ours computes the same values in one shader on every device, so these are kinds of
/// reconstruction instead.)
#[derive(Reflect, Clone, Copy, Debug, Default, PartialEq, Eq)]
#[reflect(Clone, Debug, Default, PartialEq)]
pub enum Evaluation {
    /// Four texels joined in linear light; from afar, texels of coarser pictures.
    #[default]
    Smooth,
    /// The nearest texel; from afar, that of a coarser picture: the fastest.
    Nearest,
    /// Four texels of the whole picture, also from afar, where it flickers: every texel as measured.
    Full,
}

/// An object of the list.
#[derive(Reflect, Clone, Debug, PartialEq)]
#[reflect(Clone, Debug, PartialEq)]
pub struct ObjectShown {
    /// Its place in the list.
    #[reflect(@Hidden)]
    pub choice: usize,
    /// Turn about the vertical axis, in degrees.
    #[reflect(@-180.0..=180.0_f32, @Unit("°"))]
    pub turn: f32,
    /// How it lies, before that turn.
    #[reflect(@Hidden)]
    pub tilt: Quat,
    /// Metres from its place.
    #[reflect(@Hidden)]
    pub shift: Vec3,
    /// Factor on its size.
    #[reflect(@LEAST_SCALE..=MOST_SCALE)]
    pub scale: f32,
    /// Whether it goes on turning.
    pub turning: bool,
    /// Whether it stands on something.
    pub plinth: bool,
}

/// Environment and lamps.
#[derive(Reflect, Clone, Debug, PartialEq)]
#[reflect(Clone, Debug, PartialEq)]
pub struct LightShown {
    /// Its place in the list of environments; none is black.
    #[reflect(@Hidden)]
    pub environment: Option<usize>,
    /// Whether the environment gives light.
    #[reflect(@Label("Environment's light"))]
    pub shines: bool,
    /// Whether its light is refined from frame to frame, with shadows; else it is image-based light.
    #[reflect(@Hidden)]
    pub progressive: bool,
    /// Directional lights that stand for the environment.
    #[reflect(@Hidden)]
    pub lights: u32,
    /// How many of them shine in a frame.
    #[reflect(@Hidden)]
    pub per_frame: u32,
    /// Whether they cast shadows.
    #[reflect(@Hidden)]
    pub shadows: bool,
    /// Factor on the environment's brightness.
    #[reflect(@0.01..=100.0_f32)]
    pub brightness: f32,
    /// Whether the environment is seen behind the object.
    pub backdrop: bool,
    /// Lamps.
    pub lamps: Rig,
    /// Where light comes from, in degrees round the vertical axis: lamps and environment together.
    #[reflect(@-180.0..=180.0_f32, @Unit("°"))]
    pub turn: f32,
    /// Degrees of the key lamp above the horizon.
    #[reflect(@-89.0..=89.0_f32, @Unit("°"), @Label("Lamps' height"))]
    pub height: f32,
}

/// How it is drawn.
#[derive(Reflect, Clone, Debug, PartialEq)]
#[reflect(Clone, Debug, PartialEq)]
pub struct PictureShown {
    /// Exposure value at ISO 100; one more is half as bright.
    #[reflect(@-10.0..=25.0_f32, @Unit("EV"))]
    pub exposure: f32,
    /// Pixels drawn for a pixel of the window, along each edge.
    #[reflect(@0.1..=4.0_f32, @Unit("%"))]
    pub resolution: f32,
}

impl Evaluation {
    /// All, in the order of the actions.
    pub const ALL: [Self; 3] = [Self::Smooth, Self::Nearest, Self::Full];

    /// In words.
    pub fn label(self) -> &'static str {
        match self {
            Self::Smooth => "smooth",
            Self::Nearest => "nearest texel",
            Self::Full => "full detail from afar",
        }
    }
}

/// Most halvings of a material's picture.
pub const MOST_COARSE: f32 = 6.0;
/// The smallest object, as a factor.
pub const LEAST_SCALE: f32 = 0.05;
/// The largest.
pub const MOST_SCALE: f32 = 20.0;

impl Shown {
    /// What the configuration begins with.
    pub fn start(config: &Viewer) -> Self {
        let start = &config.start;
        let object = config.models.iter().position(|m| m.name == start.object);
        let material = config.materials.iter().position(|m| m.name == start.material);
        let (turn, height) = config.light.direction;
        Self {
            material: MaterialShown {
                choice: material.unwrap_or(0),
                evaluation: Evaluation::default(),
                halvings: 0.0,
                size: 1.0,
                gain: 1.0,
            },
            object: ObjectShown {
                choice: object.unwrap_or(0),
                turn: 0.0,
                tilt: Quat::IDENTITY,
                shift: Vec3::ZERO,
                scale: 1.0,
                turning: false,
                plinth: start.floor,
            },
            light: LightShown {
                environment: config.environments.iter().position(|e| e.name == start.environment),
                shines: true,
                progressive: config.progressive.on,
                lights: config.progressive.lights,
                per_frame: config.progressive.per_frame,
                shadows: config.progressive.shadows,
                brightness: 1.0,
                backdrop: start.backdrop,
                lamps: start.light,
                turn: degrees(turn),
                height: height.clamp(-89.0, 89.0),
            },
            picture: PictureShown {
                exposure: config.exposure,
                resolution: config.resolution.scale,
            },
        }
    }

    /// Keeps to what a configuration has.
    pub fn fit(&mut self, config: &Viewer) {
        let last = |count: usize| count.saturating_sub(1);
        self.object.choice = self.object.choice.min(last(config.models.len()));
        self.material.choice = self.material.choice.min(last(config.materials.len()));
        self.light.environment = self.light.environment.filter(|&e| e < config.environments.len());
        let limits = config.resolution;
        self.picture.resolution = self.picture.resolution.clamp(limits.least, limits.greatest);
    }
}

impl ObjectShown {
    /// How it is turned.
    pub fn rotation(&self) -> Quat {
        Quat::from_rotation_y(self.turn.to_radians()) * self.tilt
    }

    /// Turns it so; the turn about the vertical axis stays the number that it is.
    pub fn set_rotation(&mut self, rotation: Quat) {
        let upright = Quat::from_rotation_y(-self.turn.to_radians());
        self.tilt = (upright * rotation).normalize();
    }

    /// Turns it by what was dragged, in degrees: about the vertical axis, and about an axis that
    /// points to the viewer's right.
    pub fn roll(&mut self, by: Vec2, right: Vec3) {
        self.turn = degrees(self.turn + by.x);
        if by.y != 0.0
            && let Ok(right) = Dir3::new(right)
        {
            let over = Quat::from_axis_angle(*right, -by.y.to_radians());
            self.set_rotation(over * self.rotation());
        }
    }
}

/// An angle from -180 to 180.
pub fn degrees(angle: f32) -> f32 {
    let angle = angle.rem_euclid(360.0);
    if angle > 180.0 { angle - 360.0 } else { angle }
}
