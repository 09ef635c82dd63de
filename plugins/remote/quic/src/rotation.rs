//! Server certificates that replace themselves.

use std::{
    fmt,
    fmt::Write as _,
    path::Path,
    sync::{Arc, Mutex, PoisonError},
    time::{Duration, SystemTime},
};

use rustls::{
    server::{ClientHello, ResolvesServerCert},
    sign::CertifiedKey,
};
use tracing::{error, info};

use crate::{Authority, AuthorityError, Leaf, authority::BACKDATED, files};

/// How long one leaf is presented. The next one is known so long in advance.
const PERIOD: Duration = Duration::from_hours(7 * 24);

/// Clocks are set back by small amounts all the time; that is no reason for new certificates.
const SET_BACK: Duration = Duration::from_secs(BACKDATED.as_secs() / 2);

/// Asks what time it is; [`SystemTime::now`] outside of tests.
pub type Clock = Arc<dyn Fn() -> SystemTime + Send + Sync>;

/// The present and the next server certificate of an authority. Time is an argument.
///
/// A leaf is presented for 7 days and valid for 13, so clients whose clocks are off by less than an hour
/// (late) or 6 days (early) get along with it. When the clock jumps to where neither of the two is to be
/// presented, both are made anew.
pub struct Certificates {
    authority: Arc<Authority>,
    current: Leaf,
    next: Leaf,
}

impl Certificates {
    /// The certificates from now on.
    ///
    /// # Errors
    /// A certificate can't be made.
    pub fn new(authority: Arc<Authority>, now: SystemTime) -> Result<Self, AuthorityError> {
        let current = authority.leaf(now)?;
        let next = authority.leaf(now + PERIOD)?;
        Ok(Self { authority, current, next })
    }

    /// The leaf to present now. If a new one is due and can't be made, the error is logged and the old
    /// one stays.
    pub fn current(&mut self, now: SystemTime) -> &Leaf {
        if let Err(error) = self.advance(now) {
            error!("the server keeps its old certificate: {error}");
        }
        &self.current
    }

    /// [`Leaf::hash`] of what is presented now and of what will be presented in the next period.
    pub fn hashes(&mut self, now: SystemTime) -> [[u8; 32]; 2] {
        self.current(now);
        [self.current.hash(), self.next.hash()]
    }

    fn advance(&mut self, now: SystemTime) -> Result<(), AuthorityError> {
        let is_of = |leaf: &Leaf, early: Duration| {
            now + early >= leaf.start() && now < leaf.start() + PERIOD
        };
        if is_of(&self.current, SET_BACK) {
            return Ok(());
        }
        if is_of(&self.next, Duration::ZERO) {
            let after = self.authority.leaf(self.next.start() + PERIOD)?;
            self.current = std::mem::replace(&mut self.next, after);
            info!("the server presents its next certificate");
        } else {
            let (current, next) = (self.authority.leaf(now)?, self.authority.leaf(now + PERIOD)?);
            (self.current, self.next) = (current, next);
            info!("the clock has jumped: the server presents a new certificate");
        }
        Ok(())
    }
}

/// [`Certificates`] for TLS: asks the clock at every handshake.
pub(crate) struct Rotation {
    certificates: Mutex<Certificates>,
    clock: Clock,
}

impl Rotation {
    pub(crate) fn new(authority: Arc<Authority>, clock: Clock) -> Result<Self, AuthorityError> {
        let certificates = Mutex::new(Certificates::new(authority, clock())?);
        Ok(Self { certificates, clock })
    }

    fn with<R>(&self, f: impl FnOnce(&mut Certificates, SystemTime) -> R) -> R {
        let mut guard = self.certificates.lock().unwrap_or_else(PoisonError::into_inner);
        f(&mut guard, (self.clock)())
    }

    pub(crate) fn hashes(&self) -> [[u8; 32]; 2] {
        self.with(Certificates::hashes)
    }
}

impl fmt::Debug for Rotation {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str("Rotation")
    }
}

impl ResolvesServerCert for Rotation {
    fn resolve(&self, _: ClientHello<'_>) -> Option<Arc<CertifiedKey>> {
        Some(self.with(|certificates, now| Arc::clone(certificates.current(now).certified())))
    }
}

/// Writes hashes for browsers (`serverCertificateHashes` of a `WebTransport` object):
/// `{"algorithm": "sha-256", "hashes": ["hexadecimal", ..]}`.
pub(crate) fn write_hashes(path: &Path, hashes: &[[u8; 32]]) -> std::io::Result<()> {
    let hex = |hash: &[u8; 32]| {
        hash.iter().fold(String::new(), |mut text, byte| {
            let _ = write!(text, "{byte:02x}");
            text
        })
    };
    let list: Vec<_> = hashes.iter().map(|hash| format!("\"{}\"", hex(hash))).collect();
    let json = format!("{{\"algorithm\": \"sha-256\", \"hashes\": [{}]}}\n", list.join(", "));
    files::replace(path, json.as_bytes())
}

#[cfg(test)]
mod tests {
    use rustls::pki_types::UnixTime;

    use super::*;
    use crate::{Pin, authority::since_1970};

    const HOUR: Duration = Duration::from_hours(1);

    fn certificates(now: SystemTime) -> (Certificates, Pin) {
        let authority = Authority::open(tempfile::tempdir().unwrap().path()).unwrap();
        let pin = Pin::new(authority.fingerprint());
        (Certificates::new(Arc::new(authority), now).unwrap(), pin)
    }

    fn accepted(pin: &Pin, leaf: &Leaf, now: SystemTime) {
        let chain = &leaf.certified().cert;
        let now = UnixTime::since_unix_epoch(since_1970(now));
        pin.check(&chain[0], &chain[1..], now).unwrap();
    }

    #[test]
    fn a_month_and_more_hour_by_hour() {
        let start = SystemTime::UNIX_EPOCH + Duration::from_hours(24 * 20_000);
        let (mut certificates, pin) = certificates(start);
        let mut known = certificates.hashes(start).to_vec();
        let mut presented = Vec::new();
        for hour in 0..40 * 24 {
            let now = start + HOUR * hour;
            let hashes = certificates.hashes(now);
            let leaf = certificates.current(now).clone();
            // Clients whose clocks are late, right and early.
            for client in [now - HOUR / 3, now, now + HOUR / 3] {
                accepted(&pin, &leaf, client);
            }
            assert!(known.contains(&leaf.hash()), "hour {hour}: presented before it was announced");
            assert_eq!(hashes[0], leaf.hash());
            known = hashes.to_vec();
            if presented.last() != Some(&leaf.hash()) {
                presented.push(leaf.hash());
            }
        }
        assert_eq!(presented.len(), 6, "one a week");
    }

    #[test]
    fn jumps_of_the_clock() {
        let start = SystemTime::UNIX_EPOCH + Duration::from_hours(24 * 20_000);
        let (mut certificates, pin) = certificates(start);
        let days = |n: u64| HOUR * 24 * n as u32;
        let first = certificates.current(start).hash();
        let jumps = [
            start + days(31),
            start - days(31),
            start - days(31) + HOUR,
            start + days(400),
            start + days(400 + 13),
            start,
            SystemTime::UNIX_EPOCH,
            start + days(1),
        ];
        for now in jumps {
            let leaf = certificates.current(now).clone();
            accepted(&pin, &leaf, now);
            accepted(&pin, &leaf, now + HOUR / 3);
            accepted(&pin, &leaf, (now - HOUR / 3).max(SystemTime::UNIX_EPOCH));
        }
        // Setting the clock by a little changes nothing.
        let (mut certificates, _) = self::certificates(start);
        let leaf = certificates.current(start).hash();
        assert_ne!(leaf, first);
        for now in [start - HOUR / 3, start + HOUR / 3, start - HOUR / 60] {
            assert_eq!(certificates.current(now).hash(), leaf);
        }
    }

    #[test]
    fn hashes_are_written_for_browsers() {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("hashes.json");
        write_hashes(&path, &[[0xab; 32], [1; 32]]).unwrap();
        let text = std::fs::read_to_string(&path).unwrap();
        let (ab, one) = ("ab".repeat(32), "01".repeat(32));
        let expected =
            format!("{{\"algorithm\": \"sha-256\", \"hashes\": [\"{ab}\", \"{one}\"]}}\n");
        assert_eq!(text, expected);
    }
}
