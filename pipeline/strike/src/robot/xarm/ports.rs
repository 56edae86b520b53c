//! An arm's ports.

use std::io;
use std::net::{SocketAddr, ToSocketAddrs};

use super::wire;

/// Addresses of an arm's ports.
#[derive(Clone, Copy, Debug)]
pub struct Ports {
    /// Requests and replies.
    pub control: SocketAddr,
    /// The real-time report.
    pub realtime: SocketAddr,
    /// The rich report.
    pub report: SocketAddr,
}

impl Ports {
    /// The maker's ports of a host. Errors where the name is not known.
    pub fn of(host: &str) -> io::Result<Self> {
        let address = (host, wire::CONTROL_PORT)
            .to_socket_addrs()?
            .next()
            .ok_or_else(|| io::Error::other("the name has no address"))?;
        let with = |port| SocketAddr::new(address.ip(), port);
        Ok(Self {
            control: address,
            realtime: with(wire::REALTIME_PORT),
            report: with(wire::REPORT_PORT),
        })
    }
}
