//! Connections to the ports of an arm, and what comes over them.

use std::io;
use std::net::{SocketAddr, TcpStream};
use std::ops::RangeInclusive;
use std::thread::{self, JoinHandle};
use std::time::Duration;

/// How long a connection may take.
pub(crate) const CONNECT: Duration = Duration::from_secs(2);
/// How long a socket may refuse a frame of some hundred bytes.
const SEND: Duration = Duration::from_millis(50);

/// Whether an error means that nothing came within a socket's time.
pub(crate) fn is_nothing_yet(error: &io::Error) -> bool {
    use io::ErrorKind::{Interrupted, TimedOut, WouldBlock};
    matches!(error.kind(), WouldBlock | TimedOut | Interrupted)
}

/// What happened to a connection, where the system's words say little.
pub(super) fn what_happened(error: &io::Error) -> String {
    match error.kind() {
        io::ErrorKind::UnexpectedEof => "the connection was closed from there".into(),
        _ if is_nothing_yet(error) => "nothing came in time".into(),
        _ => error.to_string(),
    }
}

/// Starts a thread. Where the system gives none, the error says what to mend.
pub(crate) fn start<T: Send + 'static>(
    name: &str,
    does: impl FnOnce() -> T + Send + 'static,
) -> io::Result<JoinHandle<T>> {
    let thread = thread::Builder::new().name(name.into()).spawn(does);
    thread.map_err(|error| no_thread(&error))
}

/// What to mend where the system gives no thread.
pub(super) fn no_thread(error: &io::Error) -> io::Error {
    let why = format!(
        "this computer starts no more threads ({error}); end other programs, or raise its limits (`ulimit -u`, `ulimit -v`)"
    );
    io::Error::new(io::ErrorKind::OutOfMemory, why)
}

/// Why there is no connection, and what to mend: where the system gives no more files or threads, that is no fault of the network.
pub(crate) fn why_none(error: &io::Error, mend: &str) -> String {
    const NO_MORE_FILES: [i32; 2] = [23, 24];
    match error.raw_os_error() {
        Some(code) if NO_MORE_FILES.contains(&code) => {
            format!(
                "{error}: this computer gives no more files; end other programs, or raise its limit (`ulimit -n`)"
            )
        }
        _ if error.kind() == io::ErrorKind::OutOfMemory => error.to_string(),
        _ => format!("{}; {mend}", what_happened(error)),
    }
}

/// A connection to a port of an arm.
pub(crate) fn connect(address: SocketAddr, patience: Duration) -> io::Result<TcpStream> {
    let stream = TcpStream::connect_timeout(&address, patience)?;
    stream.set_nodelay(true)?;
    stream.set_write_timeout(Some(SEND))?;
    Ok(stream)
}

/// A connection to a port that nothing is to be read from: a thread throws away what comes until it is over, so that the controller never
/// waits.
pub(crate) fn connect_unread(address: SocketAddr, patience: Duration) -> io::Result<TcpStream> {
    let stream = connect(address, patience)?;
    let mut told = stream.try_clone()?;
    start("arm-told", move || io::copy(&mut told, &mut io::sink()))?;
    Ok(stream)
}

/// A connection to a port that reports: whoever reads it comes back within `patience` and every second, so that it ends with the
/// program's use of the arm.
pub(crate) fn listen(address: SocketAddr, patience: Duration) -> io::Result<TcpStream> {
    let stream = connect(address, patience)?;
    stream.set_read_timeout(Some(patience.min(Duration::from_secs(1))))?;
    Ok(stream)
}

/// Reads a frame whose length (bytes, its header included) stands in its header. Errors where it is none of `lengths`.
pub(crate) fn read_frame<const HEADER: usize>(
    stream: &mut impl io::Read,
    length: fn([u8; HEADER]) -> usize,
    lengths: RangeInclusive<usize>,
) -> io::Result<Vec<u8>> {
    let mut header = [0; HEADER];
    stream.read_exact(&mut header)?;
    let length = length(header);
    if !lengths.contains(&length) {
        let why = format!(
            "a frame says that it has {length} bytes, {} to {} are known",
            lengths.start(),
            lengths.end()
        );
        return Err(garbage(why));
    }
    let mut frame = vec![0; length];
    frame[..HEADER].copy_from_slice(&header);
    stream.read_exact(&mut frame[HEADER..])?;
    Ok(frame)
}

/// The first version in a text, as 2.4.0 in `v2.4.0`: its first two numbers.
pub(crate) fn version_in(text: &str) -> Option<(u32, u32)> {
    let dotted = |c: char| c.is_ascii_digit() || c == '.';
    text.split(|c| !dotted(c)).find_map(|word| {
        let (major, rest) = word.split_once('.')?;
        let minor = rest.split('.').next()?;
        Some((major.parse().ok()?, minor.parse().ok()?))
    })
}

/// The error of received data that makes no sense.
pub(crate) fn garbage(why: impl Into<String>) -> io::Error {
    io::Error::new(io::ErrorKind::InvalidData, why.into())
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn files_and_threads_that_have_run_out_are_no_fault_of_the_network() {
        let told = |code| why_none(&io::Error::from_raw_os_error(code), "check the network");
        assert!(told(111).ends_with("check the network"));
        assert!(told(11).contains("in time"));
        assert!(told(24).contains("ulimit") && !told(24).contains("network"));
        let none = no_thread(&io::Error::from_raw_os_error(11));
        let told = why_none(&none, "check the network");
        assert!(
            told.contains("threads") && !told.contains("network"),
            "{told}"
        );
    }
}
