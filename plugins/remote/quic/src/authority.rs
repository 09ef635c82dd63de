//! Who the server is: a certificate authority of its own that stays, and the access token.

use std::{
    fmt::Write as _,
    io,
    path::{Path, PathBuf},
    sync::Arc,
    time::{Duration, SystemTime},
};

use farlight_wire::Token;
use rcgen::{
    BasicConstraints, CertificateParams, DnType, ExtendedKeyUsagePurpose, IsCa, Issuer, KeyPair,
    KeyUsagePurpose, PKCS_ECDSA_P256_SHA256, date_time_ymd,
};
use rustls::{
    crypto::ring::sign::any_ecdsa_type,
    pki_types::{CertificateDer, PrivatePkcs8KeyDer, UnixTime, pem::PemObject},
    sign::CertifiedKey,
};
use sha2::{Digest, Sha256};
use thiserror::Error;

use crate::{Pin, files};

/// The name in every server certificate. Clients check this name and not the host's: who the server
/// is follows from its authority, wherever it runs. `.invalid` can belong to nobody (RFC 2606).
pub const SERVER_NAME: &str = "farlight.invalid";

/// How long before its start a leaf is already valid, for clients whose clocks are late.
pub(crate) const BACKDATED: Duration = Duration::from_hours(1);

/// How long a leaf is valid after its start. Browsers take pinned certificates of 14 days at most
/// ("custom certificate requirements" of the WebTransport specification of the W3C).
pub(crate) const LEAF_LIFETIME: Duration = Duration::from_hours(13 * 24);

const AUTHORITY_FILE: &str = "authority.pem";
const TOKEN_FILE: &str = "token";

/// The certificate authority of one server, kept in a folder: a key (ECDSA P-256), a certificate that
/// does not expire, and the access token. Clients know it by [`fingerprint`](Self::fingerprint).
pub struct Authority {
    certificate: CertificateDer<'static>,
    issuer: Issuer<'static, KeyPair>,
    token: Token,
    secret: [u8; 32],
}

/// What is wrong with the folder of an authority.
#[derive(Debug, Error)]
pub enum AuthorityError {
    /// A file can't be read or made.
    #[error("{}: {source}", path.display())]
    File {
        /// Which.
        path: PathBuf,
        /// Why.
        source: io::Error,
    },
    /// A file has other content than it should. It is left as it is, since replacing it would lock out
    /// every client.
    #[error("{} is damaged: {why}; restore it, or remove it to make a new one (old invitations will no longer work)", path.display())]
    Damaged {
        /// Which.
        path: PathBuf,
        /// In which way.
        why: String,
    },
    /// A certificate can't be made.
    #[error("can't make a certificate: {0}")]
    Make(String),
}

/// A server certificate of a few days, with its key and the certificate of its authority.
#[derive(Clone, Debug)]
pub struct Leaf {
    certified: Arc<CertifiedKey>,
    start: SystemTime,
    hash: [u8; 32],
}

impl Authority {
    /// Reads the authority in a folder, or makes one if there is none. Of processes that do this at
    /// once all get the same. On Unix its files can be read by their owner only.
    ///
    /// # Errors
    /// See [`AuthorityError`].
    pub fn open(folder: impl AsRef<Path>) -> Result<Self, AuthorityError> {
        let path = folder.as_ref().join(AUTHORITY_FILE);
        let pem = files::read_or_create(&path, || Ok(make_pem().map_err(io::Error::other)?.into()))
            .map_err(|source| AuthorityError::File { path: path.clone(), source })?;
        let (certificate, issuer, secret) =
            parse(&pem).map_err(|why| AuthorityError::Damaged { path: path.clone(), why })?;

        let token_path = folder.as_ref().join(TOKEN_FILE);
        let text = files::read_or_create(&token_path, || {
            let mut token = [0; 16];
            getrandom::fill(&mut token).map_err(io::Error::other)?;
            Ok(format!("{}\n", Token(token)).into())
        })
        .map_err(|source| AuthorityError::File { path: token_path.clone(), source })?;
        let token = std::str::from_utf8(&text).ok().and_then(|text| text.trim().parse().ok());
        let token = token.ok_or_else(|| AuthorityError::Damaged {
            path: token_path,
            why: "it is not 32 hexadecimal digits".into(),
        })?;

        let authority = Self { certificate, issuer, token, secret };
        authority.check().map_err(|why| AuthorityError::Damaged { path, why })?;
        Ok(authority)
    }

    /// SHA-256 of the DER encoding of its certificate: what clients pin.
    #[must_use]
    pub fn fingerprint(&self) -> [u8; 32] {
        Sha256::digest(&self.certificate).into()
    }

    /// Lets clients in.
    #[must_use]
    pub fn token(&self) -> Token {
        self.token
    }

    /// A new server certificate with a new key, valid from one hour before `start` to 13 days after.
    ///
    /// # Errors
    /// [`AuthorityError::Make`], for example when the system gives no random numbers.
    pub fn leaf(&self, start: SystemTime) -> Result<Leaf, AuthorityError> {
        let make = |error: rcgen::Error| AuthorityError::Make(error.to_string());
        let mut params = CertificateParams::new([SERVER_NAME.to_owned()]).map_err(make)?;
        params.distinguished_name.push(DnType::CommonName, SERVER_NAME);
        params.key_usages = vec![KeyUsagePurpose::DigitalSignature];
        params.extended_key_usages = vec![ExtendedKeyUsagePurpose::ServerAuth];
        params.use_authority_key_identifier_extension = true;
        let since_1970 = since_1970(start);
        let epoch = date_time_ymd(1970, 1, 1);
        params.not_before = epoch + since_1970.saturating_sub(BACKDATED);
        params.not_after = epoch + (since_1970 + LEAF_LIFETIME);
        let key = KeyPair::generate_for(&PKCS_ECDSA_P256_SHA256).map_err(make)?;
        let certificate = params.signed_by(&key, &self.issuer).map_err(make)?;
        let hash = Sha256::digest(certificate.der()).into();
        let signer = any_ecdsa_type(&PrivatePkcs8KeyDer::from(key.serialize_der()).into())
            .map_err(|error| AuthorityError::Make(error.to_string()))?;
        let chain = vec![certificate.der().clone(), self.certificate.clone()];
        Ok(Leaf { certified: Arc::new(CertifiedKey::new(chain, signer)), start, hash })
    }

    /// A secret for the use that `what` names, the same after every start.
    pub(crate) fn derive(&self, what: &str) -> [u8; 32] {
        Sha256::new().chain_update(self.secret).chain_update(what).finalize().into()
    }

    /// Whether a client would believe what it signs.
    fn check(&self) -> Result<(), String> {
        let now = SystemTime::now();
        let leaf = self.leaf(now).map_err(|error| error.to_string())?;
        let now = UnixTime::since_unix_epoch(since_1970(now));
        let pin = Pin::new(self.fingerprint());
        pin.check(leaf.certificate(), &leaf.certified.cert[1..], now)
            .map_err(|_| "the key and the certificate don't belong together".to_owned())
    }
}

impl Leaf {
    /// What TLS presents: the certificate, the authority's after it, and the key.
    #[must_use]
    pub fn certified(&self) -> &Arc<CertifiedKey> {
        &self.certified
    }

    /// The server's certificate.
    #[must_use]
    pub fn certificate(&self) -> &CertificateDer<'static> {
        &self.certified.cert[0]
    }

    /// SHA-256 of the DER encoding of [`certificate`](Self::certificate), as browsers want it.
    #[must_use]
    pub fn hash(&self) -> [u8; 32] {
        self.hash
    }

    /// What it was made for.
    #[must_use]
    pub fn start(&self) -> SystemTime {
        self.start
    }
}

/// Times of certificates begin in 1970 and end with the year 9999.
pub(crate) fn since_1970(time: SystemTime) -> Duration {
    const LATEST: Duration = Duration::from_hours(7900 * 365 * 24);
    time.duration_since(SystemTime::UNIX_EPOCH).unwrap_or_default().min(LATEST)
}

/// A new key and its certificate.
fn make_pem() -> Result<String, rcgen::Error> {
    let mut params = CertificateParams::default();
    params.distinguished_name = rcgen::DistinguishedName::new();
    params.distinguished_name.push(DnType::CommonName, "Farlight lighting server");
    // Valid always, also on machines that start with their clock in 1970.
    params.not_before = date_time_ymd(1970, 1, 1);
    params.not_after = date_time_ymd(9999, 12, 31);
    params.is_ca = IsCa::Ca(BasicConstraints::Constrained(0));
    params.key_usages = vec![KeyUsagePurpose::KeyCertSign];
    let key = KeyPair::generate_for(&PKCS_ECDSA_P256_SHA256)?;
    let certificate = params.self_signed(&key)?;
    let mut pem = key.serialize_pem();
    let _ = write!(pem, "{}", certificate.pem());
    Ok(pem)
}

type Parsed = (CertificateDer<'static>, Issuer<'static, KeyPair>, [u8; 32]);

fn parse(pem: &[u8]) -> Result<Parsed, String> {
    let key = PrivatePkcs8KeyDer::from_pem_slice(pem).map_err(|_| "it has no private key")?;
    let certificate = CertificateDer::from_pem_slice(pem).map_err(|_| "it has no certificate")?;
    let secret = Sha256::digest(key.secret_pkcs8_der()).into();
    let key = KeyPair::from_pkcs8_der_and_sign_algo(&key, &PKCS_ECDSA_P256_SHA256)
        .map_err(|error| format!("its private key can't be used: {error}"))?;
    let issuer = Issuer::from_ca_cert_der(&certificate, key)
        .map_err(|error| format!("its certificate can't be used: {error}"))?;
    Ok((certificate, issuer, secret))
}

#[cfg(test)]
mod tests {
    use std::fs;

    use super::*;

    #[test]
    fn it_stays() {
        let folder = tempfile::tempdir().unwrap();
        let one = Authority::open(folder.path()).unwrap();
        let two = Authority::open(folder.path()).unwrap();
        assert_eq!(one.fingerprint(), two.fingerprint());
        assert_eq!(one.token(), two.token());
        assert_eq!(one.derive("x"), two.derive("x"));
        assert_ne!(one.derive("x"), one.derive("y"));
        let other = tempfile::tempdir().unwrap();
        let other = Authority::open(other.path()).unwrap();
        assert_ne!(one.fingerprint(), other.fingerprint());
        assert_ne!(one.token(), other.token());
        assert_ne!(one.leaf(SystemTime::now()).unwrap().hash(), {
            one.leaf(SystemTime::now()).unwrap().hash()
        });
    }

    #[test]
    fn damage_is_reported_and_nothing_is_replaced() {
        let folder = tempfile::tempdir().unwrap();
        let other = tempfile::tempdir().unwrap();
        Authority::open(folder.path()).unwrap();
        Authority::open(other.path()).unwrap();
        let path = folder.path().join(AUTHORITY_FILE);
        let good = fs::read_to_string(&path).unwrap();
        let certificate = |pem: &str| pem[pem.find("-----BEGIN CERT").unwrap()..].to_owned();
        let theirs = certificate(&fs::read_to_string(other.path().join(AUTHORITY_FILE)).unwrap());
        let damaged = [
            String::new(),
            good[..good.len() / 3].to_owned(),
            good[..good.len() * 9 / 10].to_owned(),
            certificate(&good),
            good.replace(&certificate(&good), &theirs),
        ];
        for content in damaged {
            fs::write(&path, &content).unwrap();
            let error = Authority::open(folder.path()).err().unwrap();
            assert!(matches!(error, AuthorityError::Damaged { .. }), "{error}");
            assert!(error.to_string().contains(AUTHORITY_FILE), "{error}");
            assert_eq!(fs::read_to_string(&path).unwrap(), content);
        }
        fs::write(&path, &good).unwrap();
        fs::write(folder.path().join(TOKEN_FILE), "abc").unwrap();
        let error = Authority::open(folder.path()).err().unwrap().to_string();
        assert!(error.contains("token is damaged"), "{error}");
    }

    #[test]
    fn many_that_start_at_once_are_one() {
        let folder = tempfile::tempdir().unwrap();
        let all: Vec<_> = std::thread::scope(|scope| {
            let open = || Authority::open(folder.path()).unwrap();
            let threads: Vec<_> = (0..8).map(|_| scope.spawn(open)).collect();
            threads.into_iter().map(|t| t.join().unwrap()).collect()
        });
        for one in &all {
            assert_eq!(one.fingerprint(), all[0].fingerprint());
            assert_eq!(one.token(), all[0].token());
        }
    }

    #[test]
    fn clocks_far_off_do_no_harm() {
        let folder = tempfile::tempdir().unwrap();
        let authority = Authority::open(folder.path()).unwrap();
        let pin = Pin::new(authority.fingerprint());
        let years = |n: u64| Duration::from_hours(n * 365 * 24);
        let epoch = SystemTime::UNIX_EPOCH;
        for time in [epoch, epoch - years(10), epoch + years(79), epoch + years(9000)] {
            let leaf = authority.leaf(time).unwrap();
            let now = UnixTime::since_unix_epoch(since_1970(time));
            pin.check(leaf.certificate(), &leaf.certified().cert[1..], now).unwrap();
        }
    }
}
