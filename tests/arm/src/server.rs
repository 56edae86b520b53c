//! The ports: each connection on a thread of its own.

use std::io::{self, Write};
use std::net::{IpAddr, SocketAddr, TcpListener, TcpStream};
use std::sync::atomic::{AtomicBool, Ordering};
use std::sync::{Arc, Mutex};
use std::thread;
use std::time::{Duration, Instant};

use crate::foxglove::Topic;
use crate::frames::{Reported, Request};
use crate::model::Model;
use crate::shared::{Shared, is_cut, is_dead, is_held, is_shut, more};
use crate::state::{Event, State};
use crate::table::Table;
use crate::{Fault, Step, ur};

/// Makers whose arms are emulated.
#[derive(Clone, Copy, Debug, PartialEq, Eq, clap::ValueEnum)]
pub enum Maker {
    /// UFACTORY's xArm7.
    #[value(name = "xarm")]
    XArm,
    /// Universal Robots' e-Series.
    Ur,
}

/// From one real-time report to the next, and from one ordinary report to the next.
const REALTIME: Duration = Duration::from_millis(4);
const ORDINARY: Duration = Duration::from_millis(200);

#[derive(Clone, Copy, Debug)]
pub enum Listening {
    /// The maker's ports of an address.
    Standard(IpAddr),
    /// Free ports of the loopback address.
    Free,
}

/// A controller that runs until it is dropped.
pub struct Emulator {
    /// The emulator's addresses. Of an xArm: control, real-time, ordinary and rich report. Of Universal Robots: two of scripts, RTDE, dashboard.
    pub ports: [SocketAddr; 4],
    shared: Arc<Shared>,
}

/// What serves a connection of a port.
type Serve = fn(&Shared, TcpStream);

impl Emulator {
    /// Starts one of a maker's arm; the fault is made once, at its step.
    pub fn start(
        maker: Maker,
        listening: Listening,
        model: Model,
        fault: Option<(Step, Fault)>,
    ) -> io::Result<Self> {
        /// No limit that a line could feel.
        const JERK: f64 = 1e9;
        let mut state = State::new(model, fault);
        let (ports, serve): ([u16; 4], [Serve; 4]) = match maker {
            Maker::XArm => (
                [502, 30_000, 30_001, 30_002],
                [
                    control,
                    realtime,
                    |shared, stream| report(shared, stream, Reported::ordinary),
                    |shared, stream| report(shared, stream, Reported::rich),
                ],
            ),
            Maker::Ur => {
                state.ramp[0] = JERK;
                (
                    [30_001, 30_002, 30_004, 29_999],
                    [ur::script, ur::script, ur::rtde, ur::dashboard],
                )
            }
        };
        Self::serve(listening, state, ports, serve)
    }

    fn serve(
        listening: Listening,
        state: State,
        ports: [u16; 4],
        serve: [Serve; 4],
    ) -> io::Result<Self> {
        let listen = |port: u16| match listening {
            Listening::Standard(address) => TcpListener::bind((address, port)),
            Listening::Free => TcpListener::bind(("127.0.0.1", 0)),
        };
        let listeners: Vec<TcpListener> =
            ports.into_iter().map(listen).collect::<io::Result<_>>()?;
        let shared = Arc::new(Shared {
            state: Mutex::new(state),
            ends: AtomicBool::new(false),
        });
        let mut ports = Vec::new();
        for (listener, serve) in listeners.into_iter().zip(serve) {
            ports.push(listener.local_addr()?);
            listener.set_nonblocking(true)?;
            let shared = shared.clone();
            thread::spawn(move || accept(&shared, &listener, serve));
        }
        let ticking = shared.clone();
        thread::spawn(move || {
            while !ticking.ends() {
                ticking.lock().pass();
                thread::sleep(Duration::from_millis(1));
            }
        });
        Ok(Self {
            ports: [ports[0], ports[1], ports[2], ports[3]],
            shared,
        })
    }

    /// This emulator with a table before the arm, and a camera that publishes what it sees of the table, at its rate in Hz.
    pub fn with_table(self, table: Table, (camera, rate): (Topic, f64)) -> Self {
        let shared = self.shared.clone();
        shared.lock().table = Some(table);
        thread::spawn(move || {
            let mut next = Instant::now();
            while !shared.ends() {
                next += Duration::from_secs_f64(1.0 / rate);
                thread::sleep(next.saturating_duration_since(Instant::now()));
                let seen = shared
                    .lock()
                    .table
                    .as_mut()
                    .and_then(|table| table.seen(Instant::now()));
                if let Some(point) = seen {
                    camera.publish(point.x, point.y);
                }
            }
        });
        self
    }

    /// Looks at the table or changes it; none where there is none.
    pub fn table<T>(&self, look: impl FnOnce(&mut Table) -> T) -> Option<T> {
        self.shared.lock().table.as_mut().map(look)
    }

    /// Lines that came and were to be moved.
    pub fn lines(&self) -> usize {
        let state = self.shared.lock();
        let events = state.events.iter();
        events
            .filter(|(_, event)| matches!(event, Event::Line))
            .count()
    }

    /// What came, and when the fault was made.
    pub fn events(&self) -> Vec<(Instant, Event)> {
        self.shared.lock().events.clone()
    }

    /// How far the tip moved since the first stop, in mm.
    pub fn moved_after_stop(&self) -> f64 {
        self.shared.lock().moved_after_stop
    }

    pub fn state(&self) -> u8 {
        self.shared.lock().reported().state
    }

    /// Whether a script runs, or a line is moved on.
    pub fn is_running(&self) -> bool {
        self.shared.lock().reported().is_running
    }

    /// Jerk in mm/s³ and greatest acceleration in mm/s² that lines have now.
    pub fn ramp(&self) -> [f64; 2] {
        self.shared.lock().ramp
    }

    pub fn make(&self, fault: Fault) {
        let mut state = self.shared.lock();
        state.fault = Some((Step::Connect, fault));
        state.make_fault();
    }

    /// Lets another program give its signs of life from now on.
    pub fn is_claimed(&self) {
        self.shared.lock().is_claimed = true;
    }

    /// What is changed of the arm now.
    pub fn change(&self, change: impl FnOnce(&mut Model)) {
        change(&mut self.shared.lock().model);
    }

    /// Where the tip is, in mm and rad.
    pub fn pose(&self) -> [f64; 6] {
        self.shared.lock().reported().pose
    }
}

impl Drop for Emulator {
    fn drop(&mut self) {
        self.shared.ends.store(true, Ordering::Relaxed);
    }
}

fn accept(shared: &Arc<Shared>, listener: &TcpListener, serve: Serve) {
    while !shared.ends() {
        if shared.lock().is_made(Fault::Gone) {
            // Closing the listener refuses what comes.
            return;
        }
        match listener.accept() {
            Ok((stream, _)) => {
                let shared = shared.clone();
                thread::spawn(move || {
                    let _ = stream.set_nonblocking(false);
                    let _ = stream.set_nodelay(true);
                    serve(&shared, stream);
                });
            }
            Err(_) => thread::sleep(Duration::from_millis(2)),
        }
    }
}

fn control(shared: &Shared, mut stream: TcpStream) {
    let since = Instant::now();
    let _ = stream.set_read_timeout(Some(Duration::from_millis(5)));
    let mut waiting = Vec::new();
    while !shared.ends() && !is_shut(shared, since) {
        let Some(came) = more(&mut stream) else {
            return;
        };
        waiting.extend(came);
        if is_dead(shared, since) {
            waiting.clear();
            continue;
        }
        // The maker's heartbeats have no register of their own and no answer.
        while let Some(request) = whole(&mut waiting) {
            let reply = shared.lock().answer(&request);
            let reply = match shared.made() {
                Some(Fault::SlowReplies) => {
                    thread::sleep(Duration::from_secs(3));
                    reply
                }
                Some(Fault::GarbageReply) => vec![0xa5; 32],
                _ => reply,
            };
            if is_shut(shared, since) || stream.write_all(&reply).is_err() {
                return;
            }
        }
    }
}

fn whole(waiting: &mut Vec<u8>) -> Option<Request> {
    let length = 6 + usize::from(u16::from_be_bytes([*waiting.get(4)?, *waiting.get(5)?]));
    if waiting.len() < length {
        return None;
    }
    let rest = waiting.split_off(length);
    let bytes = std::mem::replace(waiting, rest);
    if bytes[6] == 0 {
        return whole(waiting);
    }
    Some(Request { bytes })
}

fn realtime(shared: &Shared, mut stream: TcpStream) {
    let since = Instant::now();
    let mut next = Instant::now();
    let mut held = Vec::new();
    while !shared.ends() && !is_cut(shared, since) {
        next += REALTIME;
        thread::sleep(next.saturating_duration_since(Instant::now()));
        let made = shared.made();
        let frame = shared.lock().shown().realtime();
        if is_held(shared) {
            held.extend(frame);
            continue;
        }
        let frame = [std::mem::take(&mut held), frame].concat();
        let bytes = match made {
            Some(Fault::Silent) => continue,
            Some(Fault::HalfOpen | Fault::Dead) if is_dead(shared, since) => continue,
            Some(Fault::Garbage) => vec![0x5a; 804],
            Some(Fault::ShortFrame) => {
                let _ = stream.write_all(&frame[..300]);
                return;
            }
            _ => frame,
        };
        if stream.write_all(&bytes).is_err() {
            return;
        }
    }
}

fn report(shared: &Shared, mut stream: TcpStream, frame: fn(&Reported) -> Vec<u8>) {
    let since = Instant::now();
    while !shared.ends() && !is_cut(shared, since) {
        let frame = frame(&shared.lock().reported());
        if is_dead(shared, since) || stream.write_all(&frame).is_err() {
            return;
        }
        thread::sleep(ORDINARY);
    }
}
