//! The command line.

use std::path::PathBuf;

use super::config::{Environment, HeadsetMode, Material, Model, Rig, Shape, Viewer};
use super::program::size;

/// What `--help` prints.
pub const HELP: &str = "\
Measured materials (BTFs) on objects, under lamps and environments.

USAGE
    btf_viewer [OPTIONS]                      in a window and, if there is one, in a headset; F1 shows
                                              what keys, gamepad or controllers do
    btf_viewer --headless --out DIR [OPTIONS] without a window: a turntable as PNG files

OPTIONS
    --config FILE       configuration (default: assets/config/btf_viewer.ron), which explains itself:
                        lists of objects, materials and environments, camera, window, exposure, ...
    --object NAME       one of the configuration's objects, or a glTF file
    --material NAME     one of its materials, or a file: .fbtf, a BTFbase binary or folder; for archives
                        of pictures see `farlight btf import`
    --light RIG         point, five, sun, spot or none
    --environment NAME  one of its environments, a file (.hdr, .exr, .ktx2), or none
    --progressive on|off  whether the environment's light is refined from frame to frame, with shadows,
                        or is Bevy's image-based light
    --exposure EV       exposure value at ISO 100; one more is half as bright
    --camera X,Y,Z      where the camera stands, in metres from the object's middle; the object faces +z
    --size WxH          of the pictures (default 640x480) or of the window, 16 to 8192 a side
    --xr auto|on|off    whether a headset is used: if there is one; it must be there; never
    --headless          no window
    --out DIR           where the pictures go: frame_000.png, ... and contact.png with all of them
    --frames N          pictures of the whole turn, 1 to 1000 (default 12)
    --replay FILE       plays a recording of actions (docs/controls.md); without a window instead of the
                        turntable: before.png and after.png, and on the console what it did
    --ui                instead of the turntable: the first screen, help, menu, and what both eyes of a
                        headset see, as first.png, help.png, menu.png, left.png and right.png
    -h, --help          this text

EXAMPLES
    cargo run --example btf_viewer
    cargo run --example btf_viewer -- --material my/measured/leather --object plane --light sun
    cargo run --example btf_viewer -- --headless --out turn --object hippo --environment sky --frames 24

EXIT STATUS
    0 done; 1 something could not be read or drawn; 2 the command line is wrong
";

/// What the program is asked to do.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Args {
    /// Print [`HELP`].
    pub help: bool,
    /// The configuration file, if not the usual one.
    pub config: Option<PathBuf>,
    object: Option<String>,
    material: Option<String>,
    light: Option<Rig>,
    environment: Option<String>,
    progressive: Option<bool>,
    xr: Option<HeadsetMode>,
    exposure: Option<f32>,
    camera: Option<(f32, f32, f32)>,
    /// Size of pictures or window.
    pub size: Option<(u32, u32)>,
    /// Where the turntable's pictures go.
    pub headless: Option<PathBuf>,
    /// How many.
    pub frames: u32,
    /// A recording of actions.
    pub replay: Option<PathBuf>,
    /// Pictures of the program instead.
    pub ui: bool,
}

impl Args {
    /// Reads the arguments, the program's name left out.
    pub fn parse(arguments: impl IntoIterator<Item = String>) -> Result<Self, String> {
        let mut args = Self { frames: 12, ..Self::default() };
        let (mut headless, mut out) = (false, None);
        let mut arguments = arguments.into_iter();
        while let Some(name) = arguments.next() {
            let mut value = || arguments.next().ok_or(format!("{name} needs a value"));
            match name.as_str() {
                "-h" | "--help" => return Ok(Self { help: true, ..args }),
                "--config" => args.config = Some(value()?.into()),
                "--object" => args.object = Some(value()?),
                "--material" => args.material = Some(value()?),
                "--light" => args.light = Some(rig(&value()?)?),
                "--environment" => args.environment = Some(value()?),
                "--progressive" => {
                    args.progressive = Some(match value()?.as_str() {
                        "on" => true,
                        "off" => false,
                        other => return Err(format!("--progressive {other}: not on or off")),
                    });
                }
                "--xr" => args.xr = Some(headset(&value()?)?),
                "--exposure" => args.exposure = Some(number(&name, &value()?)?),
                "--camera" => args.camera = Some(place(&value()?)?),
                "--size" => args.size = Some(size(&value()?, 16..=8192)?),
                "--replay" => args.replay = Some(value()?.into()),
                "--ui" => args.ui = true,
                "--headless" => headless = true,
                "--out" => out = Some(PathBuf::from(value()?)),
                "--frames" => {
                    let text = value()?;
                    let frames = text.parse().ok().filter(|n| (1..=1000).contains(n));
                    args.frames = frames.ok_or(format!("--frames {text}: not 1 to 1000"))?;
                }
                other => return Err(format!("{other}: unknown; --help lists what there is")),
            }
        }
        args.headless = match (headless, out) {
            (true, None) => return Err("--headless needs --out DIR".into()),
            (false, Some(_)) => return Err("--out goes with --headless".into()),
            (_, out) => out,
        };
        if args.ui && args.headless.is_none() {
            return Err("--ui goes with --headless".into());
        }
        Ok(args)
    }

    /// Puts what the command line says over a configuration. Files become entries of its lists, relative
    /// to the folder that the program was started in.
    pub fn apply(&self, config: &mut Viewer) -> Result<(), String> {
        let file = |name: &str| {
            let path = std::path::absolute(name).ok().filter(|path| path.exists());
            path.map(|path| path.to_string_lossy().into_owned())
        };
        let unknown = |what: &str, name: &str, names: Vec<&str>| {
            format!("{what} {name}: no such file, and none of {}", names.join(", "))
        };
        if let Some(name) = &self.object {
            if !config.models.iter().any(|m| m.name == *name) {
                let names = config.models.iter().map(|m| m.name.as_str()).collect();
                let path = file(name).ok_or_else(|| unknown("--object", name, names))?;
                let shape = Shape::File(path);
                config.models.push(Model { name: name.clone(), shape, uv_metres: 1.0, turn: 0.0 });
            }
            config.start.object.clone_from(name);
        }
        if let Some(name) = &self.material {
            if !config.materials.iter().any(|m| m.name == *name) {
                let names = config.materials.iter().map(|m| m.name.as_str()).collect();
                let path = file(name).ok_or_else(|| unknown("--material", name, names))?;
                let name = name.clone();
                config.materials.push(Material { name, path, size: None, gain: 1.0 });
            }
            config.start.material.clone_from(name);
        }
        if let Some(name) = &self.environment {
            if name == "none" {
                config.start.environment.clear();
            } else {
                if !config.environments.iter().any(|e| e.name == *name) {
                    let names = config.environments.iter().map(|e| e.name.as_str()).collect();
                    let path = file(name).ok_or_else(|| unknown("--environment", name, names))?;
                    let name = name.clone();
                    config.environments.push(Environment {
                        name,
                        path,
                        brightness: 1000.0,
                        turn: 0.0,
                    });
                }
                config.start.environment.clone_from(name);
            }
        }
        config.start.light = self.light.unwrap_or(config.start.light);
        config.progressive.on = self.progressive.unwrap_or(config.progressive.on);
        config.exposure = self.exposure.unwrap_or(config.exposure);
        config.camera.position = self.camera.unwrap_or(config.camera.position);
        config.xr.mode = self.xr.unwrap_or(config.xr.mode);
        config.window = self.size.unwrap_or(config.window);
        Ok(())
    }
}

fn rig(text: &str) -> Result<Rig, String> {
    Rig::ALL
        .into_iter()
        .find(|rig| rig.name() == text)
        .ok_or(format!("--light {text}: not point, five, sun, spot or none"))
}

fn headset(text: &str) -> Result<HeadsetMode, String> {
    match text {
        "auto" => Ok(HeadsetMode::Auto),
        "on" => Ok(HeadsetMode::On),
        "off" => Ok(HeadsetMode::Off),
        _ => Err(format!("--xr {text}: not auto, on or off")),
    }
}

fn number(name: &str, text: &str) -> Result<f32, String> {
    text.parse()
        .ok()
        .filter(|value: &f32| value.is_finite())
        .ok_or(format!("{name} {text}: not a number"))
}

fn place(text: &str) -> Result<(f32, f32, f32), String> {
    let wrong = || format!("--camera {text}: not X,Y,Z");
    let numbers: Vec<f32> =
        text.split(',').map(|n| n.trim().parse().map_err(|_| wrong())).collect::<Result<_, _>>()?;
    match numbers[..] {
        [x, y, z] if [x, y, z].iter().all(|v| v.is_finite()) => Ok((x, y, z)),
        _ => Err(wrong()),
    }
}
