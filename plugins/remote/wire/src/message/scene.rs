//! Snapshots as bytes.
//!
//! An object is its tag (`u8`), its id, the length of its state (0: removed) and the state; a reader
//! skips tags that it does not know. Materials carry the standard parameters and then a list of
//! extensions (kind `u16`, length, bytes), which readers that don't know the kind skip: they show
//! the standard parameters instead.

use farlight_gi_solver::{
    scene::{
        AlphaMode, DirectSky, Instance, InstanceId, Light, LightId, LightKind, Material,
        MaterialId, MeshId, TextureId,
    },
    session::{GridId, ProbeGrid, SnapshotId},
};
use glam::{Affine2, Affine3A, Quat, UVec3, Vec4};

use super::{Object, ObjectKey, SkyObject, SnapshotPart};
use crate::{
    BlobHash, WireError,
    codec::{Reader, Writer},
};

/// Bytes of an object's state.
const MAX_STATE: usize = 4096;
/// Extensions of a material.
const MAX_EXTENSIONS: usize = 16;

pub(super) fn write_part(w: &mut Writer, part: &SnapshotPart) {
    w.u64(part.snapshot.0);
    w.u8(part.last.into());
    w.count(part.changes.len());
    for (key, object) in &part.changes {
        write_change(w, key, object.as_ref());
    }
}

pub(super) fn read_part(bytes: &[u8]) -> Result<SnapshotPart, WireError> {
    let mut r = Reader::new("a snapshot", bytes);
    let (snapshot, last) = (SnapshotId(r.u64()?), r.flag()?);
    // The shortest change: a tag, an id (none for the sky), a length.
    let count = r.count(2, usize::MAX)?;
    let mut changes = Vec::new();
    for _ in 0..count {
        changes.extend(read_change(&mut r)?);
    }
    Ok(SnapshotPart { snapshot, last, changes })
}

/// Writes an object and its newest state.
pub(crate) fn write_change(w: &mut Writer, key: &ObjectKey, object: Option<&Object>) {
    let (tag, id) = match key {
        ObjectKey::Texture(id) => (1, id.0),
        ObjectKey::Material(id) => (2, id.0),
        ObjectKey::Mesh(id) => (3, id.0),
        ObjectKey::Instance(id) => (4, id.0),
        ObjectKey::Receiver(id) => (5, id.0),
        ObjectKey::Light(id) => (6, id.0),
        ObjectKey::Sky => (7, 0),
        ObjectKey::Grid(id) => (8, id.0),
        ObjectKey::DirectSky => (9, 0),
    };
    w.u8(tag);
    w.varint(id);
    let mut state = Writer::default();
    if let Some(object) = object {
        write_state(&mut state, object);
    }
    w.bytes(&state.finish());
}

/// Whether the other side will take an object: its numbers are finite where they must be.
pub(crate) fn is_readable(key: &ObjectKey, object: &Object) -> bool {
    let mut state = Writer::default();
    write_state(&mut state, object);
    read_state(key, &state.finish()).is_ok()
}

fn write_state(w: &mut Writer, object: &Object) {
    match object {
        Object::Texture(hash) | Object::Mesh(hash) => w.raw(&hash.0),
        Object::Material(material) => write_material(w, material),
        Object::Instance(instance) => {
            w.varint(instance.mesh.0);
            w.varint(instance.material.0);
            w.floats(instance.transform.to_cols_array());
        }
        Object::Receiver => w.u8(1),
        Object::Light(light) => write_light(w, light),
        Object::Sky(SkyObject::Constant(radiance)) => {
            w.u8(0);
            w.floats(radiance.to_array());
        }
        Object::Sky(SkyObject::Image { image, rotation, scale }) => {
            w.u8(1);
            w.raw(&image.0);
            w.floats(rotation.to_array());
            w.f32(*scale);
        }
        Object::DirectSky(direct) => w.u8(match direct {
            DirectSky::Included => 0,
            DirectSky::LeftOut => 1,
        }),
        Object::Grid(grid) => {
            w.floats(grid.transform.to_cols_array());
            grid.resolution.to_array().into_iter().for_each(|n| w.u32(n));
        }
    }
}

/// `None` for an object of a newer version.
fn read_change(r: &mut Reader<'_>) -> Result<Option<(ObjectKey, Option<Object>)>, WireError> {
    let (tag, id) = (r.u8()?, r.varint()?);
    let state = r.bytes(MAX_STATE)?;
    let key = match tag {
        1 => ObjectKey::Texture(TextureId(id)),
        2 => ObjectKey::Material(MaterialId(id)),
        3 => ObjectKey::Mesh(MeshId(id)),
        4 => ObjectKey::Instance(InstanceId(id)),
        5 => ObjectKey::Receiver(InstanceId(id)),
        6 => ObjectKey::Light(LightId(id)),
        7 => ObjectKey::Sky,
        8 => ObjectKey::Grid(GridId(id)),
        9 => ObjectKey::DirectSky,
        _ => return Ok(None),
    };
    if state.is_empty() {
        return Ok(Some((key, None)));
    }
    Ok(Some((key, Some(read_state(&key, state)?))))
}

fn read_state(key: &ObjectKey, state: &[u8]) -> Result<Object, WireError> {
    let mut r = Reader::new("the state of an object", state);
    Ok(match key {
        ObjectKey::Texture(_) => Object::Texture(BlobHash(r.array()?)),
        ObjectKey::Mesh(_) => Object::Mesh(BlobHash(r.array()?)),
        ObjectKey::Material(_) => Object::Material(read_material(&mut r)?),
        ObjectKey::Instance(_) => Object::Instance(Instance {
            mesh: MeshId(r.varint()?),
            material: MaterialId(r.varint()?),
            transform: Affine3A::from_cols_array(&r.floats()?),
        }),
        ObjectKey::Receiver(_) => Object::Receiver,
        ObjectKey::Light(_) => Object::Light(read_light(&mut r)?),
        ObjectKey::Sky => Object::Sky(match r.u8()? {
            0 => SkyObject::Constant(r.floats()?.into()),
            1 => SkyObject::Image {
                image: BlobHash(r.array()?),
                rotation: Quat::from_array(r.floats()?),
                scale: r.floats::<1>()?[0],
            },
            other => return Err(r.invalid(format_args!("sky of kind {other}"))),
        }),
        ObjectKey::DirectSky => Object::DirectSky(match r.u8()? {
            0 => DirectSky::Included,
            1 => DirectSky::LeftOut,
            other => return Err(r.invalid(format_args!("direct light of the sky of kind {other}"))),
        }),
        ObjectKey::Grid(_) => {
            let transform = Affine3A::from_cols_array(&r.floats()?);
            let resolution = UVec3::new(r.u32()?, r.u32()?, r.u32()?);
            if resolution.min_element() == 0 || resolution.max_element() > 4096 {
                return Err(r.invalid(format_args!("a grid of {resolution} probes")));
            }
            Object::Grid(ProbeGrid { transform, resolution })
        }
    })
}

fn write_material(w: &mut Writer, material: &Material) {
    w.floats(material.base_color.to_array());
    write_texture(w, material.base_color_texture);
    w.floats([material.metallic, material.perceptual_roughness, material.reflectance]);
    write_texture(w, material.metallic_roughness_texture);
    w.floats(material.emissive.to_array());
    write_texture(w, material.emissive_texture);
    match material.alpha_mode {
        AlphaMode::Opaque => w.u8(0),
        AlphaMode::Mask(cutoff) => {
            w.u8(1);
            w.f32(cutoff);
        }
        AlphaMode::Blend => w.u8(2),
    }
    w.u8(material.double_sided.into());
    w.floats(material.uv_transform.to_cols_array());
    w.count(0);
}

fn read_material(r: &mut Reader<'_>) -> Result<Material, WireError> {
    let base_color = Vec4::from_array(r.floats()?);
    let base_color_texture = read_texture(r)?;
    let [metallic, perceptual_roughness, reflectance] = r.floats()?;
    let metallic_roughness_texture = read_texture(r)?;
    let emissive = r.floats()?.into();
    let emissive_texture = read_texture(r)?;
    let alpha_mode = match r.u8()? {
        0 => AlphaMode::Opaque,
        1 => AlphaMode::Mask(r.floats::<1>()?[0]),
        2 => AlphaMode::Blend,
        other => return Err(r.invalid(format_args!("alpha mode {other}"))),
    };
    let double_sided = r.flag()?;
    let uv_transform = Affine2::from_cols_array(&r.floats()?);
    for _ in 0..r.count(3, MAX_EXTENSIONS)? {
        let _kind = r.u16()?;
        r.bytes(MAX_STATE)?;
    }
    Ok(Material {
        base_color,
        base_color_texture,
        metallic,
        perceptual_roughness,
        metallic_roughness_texture,
        reflectance,
        emissive,
        emissive_texture,
        alpha_mode,
        double_sided,
        uv_transform,
    })
}

fn write_texture(w: &mut Writer, texture: Option<TextureId>) {
    w.u8(texture.is_some().into());
    if let Some(id) = texture {
        w.varint(id.0);
    }
}

fn read_texture(r: &mut Reader<'_>) -> Result<Option<TextureId>, WireError> {
    Ok(if r.flag()? { Some(TextureId(r.varint()?)) } else { None })
}

fn write_light(w: &mut Writer, light: &Light) {
    match light.kind {
        LightKind::Point => w.u8(0),
        LightKind::Spot { inner_angle, outer_angle } => {
            w.u8(1);
            w.floats([inner_angle, outer_angle]);
        }
        LightKind::Directional => w.u8(2),
    }
    w.floats(light.position.to_array());
    w.floats(light.direction.to_array());
    w.floats(light.intensity.to_array());
    w.f32(light.range);
}

fn read_light(r: &mut Reader<'_>) -> Result<Light, WireError> {
    let kind = match r.u8()? {
        0 => LightKind::Point,
        1 => {
            let [inner_angle, outer_angle] = r.floats()?;
            LightKind::Spot { inner_angle, outer_angle }
        }
        2 => LightKind::Directional,
        other => return Err(r.invalid(format_args!("light of kind {other}"))),
    };
    let (position, direction) = (r.floats()?.into(), r.floats()?.into());
    let intensity = r.floats()?.into();
    // Infinity: no range window.
    let range = r.f32()?;
    if range.is_nan() {
        return Err(r.invalid("a light's range is not a number"));
    }
    Ok(Light { kind, position, direction, intensity, range })
}

#[cfg(test)]
mod tests {
    use glam::{Vec2, Vec3};

    use super::*;

    fn part() -> SnapshotPart {
        let instance = Instance {
            mesh: MeshId(3),
            material: MaterialId(u64::MAX),
            transform: Affine3A::from_scale_rotation_translation(
                Vec3::new(1.0, -2.0, 3.0),
                Quat::from_rotation_y(1.0),
                Vec3::splat(0.5),
            ),
        };
        let material = Material {
            base_color_texture: Some(TextureId(1 << 40)),
            alpha_mode: AlphaMode::Mask(0.25),
            emissive: Vec3::new(1e4, 0.0, 3.0),
            uv_transform: Affine2::from_scale(Vec2::new(2.0, 3.0)),
            ..Default::default()
        };
        let light = |kind, range| Light {
            kind,
            position: Vec3::X,
            direction: -Vec3::Y,
            intensity: Vec3::new(1.0, 2.0, 3.0),
            range,
        };
        let spot = LightKind::Spot { inner_angle: 0.1, outer_angle: 0.4 };
        let sky =
            SkyObject::Image { image: BlobHash([9; 32]), rotation: Quat::IDENTITY, scale: 2.0 };
        let grid = ProbeGrid { transform: Affine3A::IDENTITY, resolution: UVec3::new(4, 5, 6) };
        let changes = vec![
            (ObjectKey::Texture(TextureId(1)), Some(Object::Texture(BlobHash([7; 32])))),
            (ObjectKey::Material(MaterialId(2)), Some(Object::Material(material))),
            (ObjectKey::Mesh(MeshId(3)), Some(Object::Mesh(BlobHash([8; 32])))),
            (ObjectKey::Mesh(MeshId(4)), None),
            (ObjectKey::Instance(InstanceId(5)), Some(Object::Instance(instance))),
            (ObjectKey::Receiver(InstanceId(5)), Some(Object::Receiver)),
            (ObjectKey::Light(LightId(6)), Some(Object::Light(light(spot, 20.0)))),
            (
                ObjectKey::Light(LightId(7)),
                Some(Object::Light(light(LightKind::Point, f32::INFINITY))),
            ),
            (ObjectKey::Sky, Some(Object::Sky(sky))),
            (ObjectKey::DirectSky, Some(Object::DirectSky(DirectSky::LeftOut))),
            (ObjectKey::Grid(GridId(8)), Some(Object::Grid(grid))),
            (ObjectKey::Grid(GridId(9)), None),
        ];
        SnapshotPart { snapshot: SnapshotId(42), last: true, changes }
    }

    fn bytes(part: &SnapshotPart) -> Vec<u8> {
        let mut w = Writer::default();
        write_part(&mut w, part);
        w.finish()
    }

    #[test]
    fn snapshots_come_back() {
        assert_eq!(read_part(&bytes(&part())), Ok(part()));
    }

    #[test]
    fn a_cut_snapshot_is_refused() {
        let bytes = bytes(&part());
        for end in 0..bytes.len() {
            assert!(read_part(&bytes[..end]).is_err(), "{end}");
        }
    }

    #[test]
    fn objects_of_a_newer_version_are_skipped() {
        let mut w = Writer::default();
        w.u64(42);
        w.u8(1);
        w.count(2);
        w.u8(200);
        w.varint(7);
        w.bytes(b"something new");
        write_change(&mut w, &ObjectKey::Mesh(MeshId(4)), None);
        let part = read_part(&w.finish()).unwrap();
        assert_eq!(part.changes, [(ObjectKey::Mesh(MeshId(4)), None)]);
    }

    #[test]
    fn numbers_that_are_not_finite_are_refused() {
        let mut part = part();
        part.changes.retain(|(key, _)| matches!(key, ObjectKey::Instance(_)));
        let Some((_, Some(Object::Instance(instance)))) = part.changes.first_mut() else {
            panic!()
        };
        instance.transform.translation.x = f32::NAN;
        assert!(matches!(read_part(&bytes(&part)), Err(WireError::Invalid { .. })));
    }
}
