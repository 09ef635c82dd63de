//! The lights of a bake: those of the file, and those that were added to it.

use std::{collections::BTreeMap, f32::consts::PI};

use bevy::{
    camera::visibility::RenderLayers,
    ecs::system::SystemParam,
    light::{CascadeShadowConfig, CascadeShadowConfigBuilder},
    platform::collections::HashMap,
    prelude::*,
};
use farlight_baked_format::{
    Manifest,
    manifest::{Direct, Light, LightKind, Volume},
};

use crate::{BakedPart, backs::seeing_backs};

/// Distance in metres at which a light ends whose manifest names none.
const FAR: f32 = 1000.0;

/// What shines at some weights.
#[derive(Debug, Default, PartialEq)]
pub(crate) struct Plan<'m> {
    /// Lights of the file by node.
    pub(crate) own: BTreeMap<u32, Shine<'m>>,
    /// Lights to spawn: one for each that differs in more than its intensity.
    pub(crate) added: Vec<Shine<'m>>,
    /// The largest box of probes from corner to corner, in metres; 0 if there is none.
    size: f32,
}

/// One light.
#[derive(Debug, PartialEq)]
pub(crate) struct Shine<'m> {
    light: &'m Light,
    /// Sum over the scenarios: cd or lx.
    intensity: Vec3,
    /// Whether lightmaps hold what arrives straight from it, in all scenarios.
    baked: bool,
}

impl<'m> Plan<'m> {
    /// Adds the lights of all scenarios, each by its weight.
    pub(crate) fn new(manifest: &'m Manifest, weights: &[f32]) -> Self {
        let size = manifest.volumes.iter().map(diagonal).fold(0.0, f32::max);
        let mut plan = Self { size, ..Self::default() };
        for (scenario, &weight) in manifest.scenarios.iter().zip(weights) {
            for light in &scenario.lights {
                let intensity = Vec3::from(light.intensity) * weight;
                let baked = light.direct == Direct::Baked;
                let shine = Shine { light, intensity, baked };
                match light.node {
                    Some(node) => {
                        plan.own.entry(node).and_modify(|known| known.add(&shine)).or_insert(shine);
                    }
                    None => match plan.added.iter_mut().find(|known| known.is_same(light)) {
                        Some(known) => known.add(&shine),
                        None => plan.added.push(shine),
                    },
                }
            }
        }
        plan
    }
}

impl Shine<'_> {
    fn add(&mut self, other: &Self) {
        self.intensity += other.intensity;
        self.baked &= other.baked;
    }

    /// Whether `light` is this one, brighter or darker.
    fn is_same(&self, light: &Light) -> bool {
        let Light { intensity: _, node: _, name, direct, kind, position, direction, range, radius } =
            light;
        let own = self.light;
        own.name == *name
            && own.direct == *direct
            && own.kind == *kind
            && own.position == *position
            && own.direction == *direction
            && own.range == *range
            && own.radius == *radius
    }

    /// Colour, and its factor in cd or lx.
    fn colour(&self) -> (Color, f32) {
        let most = self.intensity.max_element();
        if !(most.is_finite() && most > 0.0) {
            return (Color::WHITE, 0.0);
        }
        let colour = self.intensity.max(Vec3::ZERO) / most;
        (Color::linear_rgb(colour.x, colour.y, colour.z), most)
    }

    fn is_on(&self) -> bool {
        self.colour().1 > 0.0
    }

    fn range(&self) -> f32 {
        if self.light.range > 0.0 { self.light.range } else { FAR }
    }

    fn transform(&self) -> Transform {
        let direction = Dir3::new(self.light.direction.into()).unwrap_or(Dir3::NEG_Z);
        let up = direction.any_orthonormal_vector();
        Transform::from_translation(self.light.position.into()).looking_to(direction, up)
    }
}

/// Components of lights.
#[derive(SystemParam)]
pub(crate) struct LightQueries<'w, 's> {
    point: Query<'w, 's, &'static mut PointLight>,
    spot: Query<'w, 's, &'static mut SpotLight>,
    sun: Query<'w, 's, &'static mut DirectionalLight>,
    layers: Query<'w, 's, Option<&'static RenderLayers>>,
}

/// Sets fields of a component from variables of their names. A component that is so already is not
/// touched.
macro_rules! set {
    ($component:ident: $($field:ident),+) => {
        if $($component.$field != $field)||+ {
            $($component.$field = $field;)+
        }
    };
}

/// A light of the file as it was.
struct Original {
    component: LightComponent,
    layers: Option<RenderLayers>,
}

/// Its component.
enum LightComponent {
    Point(PointLight),
    Spot(SpotLight),
    Sun(DirectionalLight),
}

/// The lights of a root.
#[derive(Default)]
pub(crate) struct Lights {
    /// The lights of the spawned scene, by node.
    pub(crate) found: HashMap<u32, Vec<Entity>>,
    own: HashMap<Entity, Original>,
    added: Vec<Entity>,
}

impl Lights {
    pub(crate) fn len(&self) -> usize {
        self.own.len() + self.added.len()
    }

    /// Makes the lights what the plan says; `anew` says that its added lights may be others than
    /// before.
    pub(crate) fn apply(
        &mut self,
        plan: &Plan,
        root: Entity,
        anew: bool,
        commands: &mut Commands,
        queries: &mut LightQueries,
    ) {
        let mut known = std::mem::take(&mut self.own);
        for (node, shine) in &plan.own {
            for &entity in self.found.get(node).into_iter().flatten() {
                let original = known.remove(&entity).or_else(|| {
                    let original = queries.original(entity)?;
                    commands.entity(entity).try_insert(seeing_backs(original.layers.as_ref()));
                    Some(original)
                });
                if let Some(original) = original {
                    queries.shine(entity, shine);
                    self.own.insert(entity, original);
                }
            }
        }
        for (entity, original) in known {
            queries.restore(entity, original, commands);
        }

        if anew || self.added.len() != plan.added.len() {
            self.despawn(commands);
            self.added
                .extend(plan.added.iter().map(|shine| spawn(shine, plan.size, root, commands)));
            return;
        }
        for (&entity, shine) in self.added.iter().zip(&plan.added) {
            queries.shine(entity, shine);
            queries.cast_shadows(entity, shine.is_on());
        }
    }

    fn despawn(&mut self, commands: &mut Commands) {
        for entity in self.added.drain(..) {
            commands.entity(entity).try_despawn();
        }
    }

    /// Undoes everything.
    pub(crate) fn remove(mut self, commands: &mut Commands, queries: &mut LightQueries) {
        self.despawn(commands);
        for (entity, original) in self.own {
            queries.restore(entity, original, commands);
        }
    }
}

impl LightQueries<'_, '_> {
    fn original(&self, entity: Entity) -> Option<Original> {
        let layers = self.layers.get(entity).ok()?.cloned();
        let component = if let Ok(light) = self.point.get(entity) {
            LightComponent::Point(*light)
        } else if let Ok(light) = self.spot.get(entity) {
            LightComponent::Spot(*light)
        } else {
            LightComponent::Sun(*self.sun.get(entity).ok()?)
        };
        Some(Original { component, layers })
    }

    /// Gives a light its intensity and says whether lightmaps hold its direct light.
    fn shine(&mut self, entity: Entity, shine: &Shine) {
        let (color, most) = shine.colour();
        let (intensity, range, radius) = (most * 4.0 * PI, shine.range(), shine.light.radius);
        let affects_lightmapped_mesh_diffuse = !shine.baked;
        if let Ok(mut light) = self.point.get_mut(entity) {
            set!(light: color, intensity, range, radius, affects_lightmapped_mesh_diffuse);
        }
        if let Ok(mut light) = self.spot.get_mut(entity) {
            set!(light: color, intensity, range, radius, affects_lightmapped_mesh_diffuse);
        }
        if let Ok(mut light) = self.sun.get_mut(entity) {
            let illuminance = most;
            set!(light: color, illuminance, affects_lightmapped_mesh_diffuse);
        }
    }

    /// A light that doesn't shine costs no shadow map. (It isn't hidden instead: a directional light of
    /// Bevy 0.19.1 that was hidden and is shown again has lost its shadows.)
    fn cast_shadows(&mut self, entity: Entity, shadow_maps_enabled: bool) {
        if let Ok(mut light) = self.point.get_mut(entity) {
            set!(light: shadow_maps_enabled);
        }
        if let Ok(mut light) = self.spot.get_mut(entity) {
            set!(light: shadow_maps_enabled);
        }
        if let Ok(mut light) = self.sun.get_mut(entity) {
            set!(light: shadow_maps_enabled);
        }
    }

    fn restore(&mut self, entity: Entity, original: Original, commands: &mut Commands) {
        // The entity may be gone, or no light any more.
        let _ = match original.component {
            LightComponent::Point(light) => self.point.get_mut(entity).map(|mut now| *now = light),
            LightComponent::Spot(light) => self.spot.get_mut(entity).map(|mut now| *now = light),
            LightComponent::Sun(light) => self.sun.get_mut(entity).map(|mut now| *now = light),
        };
        match original.layers {
            Some(layers) => commands.entity(entity).try_insert(layers),
            None => commands.entity(entity).try_remove::<RenderLayers>(),
        };
    }
}

/// A light that the bake added, below the root. It casts shadows: objects without a lightmap, and
/// what shines on lightmapped ones, are lit by it too.
fn spawn(shine: &Shine, size: f32, root: Entity, commands: &mut Commands) -> Entity {
    let (color, most) = shine.colour();
    let (intensity, range, radius) = (most * 4.0 * PI, shine.range(), shine.light.radius);
    let name = if shine.light.name.is_empty() { "baked light" } else { &shine.light.name };
    let common = (
        BakedPart,
        Name::new(name.to_owned()),
        shine.transform(),
        seeing_backs(None),
        ChildOf(root),
    );
    let affects_lightmapped_mesh_diffuse = !shine.baked;
    let mut entity = commands.spawn(common);
    match shine.light.kind {
        LightKind::Point => entity.insert(PointLight {
            color,
            intensity,
            range,
            radius,
            shadow_maps_enabled: shine.is_on(),
            affects_lightmapped_mesh_diffuse,
            ..default()
        }),
        LightKind::Spot { inner, outer } => entity.insert(SpotLight {
            color,
            intensity,
            range,
            radius,
            inner_angle: inner,
            outer_angle: outer,
            shadow_maps_enabled: shine.is_on(),
            affects_lightmapped_mesh_diffuse,
            ..default()
        }),
        LightKind::Directional => entity.insert((
            DirectionalLight {
                color,
                illuminance: most,
                shadow_maps_enabled: shine.is_on(),
                affects_lightmapped_mesh_diffuse,
                ..default()
            },
            cascades(size),
        )),
    };
    entity.id()
}

/// Shadow maps for a scene of `size` metres from corner to corner: Bevy's are for landscapes of 150 m, and
/// let sunlight of a width of some centimetres into the corners of rooms.
fn cascades(size: f32) -> CascadeShadowConfig {
    let landscape = CascadeShadowConfigBuilder::default();
    if size <= 0.0 {
        return landscape.build();
    }
    // Also somebody who looks in from outside sees shadows.
    let maximum_distance = (size * 3.0).clamp(4.0, landscape.maximum_distance);
    let first_cascade_far_bound = (size / 4.0).clamp(1.0, landscape.first_cascade_far_bound);
    CascadeShadowConfigBuilder { maximum_distance, first_cascade_far_bound, ..landscape }.build()
}

fn diagonal(volume: &Volume) -> f32 {
    let [x, y, z, _] = volume.transform.map(Vec3::from);
    Vec3::new(x.length(), y.length(), z.length()).length()
}

#[cfg(test)]
mod tests {
    use farlight_baked_format::manifest::Scenario;

    use super::*;

    fn light(name: &str, node: Option<u32>, intensity: f32) -> Light {
        Light {
            node,
            name: name.into(),
            direct: Direct::Baked,
            kind: LightKind::Point,
            position: [0.0; 3],
            direction: [0.0; 3],
            intensity: [intensity, intensity / 2.0, 0.0],
            range: 0.0,
            radius: 0.0,
        }
    }

    fn scenario(name: &str, lights: Vec<Light>) -> Scenario {
        Scenario { name: name.into(), lights, ..Scenario::default() }
    }

    #[test]
    fn lights_follow_the_weights() {
        let moved = Light { position: [1.0, 0.0, 0.0], ..light("lamp", None, 8.0) };
        let realtime = Light { direct: Direct::Realtime, ..light("own", Some(3), 1.0) };
        let manifest = Manifest {
            scenarios: vec![
                scenario("a", vec![light("lamp", None, 10.0), light("own", Some(3), 4.0)]),
                scenario("b", vec![light("lamp", None, 20.0), moved, realtime]),
                scenario("c", vec![light("other", Some(4), 6.0)]),
            ],
            ..Manifest::default()
        };
        let plan = Plan::new(&manifest, &[0.5, 0.25, 0.0]);
        let added: Vec<_> = plan.added.iter().map(|shine| shine.intensity.x).collect();
        assert_eq!(added, [10.0, 2.0], "the same light adds up, one elsewhere is another");
        assert_eq!(plan.own[&3].intensity.x, 2.25);
        assert!(!plan.own[&3].baked, "one scenario leaves its direct light to the engine");
        assert_eq!(plan.own[&4].intensity, Vec3::ZERO, "a light of another scenario is off");
        let (color, candela) = plan.added[0].colour();
        assert_eq!((color.to_linear().green, candela), (0.5, 10.0));
    }
}
