//! Who is believed.

mod support;

use std::{
    sync::Arc,
    time::{Duration, SystemTime},
};

use farlight_quic::Authority;
use farlight_wire::{Channel, Closed, Invitation, Limits};
use support::{Host, connect, join};

fn refused(invitation: &Invitation) -> String {
    match connect(invitation, &Limits::default()).closed() {
        Closed::Untrusted(why) => why.to_string(),
        other => panic!("{other:?}"),
    }
}

#[test]
fn another_authority_is_refused() {
    // Their certificates have the same names as ours, and are signed by somebody else.
    let (mut ours, theirs) = (Host::new(), Host::new());
    let swapped = Invitation { authority: theirs.authority.fingerprint(), ..ours.invitation() };
    let why = refused(&swapped);
    assert!(why.contains("not of the authority that the invitation names"), "{why}");
    assert!(ours.accept_within(Duration::from_millis(100)).is_none());
    // Others are undisturbed.
    join(&mut ours);
}

fn shifted(shift: impl Fn(SystemTime) -> SystemTime + Send + Sync + 'static) -> Host {
    Host::with(Host::new().authority, |config| {
        config.clock = Arc::new(move || shift(SystemTime::now()));
    })
}

#[test]
fn certificates_of_other_times_are_refused() {
    let days = |n: u64| Duration::from_hours(24 * n);
    let why = refused(&shifted(move |now| now - days(30)).invitation());
    assert!(why.contains("expired 16 days ago") || why.contains("expired 17 days ago"), "{why}");
    assert!(why.contains("clock"), "{why}");
    let why = refused(&shifted(move |now| now + days(3)).invitation());
    assert!(why.contains("valid only in 2 days") && why.contains("clock"), "{why}");
    // Clocks that are off by less do.
    join(&mut shifted(|now| now + Duration::from_mins(30)));
    join(&mut shifted(move |now| now - days(5)));
}

#[test]
fn a_server_whose_clock_runs_on_renews_its_certificate() {
    // Half a month ago when it starts; then somebody sets the clock.
    let late = Arc::new(std::sync::atomic::AtomicBool::new(true));
    let clock = Arc::clone(&late);
    let mut host = shifted(move |now| {
        let late = clock.load(std::sync::atomic::Ordering::Relaxed);
        if late { now - Duration::from_hours(24 * 15) } else { now }
    });
    refused(&host.invitation());
    late.store(false, std::sync::atomic::Ordering::Relaxed);
    join(&mut host);
}

#[test]
fn a_new_server_of_the_same_authority_is_known_and_ends_old_connections() {
    let folder = tempfile::tempdir().unwrap();
    let open = || Arc::new(Authority::open(folder.path()).unwrap());
    // In front of both servers, so that the first one can vanish without a goodbye.
    let runtime = support::raw::runtime();
    let mut first = Host::with(open(), |_| {});
    let front = support::proxy::Switch::new(&runtime, first.listener.local_addr());
    let mut client = connect(&first.invitation_at(front.address), &Limits::default());
    client.opened();
    let mut server = first.accept();
    server.opened();

    let mut second = Host::with(open(), |_| {});
    assert_eq!(second.authority.fingerprint(), first.authority.fingerprint());
    front.switch(second.listener.local_addr());
    client.send(Channel::Control, b"hello?".to_vec());
    let closed = client.closed();
    assert!(closed.to_string().contains("restarted"), "{closed}");
    connect(&second.invitation_at(front.address), &Limits::default()).opened();
    second.accept().opened();
}

#[test]
fn hashes_for_browsers_are_written() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("hashes.json");
    let host = Host::with(Host::new().authority, |config| config.hashes = Some(path.clone()));
    let text = std::fs::read_to_string(&path).unwrap();
    for hash in host.listener.hashes() {
        let hex: String = hash.iter().map(|byte| format!("{byte:02x}")).collect();
        assert!(text.contains(&hex), "{text}");
    }
}
