//! Reading and checking.

use std::{collections::BTreeSet, fmt::Display, path::PathBuf};

use farlight_ron::FileError;
use ron::{Options, extensions::Extensions};
use thiserror::Error;

use super::{AddedKind, AddedLight, BakeLights, SkySpec};

/// Why a file of lights can't be used.
#[derive(Debug, Error)]
pub enum LightsError {
    /// It can't be read.
    #[error("{}: can't be read: {source}", file.display())]
    Io {
        /// Which file.
        file: PathBuf,
        /// Why not.
        source: std::io::Error,
    },
    /// Something in it is wrong, or a picture of a sky that it names can't be read.
    #[error("{}:{error}", file.display())]
    Text {
        /// Which file.
        file: PathBuf,
        /// Where, and what.
        error: FileError,
    },
}

/// A field and what is wrong with it.
type Problem = (String, String);

impl LightsError {
    /// What is wrong with a field of a file with that text.
    pub(crate) fn of_field(
        file: impl Into<PathBuf>,
        text: &str,
        field: String,
        problem: &dyn Display,
    ) -> Self {
        let error = FileError::of_field(text, field, problem.to_string());
        Self::Text { file: file.into(), error }
    }
}

impl BakeLights {
    /// Reads and checks a file's text; `file` is for messages.
    ///
    /// # Errors
    /// The first thing that is wrong. Whether the names are those of the scene is checked when it is baked.
    pub fn parse(file: impl Into<PathBuf>, text: &str) -> Result<Self, LightsError> {
        let file = file.into();
        let options = Options::default().with_default_extension(Extensions::IMPLICIT_SOME);
        let lights: Result<Self, _> = options.from_str(text);
        let error = match lights {
            Ok(lights) => match lights.check() {
                Ok(()) => return Ok(lights),
                Err((field, problem)) => FileError::of_field(text, field, problem),
            },
            Err(error) => FileError::new(text, &error),
        };
        Err(LightsError::Text { file, error })
    }

    fn check(&self) -> Result<(), Problem> {
        let mut names = BTreeSet::new();
        for (i, light) in self.add.iter().enumerate() {
            let at = |field: &str| format!("add[{i}].{field}");
            light.check().map_err(|(field, problem)| (at(field), problem))?;
            if !names.insert(&light.name) {
                let problem = format!("there are two lights {:?}", light.name);
                return Err((at("name"), problem));
            }
        }
        for (map, name) in [(&self.radius, "radius"), (&self.angle, "angle")] {
            for (light, &value) in map {
                let field = format!("{name}.{light}");
                number(value, 0.0, 1e6).map_err(|problem| (field, problem))?;
            }
        }
        let mut names = BTreeSet::new();
        for (i, scenario) in self.scenarios.iter().enumerate() {
            let at = |field: &str| format!("scenarios[{i}].{field}");
            if scenario.name.is_empty() || scenario.name.chars().any(char::is_control) {
                return Err((at("name"), "a scenario needs a name, on one line".to_owned()));
            }
            if !names.insert(&scenario.name) {
                return Err((at("name"), format!("there are two scenarios {:?}", scenario.name)));
            }
            match &scenario.sky {
                None => {}
                Some(SkySpec::Constant(sky)) => {
                    colour(*sky).map_err(|problem| (at("sky"), problem))?;
                }
                Some(SkySpec::Image { scale, rotation, .. }) => {
                    number(*scale, 0.0, 1e9).map_err(|problem| (at("sky.scale"), problem))?;
                    number(*rotation, -1e6, 1e6)
                        .map_err(|problem| (at("sky.rotation"), problem))?;
                }
            }
            for (material, factor) in &scenario.emission {
                let field = || at(&format!("emission.{material}"));
                number(*factor, 0.0, 1e9).map_err(|problem| (field(), problem))?;
            }
        }
        Ok(())
    }
}

impl AddedLight {
    fn check(&self) -> Result<(), (&'static str, String)> {
        if self.name.is_empty() || self.name.chars().any(char::is_control) {
            return Err(("name", "a light needs a name, on one line".to_owned()));
        }
        let directional = self.kind == AddedKind::Directional;
        for (field, vector) in [("position", self.position), ("direction", self.direction)] {
            if !vector.iter().all(|v| v.is_finite() && v.abs() <= 1e9) {
                return Err((field, format!("{vector:?} is no place or direction")));
            }
        }
        colour(self.intensity).map_err(|problem| ("intensity", problem))?;
        if self.kind != AddedKind::Point && self.direction == [0.0; 3] {
            return Err(("direction", "spot and directional lights need one".to_owned()));
        }
        if let AddedKind::Spot { inner, outer } = self.kind {
            let good = 0.0 <= inner && inner < outer && outer <= 90.0;
            if !good {
                let problem = format!(
                    "inner {inner} and outer {outer} must be 0 <= inner < outer <= 90 (degrees)"
                );
                return Err(("kind", problem));
            }
        }
        if let Some(range) = self.range
            && !(range.is_finite() && range > 0.0)
        {
            return Err(("range", format!("{range} must be finite and above 0 (metres)")));
        }
        number(self.radius, 0.0, 1e6).map_err(|problem| ("radius", problem))?;
        number(self.angle, 0.0, 89.0).map_err(|problem| ("angle", problem))?;
        match directional {
            true if self.radius != 0.0 => Err((
                "radius",
                "directional lights have none: say half the angle under which it is seen, as angle"
                    .to_owned(),
            )),
            false if self.angle != 0.0 => {
                Err(("angle", "only directional lights have one: say a radius".to_owned()))
            }
            _ => Ok(()),
        }
    }
}

fn number(value: f32, low: f32, high: f32) -> Result<(), String> {
    if (low..=high).contains(&value) {
        Ok(())
    } else {
        Err(format!("{value}, must be {low} to {high}"))
    }
}

fn colour(rgb: [f32; 3]) -> Result<(), String> {
    if rgb.iter().all(|v| (0.0..=1e12).contains(v)) {
        Ok(())
    } else {
        Err(format!("{rgb:?} must be three finite numbers, not negative"))
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn problem(text: &str) -> String {
        BakeLights::parse("lights.ron", text).unwrap_err().to_string()
    }

    #[test]
    fn a_whole_file() {
        let text = r#"BakeLights(
            add: [
                (name: "lamp", position: (0, 2.2, 0), intensity: (80, 70, 55), radius: 0.05, range: 8),
                (name: "desk", kind: Spot(inner: 20, outer: 30), direction: (0, -1, 0),
                    intensity: (9, 9, 9), direct: Realtime),
                (name: "sun", kind: Directional, direction: (0, -1, 1), intensity: (2e4, 2e4, 2e4)),
            ],
            realtime: ["Torch"],
            radius: {"Ceiling": 0.1},
            scenarios: [
                (name: "noon", lights: ["sun"], sky: Image(file: "noon.hdr", rotation: 90)),
                (name: "off", lights: [], sky: Constant((0, 0, 1)), emission: {"Shade": 0}),
                (name: "all"),
            ],
        )"#;
        let lights = BakeLights::parse("lights.ron", text).unwrap();
        assert_eq!(lights.add[0].range, Some(8.0));
        assert_eq!(lights.scenarios[1].lights, Some(Vec::new()));
        assert_eq!(lights.scenarios[2].lights, None);
        let Some(SkySpec::Image { scale, .. }) = &lights.scenarios[0].sky else { panic!() };
        assert_eq!(*scale, 1.0);
        assert_eq!(BakeLights::parse("x", "BakeLights()").unwrap(), BakeLights::default());
    }

    #[test]
    fn errors_name_the_file_and_the_field() {
        let error = problem("BakeLights(\n  add: [(nam: \"x\")],\n)");
        assert!(error.starts_with("lights.ron:2:") && error.contains("nam"), "{error}");
        for (text, expected) in [
            ("add: [(intensity: (1, 1, 1))]", "lights.ron:1:18: add[0].name: "),
            ("add: [(name: \"a\"), (name: \"a\")]", "add[1].name: "),
            ("add: [(name: \"a\", intensity: (1, -1, 1))]", "add[0].intensity: "),
            ("add: [(name: \"a\", intensity: (NaN, 1, 1))]", "add[0].intensity: "),
            ("add: [(name: \"a\", position: (inf, 1, 1))]", "add[0].position: "),
            ("add: [(name: \"a\", kind: Directional)]", "add[0].direction: "),
            ("add: [(name: \"a\", range: 0)]", "add[0].range: "),
            ("add: [(name: \"a\", angle: 1)]", "add[0].angle: "),
            (
                "add: [(name: \"a\", kind: Spot(inner: 40, outer: 30), direction: (0, 1, 0))]",
                "add[0].kind: ",
            ),
            ("radius: {\"b\": -1}", "1:21: radius.b: "),
            ("scenarios: [()]", "scenarios[0].name: "),
            ("scenarios: [(name: \"a\"), (name: \"a\")]", "scenarios[1].name: "),
            ("scenarios: [(name: \"a\", sky: Constant((1, 1, -1)))]", "scenarios[0].sky: "),
            ("scenarios: [(name: \"a\", emission: {\"m\": -1})]", "scenarios[0].emission.m: "),
        ] {
            let error = problem(&format!("BakeLights({text})"));
            assert!(error.contains(expected), "{text}: {error}");
        }
    }
}
