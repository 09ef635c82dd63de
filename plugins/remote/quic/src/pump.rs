//! A [`Link`] over a WebTransport connection, the same for both sides.
//!
//! One bidirectional stream, opened by the client, carries the control channel; every other message has
//! a unidirectional stream of its own, so that a lost packet delays only the message that it is of.

use std::{sync::Arc, time::Duration};

use farlight_wire::{
    Channel, CloseCode, Closed, Limits, Link, LinkEvent, LinkStats, Transmit, TransmitId,
};
use tokio::{
    sync::mpsc::{UnboundedReceiver, UnboundedSender, unbounded_channel},
    task::JoinSet,
    time::timeout,
};
use wtransport::{Connection, RecvStream, SendStream};

use crate::{end::End, incoming, outgoing, outgoing::Outgoing, shared::Shared};

/// How long a goodbye waits for the control messages before it to arrive.
const FLUSH: Duration = Duration::from_millis(500);

/// How long the packet with the goodbye takes to leave.
const LEAVE: Duration = Duration::from_millis(5);

/// How long messages that have arrived before the end of the connection may take to be read.
const DRAIN: Duration = Duration::from_millis(100);

/// What a link asks of its task.
pub(crate) enum Command {
    Send(Transmit),
    Cancel(TransmitId),
    Close(CloseCode, String),
}

/// The session's end of a connection.
pub(crate) struct QuicLink {
    shared: Arc<Shared>,
    commands: UnboundedSender<Command>,
}

impl QuicLink {
    /// A link, and what its task needs.
    pub(crate) fn new(shared: Arc<Shared>) -> (Self, UnboundedReceiver<Command>) {
        let (commands, receiver) = unbounded_channel();
        (Self { shared, commands }, receiver)
    }
}

impl Link for QuicLink {
    fn send(&mut self, transmit: Transmit) {
        let _ = self.commands.send(Command::Send(transmit));
    }

    fn cancel(&mut self, id: TransmitId) {
        let _ = self.commands.send(Command::Cancel(id));
    }

    fn poll(&mut self) -> Option<LinkEvent> {
        self.shared.poll()
    }

    fn close(&mut self, code: CloseCode, reason: &str) {
        let _ = self.commands.send(Command::Close(code, reason.to_owned()));
    }

    fn stats(&self) -> LinkStats {
        self.shared.stats()
    }
}

/// What was asked for while connecting comes first.
async fn next(
    early: &mut std::vec::IntoIter<Command>,
    commands: &mut UnboundedReceiver<Command>,
) -> Option<Command> {
    match early.next() {
        Some(command) => Some(command),
        None => commands.recv().await,
    }
}

/// Moves messages until the connection ends, one side closes it, or the link is dropped. Tells the other
/// side and says why.
pub(crate) async fn run(
    connection: &Connection,
    (send, receive): (SendStream, RecvStream),
    shared: &Arc<Shared>,
    commands: &mut UnboundedReceiver<Command>,
    early: Vec<Command>,
    limits: &Limits,
) -> Closed {
    shared.opened(connection.quic_connection().clone());
    let mut early = early.into_iter();
    let mut readers = JoinSet::new();
    readers.spawn(incoming::control(receive, connection.clone(), Arc::clone(shared), *limits));
    readers.spawn(incoming::streams(connection.clone(), Arc::clone(shared), *limits));
    let mut outgoing = Outgoing::new(connection.clone(), Arc::clone(shared));
    let (control, control_receiver) = unbounded_channel();
    let mut writer = JoinSet::new();
    writer.spawn(outgoing::control(send, control_receiver, Arc::clone(shared)));

    let end = loop {
        let result = tokio::select! {
            error = connection.quic_connection().closed() => break End::Gone(error),
            command = next(&mut early, commands) => {
                match command {
                    Some(Command::Send(transmit)) if transmit.channel == Channel::Control => {
                        let _ = control.send(transmit);
                    }
                    Some(Command::Send(transmit)) => outgoing.send(transmit),
                    Some(Command::Cancel(id)) => outgoing.cancel(id),
                    Some(Command::Close(code, reason)) => break End::Ours(code, reason),
                    // Dropped without a goodbye: the session may go on elsewhere.
                    None => break End::Ours(CloseCode::Abandoned, String::new()),
                }
                continue;
            }
            () = outgoing.arrived() => continue,
            Some(result) = readers.join_next() => result,
        };
        match result {
            Ok(Err(end)) => break end,
            // The end of the connection has ended them.
            Ok(Ok(())) => {}
            Err(error) => break End::Lost(error.to_string()),
        }
    };

    match &end {
        End::Ours(..) => {
            drop(control);
            let _ = timeout(FLUSH, writer.join_next()).await;
        }
        // What the other side said before it left is worth hearing.
        End::Gone(_) => {
            let read = async { while readers.join_next().await.is_some() {} };
            let _ = timeout(DRAIN, read).await;
        }
        End::Broken(..) | End::Lost(_) => {}
    }
    // First the connection and then the streams: a stream that is dropped looks finished.
    let (code, reason) = end.code_and_reason();
    connection.close(code, reason);
    // Another task sends it. Whoever waits for the end of the link may end the process then.
    tokio::time::sleep(LEAVE).await;
    end.into_closed()
}
