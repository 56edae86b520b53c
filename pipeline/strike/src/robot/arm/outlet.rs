//! Where requests to an arm go out. A stop goes out whatever else happens, over every connection there is, and closes the way for all else.

use std::io::{self, Write};
use std::net::{Shutdown, TcpStream};
use std::sync::{Arc, Mutex, PoisonError};
use std::time::{Duration, Instant};

use rustix::event::{PollFd, PollFlags, Timespec, poll};

use super::connection::is_nothing_yet;

/// Time between two looks for a reply, so that a stop ends the waiting.
const TICK: Duration = Duration::from_millis(10);

#[derive(Debug)]
struct Ways {
    /// The connections, each with the bytes that stop the arm over it.
    stops: Vec<(TcpStream, Vec<u8>)>,
    is_stopped: bool,
}

impl Drop for Ways {
    /// Shuts its connections, which ends what is still read over them: nothing is sent any more.
    fn drop(&mut self) {
        for (stream, _) in &self.stops {
            // One that is over already is closed, too.
            let _ = stream.shutdown(Shutdown::Read);
        }
    }
}

/// The connections to an arm: sends requests, and stops it from any thread.
#[derive(Clone, Debug)]
pub struct Outlet {
    ways: Arc<Mutex<Ways>>,
}

impl Outlet {
    /// An outlet over these connections, each with the bytes that stop the arm.
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

    /// Whether a connection that it is stopped over is closed: a guard that can stop nothing is none.
    pub(crate) fn is_closed(&self) -> bool {
        let ways = self.ways.lock().unwrap_or_else(PoisonError::into_inner);
        let closed = PollFlags::RDHUP | PollFlags::HUP | PollFlags::ERR;
        ways.stops.iter().any(|(stream, _)| {
            let mut asked = [PollFd::new(stream, PollFlags::RDHUP)];
            let answer = poll(&mut asked, Some(&Timespec::default()));
            answer.is_ok() && asked[0].revents().intersects(closed)
        })
    }

    /// Whether it was stopped from here.
    pub fn is_stopped(&self) -> bool {
        let ways = self.ways.lock().unwrap_or_else(PoisonError::into_inner);
        ways.is_stopped
    }

    /// Sends a request that is no stop; errors once the arm was stopped.
    pub fn send(&self, mut stream: &TcpStream, bytes: &[u8]) -> io::Result<()> {
        let ways = self.ways.lock().unwrap_or_else(PoisonError::into_inner);
        if ways.is_stopped {
            return Err(stopped());
        }
        stream.write_all(bytes)
    }

    /// Reads the bytes that come, up to a moment or a stop.
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

    /// Reads one line of text, up to a moment or a stop.
    pub(crate) fn read_line(&self, stream: &TcpStream, until: Instant) -> io::Result<String> {
        let mut line = Vec::new();
        while !line.ends_with(b"\n") {
            line.extend(self.read(stream, until)?);
        }
        Ok(String::from_utf8_lossy(&line).trim().to_owned())
    }
}

fn stopped() -> io::Error {
    io::Error::other("the arm was stopped: nothing more is sent to it")
}

#[cfg(test)]
mod tests {
    use std::net::TcpListener;
    use std::thread;

    use super::*;

    #[test]
    fn a_way_that_was_closed_from_there_is_seen_with_nothing_sent() {
        let listener = TcpListener::bind("127.0.0.1:0").expect("a port");
        let address = listener.local_addr().expect("an address");
        let connect = || TcpStream::connect(address).expect("connects");
        let (first, spare) = (connect(), connect());
        let [kept, closed] = [0; 2].map(|_| listener.accept().expect("accepts").0);
        let outlet = Outlet::new(vec![(first, Vec::new()), (spare, Vec::new())]);
        assert!(!outlet.is_closed());
        drop(closed);
        let begun = Instant::now();
        while !outlet.is_closed() {
            assert!(begun.elapsed() < Duration::from_secs(20));
            thread::sleep(Duration::from_millis(1));
        }
        drop(kept);
    }
}
