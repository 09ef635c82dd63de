//! What is known of each root, and the light on its meshes.

use std::{borrow::Cow, sync::Arc};

use bevy::{
    ecs::entity::EntityHashMap,
    mesh::{MeshAccessError, VertexAttributeValues},
    pbr::Lightmap,
    platform::collections::HashMap,
    prelude::*,
};
use farlight_baked_format::{Fingerprint, manifest::Receiver};
use farlight_core::{BakedSurface, LeftOut};

use crate::{
    BakedLighting, BakedManifest, BakedState, backs::SolidBack, find::Found, lights::Lights,
    status::BakedRoot, textures::Textures,
};

/// Frames for which a lightmap of somebody else may be there who takes it away because of ours.
const PATIENCE: u8 = 8;

/// An entity with a [`BakedLighting`].
pub(crate) struct Root {
    pub(crate) status: BakedRoot,
    /// To be looked at again.
    pub(crate) dirty: bool,
    /// The manifest may be another than that of the textures.
    pub(crate) reloaded: bool,
    /// Scenarios may have other weights.
    pub(crate) reweighed: bool,
    /// What else [`BakedLighting`] says: manifest, bicubic, dimmable, solid backs.
    pub(crate) options: (AssetId<BakedManifest>, [bool; 3]),
    pub(crate) weights: Vec<f32>,
    pub(crate) textures: Option<Textures>,
    pub(crate) lights: Lights,
    pub(crate) volumes: Vec<Entity>,
    /// Whether it is known who is to be lit.
    looked: bool,
    lit: EntityHashMap<Place>,
    coming: EntityHashMap<Coming>,
}

/// A mesh's place in a lightmap.
#[derive(Clone, Debug, PartialEq)]
pub(crate) struct Place {
    image: Handle<Image>,
    rect: Rect,
    bicubic: bool,
    solid_back: bool,
}

struct Coming {
    place: Place,
    /// Frames to wait: Bevy must have seen a frame without a lightmap before it takes another.
    frames: u8,
    /// Frames in which a lightmap of somebody else was there.
    waited: u8,
}

/// Materials of lit meshes.
pub(crate) type Materials<'w, 's> =
    Query<'w, 's, Option<&'static mut MeshMaterial3d<StandardMaterial>>>;

impl Root {
    pub(crate) fn new(entity: Entity) -> Self {
        Self {
            status: BakedRoot::new(entity),
            dirty: true,
            reloaded: true,
            reweighed: false,
            options: (AssetId::default(), [false; 3]),
            looked: false,
            weights: Vec::new(),
            textures: None,
            lights: Lights::default(),
            volumes: Vec::new(),
            lit: EntityHashMap::default(),
            coming: EntityHashMap::default(),
        }
    }

    pub(crate) fn is_lit(&self, entity: Entity) -> bool {
        self.lit.contains_key(&entity) || self.coming.contains_key(&entity)
    }

    pub(crate) fn is_arriving(&self) -> bool {
        !self.coming.is_empty()
    }

    pub(crate) fn receivers(&self) -> usize {
        self.lit.len()
    }

    /// What a manifest's receivers are in the spawned scene: places of entities, and what is left out.
    /// Answers `None` while meshes are on their way.
    pub(crate) fn places(
        &self,
        lighting: &BakedLighting,
        manifest: &BakedManifest,
        found: &Found,
        meshes: &Assets<Mesh>,
        prints: &mut Fingerprints,
    ) -> Option<(EntityHashMap<Place>, Vec<LeftOut>)> {
        let textures = self.textures.as_ref()?;
        let mut places = EntityHashMap::default();
        let mut left_out = Vec::new();
        let mut leave = |entity, reason: String| {
            left_out.push(LeftOut { entity, reason: Cow::Owned(reason) });
        };
        for receiver in &manifest.receivers {
            let Receiver { node, primitive, name, .. } = receiver;
            let Some(entities) = found.primitives.get(&(*node, *primitive)) else {
                let what = format!("primitive {primitive} of node {node} {name:?}");
                leave(self.status.entity, format!("{what} is not in the scene"));
                continue;
            };
            for &(entity, mesh) in entities {
                let mesh_data = meshes.get(mesh)?;
                let place = textures
                    .pages
                    .get(receiver.page as usize)
                    .ok_or_else(|| format!("there is no page {}", receiver.page))
                    .and_then(|page| match &page.problem {
                        Some(problem) => Err(problem.clone()),
                        None => Ok(Place {
                            image: page.image.clone(),
                            rect: uv_rect(receiver.rect, manifest.page_size),
                            bicubic: lighting.bicubic,
                            solid_back: lighting.solid_backs,
                        }),
                    })
                    .and_then(|place| prints.check(mesh, mesh_data, receiver.uv).map(|()| place));
                match place {
                    Ok(place) => drop(places.insert(entity, place)),
                    Err(reason) => leave(entity, format!("it has no lightmap: {reason}")),
                }
            }
        }
        left_out.extend(manifest.left_out.iter().flat_map(|left| {
            let key = (left.node, left.primitive);
            let entities = found.primitives.get(&key).into_iter().flatten();
            entities.map(|&(entity, _)| LeftOut {
                entity,
                reason: Cow::Owned(format!("it was not baked: {}", left.reason)),
            })
        }));
        Some((places, left_out))
    }

    /// Wants these places and no others.
    pub(crate) fn want(
        &mut self,
        mut places: EntityHashMap<Place>,
        commands: &mut Commands,
        materials: &mut Materials,
    ) {
        self.coming.retain(|entity, coming| {
            let same = places.get(entity) == Some(&coming.place);
            if !same && !places.contains_key(entity) {
                commands.entity(*entity).try_remove::<BakedSurface>();
            }
            same
        });
        let mut frames = EntityHashMap::default();
        self.lit.retain(|&entity, place| {
            let keep = places.get(&entity) == Some(place);
            if !keep {
                unlight(entity, places.contains_key(&entity), commands, materials);
                frames.insert(entity, 1);
            }
            keep
        });
        places.retain(|entity, _| !self.is_lit(*entity));
        for (entity, place) in places {
            commands.entity(entity).try_insert(BakedSurface);
            let frames = frames.get(&entity).copied().unwrap_or(0);
            self.coming.insert(entity, Coming { place, frames, waited: 0 });
        }
        self.looked = true;
        if self.is_arriving() || self.status.state != BakedState::Lit {
            self.status.state = BakedState::Loading;
        }
    }

    /// Something is on its way: looks again in the next frame.
    pub(crate) fn wait(&mut self) {
        self.status.state = BakedState::Loading;
        self.looked = false;
        self.dirty = true;
    }

    /// Whether everything that can be lit is.
    pub(crate) fn is_done(&self) -> bool {
        self.looked && !self.is_arriving()
    }

    pub(crate) fn take_weights(&mut self, weights: Vec<f32>, manifest: &BakedManifest) {
        let names = manifest.scenario_names().map(str::to_owned);
        self.status.scenarios = names.zip(weights.iter().copied()).collect();
        self.weights = weights;
    }

    /// Inserts lightmaps that are due.
    ///
    /// Bevy takes a lightmap's place only once, and chooses the pipeline when the material changes:
    /// so a component that comes or goes marks the material as changed in the same frame, and one
    /// that becomes another is gone for a frame.
    pub(crate) fn arrive(
        &mut self,
        commands: &mut Commands,
        lightmapped: &Query<(), With<Lightmap>>,
        materials: &mut Materials,
    ) -> bool {
        let mut changed = false;
        let (lit, left_out) = (&mut self.lit, &mut self.status.left_out);
        self.coming.retain(|&entity, coming| {
            if coming.frames > 0 {
                coming.frames -= 1;
                return true;
            }
            let Ok(material) = materials.get_mut(entity) else { return false };
            if lightmapped.contains(entity) {
                coming.waited += 1;
                if coming.waited <= PATIENCE {
                    return true;
                }
                let reason = "it has a Lightmap of its own".into();
                left_out.push(LeftOut { entity, reason });
                commands.entity(entity).try_remove::<BakedSurface>();
                changed = true;
                return false;
            }
            if std::mem::take(&mut coming.waited) > 0 {
                // It has just gone.
                coming.frames = 1;
                return true;
            }
            let Place { image, rect, bicubic, solid_back } = coming.place.clone();
            commands.entity(entity).try_insert(Lightmap {
                image,
                uv_rect: rect,
                bicubic_sampling: bicubic,
            });
            if solid_back {
                commands.entity(entity).try_insert(SolidBack::default());
            }
            if let Some(mut material) = material {
                material.set_changed();
            }
            lit.insert(entity, coming.place.clone());
            changed = true;
            false
        });
        changed
    }

    /// Forgets an entity whose lightmap has gone without us.
    pub(crate) fn lost(&mut self, entity: Entity) {
        self.dirty |= self.lit.remove(&entity).is_some();
    }

    /// Takes all lightmaps away.
    pub(crate) fn unlight(&mut self, commands: &mut Commands, materials: &mut Materials) {
        self.want(EntityHashMap::default(), commands, materials);
        self.looked = false;
    }

    /// Shows nothing, and why.
    pub(crate) fn fail(&mut self, reason: String) {
        let state = BakedState::Failed { reason: Arc::from(reason) };
        if self.status.state != state {
            if let BakedState::Failed { reason } = &state {
                error!("{}: nothing is lit by baked light: {reason}", self.status.entity);
            }
            self.status.state = state;
        }
        self.looked = false;
    }
}

fn unlight(entity: Entity, again: bool, commands: &mut Commands, materials: &mut Materials) {
    // The entity may be despawned.
    if let Ok(material) = materials.get_mut(entity) {
        if let Some(mut material) = material {
            material.set_changed();
        }
        let mut entity = commands.entity(entity);
        entity.try_remove::<(Lightmap, SolidBack)>();
        if !again {
            entity.try_remove::<BakedSurface>();
        }
    }
}

/// A rectangle of texels as Bevy wants it.
fn uv_rect([x, y, width, height]: [u32; 4], page: u32) -> Rect {
    let corner = |x: u32, y: u32| Vec2::new(x as f32, y as f32) / page as f32;
    // The manifest was checked: this stays on the page.
    Rect::from_corners(corner(x, y), corner(x + width, y + height))
}

/// Fingerprints of second UV sets.
#[derive(Resource, Default)]
pub(crate) struct Fingerprints(HashMap<AssetId<Mesh>, Result<Option<Fingerprint>, &'static str>>);

impl Fingerprints {
    pub(crate) fn forget(&mut self, mesh: AssetId<Mesh>) {
        self.0.remove(&mesh);
    }

    pub(crate) fn is_empty(&self) -> bool {
        self.0.is_empty()
    }

    /// Whether a mesh's second UV set is the one that the lightmap was baked for.
    fn check(&mut self, id: AssetId<Mesh>, mesh: &Mesh, baked: Fingerprint) -> Result<(), String> {
        match *self.0.entry(id).or_insert_with(|| fingerprint(mesh)) {
            Ok(Some(found)) if found != baked => Err(format!(
                "its second UV set is another one than what was baked ({found}, not {baked}): bake \
                 the scene again, or load the .glb file of the same bake"
            )),
            // What is on the GPU only is believed.
            Ok(_) => Ok(()),
            Err(reason) => Err(reason.into()),
        }
    }
}

/// `None` where the mesh's data is on the GPU only.
fn fingerprint(mesh: &Mesh) -> Result<Option<Fingerprint>, &'static str> {
    match mesh.try_attribute(Mesh::ATTRIBUTE_UV_1) {
        Ok(VertexAttributeValues::Float32x2(uv)) => {
            Ok(Some(Fingerprint::of_uv(uv.iter().copied().map(Vec2::from))))
        }
        Ok(_) => Err("its second UV set is not made of two floats a vertex"),
        Err(MeshAccessError::ExtractedToRenderWorld) => Ok(None),
        Err(MeshAccessError::NotFound) => Err("it has no second UV set"),
    }
}
