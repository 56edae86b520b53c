//! One program for one arm.

use std::io::{self, ErrorKind};
use std::os::linux::net::SocketAddrExt;
use std::os::unix::net::{SocketAddr, UnixListener};
use std::thread;
use std::time::Duration;

/// Number of tries, and the time between two, 0.3 s in all: what a program held that has just ended is let go a moment later, by a process that it
/// was starting, or by a controller that has not noticed yet.
const LET_GO: (u32, Duration) = (30, Duration::from_millis(10));

/// Takes what one program at a time may hold, in several tries. Errors with `ResourceBusy` where another one keeps it.
pub(super) fn once_free<T>(mut take: impl FnMut() -> io::Result<T>) -> io::Result<T> {
    let (times, apart) = LET_GO;
    for _ in 0..times {
        match take() {
            Err(error) if error.kind() == ErrorKind::ResourceBusy => thread::sleep(apart),
            taken => return taken,
        }
    }
    take()
}

/// Held while a program drives an arm. The system frees it when the program ends, however it ends, and it knows no user or folder: a name
/// in the abstract namespace of Unix sockets.
#[derive(Debug)]
pub(super) struct Claim(#[expect(dead_code, reason = "held, not used")] UnixListener);

impl Claim {
    /// Claims an arm by its address or its serial number. Errors with `ResourceBusy` where another program of this computer holds it.
    pub(super) fn take(what: &str) -> io::Result<Self> {
        let name = format!("carom arm {what}");
        // A socket's name has at most 107 bytes.
        let name = &name.as_bytes()[..name.len().min(100)];
        let name = SocketAddr::from_abstract_name(name)?;
        let bound = once_free(|| {
            UnixListener::bind_addr(&name).map_err(|error| match error.kind() {
                ErrorKind::AddrInUse => ErrorKind::ResourceBusy.into(),
                _ => error,
            })
        });
        bound.map(Self)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn an_arm_is_one_programs_at_a_time() {
        let first = Claim::take("of a test").expect("free");
        let error = Claim::take("of a test").expect_err("held");
        assert_eq!(error.kind(), ErrorKind::ResourceBusy);
        drop(first);
        Claim::take("of a test").expect("free again");
    }

    #[test]
    fn what_is_let_go_a_moment_later_is_had() {
        let mut times = 0;
        let mut busy_for = |most: u32| {
            times = 0;
            once_free(|| {
                times += 1;
                match times <= most {
                    true => Err(io::Error::from(ErrorKind::ResourceBusy)),
                    false => Ok(()),
                }
            })
        };
        busy_for(10).expect("it is let go");
        busy_for(u32::MAX).expect_err("it is kept");
        // What fails otherwise is not asked for again.
        let mut asked = 0;
        let refused = once_free(|| {
            asked += 1;
            Err::<(), _>(io::Error::from(ErrorKind::ConnectionRefused))
        });
        assert_eq!((refused.is_err(), asked), (true, 1));
    }
}
