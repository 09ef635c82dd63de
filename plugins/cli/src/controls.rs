//! `farlight controls`: input bindings, explained.

use std::path::{Path, PathBuf};

use clap::{Subcommand, ValueEnum};
use farlight_bindings::{
    ActionInfo, ActionKind, Bindings, Context, Device, Preset, Severity, defaults_ron, help_text,
    table,
};

use crate::error::{CliError, read_text};

/// Input bindings: what does what on which device
///
/// Actions have names (orbit, next_material, menu); bindings say which input of a device does them:
/// those in a file ControlsSettings(...), and the defaults for what the file leaves out.
#[derive(clap::Args)]
#[command(disable_help_subcommand = true, after_help = DEVICES)]
pub(crate) struct Args {
    #[command(subcommand)]
    command: Command,
}

const DEVICES: &str = "\
DEVICE is one of
  keyboard_mouse   keyboard and mouse
  gamepad          a gamepad with two sticks
  wii_remote       a Wii Remote as Linux presents it (unverified)
  touch            a touch screen
  xr_touch         Oculus Touch controllers
  xr_index         Valve Index controllers
  xr_vive          HTC Vive wands
  xr_simple        controllers with one button to select and one for the menu
  xr_hands         bare hands in a headset

`farlight check FILE.ron` says what is wrong in a file and which inputs do two things at once.";

#[derive(Subcommand)]
enum Command {
    /// Print the table of all actions by device, as Markdown
    #[command(after_help = DEVICES)]
    Table {
        /// Only these devices
        #[arg(long = "device", value_name = "DEVICE", value_parser = device)]
        devices: Vec<Device>,
        #[command(flatten)]
        source: Source,
    },
    /// Print what a device does, as the help on screen says it
    #[command(after_help = DEVICES)]
    Help {
        /// The device in hand
        #[arg(long, value_name = "DEVICE", value_parser = device, default_value = "keyboard_mouse")]
        device: Device,
        #[command(flatten)]
        source: Source,
    },
    /// Print a commented file with everything as it is by default, to be changed
    Defaults {
        /// For an object in front of you, or for a room that you walk about in
        #[arg(long, value_name = "PRESET", default_value = "viewer")]
        preset: Kind,
    },
}

#[derive(Clone, Copy, ValueEnum)]
enum Kind {
    Viewer,
    Room,
}

impl From<Kind> for Preset {
    fn from(kind: Kind) -> Self {
        match kind {
            Kind::Viewer => Self::Viewer,
            Kind::Room => Self::Room,
        }
    }
}

/// Which bindings.
#[derive(clap::Args)]
struct Source {
    /// The bindings of this file instead of the defaults
    #[arg(long, value_name = "FILE.ron")]
    file: Option<PathBuf>,
    /// The defaults for an object in front of you, or for a room that you walk about in; without it,
    /// those of the file
    #[arg(long, value_name = "PRESET")]
    preset: Option<Kind>,
    #[command(flatten)]
    game: Game,
}

/// Actions of a game.
#[derive(clap::Args, Default)]
pub(crate) struct Game {
    /// Actions that the game adds, separated by commas: `jump`, `strafe:axis`, `aim:axis2`
    #[arg(long, value_name = "NAME[:KIND]", value_delimiter = ',', value_parser = action)]
    pub(crate) actions: Vec<ActionInfo>,
}

fn device(name: &str) -> Result<Device, String> {
    Device::named(&name.replace('-', "_")).ok_or_else(|| {
        let names: Vec<_> = Device::ALL.iter().map(|device| device.name()).collect();
        format!("there are {}", names.join(", "))
    })
}

fn action(text: &str) -> Result<ActionInfo, String> {
    let (name, kind) = text.split_once(':').unwrap_or((text, "button"));
    let kind = match kind {
        "button" => ActionKind::Button,
        "axis" => ActionKind::Axis,
        "axis2" => ActionKind::Axis2,
        _ => return Err("an action is a button, an axis or an axis2".into()),
    };
    if name.is_empty() {
        return Err("an action has a name".into());
    }
    // A few names until the command ends.
    let name: &'static str = String::from(name).leak();
    Ok(ActionInfo { name, label: name, kind, context: Context::Scene, unit: "" })
}

impl Source {
    fn bindings(&self) -> Result<Bindings, CliError> {
        let mut bindings = match &self.file {
            Some(path) => read(path, &read_text(path)?)?,
            None => Bindings::default(),
        };
        if let Some(preset) = self.preset {
            bindings.preset = preset.into();
        }
        Ok(bindings)
    }
}

fn read(path: &Path, text: &str) -> Result<Bindings, CliError> {
    Bindings::from_ron(text).map_err(|error| CliError::beside(path, error))
}

/// Runs the subcommand.
pub(crate) fn run(args: &Args) -> Result<(), CliError> {
    match &args.command {
        Command::Table { devices, source } => {
            let devices = if devices.is_empty() { &Device::ALL[..] } else { devices };
            print!("{}", table(&source.bindings()?, devices, &source.game.actions));
        }
        Command::Help { device, source } => {
            print!("{}", help_text(&source.bindings()?, *device, &source.game.actions));
        }
        Command::Defaults { preset } => print!("{}", defaults_ron((*preset).into())),
    }
    Ok(())
}

/// Checks a file of bindings: what is wrong, worst first, a line each.
pub(crate) fn check(path: &Path, text: &str, game: &Game, strict: bool) -> Result<(), CliError> {
    let bindings = read(path, text)?;
    let mut errors = Vec::new();
    let mut say = |severity: Severity, line: String| match severity {
        Severity::Note => eprintln!("note: {line}"),
        Severity::Warning if !strict => eprintln!("warning: {line}"),
        _ => errors.push(line),
    };
    let mut problems = bindings.check(&game.actions);
    problems.sort_by_key(|problem| std::cmp::Reverse(problem.severity));
    for problem in problems {
        let place = problem.place(text).map(|(line, column)| format!("{line}:{column}: "));
        let line = format!("{}:{}{problem}", path.display(), place.unwrap_or_default());
        say(problem.severity, line);
    }
    for device in Device::ALL {
        for conflict in bindings.conflicts(device, &game.actions) {
            let place = conflict.place(&bindings, text);
            let place = place.map(|(line, column)| format!("{line}:{column}:"));
            let line = format!("{}:{} {conflict}", path.display(), place.unwrap_or_default());
            say(Severity::Warning, line);
        }
    }
    if errors.is_empty() { Ok(()) } else { Err(CliError::new(errors.join("\nerror: "))) }
}
