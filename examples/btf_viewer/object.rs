//! The object: a sphere, a plane or a glTF file, brought to one size and onto a plinth.

use bevy::{
    asset::{AssetPath, LoadState},
    gltf::GltfMaterialName,
    light::NotShadowCaster,
    mesh::VertexAttributeValues,
    prelude::*,
};

use super::{
    config::{Model, Shape},
    shown::{Shown, degrees},
    stage::Stage,
    state::{Config, Problems},
    tangents,
};

/// Radius and half the height of the upright cylinder that every object fits, so that wide ones are
/// not small on screen.
const REACH: [f32; 2] = [1.3, 0.95];
/// Radius of the sphere and half the edge of the plane, in metres of cloth.
const SPHERE: f32 = 0.1;
/// The plinth.
const PLINTH: [f32; 2] = [1.45, 0.1];

/// Turns with the object. Its child is the object.
#[derive(Component)]
pub struct Turntable;

/// The object; with `Arriving` its parts are not there yet.
#[derive(Component)]
pub struct Object(Model);

/// The file is being read.
#[derive(Component)]
pub struct Arriving(Handle<WorldAsset>);

/// A surface for the measured material.
#[derive(Component)]
pub struct Surface {
    /// Metres that a unit of its UV set is, along u and v.
    pub uv_metres: Vec2,
}

/// What the object stands on.
#[derive(Component)]
pub struct Plinth;

/// Makes the turntable and the plinth.
pub fn spawn(
    mut commands: Commands,
    mut meshes: ResMut<Assets<Mesh>>,
    mut materials: ResMut<Assets<StandardMaterial>>,
) {
    commands.spawn((Turntable, Transform::default(), Visibility::default()));
    let [radius, height] = PLINTH;
    commands.spawn((
        Plinth,
        NotShadowCaster,
        Mesh3d(meshes.add(Cylinder::new(radius, height).mesh().resolution(96))),
        MeshMaterial3d(materials.add(StandardMaterial {
            base_color: Color::srgb(0.33, 0.32, 0.31),
            perceptual_roughness: 0.55,
            ..default()
        })),
        Visibility::Hidden,
    ));
}

/// Replaces the object when another one is chosen.
pub fn choose(
    mut commands: Commands,
    config: Res<Config>,
    shown: Res<Shown>,
    server: Res<AssetServer>,
    mut meshes: ResMut<Assets<Mesh>>,
    turntable: Single<Entity, With<Turntable>>,
    mut materials: ResMut<Assets<StandardMaterial>>,
    objects: Query<(Entity, &Object)>,
    mut problems: ResMut<Problems>,
) {
    let Some(model) = config.0.models.get(shown.object.choice) else { return };
    if objects.iter().any(|(_, object)| object.0 == *model) {
        return;
    }
    for (entity, _) in &objects {
        commands.entity(entity).despawn();
    }
    problems.object = None;
    let object = (
        Object(model.clone()),
        ChildOf(*turntable),
        Transform::from_rotation(Quat::from_rotation_y(model.turn.to_radians())),
        // Not seen before its size is known.
        Visibility::Hidden,
    );
    let (mut mesh, uv_metres) = match &model.shape {
        Shape::Sphere => {
            let around = std::f32::consts::TAU * SPHERE;
            let mesh = Sphere::new(SPHERE).mesh().uv(128, 64);
            // Its poles lie on z; here they are above and below.
            let upright = Quat::from_rotation_x(-std::f32::consts::FRAC_PI_2);
            (mesh.rotated_by(upright), Vec2::new(around, around * 0.5))
        }
        Shape::Plane => {
            let edge = 2.0 * SPHERE;
            (Rectangle::new(edge, edge).mesh().build(), Vec2::splat(edge))
        }
        Shape::File(path) => {
            let path = AssetPath::from_path_buf(path.into()).with_label("Scene0");
            let scene: Handle<WorldAsset> = server.load(path);
            commands.spawn((object, Arriving(scene.clone()), WorldAssetRoot(scene)));
            return;
        }
    };
    tangents::add(&mut mesh);
    let plain = materials.add(plain());
    let part = (Mesh3d(meshes.add(mesh)), MeshMaterial3d(plain), Surface { uv_metres });
    commands.spawn(object).with_child((part, Transform::default(), Unfitted));
}

/// Its place and size are not known yet.
#[derive(Component)]
pub struct Unfitted;

/// What a surface shows until its measured material is there.
fn plain() -> StandardMaterial {
    StandardMaterial {
        base_color: Color::srgb(0.5, 0.48, 0.45),
        perceptual_roughness: 0.9,
        ..default()
    }
}

/// Marks the surfaces of a file that has arrived.
pub fn arrive(
    mut commands: Commands,
    server: Res<AssetServer>,
    mut meshes: ResMut<Assets<Mesh>>,
    arriving: Query<(Entity, &Object, &Arriving)>,
    children: Query<&Children>,
    parts: Query<(&Mesh3d, Option<&GltfMaterialName>)>,
    mut problems: ResMut<Problems>,
) {
    for (entity, object, Arriving(scene)) in &arriving {
        if let LoadState::Failed(error) = server.load_state(scene) {
            commands.entity(entity).remove::<Arriving>();
            problems.object = Some(error.to_string());
            continue;
        }
        let found: Vec<_> = children
            .iter_descendants(entity)
            .filter_map(|part| Some((part, parts.get(part).ok()?)))
            .collect();
        if found.is_empty() {
            continue;
        }
        let measured = |name: Option<&GltfMaterialName>| name.is_some_and(|name| name.0 == "btf");
        let some = found.iter().any(|(_, (_, name))| measured(*name));
        for (part, (mesh, name)) in found {
            commands.entity(part).insert(Unfitted);
            if measured(name) || !some {
                if let Some(mut mesh) = meshes.get_mut(mesh) {
                    tangents::add(&mut mesh);
                }
                let uv_metres = Vec2::splat(object.0.uv_metres);
                commands.entity(part).insert(Surface { uv_metres });
            }
        }
        commands.entity(entity).remove::<Arriving>();
    }
}

/// Brings an object to its size, its middle to the turntable's.
pub fn fit(
    mut commands: Commands,
    stage: Res<Stage>,
    meshes: Res<Assets<Mesh>>,
    unfitted: Query<(), With<Unfitted>>,
    children: Query<&Children>,
    parts: Query<&Mesh3d>,
    nodes: Query<(&ChildOf, &Transform), Without<Object>>,
    mut objects: Query<(Entity, &Object, &mut Transform, &mut Visibility)>,
    mut form: ResMut<Form>,
) {
    if unfitted.is_empty() && !stage.is_changed() {
        return;
    }
    for (entity, object, mut transform, mut visibility) in &mut objects {
        let turn = Quat::from_rotation_y(object.0.turn.to_radians());
        let (mut low, mut high) = (Vec3::MAX, Vec3::MIN);
        let mut points = Vec::new();
        for part in children.iter_descendants(entity) {
            let Ok(mesh) = parts.get(part) else { continue };
            let mut frame = Mat4::IDENTITY;
            let mut node = part;
            while let Ok((parent, local)) = nodes.get(node) {
                frame = local.to_matrix() * frame;
                node = parent.parent();
            }
            let positions = meshes.get(mesh).and_then(|m| m.attribute(Mesh::ATTRIBUTE_POSITION));
            if let Some(VertexAttributeValues::Float32x3(positions)) = positions {
                for p in positions {
                    let p = turn * frame.transform_point3(Vec3::from(*p));
                    low = low.min(p);
                    high = high.max(p);
                    points.push(p);
                }
            }
            commands.entity(part).remove::<Unfitted>();
        }
        let half = 0.5 * (high - low);
        let middle = low.midpoint(high);
        let [radius, height] = REACH;
        let fitting = (radius / half.xz().length()).min(height / half.y);
        if !fitting.is_finite() || fitting <= 0.0 {
            continue;
        }
        let scale = if stage.life_size { 1.0 } else { fitting * stage.scale };
        transform.set_if_neq(Transform {
            translation: -middle * scale,
            rotation: turn,
            scale: Vec3::splat(scale),
        });
        *visibility = Visibility::Inherited;
        points.iter_mut().for_each(|point| *point -= middle);
        *form = Form { points, lowest: None, scale, reach: half.xz().length() * scale };
    }
}

/// What is known of the object's form.
#[derive(Resource, Default)]
pub struct Form {
    /// Its points, about its middle, in the file's unit.
    points: Vec<Vec3>,
    /// How deep it reaches in that unit, lying so.
    lowest: Option<(Quat, f32)>,
    /// Metres of that unit.
    scale: f32,
    /// Radius of the upright cylinder round it, in metres.
    pub reach: f32,
}

impl Form {
    /// The height of its lowest point, lying so, whatever its turn about the vertical axis.
    fn lowest(&mut self, tilt: Quat) -> f32 {
        match self.lowest {
            Some((known, lowest)) if known == tilt => lowest,
            _ => {
                let up = tilt.inverse() * Vec3::Y;
                let lowest = self.points.iter().map(|p| up.dot(*p)).reduce(f32::min);
                self.lowest = Some((tilt, lowest.unwrap_or(0.0)));
                lowest.unwrap_or(0.0)
            }
        }
    }
}

/// Turns and moves the object; moves and hides the plinth below it.
pub fn place(
    time: Res<Time>,
    stage: Res<Stage>,
    mut form: ResMut<Form>,
    mut shown: ResMut<Shown>,
    mut turntable: Single<&mut Transform, (With<Turntable>, Without<Plinth>)>,
    plinth: Single<(&mut Transform, &mut Visibility), With<Plinth>>,
) {
    if shown.object.turning {
        let turn = shown.object.turn + 20.0 * time.delta_secs();
        shown.object.turn = degrees(turn);
    }
    let object = &shown.object;
    let rotation = object.rotation();
    // Written only where it is another: what moves isn't refined.
    turntable.set_if_neq(Transform {
        translation: stage.middle + object.shift,
        rotation,
        scale: Vec3::splat(object.scale),
    });
    let (mut transform, mut visibility) = plinth.into_inner();
    let [radius, thickness] = PLINTH;
    let wide = if stage.life_size { form.reach * 1.1 / radius } else { stage.scale };
    // A little lower than the lowest point, so that cloth that lies flat is not in the same plane.
    let lowest = form.lowest(object.tilt) * form.scale * object.scale;
    let top = stage.middle.y + lowest - 0.006 * stage.scale;
    let tall = stage.floor.map_or(thickness * stage.scale, |floor| (top - floor).max(0.01));
    transform.set_if_neq(Transform {
        translation: Vec3::new(stage.middle.x, top - 0.5 * tall, stage.middle.z),
        rotation: Quat::IDENTITY,
        scale: Vec3::new(wide, tall / thickness, wide),
    });
    let wanted = if object.plinth { Visibility::Inherited } else { Visibility::Hidden };
    visibility.set_if_neq(wanted);
}
