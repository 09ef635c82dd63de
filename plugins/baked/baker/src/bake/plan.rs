//! What shines in each scenario.

use std::collections::{BTreeMap, BTreeSet};

use farlight_baked_format::{Fingerprint, manifest::Direct};
use farlight_gi_solver::{
    import::ImportedScene,
    scene::{Light, LightKind, MaterialId, Sky},
};
use glam::{Quat, Vec3};

use super::input::Input;
use crate::{
    BakeError, BakeOptions,
    lights::{AddedKind, AddedLight, LightsError, ScenarioSpec, SkySpec},
    store::Key,
};

/// The name of the only scenario where none is named.
const DEFAULT: &str = "default";
/// Range of lights in metres where none is given: Bevy's.
const RANGE: f32 = 20.0;

/// What shines in a scenario.
pub(super) struct Plan {
    pub(super) name: String,
    pub(super) lights: Vec<PlannedLight>,
    pub(super) sky: Sky,
    /// Emission of materials in cd/m² where it isn't the scene's.
    pub(super) emission: BTreeMap<MaterialId, Vec3>,
    sky_print: Fingerprint,
}

/// A light that shines.
#[derive(Clone, Debug)]
pub(super) struct PlannedLight {
    /// Its node; `None` for an added one.
    pub(super) node: Option<u32>,
    pub(super) name: String,
    pub(super) light: Light,
    /// Metres, or radians of a directional one.
    pub(super) radius: f32,
    pub(super) direct: Direct,
}

impl Plan {
    /// All scenarios, in their order.
    pub(super) fn all(
        options: &BakeOptions,
        input: &Input,
        imported: &ImportedScene,
    ) -> Result<Vec<Self>, BakeError> {
        let field = |field: String, problem: String| {
            let file = options.lights.clone().unwrap_or_default();
            LightsError::of_field(file, &input.lights_text, field, &problem)
        };
        let lights = all_lights(input, imported, &field)?;
        let default = [ScenarioSpec { name: DEFAULT.to_owned(), ..ScenarioSpec::default() }];
        let specs = match input.lights.scenarios.as_slice() {
            [] => &default[..],
            specs => specs,
        };
        for name in &options.scenarios {
            if !specs.iter().any(|spec| spec.name == *name) {
                let names: Vec<_> = specs.iter().map(|spec| format!("{:?}", spec.name)).collect();
                let problem =
                    format!("there is no scenario {name:?}; there are {}", names.join(", "));
                return Err(BakeError::Option { option: "scenario", problem });
            }
        }
        let mut skies = BTreeMap::new();
        let mut plans = Vec::new();
        for (i, spec) in specs.iter().enumerate() {
            let at = |name: &str| format!("scenarios[{i}].{name}");
            if let Some(names) = &spec.lights {
                check_names(names, &lights).map_err(|problem| field(at("lights"), problem))?;
            }
            let mut key = Key::new("sky");
            let sky = match &spec.sky {
                None => constant(options.sky, &mut key),
                Some(SkySpec::Constant(sky)) => constant(Vec3::from(*sky), &mut key),
                Some(SkySpec::Image { file, scale, rotation }) => {
                    let source = &input.skies[file];
                    key.print(source.fingerprint).float(*scale).float(*rotation);
                    let image = match skies.get(file) {
                        Some(image) => Clone::clone(image),
                        None => {
                            let image = source.decode();
                            let image = image
                                .map_err(|error| field(source.field.clone(), error.to_string()))?;
                            skies.insert(file.clone(), image.clone());
                            image
                        }
                    };
                    let rotation = Quat::from_rotation_y(rotation.to_radians());
                    Sky::Image { image, rotation, scale: *scale }
                }
            };
            let mut emission = BTreeMap::new();
            for (name, factor) in &spec.emission {
                let found: Vec<_> =
                    input.material_names().filter(|(_, n)| n == name).map(|(id, _)| id).collect();
                if found.is_empty() {
                    let names: Vec<_> =
                        input.material_names().map(|(_, name)| format!("{name:?}")).collect();
                    let problem = format!(
                        "the scene has no material {name:?}; it has {}",
                        shorten(&names.join(", "))
                    );
                    return Err(field(at("emission"), problem).into());
                }
                for id in found.into_iter().map(MaterialId) {
                    // Materials that nothing uses were not read.
                    if let Some(material) = imported.scene.materials.get(&id) {
                        emission.insert(id, material.emissive * *factor);
                    }
                }
            }
            let shines = |light: &&PlannedLight| {
                spec.lights.as_ref().is_none_or(|names| names.contains(&light.name))
            };
            plans.push(Self {
                name: spec.name.clone(),
                lights: lights.iter().filter(shines).cloned().collect(),
                sky,
                emission,
                sky_print: key.finish(),
            });
        }
        Ok(plans)
    }

    /// What the indirect light depends on, beside the geometry.
    pub(super) fn hash(&self, key: &mut Key) {
        key.print(self.sky_print).number(self.lights.len() as u64);
        for light in &self.lights {
            hash_light(&light.light, key);
        }
        for (id, emission) in &self.emission {
            key.number(id.0).vector(*emission);
        }
    }

    /// What the direct light depends on, beside the geometry.
    pub(super) fn hash_direct(&self, key: &mut Key) {
        for light in self.lights.iter().filter(|light| light.direct == Direct::Baked) {
            hash_light(&light.light, key);
            key.float(light.radius);
        }
    }

    /// The sky's radiance where it is the same from everywhere.
    pub(super) fn constant_sky(&self) -> Vec3 {
        match &self.sky {
            Sky::Constant(radiance) => *radiance,
            Sky::Image { .. } => Vec3::ZERO,
        }
    }
}

/// The lights of the file, then the added ones.
fn all_lights(
    input: &Input,
    imported: &ImportedScene,
    field: &dyn Fn(String, String) -> LightsError,
) -> Result<Vec<PlannedLight>, BakeError> {
    let extra = &input.lights;
    let mut lights = Vec::new();
    for id in &imported.light_ids {
        let Some(&light) = imported.scene.lights.get(id) else { continue };
        let node = id.0 as u32;
        let name = input.node_name(node).to_owned();
        let direct = match extra.realtime.contains(&name) && !name.is_empty() {
            true => Direct::Realtime,
            false => Direct::Baked,
        };
        let radius = match light.kind {
            LightKind::Directional => {
                extra.angle.get(&name).map_or(0.0, |angle| angle.to_radians())
            }
            _ => extra.radius.get(&name).copied().unwrap_or_default(),
        };
        lights.push(PlannedLight { node: Some(node), name, light, radius, direct });
    }
    let of = |wanted: bool| -> Vec<PlannedLight> {
        let is = |light: &&PlannedLight| (light.light.kind == LightKind::Directional) == wanted;
        lights.iter().filter(is).cloned().collect()
    };
    let check = |names: Vec<String>, among: &[PlannedLight], name: &str| {
        check_names(&names, among).map_err(|problem| field(name.to_owned(), problem))
    };
    check(extra.realtime.clone(), &lights, "realtime")?;
    check(extra.radius.keys().cloned().collect(), &of(false), "radius")?;
    check(extra.angle.keys().cloned().collect(), &of(true), "angle")?;
    let names: BTreeSet<String> = lights.iter().map(|light| light.name.clone()).collect();
    for (i, light) in extra.add.iter().enumerate() {
        if names.contains(&light.name) {
            let problem = format!("the scene has a light {:?} already", light.name);
            return Err(field(format!("add[{i}].name"), problem).into());
        }
        lights.push(added(light));
    }
    Ok(lights)
}

fn added(spec: &AddedLight) -> PlannedLight {
    let (kind, radius, range) = match spec.kind {
        AddedKind::Directional => (LightKind::Directional, spec.angle.to_radians(), f32::INFINITY),
        AddedKind::Point => (LightKind::Point, spec.radius, spec.range.unwrap_or(RANGE)),
        AddedKind::Spot { inner, outer } => {
            let outer_angle = outer.to_radians().max(1e-3);
            let inner_angle = inner.to_radians().min(outer_angle - 1e-4);
            let kind = LightKind::Spot { inner_angle, outer_angle };
            (kind, spec.radius, spec.range.unwrap_or(RANGE))
        }
    };
    let direction = Vec3::from(spec.direction).normalize_or(Vec3::NEG_Y);
    let light = Light {
        kind,
        position: spec.position.into(),
        direction,
        intensity: spec.intensity.into(),
        range,
    };
    PlannedLight { node: None, name: spec.name.clone(), light, radius, direct: spec.direct }
}

fn check_names(names: &[String], lights: &[PlannedLight]) -> Result<(), String> {
    let unknown = names.iter().find(|&name| !lights.iter().any(|light| light.name == **name));
    let Some(unknown) = unknown else { return Ok(()) };
    let known: Vec<_> = lights
        .iter()
        .filter(|light| !light.name.is_empty())
        .map(|light| format!("{:?}", light.name))
        .collect();
    Err(match known.is_empty() {
        true => format!("there is no such light {unknown:?}; there are none with a name"),
        false => {
            format!("there is no such light {unknown:?}; there are {}", shorten(&known.join(", ")))
        }
    })
}

fn shorten(text: &str) -> String {
    let mut short: String = text.chars().take(300).collect();
    if short.len() < text.len() {
        short += " ...";
    }
    short
}

fn constant(sky: Vec3, key: &mut Key) -> Sky {
    key.text("constant").vector(sky);
    Sky::Constant(sky)
}

fn hash_light(light: &Light, key: &mut Key) {
    match light.kind {
        LightKind::Point => key.text("point"),
        LightKind::Directional => key.text("directional"),
        LightKind::Spot { inner_angle, outer_angle } => {
            key.text("spot").float(inner_angle).float(outer_angle)
        }
    };
    key.vector(light.position).vector(light.direction).vector(light.intensity).float(light.range);
}
