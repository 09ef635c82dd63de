//! What a mesh with a measured material carries.

use bevy::{
    asset::Asset,
    ecs::system::{SystemParamItem, lifetimeless::SRes},
    math::Vec2,
    mesh::MeshVertexBufferLayoutRef,
    pbr::{
        Lightmap, MATERIAL_BIND_GROUP_INDEX, Material, MaterialPipeline, MaterialPipelineKey,
        MeshPipelineKey,
    },
    prelude::*,
    reflect::TypePath,
    render::{
        render_resource::{
            AsBindGroup, AsBindGroupError, BindGroupLayout, BindGroupLayoutEntry, BindingResources,
            BindingType, BufferBindingType, OwnedBindingResource, RenderPipelineDescriptor,
            ShaderStages, SpecializedMeshPipelineError, UnpreparedBindGroup,
        },
        renderer::RenderDevice,
    },
    shader::{ShaderDefVal, ShaderRef},
};
use farlight_core::shader_path;

use crate::{
    BtfAsset,
    tables::{BtfTables, ENTRIES_BINDING, TABLES_BINDING, storage_is_usable},
};

/// How texels are joined to a picture.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Hash, Reflect)]
pub enum BtfFilter {
    /// The nearest texel: sharp squares, the least work.
    Nearest,
    /// Four texels, weighted by distance, in linear light.
    #[default]
    Bilinear,
}

/// A measured material on a mesh. The mesh needs normals and a first UV set; tangents are taken
/// from the mesh or derived from the UVs.
///
/// A value of the material is light already: radiance is E / pi times the value in linear light,
/// for an irradiance E of a surface that faces the light. The view's azimuth 0 is where u grows,
/// 90 degrees where v falls (up the picture). Nothing is seen until the file is loaded.
#[derive(Asset, TypePath, Clone, Debug)]
pub struct BtfMaterial {
    /// The measured data.
    pub btf: Handle<BtfAsset>,
    /// How often the picture repeats over the UV square.
    pub repeat: Vec2,
    /// Factor on the reflected light, 1 as measured.
    pub gain: f32,
    /// How texels are joined.
    pub filter: BtfFilter,
    /// The picture's resolution: how often its width and height are halved at least, from 0 to the
    /// number of coarser pictures (down to about 4 x 4 texels); between two numbers they are dithered.
    /// Where the material is seen from afar, coarser pictures are shown anyway. A negative number puts
    /// that off, by so many halvings: sharper, until it flickers. [`Self::WHOLE_PICTURE`] shows no coarser
    /// pictures at all.
    pub coarseness: f32,
    /// Whether the backs of triangles are seen too, as the same material.
    pub double_sided: bool,
    /// Whether light that stands lower than any that was measured
    /// ([`Info::light_limit`](crate::codec::Info::light_limit)) fades out with its cosine. What the
    /// data has there is extrapolated and does not end in black at the horizon, which shows as a hard
    /// line round objects where their own shadow begins. Values above the limit are untouched.
    pub fade_beyond_measured: bool,
}

impl BtfMaterial {
    /// The [`coarseness`](Self::coarseness) with which every texel is as measured, at any distance.
    pub const WHOLE_PICTURE: f32 = -32.0;

    /// As measured, once over the UV square.
    pub fn new(btf: Handle<BtfAsset>) -> Self {
        Self {
            btf,
            repeat: Vec2::ONE,
            gain: 1.0,
            filter: BtfFilter::default(),
            coarseness: 0.0,
            double_sided: false,
            fade_beyond_measured: true,
        }
    }
}

/// What makes another pipeline.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub struct BtfMaterialKey {
    double_sided: bool,
    filter: BtfFilter,
}

/// Bindings of a group of its own for each material, which nothing is drawn with:
/// `bind_groups.rs` gives materials of one buffer one group.
impl AsBindGroup for BtfMaterial {
    type Data = BtfMaterialKey;
    type Param = SRes<BtfTables>;

    fn label() -> &'static str {
        "farlight_btf_material"
    }

    fn bind_group_data(&self) -> Self::Data {
        BtfMaterialKey { double_sided: self.double_sided, filter: self.filter }
    }

    fn unprepared_bind_group(
        &self,
        _layout: &BindGroupLayout,
        _device: &RenderDevice,
        tables: &mut SystemParamItem<'_, '_, Self::Param>,
        _force_no_bindless: bool,
    ) -> Result<UnpreparedBindGroup, AsBindGroupError> {
        let bindings = tables.placeholder(self).ok_or(AsBindGroupError::RetryNextUpdate)?;
        let bindings: Vec<(u32, OwnedBindingResource)> = bindings;
        Ok(UnpreparedBindGroup { bindings: BindingResources(bindings) })
    }

    fn bind_group_layout_entries(device: &RenderDevice, _: bool) -> Vec<BindGroupLayoutEntry> {
        let entry = |binding, ty| BindGroupLayoutEntry {
            binding,
            visibility: ShaderStages::FRAGMENT,
            ty: BindingType::Buffer { ty, has_dynamic_offset: false, min_binding_size: None },
            count: None,
        };
        if storage_is_usable(device) {
            let storage = BufferBindingType::Storage { read_only: true };
            vec![entry(TABLES_BINDING, storage), entry(ENTRIES_BINDING, storage)]
        } else {
            vec![entry(0, BufferBindingType::Uniform)]
        }
    }
}

impl Material for BtfMaterial {
    fn fragment_shader() -> ShaderRef {
        ShaderRef::Path(shader_path("btf/material.wgsl").into())
    }

    fn specialize(
        _pipeline: &MaterialPipeline,
        descriptor: &mut RenderPipelineDescriptor,
        _layout: &MeshVertexBufferLayoutRef,
        key: MaterialPipelineKey<Self>,
    ) -> Result<(), SpecializedMeshPipelineError> {
        if key.bind_group_data.double_sided {
            descriptor.primitive.cull_mode = None;
        }
        if let Some(fragment) = &mut descriptor.fragment {
            // A lightmap holds the environment already, and Bevy 0.19.1 can't compile the two
            // together where binding arrays are missing.
            if key.mesh_key.contains(MeshPipelineKey::LIGHTMAPPED) {
                fragment.shader_defs.retain(|def| *def != "ENVIRONMENT_MAP".into());
            }
            let number = |name: &str, value: u32| ShaderDefVal::UInt(name.into(), value);
            fragment.shader_defs.extend([
                number("BTF_GROUP", MATERIAL_BIND_GROUP_INDEX as u32),
                number("BTF_TABLES", TABLES_BINDING),
                "BTF_LINEAR".into(),
            ]);
            if key.bind_group_data.filter == BtfFilter::Nearest {
                fragment.shader_defs.push("BTF_NEAREST".into());
            }
        }
        Ok(())
    }
}

/// Bevy finds another pipeline for a mesh when its material changes, not when its lightmap comes or
/// goes; without one, it would draw the mesh with bindings that are not there.
pub(crate) fn notice_lightmaps(
    mut materials: Query<&mut MeshMaterial3d<BtfMaterial>>,
    new: Query<Entity, (With<MeshMaterial3d<BtfMaterial>>, Added<Lightmap>)>,
    mut gone: RemovedComponents<Lightmap>,
) {
    for entity in new.iter().chain(gone.read()) {
        if let Ok(mut material) = materials.get_mut(entity) {
            material.set_changed();
        }
    }
}
