//! From an asset to what the render world takes: coarser pictures are made in a task.

use std::sync::Arc;

use bevy::{
    platform::collections::HashMap,
    prelude::*,
    tasks::{AsyncComputeTaskPool, Task, block_on, poll_once},
};
use farlight_btf_codec::Btf;

use crate::{BtfAsset, BtfMaterial, BtfStatus, coarse::CoarseLevels, status::SharedReport};

/// A material's data with all that is made of it.
#[derive(Debug)]
pub(crate) struct Prepared {
    pub(crate) btf: Arc<Btf>,
    pub(crate) coarse: CoarseLevels,
}

/// The data of all assets; the render world asks for all of it again when the device was lost.
#[derive(Resource, Default)]
pub(crate) struct PreparedBtfs {
    tasks: HashMap<AssetId<BtfAsset>, Task<Prepared>>,
    pub(crate) ready: HashMap<AssetId<BtfAsset>, Arc<Prepared>>,
    /// Since the last extraction.
    pub(crate) changed: Vec<AssetId<BtfAsset>>,
}

pub(crate) fn start(
    mut events: MessageReader<AssetEvent<BtfAsset>>,
    assets: Res<Assets<BtfAsset>>,
    server: Option<Res<AssetServer>>,
    mut prepared: ResMut<PreparedBtfs>,
    mut status: ResMut<BtfStatus>,
) {
    for event in events.read() {
        match *event {
            AssetEvent::Added { id } | AssetEvent::Modified { id } => {
                let Some(asset) = assets.get(id) else { continue };
                if let Some(path) = server.as_ref().and_then(|server| server.get_path(id)) {
                    let path = path.to_string();
                    if status.failed.iter().any(|failure| failure.path == path) {
                        status.recover(&path);
                    }
                }
                let btf = asset.0.clone();
                let work = async move { Prepared { coarse: CoarseLevels::of(&btf), btf } };
                prepared.tasks.insert(id, AsyncComputeTaskPool::get_or_init(default).spawn(work));
            }
            AssetEvent::Removed { id } | AssetEvent::Unused { id } => {
                prepared.tasks.remove(&id);
                if prepared.ready.remove(&id).is_some() {
                    prepared.changed.push(id);
                }
            }
            AssetEvent::LoadedWithDependencies { .. } => {}
        }
    }
}

/// Takes what is done; materials that show it are prepared anew.
pub(crate) fn finish(
    mut prepared: ResMut<PreparedBtfs>,
    mut materials: ResMut<Assets<BtfMaterial>>,
    report: Res<SharedReport>,
    mut status: ResMut<BtfStatus>,
) {
    let prepared = &mut *prepared;
    let mut done = Vec::new();
    for (id, task) in &mut prepared.tasks {
        if let Some(result) = block_on(poll_once(task)) {
            done.push((*id, result));
        }
    }
    for (id, result) in done {
        prepared.tasks.remove(&id);
        prepared.ready.insert(id, Arc::new(result));
        prepared.changed.push(id);
        let users: Vec<_> = materials
            .iter()
            .filter(|(_, material)| material.btf.id() == id)
            .map(|(material, _)| material)
            .collect();
        for user in users {
            // To borrow it for a change tells everybody that it has changed.
            if let Some(mut material) = materials.get_mut(user) {
                let _: &mut BtfMaterial = &mut material;
            }
        }
    }
    let waiting = prepared.tasks.len() + report.with(|report| report.uploading);
    if status.waiting != waiting {
        status.waiting = waiting;
    }
}
