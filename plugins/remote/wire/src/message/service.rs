//! What a server can do for a client, negotiated in the greetings.

use crate::{
    WireError,
    codec::{Reader, Writer},
};

/// Most services that a greeting may name.
const MAX_SERVICES: usize = 64;

/// A service and the versions of it that one side knows.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) struct Service {
    /// Which service.
    pub id: u16,
    /// The oldest version.
    pub oldest: u16,
    /// The newest version.
    pub newest: u16,
}

/// Lightmap texels of receivers.
const LIGHTMAPS: u16 = 1;
/// Probes of grids.
const PROBES: u16 = 2;

impl Service {
    /// What this version of the crate knows; the same on both sides.
    pub(crate) const ALL: [Self; 2] =
        [Self { id: LIGHTMAPS, oldest: 1, newest: 1 }, Self { id: PROBES, oldest: 1, newest: 1 }];
}

/// The services that both sides know, each in the newest common version.
pub(crate) fn agree(ours: &[Service], theirs: &[Service]) -> Vec<Service> {
    let common = |ours: &Service| {
        let theirs = theirs.iter().find(|t| t.id == ours.id)?;
        let newest = ours.newest.min(theirs.newest);
        (newest >= ours.oldest.max(theirs.oldest)).then_some(Service {
            oldest: newest,
            newest,
            ..*ours
        })
    };
    ours.iter().filter_map(common).collect()
}

pub(super) fn write(w: &mut Writer, services: &[Service]) {
    w.count(services.len());
    for service in services {
        w.u16(service.id);
        w.u16(service.oldest);
        w.u16(service.newest);
    }
}

pub(super) fn read(r: &mut Reader<'_>) -> Result<Vec<Service>, WireError> {
    let count = r.count(6, MAX_SERVICES)?;
    (0..count).map(|_| Ok(Service { id: r.u16()?, oldest: r.u16()?, newest: r.u16()? })).collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_newest_common_version_is_taken() {
        let service = |id, oldest, newest| Service { id, oldest, newest };
        let ours = [service(1, 1, 4), service(2, 3, 3), service(3, 1, 1)];
        let theirs = [service(1, 2, 3), service(2, 1, 2), service(9, 1, 1)];
        assert_eq!(agree(&ours, &theirs), [service(1, 3, 3)]);
        assert_eq!(agree(&Service::ALL, &Service::ALL), Service::ALL);
        assert!(agree(&ours, &[]).is_empty());
    }
}
