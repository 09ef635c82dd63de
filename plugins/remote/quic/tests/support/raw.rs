//! A client that does what it likes.

use std::sync::Arc;

use farlight_quic::Pin;
use farlight_wire::Invitation;
use rustls::{ClientConfig as Tls, crypto::ring, version::TLS13};
use tokio::runtime::{Builder, Runtime};
use wtransport::{
    ClientConfig, Connection, Endpoint, endpoint::endpoint_side::Client, error::ConnectingError,
    quinn,
};

pub(crate) fn runtime() -> Runtime {
    Builder::new_multi_thread().worker_threads(1).enable_all().build().unwrap()
}

/// Connects to any path; without a control stream.
pub(crate) async fn connect(
    invitation: &Invitation,
    path: &str,
) -> Result<(Endpoint<Client>, Connection), ConnectingError> {
    let mut tls = Tls::builder_with_provider(Arc::new(ring::default_provider()))
        .with_protocol_versions(&[&TLS13])
        .unwrap()
        .dangerous()
        .with_custom_certificate_verifier(Arc::new(Pin::new(invitation.authority)))
        .with_no_client_auth();
    tls.alpn_protocols = vec![b"h3".to_vec()];
    let transport = quinn::TransportConfig::default();
    let config = ClientConfig::builder()
        .with_bind_address(([127, 0, 0, 1], 0).into())
        .with_custom_tls_and_transport(tls, transport)
        .build();
    let endpoint = Endpoint::client(config).unwrap();
    let url = format!("https://{}:{}{path}", invitation.host, invitation.port);
    let connection = endpoint.connect(url).await?;
    Ok((endpoint, connection))
}
