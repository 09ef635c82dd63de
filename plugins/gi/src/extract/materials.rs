//! Standard materials, and surfaces of which the reflectance is all that is known.

use bevy::{ecs::entity::EntityHashSet, mesh::UvChannel, prelude::*};
use farlight_core::DiffuseReflectance;
use farlight_gi_solver::{
    SceneChange,
    scene::{self, MaterialId, TextureId},
};

use super::{Extractor, set_material};
use crate::{
    GiSettings,
    status::{GiMeter, Stage},
};

/// What says how an instance reflects.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub(super) enum MaterialKey {
    Standard(AssetId<StandardMaterial>),
    /// [`DiffuseReflectance`] of the entity. Each has a material of its own, so that a change of
    /// colour is no change of geometry.
    Reflectance(Entity),
}

/// A material that instances use.
pub(super) struct MaterialState {
    pub(super) id: MaterialId,
    pub(super) shading: Shading,
    /// Something about it that its instances should know.
    pub(super) remark: Option<String>,
    users: EntityHashSet,
    textures: Vec<AssetId<Image>>,
    dirty: bool,
}

/// How an instance takes part.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Shading {
    /// The asset isn't loaded yet.
    Unknown,
    Opaque,
    Blended,
}

impl Extractor {
    pub(super) fn use_material(&mut self, material: MaterialKey, entity: Entity) -> &MaterialState {
        if !self.materials.contains_key(&material) {
            let id = MaterialId(self.new_id());
            let state = MaterialState {
                id,
                shading: Shading::Unknown,
                remark: None,
                users: EntityHashSet::default(),
                textures: Vec::new(),
                dirty: true,
            };
            self.materials.insert(material, state);
        }
        let state = self.materials.get_mut(&material).expect("it was just inserted");
        state.users.insert(entity);
        state
    }

    pub(super) fn release_material(&mut self, material: MaterialKey, entity: Entity) {
        let Some(state) = self.materials.get_mut(&material) else { return };
        state.users.remove(&entity);
        if state.users.is_empty()
            && let Some(state) = self.materials.remove(&material)
        {
            self.changes.unused.push(SceneChange::RemoveMaterial(state.id));
            if let MaterialKey::Standard(material) = material {
                for texture in state.textures {
                    self.release_texture(texture, material);
                }
            }
        }
    }
}

/// Looks at materials that are new or changed.
pub(crate) fn extract_materials(
    mut extractor: ResMut<Extractor>,
    mut events: MessageReader<AssetEvent<StandardMaterial>>,
    materials: Res<Assets<StandardMaterial>>,
    reflectances: Query<&DiffuseReflectance>,
    changed: Query<Entity, Changed<DiffuseReflectance>>,
    settings: Res<GiSettings>,
    mut exposure_ref: Local<f32>,
    meter: Res<GiMeter>,
) {
    let _measure = meter.measure(Stage::Extract as usize);
    let extractor = &mut *extractor;
    for event in events.read() {
        if let AssetEvent::Added { id } | AssetEvent::Modified { id } = event
            && let Some(state) = extractor.materials.get_mut(&MaterialKey::Standard(*id))
        {
            state.dirty = true;
        }
    }
    for entity in &changed {
        if let Some(state) = extractor.materials.get_mut(&MaterialKey::Reflectance(entity)) {
            state.dirty = true;
        }
    }
    if settings.exposure_ref != *exposure_ref {
        *exposure_ref = settings.exposure_ref;
        extractor.materials.values_mut().for_each(|state| state.dirty = true);
    }
    let dirty = extractor
        .materials
        .iter()
        .filter(|(_, state)| state.dirty)
        .map(|(&id, _)| id)
        .collect::<Vec<_>>();
    for id in dirty {
        match id {
            MaterialKey::Standard(id) => {
                let Some(material) = materials.get(id) else { continue };
                look(extractor, id, material, settings.exposure_ref);
            }
            MaterialKey::Reflectance(entity) => {
                let Some(converted) = reflectances.get(entity).ok().and_then(diffuse) else {
                    continue;
                };
                take(extractor, id, Shading::Opaque, None, Vec::new(), converted);
            }
        }
    }
}

fn look(
    extractor: &mut Extractor,
    id: AssetId<StandardMaterial>,
    material: &StandardMaterial,
    exposure_ref: f32,
) {
    let mut used = Vec::new();
    let mut texture = |extractor: &mut Extractor, handle: &Option<Handle<Image>>, channel| {
        // The solver reads textures at the first UV set; one at the second is left out.
        let handle = handle.as_ref().filter(|_| channel == UvChannel::Uv0)?;
        used.push(handle.id());
        Some(extractor.use_texture(handle.id(), id))
    };
    let base_color_texture =
        texture(extractor, &material.base_color_texture, material.base_color_channel.clone());
    let emissive_texture =
        texture(extractor, &material.emissive_texture, material.emissive_channel.clone());
    let converted = convert(material, base_color_texture, emissive_texture, exposure_ref);
    let shading = match converted.alpha_mode {
        scene::AlphaMode::Blend => Shading::Blended,
        scene::AlphaMode::Opaque | scene::AlphaMode::Mask(_) => Shading::Opaque,
    };
    let remark = (material.lightmap_exposure != 1.0).then(|| {
        format!(
            "its material's lightmap_exposure is {}, which scales the indirect light; 1 is right",
            material.lightmap_exposure
        )
    });

    let released = take(extractor, MaterialKey::Standard(id), shading, remark, used, converted);
    for texture in released {
        extractor.release_texture(texture, id);
    }
}

/// Takes over what was found; answers textures that are no longer used.
fn take(
    extractor: &mut Extractor,
    key: MaterialKey,
    shading: Shading,
    remark: Option<String>,
    used: Vec<AssetId<Image>>,
    converted: scene::Material,
) -> Vec<AssetId<Image>> {
    let Some(state) = extractor.materials.get_mut(&key) else { return Vec::new() };
    state.dirty = false;
    let released: Vec<_> = state.textures.iter().filter(|t| !used.contains(t)).copied().collect();
    state.textures = used;
    if state.shading != shading || state.remark != remark {
        state.shading = shading;
        state.remark = remark;
        extractor.dirty.extend(state.users.iter().copied());
    }
    set_material(&mut extractor.changes, state.id, converted);
    released
}

/// A diffuse surface; nothing while its albedo isn't known.
fn diffuse(reflectance: &DiffuseReflectance) -> Option<scene::Material> {
    let albedo = reflectance.albedo.filter(|albedo| albedo.is_finite())?;
    Some(scene::Material {
        base_color: albedo.clamp(Vec3::ZERO, Vec3::ONE).extend(1.0),
        metallic: 0.0,
        perceptual_roughness: 1.0,
        reflectance: 0.0,
        double_sided: reflectance.double_sided,
        ..scene::Material::default()
    })
}

/// The solver's description of a material. Emitted radiance follows Bevy's shader: `emissive`
/// times exposure where the weight is 1, as it is on screen where the weight is 0.
fn convert(
    material: &StandardMaterial,
    base_color_texture: Option<TextureId>,
    emissive_texture: Option<TextureId>,
    exposure_ref: f32,
) -> scene::Material {
    let base = material.base_color.to_linear().to_vec4();
    let base = if base.is_finite() { base } else { Vec4::ONE };
    let emissive = material.emissive.to_vec3();
    let weight = material.emissive_exposure_weight;
    let emissive = emissive * (1.0 / exposure_ref).lerp(1.0, weight);
    scene::Material {
        base_color: base.clamp(Vec4::ZERO, Vec4::ONE),
        base_color_texture,
        metallic: material.metallic,
        perceptual_roughness: material.perceptual_roughness,
        metallic_roughness_texture: None,
        reflectance: material.reflectance,
        emissive: if emissive.is_finite() { emissive.max(Vec3::ZERO) } else { Vec3::ZERO },
        emissive_texture,
        alpha_mode: match material.alpha_mode {
            AlphaMode::Opaque => scene::AlphaMode::Opaque,
            AlphaMode::Mask(cutoff) => scene::AlphaMode::Mask(cutoff),
            AlphaMode::AlphaToCoverage => scene::AlphaMode::Mask(0.5),
            AlphaMode::Blend | AlphaMode::Premultiplied | AlphaMode::Add | AlphaMode::Multiply => {
                scene::AlphaMode::Blend
            }
        },
        double_sided: material.double_sided,
        uv_transform: material.uv_transform,
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn emission_is_absolute_with_weight_one_and_relative_to_the_exposure_with_zero() {
        let material = |weight| StandardMaterial {
            emissive: LinearRgba::rgb(2.0, 4.0, 6.0),
            emissive_exposure_weight: weight,
            ..Default::default()
        };
        let emissive = |weight| convert(&material(weight), None, None, 0.001).emissive;
        assert_eq!(emissive(1.0), Vec3::new(2.0, 4.0, 6.0));
        assert!((emissive(0.0) - Vec3::new(2000.0, 4000.0, 6000.0)).abs().max_element() < 0.01);
    }
}
