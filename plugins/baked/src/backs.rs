//! Backs that cast shadows.
//!
//! Bevy's shadow maps leave out the backs of single-sided materials, so that the sun shines through a wall that
//! nobody sees from outside: as highlights on what lightmaps light rightly, and on all that moves. So
//! every lit mesh of such a material gets a twin that is culled the other way round and that only lights of
//! the bake see, on a render layer of its own.

use bevy::{
    camera::visibility::RenderLayers,
    ecs::{lifecycle::HookContext, world::DeferredWorld},
    light::NotShadowCaster,
    platform::collections::HashMap,
    prelude::*,
    render::render_resource::Face,
};
use farlight_core::ShadowProxy;

use crate::BakedPart;

/// The [render layer](RenderLayers) of meshes that only cast shadows: lights of a bake see it, cameras
/// shouldn't.
pub const SHADOW_LAYER: usize = 62;

/// On a lit mesh whose back is to cast shadows too.
#[derive(Component, Default)]
#[component(on_remove = forget)]
pub(crate) struct SolidBack {
    /// The twin, and the mesh and the material that it was made from.
    twin: Option<(Entity, (AssetId<Mesh>, AssetId<StandardMaterial>))>,
}

fn forget(mut world: DeferredWorld, HookContext { entity, .. }: HookContext) {
    let twin = world.get::<SolidBack>(entity).and_then(|solid| solid.twin);
    if let Some((twin, _)) = twin {
        world.commands().entity(twin).try_despawn();
    }
}

/// The layers of a light that sees [`SHADOW_LAYER`] too.
pub(crate) fn seeing_backs(layers: Option<&RenderLayers>) -> RenderLayers {
    layers.cloned().unwrap_or_default().with(SHADOW_LAYER)
}

/// Materials of twins, by those of the meshes; one for all that are opaque.
#[derive(Default)]
pub(crate) struct Casters {
    opaque: Option<Handle<StandardMaterial>>,
    cut_out: HashMap<AssetId<StandardMaterial>, Handle<StandardMaterial>>,
}

impl Casters {
    /// `None` for what needs no twin: both of its sides cast shadows, or it isn't solid.
    fn of(
        &mut self,
        id: AssetId<StandardMaterial>,
        materials: &mut Assets<StandardMaterial>,
    ) -> Option<Handle<StandardMaterial>> {
        let original = materials.get(id)?;
        if original.cull_mode != Some(Face::Back) || original.double_sided {
            return None;
        }
        let culled = |original| StandardMaterial { cull_mode: Some(Face::Front), ..original };
        let made = match original.alpha_mode {
            AlphaMode::Opaque => {
                self.opaque.get_or_insert_with(|| materials.add(culled(default())))
            }
            AlphaMode::Mask(_) => {
                let original = original.clone();
                self.cut_out.entry(id).or_insert_with(|| materials.add(culled(original)))
            }
            _ => return None,
        };
        Some(made.clone())
    }
}

/// Spawns twins, and those of what became another.
pub(crate) fn cast(
    mut commands: Commands,
    mut meshes: Query<
        (Entity, &Mesh3d, &MeshMaterial3d<StandardMaterial>, &mut SolidBack, Has<NotShadowCaster>),
        Or<(Added<SolidBack>, Changed<Mesh3d>, Changed<MeshMaterial3d<StandardMaterial>>)>,
    >,
    mut materials: ResMut<Assets<StandardMaterial>>,
    mut casters: Local<Casters>,
) {
    for (entity, mesh, material, mut solid, casts_none) in &mut meshes {
        let solid = solid.bypass_change_detection();
        let from = (mesh.id(), material.id());
        if solid.twin.is_some_and(|(_, known)| known == from) {
            continue;
        }
        if let Some((twin, _)) = solid.twin.take() {
            commands.entity(twin).try_despawn();
        }
        let caster = if casts_none { None } else { casters.of(from.1, &mut materials) };
        let Some(caster) = caster else { continue };
        let twin = commands.spawn((
            BakedPart,
            ShadowProxy,
            mesh.clone(),
            MeshMaterial3d(caster),
            RenderLayers::layer(SHADOW_LAYER),
            ChildOf(entity),
        ));
        solid.twin = Some((twin.id(), from));
    }
}
