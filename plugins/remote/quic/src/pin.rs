//! How a client knows its server: by the fingerprint of the server's authority, and nothing else.

use std::{
    sync::{Arc, Mutex, PoisonError},
    time::Duration,
};

use rustls::{
    CertificateError, DigitallySignedStruct, Error, RootCertStore, SignatureScheme,
    client::{
        WebPkiServerVerifier,
        danger::{HandshakeSignatureValid, ServerCertVerified, ServerCertVerifier},
    },
    crypto::{CryptoProvider, ring, verify_tls12_signature, verify_tls13_signature},
    pki_types::{CertificateDer, ServerName, UnixTime},
};
use sha2::{Digest, Sha256};
use thiserror::Error;

use crate::SERVER_NAME;

/// Why a server is not believed, for people.
#[derive(Clone, Debug, Error, PartialEq, Eq)]
pub enum PinError {
    /// Its certificate is not signed by the pinned authority.
    #[error(
        "its certificate is not of the authority that the invitation names; it is another server, or \
         it has a new authority and the invitation is old"
    )]
    WrongAuthority,
    /// Its certificate was valid once.
    #[error(
        "its certificate expired {} ago; is the clock of this machine or of the server wrong?",
        span(*ago)
    )]
    Expired {
        /// Since when it is no longer valid.
        ago: Duration,
    },
    /// Its certificate will be valid.
    #[error(
        "its certificate is valid only in {}; is the clock of this machine or of the server wrong?",
        span(*ahead)
    )]
    NotYetValid {
        /// When it begins to be valid.
        ahead: Duration,
    },
    /// Its certificate is of the authority, but for something else.
    #[error("its certificate is for something else than a lighting server")]
    WrongUse,
    /// What it presents is not a certificate.
    #[error("its certificate can't be read: {0}")]
    Malformed(String),
}

/// A duration in the one unit that says most.
fn span(duration: Duration) -> String {
    let seconds = duration.as_secs();
    let units = [(86400, "days"), (3600, "hours"), (60, "minutes"), (1, "seconds")];
    let (size, name) = units.into_iter().find(|u| seconds >= 2 * u.0).unwrap_or((1, "seconds"));
    format!("{} {name}", seconds / size)
}

/// Accepts exactly the servers whose certificate is signed by the authority with one fingerprint, is
/// valid now and is made for [`SERVER_NAME`]. No other roots count.
#[derive(Debug)]
pub struct Pin {
    fingerprint: [u8; 32],
    provider: Arc<CryptoProvider>,
    refused: Mutex<Option<PinError>>,
}

impl Pin {
    /// Pins an authority: SHA-256 of the DER encoding of its certificate.
    #[must_use]
    pub fn new(fingerprint: [u8; 32]) -> Self {
        Self {
            fingerprint,
            provider: Arc::new(ring::default_provider()),
            refused: Mutex::new(None),
        }
    }

    /// Checks the certificate of a server and what it sent along.
    ///
    /// # Errors
    /// See [`PinError`].
    pub fn check(
        &self,
        leaf: &CertificateDer<'_>,
        others: &[CertificateDer<'_>],
        now: UnixTime,
    ) -> Result<(), PinError> {
        let is_pinned = |c: &&CertificateDer<'_>| Sha256::digest(c)[..] == self.fingerprint;
        let authority = others.iter().find(is_pinned).ok_or(PinError::WrongAuthority)?;
        let malformed = |error: &dyn std::fmt::Display| PinError::Malformed(error.to_string());
        let mut roots = RootCertStore::empty();
        roots.add(authority.clone().into_owned()).map_err(|error| malformed(&error))?;
        let verifier = WebPkiServerVerifier::builder_with_provider(
            Arc::new(roots),
            Arc::clone(&self.provider),
        )
        .build()
        .map_err(|error| malformed(&error))?;
        let name = ServerName::try_from(SERVER_NAME).map_err(|error| malformed(&error))?;
        let verified = verifier.verify_server_cert(leaf, &[], &name, &[], now);
        verified.map(|_| ()).map_err(|error| reason(&error))
    }

    /// Why the last server was refused, if it was; forgets it.
    pub(crate) fn take_refusal(&self) -> Option<PinError> {
        self.refused.lock().unwrap_or_else(PoisonError::into_inner).take()
    }
}

fn reason(error: &Error) -> PinError {
    use CertificateError as C;
    let between =
        |a: &UnixTime, b: &UnixTime| Duration::from_secs(a.as_secs().saturating_sub(b.as_secs()));
    match error {
        Error::InvalidCertificate(error) => match error {
            C::ExpiredContext { time, not_after } => {
                PinError::Expired { ago: between(time, not_after) }
            }
            C::Expired => PinError::Expired { ago: Duration::ZERO },
            C::NotValidYetContext { time, not_before } => {
                PinError::NotYetValid { ahead: between(not_before, time) }
            }
            C::NotValidYet => PinError::NotYetValid { ahead: Duration::ZERO },
            C::UnknownIssuer | C::BadSignature => PinError::WrongAuthority,
            C::NotValidForName
            | C::NotValidForNameContext { .. }
            | C::InvalidPurpose
            | C::InvalidPurposeContext { .. } => PinError::WrongUse,
            other => PinError::Malformed(other.to_string()),
        },
        other => PinError::Malformed(other.to_string()),
    }
}

impl ServerCertVerifier for Pin {
    fn verify_server_cert(
        &self,
        end_entity: &CertificateDer<'_>,
        intermediates: &[CertificateDer<'_>],
        _server_name: &ServerName<'_>,
        _ocsp_response: &[u8],
        now: UnixTime,
    ) -> Result<ServerCertVerified, Error> {
        let checked = self.check(end_entity, intermediates, now);
        let refusal = checked.err();
        let told = refusal.as_ref().map(|error| match error {
            PinError::WrongAuthority => CertificateError::UnknownIssuer,
            PinError::Expired { .. } => CertificateError::Expired,
            PinError::NotYetValid { .. } => CertificateError::NotValidYet,
            PinError::WrongUse => CertificateError::InvalidPurpose,
            PinError::Malformed(_) => CertificateError::BadEncoding,
        });
        *self.refused.lock().unwrap_or_else(PoisonError::into_inner) = refusal;
        told.map_or(Ok(ServerCertVerified::assertion()), |error| Err(error.into()))
    }

    fn verify_tls12_signature(
        &self,
        message: &[u8],
        cert: &CertificateDer<'_>,
        dss: &DigitallySignedStruct,
    ) -> Result<HandshakeSignatureValid, Error> {
        let algorithms = &self.provider.signature_verification_algorithms;
        verify_tls12_signature(message, cert, dss, algorithms)
    }

    fn verify_tls13_signature(
        &self,
        message: &[u8],
        cert: &CertificateDer<'_>,
        dss: &DigitallySignedStruct,
    ) -> Result<HandshakeSignatureValid, Error> {
        let algorithms = &self.provider.signature_verification_algorithms;
        verify_tls13_signature(message, cert, dss, algorithms)
    }

    fn supported_verify_schemes(&self) -> Vec<SignatureScheme> {
        self.provider.signature_verification_algorithms.supported_schemes()
    }
}

#[cfg(test)]
mod tests {
    use std::time::SystemTime;

    use rcgen::{CertificateParams, Issuer, KeyPair};

    use super::*;
    use crate::{Authority, Leaf, authority::since_1970};

    fn authority() -> Authority {
        Authority::open(tempfile::tempdir().unwrap().path()).unwrap()
    }

    fn check(pin: &Authority, leaf: &Leaf, now: SystemTime) -> Result<(), PinError> {
        let now = UnixTime::since_unix_epoch(since_1970(now));
        let chain = &leaf.certified().cert;
        Pin::new(pin.fingerprint()).check(&chain[0], &chain[1..], now)
    }

    #[test]
    fn who_and_when_matter() {
        let (ours, theirs) = (authority(), authority());
        let now = SystemTime::now();
        let days = |n: u64| Duration::from_hours(24 * n);
        let minutes = |n: u64| Duration::from_mins(n);
        let leaf = ours.leaf(now).unwrap();
        assert_eq!(check(&ours, &leaf, now), Ok(()));
        assert_eq!(check(&ours, &leaf, now - minutes(59)), Ok(()));
        assert_eq!(check(&ours, &leaf, now + days(13) - minutes(1)), Ok(()));
        assert_eq!(check(&theirs, &leaf, now), Err(PinError::WrongAuthority));
        let late = check(&ours, &leaf, now + days(16)).unwrap_err();
        assert!(late.to_string().contains("expired 3 days ago"), "{late}");
        let early = check(&ours, &leaf, now - minutes(90)).unwrap_err();
        assert!(early.to_string().contains("valid only in 3"), "{early}");
        assert!(early.to_string().contains("minutes"), "{early}");
    }

    #[test]
    fn the_right_authority_sent_along_is_not_enough() {
        let (ours, theirs) = (authority(), authority());
        let now = SystemTime::now();
        let (our_leaf, their_leaf) = (ours.leaf(now).unwrap(), theirs.leaf(now).unwrap());
        let unix = UnixTime::since_unix_epoch(since_1970(now));
        let pin = Pin::new(ours.fingerprint());
        let our_authority = &our_leaf.certified().cert[1..];
        let mixed = pin.check(their_leaf.certificate(), our_authority, unix);
        assert_eq!(mixed, Err(PinError::WrongAuthority));
        assert_eq!(pin.check(our_leaf.certificate(), &[], unix), Err(PinError::WrongAuthority));
        let garbage = CertificateDer::from(vec![1, 2, 3]);
        let garbage = pin.check(&garbage, our_authority, unix);
        assert!(matches!(garbage, Err(PinError::Malformed(_))), "{garbage:?}");
        // The authority itself does not serve.
        let itself = pin.check(&our_authority[0], our_authority, unix);
        assert!(itself.is_err(), "{itself:?}");
    }

    #[test]
    fn an_authority_that_is_no_certificate_is_malformed() {
        let garbage = CertificateDer::from(vec![0x30, 0x82, 1]);
        let pin = Pin::new(Sha256::digest(&garbage).into());
        let now = UnixTime::now();
        let checked = pin.check(&garbage, std::slice::from_ref(&garbage), now);
        assert!(matches!(checked, Err(PinError::Malformed(_))), "{checked:?}");
    }

    #[test]
    fn other_names_and_uses_are_refused() {
        let key = KeyPair::generate().unwrap();
        let mut params = CertificateParams::default();
        params.is_ca = rcgen::IsCa::Ca(rcgen::BasicConstraints::Unconstrained);
        let authority = params.self_signed(&key).unwrap();
        let issuer = Issuer::new(params, key);
        let pin = Pin::new(Sha256::digest(authority.der()).into());
        let check = |name: &str, usage: rcgen::ExtendedKeyUsagePurpose| {
            let mut params = CertificateParams::new([name.to_owned()]).unwrap();
            params.extended_key_usages = vec![usage];
            let leaf = params.signed_by(&KeyPair::generate().unwrap(), &issuer).unwrap();
            pin.check(leaf.der(), std::slice::from_ref(authority.der()), UnixTime::now())
        };
        use rcgen::ExtendedKeyUsagePurpose::{ClientAuth, ServerAuth};
        assert_eq!(check(SERVER_NAME, ServerAuth), Ok(()));
        assert_eq!(check("example.org", ServerAuth), Err(PinError::WrongUse));
        assert_eq!(check(SERVER_NAME, ClientAuth), Err(PinError::WrongUse));
    }
}
