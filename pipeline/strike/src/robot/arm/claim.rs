//! One program for one arm.

use std::io::{self, ErrorKind};
use std::os::linux::net::SocketAddrExt;
use std::os::unix::net::{SocketAddr, UnixListener};

/// Held while a program drives an arm. The system frees it when the program ends, however it ends, and it knows no user or folder: a name
/// in the abstract namespace of Unix sockets.
#[derive(Debug)]
pub(super) struct Claim(#[expect(dead_code, reason = "held, not used")] UnixListener);

impl Claim {
    /// Claims an arm by its address or its serial number. None where another program of this computer holds it.
    pub(super) fn take(what: &str) -> io::Result<Option<Self>> {
        let name = format!("carom arm {what}");
        // A socket's name has at most 107 bytes.
        let name = &name.as_bytes()[..name.len().min(100)];
        match UnixListener::bind_addr(&SocketAddr::from_abstract_name(name)?) {
            Ok(listener) => Ok(Some(Self(listener))),
            Err(error) if error.kind() == ErrorKind::AddrInUse => Ok(None),
            Err(error) => Err(error),
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn an_arm_is_one_programs_at_a_time() {
        let take = || Claim::take("of a test").expect("a claim or none");
        let first = take().expect("free");
        assert!(take().is_none());
        drop(first);
        assert!(take().is_some());
    }
}
