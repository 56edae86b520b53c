//! The WebSocket: connecting within a time, and one message after another, of a bounded size.

use std::io::{self, ErrorKind};
use std::net::{TcpStream, ToSocketAddrs};
use std::time::{Duration, Instant};

use tungstenite::client::IntoClientRequest;
use tungstenite::handshake::HandshakeError;
use tungstenite::http::HeaderValue;
use tungstenite::http::header::SEC_WEBSOCKET_PROTOCOL;
use tungstenite::protocol::WebSocketConfig;
use tungstenite::{Error, Message, WebSocket};

use super::error::LiveError;
use super::protocol::SUBPROTOCOLS;
use crate::robot::arm::{is_nothing_yet, why_none};

/// How long connecting may take, the handshake included.
const CONNECT: Duration = Duration::from_secs(5);
/// Time of one read of the socket: in between, the end of the program, or that nothing comes, is noticed.
const TICK: Duration = Duration::from_millis(10);
/// How long the socket may refuse a subscription.
const SEND: Duration = Duration::from_secs(1);
/// Largest message that is taken, in bytes: an uncompressed image of 20 megapixels.
const LARGEST: usize = 64 << 20;

/// What a person should mend where nothing answers, or not as a server does.
const MEND: &str = "check that the server runs there, such as ROS 2's foxglove_bridge";

/// A connection to a server of live topics.
pub(super) struct Connection {
    url: String,
    socket: WebSocket<TcpStream>,
}

impl Connection {
    /// Connects to `ws://HOST:PORT`.
    pub(super) fn open(url: &str) -> Result<Self, LiveError> {
        let until = Instant::now() + CONNECT;
        let failed = |error: &io::Error| LiveError::Connection {
            url: url.into(),
            why: why_none(error, MEND),
        };
        let not_an_address = || LiveError::Address(url.into());
        let mut request = url.into_client_request().map_err(|_| not_an_address())?;
        let (Some("ws"), Some(host)) = (request.uri().scheme_str(), request.uri().host()) else {
            return Err(not_an_address());
        };
        let port = request.uri().port_u16().ok_or_else(not_an_address)?;
        // An IPv6 address stands in brackets in an address, and without them in a lookup.
        let host = host.trim_start_matches('[').trim_end_matches(']');
        let stream = connect(host, port, until).map_err(|error| failed(&error))?;
        request.headers_mut().insert(
            SEC_WEBSOCKET_PROTOCOL,
            HeaderValue::from_static(SUBPROTOCOLS),
        );
        let config = WebSocketConfig::default()
            .max_message_size(Some(LARGEST))
            .max_frame_size(Some(LARGEST));
        let mut shaking = tungstenite::client::client_with_config(request, stream, Some(config));
        loop {
            match shaking {
                Ok((socket, _)) => {
                    return Ok(Self {
                        url: url.into(),
                        socket,
                    });
                }
                Err(HandshakeError::Interrupted(_)) if Instant::now() > until => {
                    let why = format!("the handshake was not over within {} s", CONNECT.as_secs());
                    return Err(failed(&io::Error::other(why)));
                }
                Err(HandshakeError::Interrupted(middle)) => shaking = middle.handshake(),
                Err(HandshakeError::Failure(error)) => {
                    return Err(failed(&io::Error::other(error)));
                }
            }
        }
    }

    /// The next message; none where none came within a short time.
    pub(super) fn read(&mut self) -> Result<Option<Message>, LiveError> {
        match self.socket.read() {
            Ok(Message::Close(_)) => Err(self.broken("the server closed the connection")),
            Ok(message) => Ok(Some(message)),
            Err(Error::Io(error)) if is_nothing_yet(&error) => Ok(None),
            Err(Error::ConnectionClosed | Error::AlreadyClosed) => {
                Err(self.broken("the server closed the connection"))
            }
            Err(error) => Err(self.broken(&error.to_string())),
        }
    }

    pub(super) fn send(&mut self, text: String) -> Result<(), LiveError> {
        self.socket
            .send(Message::text(text))
            .map_err(|error| self.broken(&error.to_string()))
    }

    /// The error of a server that violates the protocol.
    pub(super) fn wrong(&self, why: String) -> LiveError {
        LiveError::Protocol {
            url: self.url.clone(),
            why,
        }
    }

    fn broken(&self, why: &str) -> LiveError {
        LiveError::Connection {
            url: self.url.clone(),
            why: format!("{why}; {MEND}"),
        }
    }
}

impl Drop for Connection {
    fn drop(&mut self) {
        // The server is sent a close; whether it arrives does not matter any more.
        let _ = self.socket.close(None);
        let _ = self.socket.flush();
    }
}

/// The first of the host's addresses that answers.
fn connect(host: &str, port: u16, until: Instant) -> io::Result<TcpStream> {
    let mut last = io::Error::other("the name has no address");
    for address in (host, port).to_socket_addrs()? {
        let left = until.saturating_duration_since(Instant::now());
        if left.is_zero() {
            return Err(ErrorKind::TimedOut.into());
        }
        match TcpStream::connect_timeout(&address, left) {
            Ok(stream) => {
                stream.set_nodelay(true)?;
                stream.set_read_timeout(Some(TICK))?;
                stream.set_write_timeout(Some(SEND))?;
                return Ok(stream);
            }
            Err(error) => last = error,
        }
    }
    Err(last)
}
