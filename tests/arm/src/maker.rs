//! Makers whose arms are emulated, and what a test strikes with.

use std::sync::Arc;
use std::sync::atomic::AtomicBool;

use rig::{Hidden, Truth};
use strike::arm::Arm;
use strike::ur::Ur;
use strike::xarm::XArm;
use strike::{Guarded, Plan, RobotError, StrikeRecord, execute};
use values::{Point, Rig, Shape};

use crate::foxglove::Topic;
use crate::{Emulator, Fault, Listening, Maker, Model, Step, Table};

type Struck = Result<Option<StrikeRecord>, RobotError>;

/// An arm of a maker's driver, connected and claimed.
pub fn connect_to<D: Arm>(
    emulator: &Emulator,
    rig: &Rig,
    interrupted: Arc<AtomicBool>,
) -> Result<Guarded<D>, RobotError> {
    Guarded::connect("arm", &emulator.ports, rig, interrupted)
}

impl Maker {
    /// The demo's rig with all that an arm of this maker needs.
    pub fn rig(self) -> Rig {
        let mut rig = Rig::demo(Shape::Cylinder);
        let robot = &mut rig.robot;
        robot.base = Some(Point::default());
        robot.keep_out = Some(0.1);
        robot.reach = Some([0.1, 0.9].into());
        // Lines of the other's have no limit of jerk.
        robot.jerk = (self == Self::XArm).then_some(100.0);
        robot.strike_height = Some(0.02);
        robot.travel_height = Some(0.07);
        robot.tool_orientation = Some([std::f64::consts::PI, 0.0, 0.0]);
        robot.tool_offset = Some([0.0, 0.0, 0.1, 0.0, 0.0, 0.0]);
        robot.payload = Some(0.3);
        rig
    }

    /// This maker's arm, high above the table.
    pub fn model(self) -> Model {
        Model {
            // A Universal Robots arm is on, its brakes released.
            is_enabled: self == Self::Ur,
            ..Model::default()
        }
    }

    /// This maker's arm near the start of the tests' plan, so that a strike takes two seconds.
    pub fn near(self) -> Model {
        Model {
            pose: [200.0, 10.0, 67.0, std::f64::consts::PI, 0.0, 0.0],
            ..self.model()
        }
    }

    pub fn emulator(self, fault: Option<(Step, Fault)>) -> Emulator {
        self.listening(self.near(), fault)
    }

    /// An emulator of this arm of the maker.
    pub fn listening(self, model: Model, fault: Option<(Step, Fault)>) -> Emulator {
        Emulator::start(self, Listening::Free, model, fault).expect("free ports")
    }

    /// An arm at a table, whose object lies there (m) and is put back by a hand or not; and the address of its camera.
    pub fn at_table(self, rig: &Rig, object: Point, puts_back: bool) -> (Emulator, String) {
        let truth = Truth {
            hidden: Hidden::none(),
            ..Truth::demo(rig, 5)
        };
        let topic = &rig.topics.centroid.name;
        let camera = Topic::serve(([127, 0, 0, 1], 0).into(), topic).expect("a free port");
        let url = format!("ws://{}", camera.address);
        let table = Table::new(truth, object, puts_back).expect("the demo's object");
        let emulator = self.emulator(None);
        (emulator.with_table(table, (camera, rig.camera.rate)), url)
    }

    /// Connects to an emulated arm of this maker and makes the plan's strike: its record, or why there is none.
    pub fn strike(self, emulator: &Emulator, plan: &Plan) -> Struck {
        fn by<D: Arm>(emulator: &Emulator, plan: &Plan) -> Struck {
            let mut arm = connect_to::<D>(emulator, plan.rig(), Arc::default())?;
            execute(&mut arm, plan)
        }
        match self {
            Self::XArm => by::<XArm>(emulator, plan),
            Self::Ur => by::<Ur>(emulator, plan),
        }
    }

    pub fn run(self, fault: Option<(Step, Fault)>, plan: &Plan) -> (Emulator, Struck) {
        self.run_of(self.near(), fault, plan)
    }

    /// Makes the plan's strike with an emulated arm of this model: the emulator, and what came of the strike.
    pub fn run_of(
        self,
        model: Model,
        fault: Option<(Step, Fault)>,
        plan: &Plan,
    ) -> (Emulator, Struck) {
        let emulator = self.listening(model, fault);
        let outcome = self.strike(&emulator, plan);
        (emulator, outcome)
    }
}
