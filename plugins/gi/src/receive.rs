//! Updates of the backend into textures, components and the status.

use std::collections::VecDeque;

use bevy::{light::IrradianceVolume, platform::time::Instant, prelude::*};
use farlight_core::{LightingChanged, RonSettings, TextureUploads, Ticket};
use farlight_gi_solver::session::{Quality, SnapshotId};

use crate::{
    BackendState, GiControl, GiLightmaps, GiProbeVolume, GiSettings, GiState, GiStatus, GiUpdate,
    GiUpdated, GiView,
    backend::{BackendFactory, GiBackend},
    extract::Extractor,
    status::{GiMeter, Remarks, Stage},
    volumes::{Volumes, show_volumes},
};

/// Makes backends.
#[derive(Resource)]
pub(crate) struct Factory(pub(crate) BackendFactory);

/// Starts the backend, and starts it anew when settings of the solver change.
pub(crate) fn start_backend(
    mut commands: Commands,
    factory: Res<Factory>,
    settings: Res<GiSettings>,
    mut in_use: Local<Option<GiSettings>>,
    mut extractor: ResMut<Extractor>,
    mut lightmaps: ResMut<GiLightmaps>,
    uploads: Res<TextureUploads>,
    mut materials: Query<Option<&mut MeshMaterial3d<StandardMaterial>>>,
) {
    if !settings.is_changed() && in_use.is_some() {
        return;
    }
    uploads.set_bytes_per_frame(settings.upload_bytes_per_frame as usize);
    let known = in_use.as_ref().is_some_and(|in_use| in_use.session() == settings.session());
    if known {
        return;
    }
    if let Err(problem) = settings.check() {
        error!("the settings of the indirect light are refused: {problem}");
        return;
    }
    lightmaps.clear(&mut commands, &mut materials, &uploads);
    lightmaps.configure(settings.page_size, settings.max_pages);
    extractor.resend();
    commands.insert_resource(GiBackend((factory.0)(&settings)));
    *in_use = Some(settings.clone());
}

/// Updates whose texels are on their way.
#[derive(Resource, Default)]
pub(crate) struct OnTheWay(VecDeque<Sent>);

struct Sent {
    snapshot: SnapshotId,
    quality: Quality,
    first: Ticket,
    last: Ticket,
    first_write: Option<Instant>,
}

/// Takes updates over and tells what was written.
pub(crate) fn receive(
    mut commands: Commands,
    mut backend: Option<ResMut<GiBackend>>,
    (mut lightmaps, mut volumes): (ResMut<GiLightmaps>, ResMut<Volumes>),
    mut extractor: ResMut<Extractor>,
    mut remarks: ResMut<Remarks>,
    mut on_the_way: ResMut<OnTheWay>,
    mut status: ResMut<GiStatus>,
    mut images: ResMut<Assets<Image>>,
    (uploads, control, view): (Res<TextureUploads>, Res<GiControl>, Res<GiView>),
    mut materials: Query<Option<&mut MeshMaterial3d<StandardMaterial>>>,
    mut shown_volumes: Query<&mut IrradianceVolume, With<GiProbeVolume>>,
    mut removed_volumes: RemovedComponents<GiProbeVolume>,
    (mut updated, mut changed): (MessageWriter<GiUpdated>, MessageWriter<LightingChanged>),
    mut device: Local<u64>,
    meter: Res<GiMeter>,
) {
    let _measure = meter.measure(Stage::Apply as usize);
    let shown = control.enabled && *view != GiView::DirectOnly;
    lightmaps.show(shown, &uploads);
    let mut visibly = show_volumes(shown, &mut shown_volumes);
    for entity in removed_volumes.read() {
        if !shown_volumes.contains(entity) {
            volumes.remove(entity, &mut commands, &uploads);
            visibly = true;
        }
    }

    let progress = uploads.progress();
    if progress.device > 1 && progress.device != *device {
        lightmaps.write_all(&uploads);
        volumes.write_all(&uploads);
        if let Some(backend) = &mut backend {
            backend.0.resync();
        }
    }
    *device = progress.device;
    // Written in the last frame, which a renderer in a thread of its own may have drawn before.
    visibly |= status.uploaded_bytes != progress.written_bytes;
    status.uploaded_bytes = progress.written_bytes;

    let mut overflow = false;
    if let Some(backend) = &mut backend {
        while let Some(update) = backend.0.poll() {
            let sent = take(
                update,
                shown,
                &mut commands,
                &mut lightmaps,
                &mut volumes,
                &extractor,
                &mut remarks,
                &mut status,
                &mut images,
                &uploads,
            );
            overflow |= sent.1;
            on_the_way.0.push_back(sent.0);
        }
        set_state(&mut status, backend.0.state());
        let link = backend.0.link();
        if status.link != link {
            status.link = link;
        }
    }
    if overflow {
        // More arrives than the GPU takes: what waits is forgotten, the pages hold it all.
        lightmaps.write_all(&uploads);
        volumes.write_all(&uploads);
    }

    let done = if uploads.has_renderer() { progress.done } else { Ticket(u64::MAX) };
    let unlit = extractor.take_unlit();
    visibly |= lightmaps.apply(&mut commands, &mut materials, &unlit, done);
    tell(
        &mut on_the_way,
        &progress.started,
        &progress.finished,
        done,
        &mut extractor,
        &mut status,
        &mut updated,
    );
    // What waits is written in this frame, as far as its share of bytes goes.
    if visibly || uploads.waiting_bytes() > 0 {
        changed.write_default();
    }
}

/// Takes one update over; answers what to wait for and whether the uploads are full.
fn take(
    update: GiUpdate,
    shown: bool,
    commands: &mut Commands,
    lightmaps: &mut GiLightmaps,
    volumes: &mut Volumes,
    extractor: &Extractor,
    remarks: &mut Remarks,
    status: &mut GiStatus,
    images: &mut Assets<Image>,
    uploads: &TextureUploads,
) -> (Sent, bool) {
    status.updates += 1;
    status.timings.push(&update.times);
    let mut tickets: Option<(Ticket, Ticket)> = None;
    let mut overflow = false;
    let mut written = |result| match result {
        Ok(Some((first, last))) => {
            tickets = Some((tickets.map_or(first, |t| t.0), last));
        }
        Ok(None) => {}
        Err(_) => overflow = true,
    };
    written(lightmaps.write(update.tiles, images, uploads));
    for grid in update.grids {
        let Some(entity) = Entity::try_from_bits(grid.grid.0) else { continue };
        if commands.get_entity(entity).is_ok() {
            let ticket = volumes.write(entity, grid, shown, commands, images, uploads);
            written(ticket.map(|ticket| ticket.map(|ticket| (ticket, ticket))));
        }
    }
    let (first, last) = tickets.unwrap_or_default();
    for placement in update.placements {
        let Some(entity) = Entity::try_from_bits(placement.instance.0) else { continue };
        // An instance that has gone since is forgotten by the backend too, soon.
        if extractor.is_receiver(entity) {
            lightmaps.place(entity, placement, last, images);
        }
    }
    for (instance, reason) in update.refused {
        if let Some(entity) = Entity::try_from_bits(instance.0) {
            remarks.note(entity, format!("it has no lightmap: {reason}"));
        }
    }
    let sent =
        Sent { snapshot: update.snapshot, quality: update.quality, first, last, first_write: None };
    (sent, overflow)
}

fn set_state(status: &mut GiStatus, state: BackendState) {
    let state = match state {
        BackendState::Failed(reason) => GiState::Failed { reason },
        BackendState::Disconnected { reason } => GiState::Disconnected { reason },
        _ if status.converting > 0 => GiState::Solving,
        BackendState::Idle => GiState::Idle,
        BackendState::Solving => GiState::Solving,
        BackendState::Converged if status.receivers == 0 => GiState::Idle,
        BackendState::Converged => GiState::Converged,
    };
    if status.state != state {
        if let GiState::Failed { reason } = &state {
            error!("global illumination has stopped: {reason}");
        }
        status.state = state;
    }
}

/// Notes what was written and sends [`GiUpdated`].
fn tell(
    on_the_way: &mut OnTheWay,
    started: &[(Ticket, Instant)],
    finished: &[(Ticket, Instant)],
    done: Ticket,
    extractor: &mut Extractor,
    status: &mut GiStatus,
    updated: &mut MessageWriter<GiUpdated>,
) {
    for sent in &mut on_the_way.0 {
        if sent.first_write.is_some() {
            continue;
        }
        let now = Instant::now();
        let at = started.iter().find(|(ticket, _)| *ticket >= sent.first).map(|&(_, at)| at);
        sent.first_write = at.or((sent.last <= done).then_some(now));
        if let Some(at) = sent.first_write
            && let Some(latency) = extractor.submit_times().latency(sent.snapshot, at)
        {
            status.timings.latency.push(latency);
        }
    }
    while let Some(sent) = on_the_way.0.front()
        && sent.last <= done
    {
        let now = Instant::now();
        let first_write = sent.first_write.unwrap_or(now);
        let all_written = finished
            .iter()
            .find(|(ticket, _)| *ticket >= sent.last)
            .map_or(first_write, |&(_, at)| at);
        status.shown = sent.snapshot;
        status.quality = sent.quality;
        let (snapshot, quality) = (sent.snapshot, sent.quality);
        updated.write(GiUpdated { snapshot, first_write, all_written, quality });
        on_the_way.0.pop_front();
    }
}
