//! A server of live topics in the Foxglove WebSocket protocol, as far as the executor asks of one.

use std::io;
use std::net::{SocketAddr, TcpListener, TcpStream};
use std::sync::atomic::{AtomicBool, Ordering};
use std::sync::{Arc, Mutex, MutexGuard, PoisonError, mpsc};
use std::thread;
use std::time::{Duration, SystemTime};

use tungstenite::handshake::server::{ErrorResponse, Request, Response};
use tungstenite::http::HeaderValue;
use tungstenite::http::header::SEC_WEBSOCKET_PROTOCOL;
use tungstenite::{Error, Message, WebSocket};

/// The protocol's name.
const SUBPROTOCOL: &str = "foxglove.websocket.v1";
/// A connection looks so often for what is to be sent.
const TICK: Duration = Duration::from_millis(2);

/// Takes a WebSocket connection with the protocol's name.
pub fn accept(stream: TcpStream) -> Option<WebSocket<TcpStream>> {
    #[expect(clippy::result_large_err, reason = "the crate requires this form")]
    fn name(_: &Request, mut response: Response) -> Result<Response, ErrorResponse> {
        response.headers_mut().insert(
            SEC_WEBSOCKET_PROTOCOL,
            HeaderValue::from_static(SUBPROTOCOL),
        );
        Ok(response)
    }
    tungstenite::accept_hdr(stream, name).ok()
}

/// A server of one topic, until it is dropped.
pub struct Topic {
    pub address: SocketAddr,
    shared: Arc<Shared>,
}

struct Shared {
    advertised: String,
    clients: Mutex<Vec<mpsc::Sender<Vec<u8>>>>,
    ends: AtomicBool,
}

impl Shared {
    fn clients(&self) -> MutexGuard<'_, Vec<mpsc::Sender<Vec<u8>>>> {
        self.clients.lock().unwrap_or_else(PoisonError::into_inner)
    }
}

impl Topic {
    /// A JSON topic of `geometry_msgs/msg/PointStamped`.
    pub fn serve(address: SocketAddr, topic: &str) -> io::Result<Self> {
        let advertised = format!(
            r#"{{"op":"advertise","channels":[{{"id":5,"topic":"{topic}","encoding":"json","schemaName":"geometry_msgs/msg/PointStamped","schema":"{{}}","schemaEncoding":"jsonschema"}}]}}"#
        );
        let listener = TcpListener::bind(address)?;
        listener.set_nonblocking(true)?;
        let topic = Self {
            address: listener.local_addr()?,
            shared: Arc::new(Shared {
                advertised,
                clients: Mutex::default(),
                ends: AtomicBool::new(false),
            }),
        };
        let shared = topic.shared.clone();
        thread::spawn(move || {
            while !shared.ends.load(Ordering::Relaxed) {
                if let Ok((stream, _)) = listener.accept() {
                    let shared = shared.clone();
                    thread::spawn(move || serve(&shared, stream));
                }
                thread::sleep(Duration::from_millis(5));
            }
        });
        Ok(topic)
    }

    /// Sends a place (m) on the table, stamped now, to whoever has subscribed.
    pub fn publish(&self, x: f64, y: f64) {
        self.publish_in("table", [x, y, 0.0]);
    }

    /// Sends a place (m) in the frame of this name, stamped now, to whoever has subscribed.
    pub fn publish_in(&self, frame: &str, [x, y, z]: [f64; 3]) {
        let since = SystemTime::now().duration_since(SystemTime::UNIX_EPOCH);
        let stamp = since.unwrap_or_default();
        self.send(&format!(
            r#"{{"header":{{"stamp":{{"sec":{},"nanosec":{}}},"frame_id":"{frame}"}},"point":{{"x":{x},"y":{y},"z":{z}}}}}"#,
            stamp.as_secs(),
            stamp.subsec_nanos()
        ));
    }

    pub fn send(&self, message: &str) {
        self.shared
            .clients()
            .retain(|client| client.send(message.as_bytes().to_vec()).is_ok());
    }
}

impl Drop for Topic {
    fn drop(&mut self) {
        self.shared.ends.store(true, Ordering::Relaxed);
    }
}

fn serve(shared: &Shared, stream: TcpStream) {
    let is_ready = stream.set_nonblocking(false).is_ok() && stream.set_nodelay(true).is_ok();
    let Some(mut socket) = accept(stream).filter(|_| is_ready) else {
        return;
    };
    let info = r#"{"op":"serverInfo","name":"emulated camera","capabilities":[]}"#;
    let _ = socket.get_mut().set_read_timeout(Some(TICK));
    if socket.send(Message::text(info)).is_err()
        || socket
            .send(Message::text(shared.advertised.clone()))
            .is_err()
    {
        return;
    }
    let (sender, receiver) = mpsc::channel();
    let mut subscription = None;
    while !shared.ends.load(Ordering::Relaxed) {
        match socket.read() {
            Ok(Message::Text(text)) if text.contains("subscribe") => {
                // {"op":"subscribe","subscriptions":[{"id":N,…
                let id = text.split(r#""id":"#).nth(1).unwrap_or_default();
                let digits: String = id.chars().take_while(char::is_ascii_digit).collect();
                if subscription.is_none() {
                    shared.clients().push(sender.clone());
                }
                subscription = digits.parse::<u32>().ok();
            }
            Ok(Message::Close(_)) => return,
            Ok(_) => {}
            Err(Error::Io(error))
                if matches!(
                    error.kind(),
                    io::ErrorKind::WouldBlock | io::ErrorKind::TimedOut
                ) => {}
            Err(_) => return,
        }
        for message in receiver.try_iter() {
            let Some(id) = subscription else { continue };
            let mut frame = vec![1];
            frame.extend(id.to_le_bytes());
            frame.extend(0u64.to_le_bytes());
            frame.extend(message);
            if socket.send(Message::binary(frame)).is_err() {
                return;
            }
        }
    }
}
