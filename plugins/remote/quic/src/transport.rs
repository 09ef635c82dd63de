//! How QUIC is set up.

use std::{
    hash::{BuildHasher, Hasher, RandomState},
    sync::Arc,
    time::Duration,
};

use rustls::{
    ClientConfig, ServerConfig, crypto::ring, server::NoServerSessionStorage, version::TLS13,
};
use sha2::{Digest, Sha256};
use wtransport::{
    quinn::{self, IdleTimeout, TransportConfig, crypto::HmacKey},
    tls::WEBTRANSPORT_ALPN,
};

use crate::{Authority, Pin, congestion::SteadyConfig, incoming, rotation::Rotation};

/// After so long without a word from the other side the connection is lost.
const IDLE: Duration = Duration::from_secs(10);

/// The client says so often that it is there when there is nothing to say, also for the sake of
/// routers that forget silent connections.
const KEEP_ALIVE: Duration = Duration::from_secs(3);

/// What the round trip may be before it is measured. Packets of the handshake are sent again after
/// three times this.
const FIRST_RTT: Duration = Duration::from_millis(100);

/// A packet counts as lost when so many later ones have arrived, or one that was sent an eighth of
/// a round trip later.
/// RFC 9002 says 3, but jitter lets more overtake, and what is sent again in vain looks like a
/// congested line.
const OVERTAKERS: u32 = 16;

/// Bytes that may be on their way to this side: of one stream, and of all.
const STREAM_WINDOW: u32 = 512 << 10;
const WINDOW: u32 = 4 << 20;

/// Bytes that QUIC keeps until they have arrived at the other side. More than messages ever ask for, so
/// that control messages always find room.
const SEND_WINDOW: u64 = 16 << 20;

/// Datagrams are not used, but WebTransport wants to have them.
const DATAGRAMS: usize = 16 << 10;

/// Settings that both sides share.
pub(crate) fn transport(client: bool) -> TransportConfig {
    let mut config = TransportConfig::default();
    config
        .max_idle_timeout(IdleTimeout::try_from(IDLE).ok())
        .keep_alive_interval(client.then_some(KEEP_ALIVE))
        .initial_rtt(FIRST_RTT)
        .packet_threshold(OVERTAKERS)
        .max_concurrent_uni_streams(incoming::STREAMS.into())
        .max_concurrent_bidi_streams(4_u8.into())
        .stream_receive_window(STREAM_WINDOW.into())
        .receive_window(WINDOW.into())
        .send_window(SEND_WINDOW)
        .datagram_receive_buffer_size(Some(DATAGRAMS))
        .datagram_send_buffer_size(DATAGRAMS)
        .congestion_controller_factory(Arc::new(SteadyConfig));
    config
}

/// TLS of a client that believes `pin`.
pub(crate) fn client_tls(pin: Arc<Pin>) -> Result<ClientConfig, rustls::Error> {
    let mut tls = ClientConfig::builder_with_provider(Arc::new(ring::default_provider()))
        .with_protocol_versions(&[&TLS13])?
        .dangerous()
        .with_custom_certificate_verifier(pin)
        .with_no_client_auth();
    tls.alpn_protocols = vec![WEBTRANSPORT_ALPN.to_vec()];
    // A resumed session would skip the certificate.
    tls.resumption = rustls::client::Resumption::disabled();
    Ok(tls)
}

/// TLS of a server.
pub(crate) fn server_tls(certificates: Arc<Rotation>) -> Result<ServerConfig, rustls::Error> {
    let mut tls = ServerConfig::builder_with_provider(Arc::new(ring::default_provider()))
        .with_protocol_versions(&[&TLS13])?
        .with_no_client_auth()
        .with_cert_resolver(certificates);
    tls.alpn_protocols = vec![WEBTRANSPORT_ALPN.to_vec()];
    tls.session_storage = Arc::new(NoServerSessionStorage {});
    tls.send_tls13_tickets = 0;
    Ok(tls)
}

/// Lets a server that was started anew tell clients of the one before that it doesn't know them
/// ("stateless reset", RFC 9000, 10.3), so that they connect again at once.
pub(crate) fn remember(config: &mut quinn::EndpointConfig, authority: &Authority) {
    config
        .reset_key(Arc::new(ResetKey(authority.derive("stateless resets"))))
        // The default takes only identifiers of its own, which a new server would not know.
        .cid_generator(|| Box::new(RandomIds));
}

/// Connection identifiers of 8 random bytes.
struct RandomIds;

impl quinn::ConnectionIdGenerator for RandomIds {
    fn generate_cid(&mut self) -> quinn::ConnectionId {
        let mut id = [0; 8];
        if getrandom::fill(&mut id).is_err() {
            id = RandomState::new().build_hasher().finish().to_le_bytes();
        }
        quinn::ConnectionId::new(&id)
    }

    fn cid_len(&self) -> usize {
        8
    }

    fn cid_lifetime(&self) -> Option<Duration> {
        None
    }
}

/// HMAC with SHA-256 (RFC 2104) and a key of 32 bytes.
struct ResetKey([u8; 32]);

impl ResetKey {
    fn hmac(&self, data: &[u8]) -> [u8; 32] {
        let padded = |with: u8| {
            let mut block = [with; 64];
            block.iter_mut().zip(self.0).for_each(|(byte, key)| *byte ^= key);
            block
        };
        let inner = Sha256::new().chain_update(padded(0x36)).chain_update(data).finalize();
        Sha256::new().chain_update(padded(0x5c)).chain_update(inner).finalize().into()
    }
}

impl HmacKey for ResetKey {
    fn sign(&self, data: &[u8], signature_out: &mut [u8]) {
        signature_out.copy_from_slice(&self.hmac(data));
    }

    fn signature_len(&self) -> usize {
        32
    }

    fn verify(&self, data: &[u8], signature: &[u8]) -> Result<(), quinn::crypto::CryptoError> {
        let expected = self.hmac(data);
        // The same time wherever they differ.
        let differs = expected.iter().zip(signature).fold(0, |differs, (a, b)| differs | (a ^ b));
        let same = signature.len() == expected.len() && differs == 0;
        if same { Ok(()) } else { Err(quinn::crypto::CryptoError) }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn hmac_as_in_rfc_4231() {
        // Test case 1: the key is 20 bytes, which zeros fill up.
        let mut key = [0; 32];
        key[..20].fill(0x0b);
        let mac = ResetKey(key).hmac(b"Hi There");
        assert_eq!(mac[..6], [0xb0, 0x34, 0x4c, 0x61, 0xd8, 0xdb]);
        assert_eq!(mac[28..], [0x2e, 0x32, 0xcf, 0xf7]);
        assert!(ResetKey(key).verify(b"Hi There", &mac).is_ok());
        assert!(ResetKey(key).verify(b"hi there", &mac).is_err());
        assert!(ResetKey(key).verify(b"Hi There", &mac[..31]).is_err());
    }
}
