//! A camera in front of what is lit.

use std::time::Duration;

use bevy::{
    pbr::Lightmap,
    prelude::*,
    render::gpu_readback::{Readback, ReadbackComplete},
};
use farlight::{baked::BakedRoot, prelude::*};

use crate::{
    folder::Folder,
    support::{
        front,
        headless::{Headless, Picture},
        linear,
    },
};

/// A picture's edge in pixels.
pub(crate) const SIZE: u32 = 64;

/// How long anything may take.
const PATIENCE: Duration = Duration::from_secs(60);

/// A renderer and a camera two metres in front of the origin that sees a square of two metres, with
/// exposure 1. Its asset folder is what a bake wrote.
pub(crate) struct Stage {
    pub(crate) headless: Headless,
}

impl Stage {
    pub(crate) fn new(folder: &Folder) -> Self {
        Self::with(folder, BakedPlugin::default())
    }

    pub(crate) fn with(folder: &Folder, plugin: BakedPlugin) -> Self {
        let headless = Headless::new(UVec2::splat(SIZE), &folder.0, |app| {
            app.add_plugins(FarlightPlugins.set(plugin))
                .insert_resource(GlobalAmbientLight::NONE)
                .insert_resource(ClearColor(Color::BLACK));
        });
        let mut headless = headless.unwrap_or_else(|problem| panic!("{problem}"));
        headless.set_frame_time(Duration::from_millis(16));
        headless.app.world_mut().spawn(front::camera());
        Self { headless }
    }

    pub(crate) fn world(&mut self) -> &mut World {
        self.headless.app.world_mut()
    }

    pub(crate) fn update(&mut self) {
        self.headless.update().unwrap_or_else(|problem| panic!("{problem}"));
    }

    pub(crate) fn until(&mut self, what: &str, done: impl FnMut(&mut World) -> bool) {
        let result = self.headless.update_until(what, PATIENCE, done);
        result.unwrap_or_else(|problem| {
            panic!("{problem}: {:?}", self.world().resource::<BakedStatus>())
        });
    }

    /// Spawns the baked scene and waits until it is lit.
    pub(crate) fn lit(&mut self) -> Entity {
        let root = self.spawn();
        self.until_lit(root);
        root
    }

    pub(crate) fn spawn(&mut self) -> Entity {
        self.world().spawn(BakedScene("room.baked.ron".into())).id()
    }

    pub(crate) fn until_lit(&mut self, root: Entity) {
        self.until("light", |world| {
            let status = world.resource::<BakedStatus>();
            status.root(root).is_some_and(|root| root.state == BakedState::Lit)
        });
    }

    pub(crate) fn failed(&mut self, root: Entity) -> String {
        let mut why = String::new();
        self.until("a failure", |world| match state(world, root).map(|root| root.state) {
            Some(BakedState::Failed { reason }) => {
                why = reason.to_string();
                true
            }
            _ => false,
        });
        why
    }

    pub(crate) fn status(&mut self, root: Entity) -> BakedRoot {
        state(self.world(), root).expect("the root has a status")
    }

    pub(crate) fn lighting(&mut self, root: Entity) -> Mut<'_, BakedLighting> {
        self.world().get_mut::<BakedLighting>(root).unwrap()
    }

    /// Entities that have a lightmap.
    pub(crate) fn lightmapped(&mut self) -> Vec<Entity> {
        let world = self.world();
        world.query_filtered::<Entity, With<Lightmap>>().iter(world).collect()
    }

    /// A picture some frames later, when what was sent before is shown.
    pub(crate) fn picture(&mut self) -> Picture {
        for _ in 0..4 {
            self.update();
        }
        self.headless.capture().unwrap_or_else(|problem| panic!("{problem}"))
    }

    /// The first texel of an image of half floats.
    pub(crate) fn first_texel(&mut self, image: &Handle<Image>) -> Vec3 {
        use std::sync::{Arc, Mutex};
        let slot = Arc::new(Mutex::new(Vec::new()));
        let filled = slot.clone();
        let mut reader = self.world().spawn(Readback::texture(image.clone()));
        reader.observe(move |event: On<ReadbackComplete>| {
            filled.lock().unwrap().clone_from(&event.data);
        });
        let reader = reader.id();
        for _ in 0..8 {
            self.update();
        }
        self.world().entity_mut(reader).despawn();
        let bytes = slot.lock().unwrap();
        linear::texels(&bytes[..8])[0]
    }

    /// Asserts a pixel's colour, given as linear light that leaves the surface.
    pub(crate) fn assert_pixel(&self, picture: &Picture, x: u32, y: u32, expected: Vec3) {
        front::assert_pixel(&self.headless, picture, x, y, expected);
    }

    pub(crate) fn assert_all(&self, picture: &Picture, expected: Vec3) {
        for (x, y) in [(5, 5), (SIZE / 2, SIZE / 2), (SIZE - 5, 9), (9, SIZE - 5)] {
            self.assert_pixel(picture, x, y, expected);
        }
    }
}

fn state(world: &World, root: Entity) -> Option<BakedRoot> {
    world.resource::<BakedStatus>().root(root).cloned()
}
