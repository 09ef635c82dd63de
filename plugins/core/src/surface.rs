//! What lighting knows of surfaces whose material it does not know.

use bevy::{app::PostUpdate, math::Vec3, prelude::*};

/// What a mesh whose material is no `StandardMaterial` reflects of the light that bounces through a
/// scene, as a diffuse surface.
///
/// Plugins with materials of their own keep it on the entities that carry them; a game may put it
/// on meshes with a `Material` of its own, so that these take part in the indirect light. Lighting
/// solvers read it where an entity has no `MeshMaterial3d<StandardMaterial>`.
#[derive(Component, Clone, Copy, Debug, Default, PartialEq, Reflect)]
#[reflect(Component, Default, Debug, Clone)]
pub struct DiffuseReflectance {
    /// The part of the light that is reflected, linear Rec. 709, 0 to 1 a channel; values beyond
    /// are cut. `None` while the material's data is on its way: the surface takes part once it
    /// is known.
    pub albedo: Option<Vec3>,
    /// Whether the backs of triangles are surfaces too.
    pub double_sided: bool,
}

/// On meshes whose light on surfaces was computed before: lighting solvers let them block and reflect
/// light, and leave their lightmap alone.
///
/// Whoever shows such light puts it there with the mesh's `Lightmap` or some frames before, in
/// [`LightmapSystems::Change`], so that a solver can take its own away.
#[derive(Component, Clone, Copy, Debug, Default, PartialEq, Eq, Reflect)]
#[reflect(Component, Default, Debug, Clone)]
pub struct BakedSurface;

/// On meshes that only cast shadows, for others: no surface that is lit, nor one that light is computed for.
#[derive(Component, Clone, Copy, Debug, Default, PartialEq, Eq, Reflect)]
#[reflect(Component, Default, Debug, Clone)]
pub struct ShadowProxy;

/// Sent in every frame in which solved light on surfaces becomes another one that no component shows:
/// texels of lightmaps or of probe volumes are written on the GPU, or light is switched off and on.
///
/// Whoever keeps pictures from frame to frame reads it, or goes on showing old light. After the last
/// message nothing more changes, so that a still scene comes to rest. Whoever solves light writes it
/// before [`LightmapSystems::Notice`] (`PostUpdate`); readers run after that.
#[derive(Message, Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct LightingChanged;

/// When `Lightmap`s come and go, in `PostUpdate`.
///
/// Bevy chooses a mesh's pipeline when its material changes, not when its lightmap does. So
/// whoever inserts or removes lightmaps does it in the first set, and each plugin with a material
/// of its own marks it as changed in the second, before Bevy's
/// `check_entities_needing_specialization`.
#[derive(SystemSet, Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub enum LightmapSystems {
    /// Inserts and removes lightmaps.
    Change,
    /// Sees those that came or went, in the same frame.
    Notice,
}

pub(crate) fn build(app: &mut App) {
    app.register_type::<DiffuseReflectance>()
        .register_type::<BakedSurface>()
        .register_type::<ShadowProxy>()
        .add_message::<LightingChanged>()
        .configure_sets(PostUpdate, (LightmapSystems::Change, LightmapSystems::Notice).chain());
}
