//! The file of added lights and scenarios.

use std::collections::BTreeMap;

use farlight_baked_format::manifest::Direct;
use serde::Deserialize;

/// Added lights, and scenarios. Every field may be left out; an unknown one is an error.
#[derive(Clone, Debug, Default, PartialEq, Deserialize)]
#[serde(deny_unknown_fields, default)]
pub struct BakeLights {
    /// Lights that the scene's file does not have.
    pub add: Vec<AddedLight>,
    /// Lights of the file whose direct light stays with the engine, by the names of their nodes.
    /// Default: that of all is baked.
    pub realtime: Vec<String>,
    /// Radii in metres of point and spot lights of the file, by the names of their nodes, for soft
    /// shadows. Default: none, sharp shadows.
    pub radius: BTreeMap<String, f32>,
    /// Half the angles in degrees under which directional lights of the file are seen, by the names of
    /// their nodes, for soft shadows. The sun's is 0.27. Default: none, sharp shadows.
    pub angle: BTreeMap<String, f32>,
    /// States of the lights. Default: one with all lights, named `default`.
    pub scenarios: Vec<ScenarioSpec>,
}

/// A light that the scene's file does not have.
#[derive(Clone, Debug, Default, PartialEq, Deserialize)]
#[serde(deny_unknown_fields, default)]
pub struct AddedLight {
    /// How scenarios and the game call it. Must be given, and be nobody else's.
    pub name: String,
    /// Its shape. Default: `Point`.
    pub kind: AddedKind,
    /// World position in metres, of point and spot lights.
    pub position: [f32; 3],
    /// The direction in which it shines, of any length, of spot and directional lights.
    pub direction: [f32; 3],
    /// Linear RGB: luminous intensity in cd of point and spot lights, illuminance in lx of
    /// directional ones.
    pub intensity: [f32; 3],
    /// Where point and spot lights end, in metres, above 0. Default: 20, as in Bevy.
    pub range: Option<f32>,
    /// Radius in metres of point and spot lights, for soft shadows. Default: 0, sharp ones.
    pub radius: f32,
    /// Half the angle in degrees under which a directional light is seen, for soft shadows. The sun's is
    /// 0.27. Default: 0, sharp ones.
    pub angle: f32,
    /// Who shows what arrives straight from it: `Baked` or `Realtime`. Default: `Baked`.
    pub direct: Direct,
}

/// Shapes of added lights.
#[derive(Clone, Copy, Debug, Default, PartialEq, Deserialize)]
#[serde(deny_unknown_fields)]
pub enum AddedKind {
    /// To all sides.
    #[default]
    Point,
    /// A cone; half angles in degrees, `0 <= inner < outer <= 90`.
    Spot {
        /// Full intensity inside.
        inner: f32,
        /// Nothing outside.
        outer: f32,
    },
    /// Parallel light.
    Directional,
}

/// A state of the lights.
#[derive(Clone, Debug, Default, PartialEq, Deserialize)]
#[serde(deny_unknown_fields, default)]
pub struct ScenarioSpec {
    /// How a game calls it. Must be given, and be no other scenario's.
    pub name: String,
    /// The lights that shine, by their names or those of their nodes. Default: all.
    pub lights: Option<Vec<String>>,
    /// What is seen outside. Default: the sky of the command, which is black where none was given.
    pub sky: Option<SkySpec>,
    /// What the emission of materials is multiplied with, by their names; 0 is off. Default: 1.
    pub emission: BTreeMap<String, f32>,
}

/// A sky.
#[derive(Clone, Debug, PartialEq, Deserialize)]
#[serde(deny_unknown_fields)]
pub enum SkySpec {
    /// The same radiance from everywhere, in cd/m²: linear RGB.
    Constant([f32; 3]),
    /// An equirectangular picture.
    Image {
        /// The file (.hdr, .exr, ...), relative to the folder of this one.
        file: String,
        /// What its values are multiplied with to be cd/m². Default: 1.
        #[serde(default = "one")]
        scale: f32,
        /// Degrees about the vertical axis, counterclockwise seen from above. Unturned, the centre of the
        /// picture is -z and what is right of it +x. Default: 0.
        #[serde(default)]
        rotation: f32,
    },
}

fn one() -> f32 {
    1.0
}
