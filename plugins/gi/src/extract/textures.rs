//! Images that materials refer to.

use bevy::{
    platform::collections::HashSet,
    prelude::*,
    tasks::{AsyncComputeTaskPool, Task, block_on, poll_once},
};
use farlight_gi_solver::{
    SceneChange,
    scene::{Texture, TextureId},
};

use super::{Extractor, pixels, set_texture};
use crate::status::{GiMeter, Stage};

/// An image that materials use.
pub(super) struct TextureState {
    id: TextureId,
    users: HashSet<AssetId<StandardMaterial>>,
    stage: TextureStage,
}

enum TextureStage {
    Waiting,
    Converting(Task<Texture>),
    Ready,
    /// Materials use their factors alone.
    Unreadable,
}

impl TextureState {
    fn is_unfinished(&self) -> bool {
        matches!(self.stage, TextureStage::Waiting | TextureStage::Converting(_))
    }
}

impl Extractor {
    pub(super) fn use_texture(
        &mut self,
        image: AssetId<Image>,
        material: AssetId<StandardMaterial>,
    ) -> TextureId {
        if !self.textures.contains_key(&image) {
            let id = TextureId(self.new_id());
            let state =
                TextureState { id, users: HashSet::default(), stage: TextureStage::Waiting };
            self.textures.insert(image, state);
        }
        let state = self.textures.get_mut(&image).expect("it was just inserted");
        state.users.insert(material);
        state.id
    }

    pub(super) fn release_texture(
        &mut self,
        image: AssetId<Image>,
        material: AssetId<StandardMaterial>,
    ) {
        let Some(state) = self.textures.get_mut(&image) else { return };
        state.users.remove(&material);
        if state.users.is_empty()
            && let Some(state) = self.textures.remove(&image)
            && matches!(state.stage, TextureStage::Ready)
        {
            self.changes.unused.push(SceneChange::RemoveTexture(state.id));
        }
    }
}

/// Starts and finishes the conversion of images. They may load long after the materials.
pub(crate) fn convert_textures(
    mut extractor: ResMut<Extractor>,
    mut events: MessageReader<AssetEvent<Image>>,
    images: Res<Assets<Image>>,
    meter: Res<GiMeter>,
) {
    let _measure = meter.measure(Stage::Extract as usize);
    let extractor = &mut *extractor;
    for event in events.read() {
        if let AssetEvent::Added { id } | AssetEvent::Modified { id } = event
            && let Some(state) = extractor.textures.get_mut(id)
        {
            state.stage = TextureStage::Waiting;
        }
    }
    let unfinished = extractor
        .textures
        .iter()
        .filter(|(_, state)| state.is_unfinished())
        .map(|(&id, _)| id)
        .collect::<Vec<_>>();
    for id in unfinished {
        advance(extractor, id, &images);
        let busy = extractor.textures.get(&id).is_some_and(TextureState::is_unfinished);
        extractor.converting += usize::from(busy && images.contains(id));
    }
}

fn advance(extractor: &mut Extractor, id: AssetId<Image>, images: &Assets<Image>) {
    let Some(state) = extractor.textures.get_mut(&id) else { return };
    match &mut state.stage {
        TextureStage::Waiting => {
            let Some(image) = images.get(id) else { return };
            if let Some(problem) = pixels::problem(image) {
                warn!(
                    "a material's image is left out of the indirect light, {problem}; its factor \
                     is used alone"
                );
                state.stage = TextureStage::Unreadable;
                return;
            }
            let bytes = image.data.as_ref().map_or(0, Vec::len);
            if !extractor.may_copy(bytes) {
                return;
            }
            let copy = image.clone();
            let task = AsyncComputeTaskPool::get().spawn(async move { pixels::texture(&copy) });
            if let Some(state) = extractor.textures.get_mut(&id) {
                state.stage = TextureStage::Converting(task);
            }
        }
        TextureStage::Converting(task) => {
            let Some(texture) = block_on(poll_once(task)) else { return };
            state.stage = TextureStage::Ready;
            set_texture(&mut extractor.changes, state.id, texture.into());
        }
        TextureStage::Ready | TextureStage::Unreadable => {}
    }
}
