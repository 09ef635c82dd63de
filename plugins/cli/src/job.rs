//! What is asked for: the receivers file.

use std::{collections::BTreeMap, path::Path};

use farlight_gi_solver::receiver::Receiver;
use glam::Vec3;
use serde::Deserialize;

use crate::error::{CliError, read_text};

/// Points, probes and visibility questions, checked.
#[derive(Debug, Default)]
pub(crate) struct Job {
    pub(crate) receivers: Vec<Receiver>,
    pub(crate) probes: Vec<Vec3>,
    pub(crate) visibility: Vec<(Vec3, usize)>,
    /// What was not understood and is left out.
    pub(crate) warnings: Vec<String>,
}

#[derive(Deserialize)]
struct File {
    #[serde(default)]
    surface: Vec<Surface>,
    #[serde(default)]
    probes: Vec<[f32; 3]>,
    #[serde(default)]
    visibility: Vec<Visibility>,
    #[serde(flatten)]
    unknown: BTreeMap<String, serde::de::IgnoredAny>,
}

#[derive(Deserialize)]
struct Surface {
    position: [f32; 3],
    normal: [f32; 3],
}

#[derive(Deserialize)]
struct Visibility {
    point: [f32; 3],
    light: usize,
}

/// How far from 1 the length of a normal may be.
const NORMAL_TOLERANCE: f32 = 0.01;

impl Job {
    /// Reads and checks a receivers file; `lights` is the number of lights in the scene.
    pub(crate) fn read(path: &Path, lights: usize) -> Result<Self, CliError> {
        Self::parse(path, &read_text(path)?, lights)
    }

    fn parse(path: &Path, text: &str, lights: usize) -> Result<Self, CliError> {
        let file: File = serde_json::from_str(text).map_err(|e| {
            // The parser ends its message with the place, which stands in front here.
            let message = e.to_string();
            let what = message.split(" at line ").next().unwrap_or(&message);
            CliError::in_file(path, format_args!("{}:{}", e.line(), e.column()), what)
        })?;
        let mut job = Self::default();
        for key in file.unknown.keys() {
            job.warnings.push(format!(
                "{}: {key:?} is ignored: the keys are surface, probes, visibility",
                path.display()
            ));
        }
        let finite = |field: &dyn Fn() -> String, v: [f32; 3]| {
            let v = Vec3::from_array(v);
            if v.is_finite() {
                Ok(v)
            } else {
                Err(CliError::in_file(path, field(), format!(" {v} is not finite")))
            }
        };
        for (i, s) in file.surface.iter().enumerate() {
            let position = finite(&|| format!(" surface[{i}].position"), s.position)?;
            let normal = finite(&|| format!(" surface[{i}].normal"), s.normal)?;
            let length = normal.length();
            if (length - 1.0).abs() > NORMAL_TOLERANCE {
                return Err(CliError::in_file(
                    path,
                    format_args!(" surface[{i}].normal"),
                    format_args!("{normal} has length {length}, must be a unit vector"),
                ));
            }
            job.receivers.push(Receiver { position, normal: normal / length });
        }
        for (i, p) in file.probes.iter().enumerate() {
            job.probes.push(finite(&|| format!(" probes[{i}]"), *p)?);
        }
        for (i, v) in file.visibility.iter().enumerate() {
            let point = finite(&|| format!(" visibility[{i}].point"), v.point)?;
            if v.light >= lights {
                let there = match lights {
                    0 => "the scene has no lights".to_owned(),
                    1 => "the scene has one light, 0".to_owned(),
                    n => format!("the scene has the lights 0 to {}", n - 1),
                };
                return Err(CliError::in_file(
                    path,
                    format_args!(" visibility[{i}].light"),
                    format_args!("{}, but {there} (in the order of their nodes)", v.light),
                ));
            }
            job.visibility.push((point, v.light));
        }
        Ok(job)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn parse(text: &str) -> Result<Job, String> {
        Job::parse(Path::new("in.json"), text, 2).map_err(|e| e.to_string())
    }

    #[test]
    fn all_parts_are_optional_and_kept_in_order() {
        let job = parse(
            r#"{"surface": [{"position": [1, 2, 3], "normal": [0, 1.001, 0], "mesh": "x"}],
                "probes": [[4, 5, 6]], "visibility": [{"point": [7, 8, 9], "light": 1}]}"#,
        )
        .unwrap();
        assert_eq!(job.receivers[0].position, Vec3::new(1.0, 2.0, 3.0));
        assert_eq!(job.receivers[0].normal, Vec3::Y);
        assert_eq!(job.probes, [Vec3::new(4.0, 5.0, 6.0)]);
        assert_eq!(job.visibility, [(Vec3::new(7.0, 8.0, 9.0), 1)]);
        assert!(parse("{}").unwrap().receivers.is_empty());
        assert_eq!(parse(r#"{"surfaces": []}"#).unwrap().warnings.len(), 1);
    }

    #[test]
    fn errors_name_file_and_place() {
        let error = parse("{\n\"surface\": [{\"position\": [1, 2], \"normal\": [0, 1, 0]}]}");
        assert!(error.unwrap_err().starts_with("in.json:2:"));
        let error = parse("{\n\"surface\": [\n{\"position\": [1, 2, 3]}]}").unwrap_err();
        assert!(error.starts_with("in.json:3:") && error.contains("normal"), "{error}");
        let error = parse(r#"{"surface": [{"position": [1, 2, 3], "normal": [0, 2, 0]}]}"#);
        assert!(error.unwrap_err().contains("surface[0].normal"));
        let error = parse(r#"{"visibility": [{"point": [1, 2, 3], "light": 2}]}"#).unwrap_err();
        assert!(error.contains("visibility[0].light") && error.contains("0 to 1"), "{error}");
        let error = parse(r#"{"probes": [[1, 2, 1e40]]}"#).unwrap_err();
        assert!(error.contains("in.json:") && error.contains("probes[0]"), "{error}");
    }
}
