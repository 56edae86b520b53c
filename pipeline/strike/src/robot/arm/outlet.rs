//! Where requests to an arm go out. A stop goes out whatever else happens, over every connection there is, and closes the way for all else.

use std::io::{self, Write};
use std::net::{SocketAddr, TcpStream};
use std::sync::{Arc, Mutex, PoisonError};
use std::time::{Duration, Instant};

/// How long a connection may take.
pub(crate) const CONNECT: Duration = Duration::from_secs(2);
/// How long a socket may refuse a frame of some hundred bytes.
const SEND: Duration = Duration::from_millis(50);
/// A reply is looked for this often, so that a stop ends the waiting.
const TICK: Duration = Duration::from_millis(10);

#[derive(Debug)]
struct Ways {
    /// Each with the bytes that stop the arm there.
    stops: Vec<(TcpStream, Vec<u8>)>,
    is_stopped: bool,
}

/// Sends, and stops from any thread.
#[derive(Clone, Debug)]
pub struct Outlet {
    ways: Arc<Mutex<Ways>>,
}

impl Outlet {
    /// Over these connections the arm is stopped by these bytes.
    pub fn new(stops: Vec<(TcpStream, Vec<u8>)>) -> Self {
        Self {
            ways: Arc::new(Mutex::new(Ways {
                stops,
                is_stopped: false,
            })),
        }
    }

    /// Stops the arm over every connection. From then on nothing else is sent, by whatever thread. Errors where none takes it.
    pub fn stop(&self) -> io::Result<()> {
        let mut ways = self.ways.lock().unwrap_or_else(PoisonError::into_inner);
        ways.is_stopped = true;
        let mut sent = Err(io::Error::from(io::ErrorKind::NotConnected));
        for (stream, bytes) in &mut ways.stops {
            let one = stream.write_all(bytes);
            if sent.is_err() {
                sent = one;
            }
        }
        sent
    }

    /// Whether it was stopped from here.
    pub fn is_stopped(&self) -> bool {
        let ways = self.ways.lock().unwrap_or_else(PoisonError::into_inner);
        ways.is_stopped
    }

    /// Sends what is no stop; errors once the arm was stopped.
    pub fn send(&self, mut stream: &TcpStream, bytes: &[u8]) -> io::Result<()> {
        let ways = self.ways.lock().unwrap_or_else(PoisonError::into_inner);
        if ways.is_stopped {
            return Err(stopped());
        }
        stream.write_all(bytes)
    }

    /// Bytes that come, up to a moment or a stop.
    pub fn read(&self, mut stream: &TcpStream, until: Instant) -> io::Result<Vec<u8>> {
        let mut bytes = vec![0; 4096];
        stream.set_read_timeout(Some(TICK))?;
        loop {
            match io::Read::read(&mut stream, &mut bytes) {
                Ok(0) => return Err(io::ErrorKind::UnexpectedEof.into()),
                Ok(count) => {
                    bytes.truncate(count);
                    return Ok(bytes);
                }
                Err(error) if is_nothing_yet(&error) => {}
                Err(error) => return Err(error),
            }
            if self.is_stopped() {
                return Err(stopped());
            }
            if Instant::now() >= until {
                return Err(io::ErrorKind::TimedOut.into());
            }
        }
    }
}

/// Nothing came within a socket's time.
pub(crate) fn is_nothing_yet(error: &io::Error) -> bool {
    use io::ErrorKind::{Interrupted, TimedOut, WouldBlock};
    matches!(error.kind(), WouldBlock | TimedOut | Interrupted)
}

/// A connection to a port of an arm.
pub(crate) fn connect(address: SocketAddr, patience: Duration) -> io::Result<TcpStream> {
    let stream = TcpStream::connect_timeout(&address, patience)?;
    stream.set_nodelay(true)?;
    stream.set_write_timeout(Some(SEND))?;
    Ok(stream)
}

fn stopped() -> io::Error {
    io::Error::other("the arm was stopped: nothing more is sent to it")
}
