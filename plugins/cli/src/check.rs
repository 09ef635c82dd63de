//! `farlight check`: configuration files.

mod baked;

use std::path::{Path, PathBuf};

use farlight_baker::lights::BakeLights;
use farlight_gi_solver::settings::GiSettings;
use farlight_server::ServerSettings;
use serde::de::DeserializeOwned;

use crate::{
    controls::{self, Game},
    error::{CliError, read_text},
};

/// Check a configuration file
///
/// The name of the file's outer struct tells what it is: ControlsSettings(...) holds input bindings,
/// GiSettings(...) the settings of global illumination, ServerSettings(...) those of a lighting server,
/// BakeLights(...) added lights and scenarios of a bake, BakedManifest(...) baked lighting, whose pages and
/// volumes are looked at too. Unknown fields, values of the wrong type and values out of range are
/// errors that name the file, the line and the field.
///
/// Of bindings, inputs that do two things at once are warnings, on every device. A game adds actions of
/// its own, which this command doesn't know: a name that is almost one of the suite's is an error,
/// another one a note. Say --actions, and those are checked as well.
#[derive(clap::Args)]
pub(crate) struct Args {
    /// The file, in RON
    #[arg(value_name = "FILE.ron", required = true)]
    files: Vec<PathBuf>,
    #[command(flatten)]
    game: Game,
    /// Warnings are errors
    #[arg(long)]
    strict: bool,
}

/// What is asked for besides the file.
#[derive(Clone, Copy)]
struct Asked<'a> {
    game: &'a Game,
    strict: bool,
}

/// What can be checked: the outer name, and how.
const KINDS: [(&str, fn(&Path, &str, Asked) -> Result<(), CliError>); 5] = [
    ("BakeLights", |path, text, _| bake_lights(path, text)),
    ("BakedManifest", |path, text, _| baked::check(path, text)),
    ("ControlsSettings", |path, text, asked| controls::check(path, text, asked.game, asked.strict)),
    ("GiSettings", |path, text, _| gi_settings(path, text)),
    ("ServerSettings", |path, text, _| server_settings(path, text).map(drop)),
];

/// Runs the subcommand.
pub(crate) fn run(args: &Args) -> Result<(), CliError> {
    for path in &args.files {
        let asked = Asked { game: &args.game, strict: args.strict };
        let kind = check(path, &read_text(path)?, asked)?;
        println!("{}: good ({kind})", path.display());
    }
    Ok(())
}

/// Checks one text and returns its kind.
fn check(path: &Path, text: &str, asked: Asked) -> Result<&'static str, CliError> {
    let known = KINDS.map(|(name, _)| name).join(", ");
    let (line, name) = outer_name(text);
    if name.is_empty() {
        return Err(CliError::in_file(
            path,
            line,
            format_args!(
                "the file must begin with what it is, for example GiSettings(...); known: {known}"
            ),
        ));
    }
    let Some((kind, check)) = KINDS.iter().find(|(kind, _)| *kind == name) else {
        return Err(CliError::in_file(
            path,
            line,
            format_args!("unknown kind {name}; known: {known}"),
        ));
    };
    check(path, text, asked)?;
    Ok(kind)
}

fn bake_lights(path: &Path, text: &str) -> Result<(), CliError> {
    BakeLights::parse(path, text).map(drop).map_err(|error| CliError::new(error.to_string()))
}

fn gi_settings(path: &Path, text: &str) -> Result<(), CliError> {
    let settings: GiSettings = parse(path, text)?;
    settings.validate().map_err(|e| out_of_range(path, text, e.field, &e))
}

/// Reads and checks the settings of a server.
pub(crate) fn server_settings(path: &Path, text: &str) -> Result<ServerSettings, CliError> {
    let settings: ServerSettings = parse(path, text)?;
    match settings.validate() {
        Ok(()) => Ok(settings),
        Err(e) => Err(out_of_range(path, text, e.field, &e)),
    }
}

fn parse<T: DeserializeOwned>(path: &Path, text: &str) -> Result<T, CliError> {
    farlight_ron::parse(text).map_err(|error| CliError::beside(path, error))
}

fn out_of_range(path: &Path, text: &str, field: &str, what: &dyn std::fmt::Display) -> CliError {
    match farlight_ron::place_of(text, field) {
        Some((line, _)) => CliError::in_file(path, line, what),
        None => CliError::in_file(path, " ", what),
    }
}

/// The first identifier after white space, comments and `#![...]` attributes, with its line; empty
/// if there is something else.
fn outer_name(text: &str) -> (usize, &str) {
    let mut rest = text;
    loop {
        rest = rest.trim_start();
        let skip = if rest.starts_with("//") {
            rest.find('\n')
        } else if rest.starts_with("/*") {
            rest.find("*/").map(|i| i + 2)
        } else if rest.starts_with("#!") {
            rest.find(']').map(|i| i + 1)
        } else {
            break;
        };
        rest = skip.map_or("", |skip| &rest[skip..]);
    }
    let before = &text[..text.len() - rest.len()];
    let end = rest.find(|c: char| !c.is_alphanumeric() && c != '_').unwrap_or(rest.len());
    (before.matches('\n').count() + 1, &rest[..end])
}

#[cfg(test)]
mod tests {
    use super::*;

    fn result(text: &str) -> Result<&'static str, String> {
        let asked = Asked { game: &Game::default(), strict: false };
        check(Path::new("gi.ron"), text, asked).map_err(|e| e.to_string())
    }

    #[test]
    fn good_files() {
        assert_eq!(result("GiSettings()"), Ok("GiSettings"));
        let text = "#![enable(implicit_some)]\n// mine\n/* a\nb */ GiSettings(\n bounces: 4,\n)";
        assert_eq!(result(text), Ok("GiSettings"));
        assert_eq!(result("ServerSettings(max_sessions: 2)"), Ok("ServerSettings"));
    }

    #[test]
    fn errors_name_file_line_and_field() {
        let error = result("GiSettings(\n  bounces: 4,\n  bouncs: 4,\n)").unwrap_err();
        assert!(error.starts_with("gi.ron:3:") && error.contains("bouncs"), "{error}");
        let error = result("GiSettings(\n  // bounces: 1,\n  bounces: 99,\n)").unwrap_err();
        assert_eq!(error, "gi.ron:3: bounces is 99, must be 1 to 64");
        let error = result("GiSettings(\n  seed: \"x\",\n)").unwrap_err();
        assert!(error.starts_with("gi.ron:2:"), "{error}");
        let error = result("\n\nSkySettings()").unwrap_err();
        assert_eq!(
            error,
            "gi.ron:3: unknown kind SkySettings; known: BakeLights, BakedManifest, ControlsSettings, \
             GiSettings, ServerSettings"
        );
        let error = result("(bounces: 4)").unwrap_err();
        assert!(error.starts_with("gi.ron:1:") && error.contains("GiSettings"), "{error}");
        let error = result("ServerSettings(\n  listen: \"x\",\n)").unwrap_err();
        assert!(error.starts_with("gi.ron:2:"), "{error}");
        let error = result("ServerSettings(\n  max_sessions: 0,\n)").unwrap_err();
        assert_eq!(error, "gi.ron:2: max_sessions is 0, must be 1 to 1024");
        assert!(result("").is_err() && result("/* never closed").is_err());
    }
}
