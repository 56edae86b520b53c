//! A plan, a rig with an arm, and one strike against the emulator.

use std::fs;
use std::io::Write;
use std::panic::{self, AssertUnwindSafe};
use std::process::Command;
use std::sync::Arc;
use std::sync::atomic::{AtomicBool, Ordering};
use std::thread;
use std::time::{Duration, Instant};

use arm::{Emulator, Fault, Listening, Model, Step};
use strike::arm::Arm;
use strike::ur::Ur;
use strike::xarm::XArm;
use strike::{Guarded, Plan, Planner, RobotError, StrikeRecord, execute};
use values::{Point, Rig};

use crate::fixture;

/// The demo's rig with all that an arm needs.
pub fn rig() -> Rig {
    let mut rig = fixture::rig();
    let robot = &mut rig.robot;
    robot.base = Some(Point::new(0.0, 0.0));
    robot.keep_out = Some(0.1);
    robot.reach = Some([0.1, 0.9].into());
    robot.jerk = Some(100.0);
    robot.strike_height = Some(0.02);
    robot.travel_height = Some(0.07);
    robot.tool_orientation = Some([std::f64::consts::PI, 0.0, 0.0]);
    robot.tool_offset = Some([0.0, 0.0, 0.1, 0.0, 0.0, 0.0]);
    robot.payload = Some(0.3);
    rig
}

pub fn plan(rig: &Rig, to: Point) -> Plan {
    let planner = Planner::within(&fixture::artifact(), store::Model::Sysid, rig).unwrap();
    planner
        .good_for(Duration::from_secs(60))
        .plan(Point::new(0.36, 0.0), to)
        .unwrap()
}

/// An arm near the start of the plan, so that a strike takes two seconds.
pub fn model() -> Model {
    Model {
        pose: [200.0, 10.0, 67.0, std::f64::consts::PI, 0.0, 0.0],
        ..Model::default()
    }
}

/// An arm of a maker's driver, connected and claimed.
pub fn connect_to<D: Arm>(
    emulator: &Emulator,
    rig: &Rig,
    interrupted: Arc<AtomicBool>,
) -> Result<Guarded<D>, RobotError> {
    Guarded::connect("arm", &emulator.ports, rig, interrupted)
}

pub fn connect(emulator: &Emulator, rig: &Rig) -> Result<Guarded<XArm>, RobotError> {
    connect_to(emulator, rig, Arc::default())
}

/// A strike that nothing disturbs. This process shares its processors: where they are taken from it for longer than reports may fail
/// to come, the strike stops, as it should, and is made again, twice at the most.
pub fn undisturbed(
    maker: Maker,
    plan: &Plan,
) -> (Emulator, Result<Option<StrikeRecord>, RobotError>) {
    before_others();
    for _ in 0..2 {
        let (emulator, outcome) = maker.run(None, plan);
        match &outcome {
            Err(RobotError::Interrupted { why, .. })
                if why.starts_with("no report came") || why.starts_with("its reports lag") =>
            {
                println!("made again: {why}");
            }
            _ => return (emulator, outcome),
        }
    }
    maker.run(None, plan)
}

/// How long this process may be without a processor for a strike to be judged: the arm reports every 4 ms, and is stopped where none comes.
const STANDSTILL: Duration = Duration::from_millis(20);
/// How often a test is made at the most; the last time decides.
const ATTEMPTS: usize = 12;

/// Takes this thread, and those that it starts, before others that want the processors, as an arm's computer would; where that is not
/// permitted, nothing is changed.
pub fn before_others() {
    let itself = fs::read_link("/proc/thread-self").unwrap_or_default();
    if let Some(thread) = itself.file_name() {
        let mut renice = Command::new("renice");
        // What it says where it may not is of no use.
        let _ = renice.args(["-n", "-20", "-p"]).arg(thread).output();
    }
}

/// A test of what is sent in time. Where it fails, and the machine stood still meanwhile, as a shared one may, it is made again, which is
/// said on standard error, past what the harness holds back.
pub fn in_time(test: impl Fn()) {
    before_others();
    for attempt in 1..=ATTEMPTS {
        let over = AtomicBool::new(false);
        let (outcome, longest) = thread::scope(|scope| {
            let longest = scope.spawn(|| longest_standstill(&over));
            let outcome = panic::catch_unwind(AssertUnwindSafe(&test));
            over.store(true, Ordering::Relaxed);
            (outcome, longest.join().unwrap())
        });
        let Err(failure) = outcome else {
            return;
        };
        if longest < STANDSTILL || attempt == ATTEMPTS {
            panic::resume_unwind(failure);
        }
        let name = thread::current().name().unwrap_or_default().to_owned();
        let text = format!("made again: {name}: this machine stood still for {longest:?}\n");
        std::io::stderr().write_all(text.as_bytes()).unwrap();
    }
}

/// The longest time by which a sleep was late until it is over.
fn longest_standstill(over: &AtomicBool) -> Duration {
    let nap = Duration::from_millis(1);
    let mut longest = Duration::ZERO;
    while !over.load(Ordering::Relaxed) {
        let start = Instant::now();
        thread::sleep(nap);
        longest = longest.max(start.elapsed() - nap);
    }
    longest
}

/// Waits until something holds, or until it is too late for it.
pub fn wait_for(holds: impl Fn() -> bool) {
    let start = Instant::now();
    while !holds() && start.elapsed() < Duration::from_secs(20) {
        thread::sleep(Duration::from_millis(1));
    }
}

/// Makers whose arms are emulated.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Maker {
    XArm,
    Ur,
}

impl Maker {
    /// The rig of an arm of this maker.
    pub fn rig(self) -> Rig {
        let mut rig = rig();
        if self == Self::Ur {
            rig.robot.jerk = None;
        }
        rig
    }

    /// The emulator's model of this maker's arm, near the start of the plan.
    pub fn model(self) -> Model {
        match self {
            Self::XArm => model(),
            Self::Ur => Model {
                pose: model().pose,
                ..Model::ur()
            },
        }
    }

    pub fn emulator(self, fault: Option<(Step, Fault)>) -> Emulator {
        self.listening(self.model(), fault)
    }

    /// An emulator of this arm of the maker.
    pub fn listening(self, model: Model, fault: Option<(Step, Fault)>) -> Emulator {
        match self {
            Self::XArm => Emulator::start(Listening::Free, model, fault).unwrap(),
            Self::Ur => Emulator::start_ur(Listening::Free, model, fault).unwrap(),
        }
    }

    /// Connects to an emulated arm of this maker and makes the plan's strike: its record, or why there is none.
    pub fn strike(
        self,
        emulator: &Emulator,
        plan: &Plan,
    ) -> Result<Option<StrikeRecord>, RobotError> {
        fn by<D: Arm>(
            emulator: &Emulator,
            plan: &Plan,
        ) -> Result<Option<StrikeRecord>, RobotError> {
            let mut arm = connect_to::<D>(emulator, plan.rig(), Arc::default())?;
            execute(&mut arm, plan)
        }
        match self {
            Self::XArm => by::<XArm>(emulator, plan),
            Self::Ur => by::<Ur>(emulator, plan),
        }
    }

    pub fn run(
        self,
        fault: Option<(Step, Fault)>,
        plan: &Plan,
    ) -> (Emulator, Result<Option<StrikeRecord>, RobotError>) {
        self.run_of(self.model(), fault, plan)
    }

    /// Makes the plan's strike with an emulated arm of this model: the emulator, and what came of the strike.
    pub fn run_of(
        self,
        model: Model,
        fault: Option<(Step, Fault)>,
        plan: &Plan,
    ) -> (Emulator, Result<Option<StrikeRecord>, RobotError>) {
        let emulator = self.listening(model, fault);
        let outcome = self.strike(&emulator, plan);
        (emulator, outcome)
    }
}
