//! The one place that reaches into MuJoCo's memory: a model and its data, owned by one worker.
#![expect(
    unsafe_code,
    reason = "a compiled model's contact parameters are changed in place, never recompiled a step"
)]

use std::sync::Once;

use mujoco_rs::{
    prelude::{MjData, MjModel},
    wrappers::mj_logging::{log_config, set_log_config},
};
use nalgebra::{Quaternion, UnitQuaternion, Vector2, Vector3};
use values::Point;

use crate::{Base, GRAVITY, WorldError, scene::LOAD_IMPEDANCE};

/// The pair of table and object, and that of tip and object, in the order that MuJoCo sorts them: by body.
const LOAD: usize = 0;
const STRIKE: usize = 1;
/// The object among the bodies.
const OBJECT: usize = 1;
/// Least friction that MuJoCo accepts.
const LEAST_FRICTION: f64 = 1e-5;

/// MuJoCo prints its warnings and appends them to a file in the current folder; a state that is not finite is reported by
/// [`crate::WorldError::Diverged`] instead.
fn keep_quiet() {
    static ONCE: Once = Once::new();
    // SAFETY: the first scene is compiled here, before any other use of MuJoCo; others wait for it.
    ONCE.call_once(|| unsafe {
        set_log_config(
            log_config()
                .with_logto_console(false)
                .with_logto_file(false),
        )
    });
}

/// A compiled scene; shared between threads.
pub(crate) struct Scene(MjModel);

impl Scene {
    /// Compiles MJCF text, and sets the spring of the foot so that it carries `weight` (N).
    pub(crate) fn compile(mjcf: &str, weight: f64) -> Result<Self, WorldError> {
        keep_quiet();
        let mut model = MjModel::from_xml_string(mjcf)
            .map_err(|error| WorldError::Compile(error.to_string()))?;
        let mut data = MjData::new(Box::new(model.clone()));
        // Tip and object must not touch while the load is measured.
        data.qpos_mut()
            .iter_mut()
            .rev()
            .take(2)
            .for_each(|q| *q = -10.0);
        data.forward();
        let load: f64 = (0..data.contact().len())
            .map(|contact| data.contact_force(contact)[0])
            .sum();
        if !(load > 0.0 && load.is_finite()) {
            return Err(WorldError::Compile(format!(
                "the foot carries {load} N in place of {weight} N"
            )));
        }
        model.pair_solref_mut()[LOAD][0] *= weight / load;
        Ok(Self(model))
    }

    /// A worker's own copy of model and data.
    pub(crate) fn engine(&self, table_contact: TableContact) -> Engine {
        let mut data = MjData::new(Box::new(self.0.clone()));
        if matches!(table_contact, TableContact::Ball(..)) {
            // Rolling friction acts beside the contact: `Engine::resist_half`.
            // SAFETY: MuJoCo reads a pair's dimensions when it finds the contact, and makes room for it in each step.
            unsafe { data.model_mut().pair_dim_mut()[LOAD] = 4 };
        }
        Engine {
            nv_object: data.model().nv() as usize - 2,
            base_friction: self.0.pair_friction()[LOAD],
            table_contact,
            friction: 1.0,
            pushed: Point::default(),
            steps: [0; 2],
            data,
        }
    }

    /// The model in MuJoCo's binary format.
    pub(crate) fn to_mjb(&self) -> Vec<u8> {
        let mut bytes = vec![0; self.0.size()];
        self.0
            .save_to_buffer(&mut bytes)
            .expect("the buffer has the model's size");
        bytes
    }
}

/// Model and data of one worker.
pub(crate) struct Engine {
    data: MjData<Box<MjModel>>,
    nv_object: usize,
    base_friction: [f64; 5],
    table_contact: TableContact,
    /// Factor on the friction on the table in the next steps.
    friction: f64,
    /// Acceleration by which the next steps push the object's centre, in m/s².
    pushed: Point,
    /// Number of steps taken: all, and those of free slides.
    steps: [u64; 2],
}

/// How the object touches the table.
#[derive(Clone, Copy, Debug)]
pub(crate) enum TableContact {
    /// A base, and the square of the radius of gyration in m².
    Flat(Base, f64),
    /// A ball's lowest point: its radius in m, and how much of rolling friction acts while it slips.
    Ball(f64, f64),
}

/// Share of what friction stops of a ball's slip in a step over which rolling friction comes in: what rolls slips by some of it, too.
const SLIPS: f64 = 0.3;
/// How far, relative to dry friction's deceleration, MuJoCo's friction reference lies beyond the cone.
const BEYOND_CONE: f64 = 1.5;

impl Engine {
    /// Resets to the scene's initial state, all at rest.
    pub(crate) fn reset(&mut self) {
        self.data.reset();
    }

    /// Steps taken since it was made: while tip and object are close, and while the object slides alone.
    pub(crate) fn steps(&self) -> [u64; 2] {
        let [all, slides] = self.steps;
        [all - slides, slides]
    }

    /// Length of the next steps, in s.
    pub(crate) fn set_timestep(&mut self, timestep: f64) {
        self.data.model_opt_mut().timestep = timestep;
    }

    /// Spring and damper between tip and object.
    pub(crate) fn set_strike_solref(&mut self, solref: [f64; 2]) {
        // SAFETY: only values of an existing pair change; no size, address or index does.
        let model = unsafe { self.data.model_mut() };
        model.pair_solref_mut()[STRIKE] = solref;
    }

    /// Spring and damper between tip and object, per unit mass (1/s², 1/s).
    pub(crate) fn strike_solref(&self) -> [f64; 2] {
        self.data.model().pair_solref()[STRIKE].map(|direct| -direct)
    }

    /// Rate in 1/s at which friction pulls the tip's slip on the object towards zero.
    pub(crate) fn set_grip(&mut self, rate: f64) {
        // SAFETY: as above.
        let model = unsafe { self.data.model_mut() };
        // MuJoCo divides a direct damping by the greatest impedance.
        let impedance = model.pair_solimp()[STRIKE][1];
        model.pair_solreffriction_mut()[STRIKE] = [-1.0, -rate * impedance];
    }

    /// Scales the friction between object and table in the next steps.
    pub(crate) fn scale_friction(&mut self, factor: f64) {
        self.friction = factor;
    }

    /// Places the object, turned by `yaw` (rad); a ball has none.
    pub(crate) fn place_object(&mut self, position: Point, yaw: f64) {
        let has_yaw = self.nv_object == 3;
        let qpos = self.data.qpos_mut();
        qpos[0] = position.x;
        qpos[1] = position.y;
        if has_yaw {
            qpos[2] = yaw;
        }
    }

    /// Moves the object by this (m), and adds this to its velocity (m/s).
    pub(crate) fn carry(&mut self, by: Point, velocity: Point) {
        let qpos = self.data.qpos_mut();
        qpos[0] += by.x;
        qpos[1] += by.y;
        let qvel = self.data.qvel_mut();
        qvel[0] += velocity.x;
        qvel[1] += velocity.y;
    }

    /// Prescribes the striker's position (m) and velocity (m/s).
    pub(crate) fn drive_striker(&mut self, position: Point, velocity: Point) {
        let nv = self.nv_object;
        let nq = self.data.qpos().len() - 2;
        let qpos = self.data.qpos_mut();
        qpos[nq] = position.x;
        qpos[nq + 1] = position.y;
        let qvel = self.data.qvel_mut();
        qvel[nv] = velocity.x;
        qvel[nv + 1] = velocity.y;
    }

    /// Position of the object in m.
    pub(crate) fn position(&self) -> Point {
        let qpos = self.data.qpos();
        Point::new(qpos[0], qpos[1])
    }

    /// Velocity of the object in m/s.
    pub(crate) fn velocity(&self) -> Point {
        let qvel = self.data.qvel();
        Point::new(qvel[0], qvel[1])
    }

    /// Angle in rad by which a cylinder or a box has turned.
    pub(crate) fn yaw(&self) -> f64 {
        if self.nv_object == 5 {
            0.0
        } else {
            self.data.qpos()[2]
        }
    }

    /// Rate at which the object turns about the vertical, in rad/s; of a ball, 0.
    pub(crate) fn spin(&self) -> f64 {
        match self.nv_object {
            3 => self.data.qvel()[2],
            _ => 0.0,
        }
    }

    /// Force on the object's centre per unit mass in the next steps, in m/s².
    pub(crate) fn push(&mut self, acceleration: Point) {
        self.pushed = acceleration;
    }

    /// Half of what the push adds to the velocity in a step: before and after it, which is exact to second order.
    /// Friction must not see the push as a force: MuJoCo's acts against the acceleration that it finds, not along the
    /// slip, and would take two thirds of a push across the motion away.
    fn push_half(&mut self) {
        let half = self.pushed * (0.5 * self.data.model_opt().timestep);
        let qvel = self.data.qvel_mut();
        qvel[0] += half.x;
        qvel[1] += half.y;
    }

    /// Whether tip and object touched in the last step. The tip is the scene's last geom.
    pub(crate) fn tip_touches(&self) -> bool {
        let tip = self.data.model().ngeom() as i32 - 1;
        self.data
            .contact()
            .iter()
            .any(|contact| contact.geom.contains(&tip))
    }

    /// A ball's rate of turning about x and y in rad/s, and the slip of its lowest point in m/s: by what it does not roll.
    fn ball_motion(&self, radius: f64) -> (Vector2<f64>, f64) {
        let (velocity, turning) = (self.velocity(), self.attitude() * self.turning());
        let slip = Point::new(
            velocity.x - turning.y * radius,
            velocity.y + turning.x * radius,
        );
        (turning.xy(), slip.norm())
    }

    /// Attitude of a ball.
    fn attitude(&self) -> UnitQuaternion<f64> {
        let qpos = self.data.qpos();
        UnitQuaternion::new_unchecked(Quaternion::new(qpos[2], qpos[3], qpos[4], qpos[5]))
    }

    /// A ball's rate of turning in rad/s; MuJoCo gives it in the ball's own frame.
    fn turning(&self) -> Vector3<f64> {
        Vector3::from_column_slice(&self.data.qvel()[2..5])
    }

    /// Half of what rolling friction takes from a ball's turning in a step: a torque of the load times its length. It is no part of the
    /// contact's cone, in which it would weaken the friction of a ball that slips. A ball slips where friction could not stop that in a step.
    fn resist_half(&mut self) {
        let TableContact::Ball(radius, in_slip) = self.table_contact else {
            return;
        };
        let timestep = self.data.model_opt().timestep;
        let model = self.data.model();
        let gyration = model.body_inertia()[OBJECT][0] / model.body_mass()[OBJECT];
        let [slide, _, _, length, _] = self.base_friction.map(|mu| mu * self.friction * GRAVITY);
        let (turning, slip) = self.ball_motion(radius);
        let stopped = slide * (1.0 + radius * radius / gyration) * timestep;
        let rolls = ((1.0 - slip / stopped.max(1e-12)) / SLIPS).clamp(0.0, 1.0);
        let taken = length / gyration * (rolls + (1.0 - rolls) * in_slip) * 0.5 * timestep;
        let change = turning * (-(taken / turning.norm().max(1e-12)).min(1.0));
        let own = self.attitude().inverse_transform_vector(&change.push(0.0));
        for (rate, change) in self.data.qvel_mut()[2..5].iter_mut().zip(own.iter()) {
            *rate += change;
        }
    }

    /// MuJoCo's soft friction pulls what slides towards rest at a rate b, and its convex cone loads a contact in
    /// proportion to how far that pull lies beyond the cone: at a fixed b friction would grow with speed. So b follows
    /// the slip, and the pull is always the same little beyond the cone. The cone's semi-axes follow it too: so that its
    /// friction, which is along the pull less what it brakes, is the base's.
    fn follow_slip(&mut self) {
        let weight = (self.friction * self.base_friction[0]).max(LEAST_FRICTION) * GRAVITY;
        let fastest = 0.9 / self.data.model_opt().timestep;
        let rate = |slip: f64| (BEYOND_CONE * weight / slip.max(1e-9)).min(fastest);
        let (rate, axes) = match self.table_contact {
            // Friction at a ball's lowest point turns it too, and stops that seven halves as fast as it would a block.
            TableContact::Ball(radius, _) => (rate(self.ball_motion(radius).1 / 3.5), [1.0; 2]),
            TableContact::Flat(base, gyration) => {
                let (v, w) = (self.velocity().norm().max(1e-9), base.arm * self.spin());
                let rate = rate(v.hypot(w));
                let [pull, turning] = base.pull(v * v, w * w);
                let left = |braked: f64| (rate - weight * braked).max(0.1 * rate);
                let share = left(turning * base.arm * base.arm / gyration) / left(pull);
                let (along, around) = (pull * v * v, turning * w * w);
                let axes = [
                    pull * (along + around * share),
                    turning * (along / share + around),
                ];
                (rate, axes.map(f64::sqrt))
            }
        };
        let [slide, _, turn, ..] = self.base_friction.map(|mu| mu * self.friction);
        let friction = [slide * axes[0], slide * axes[0], turn * axes[1], 0.0, 0.0];
        // SAFETY: as above.
        let model = unsafe { self.data.model_mut() };
        model.pair_friction_mut()[LOAD] = friction.map(|mu| mu.max(LEAST_FRICTION));
        // MuJoCo divides a direct damping by the impedance.
        model.pair_solreffriction_mut()[LOAD] = [-1.0, -rate * LOAD_IMPEDANCE];
    }

    /// One step of MuJoCo's: semi-implicit, which keeps the energy of a stiff contact.
    pub(crate) fn step(&mut self) {
        self.push_half();
        self.resist_half();
        self.follow_slip();
        self.data.step();
        self.resist_half();
        self.push_half();
        self.steps[0] += 1;
    }

    /// One step of a free slide: the position moves by the mean of old and new velocity, which is exact under constant
    /// deceleration where the semi-implicit step is off by half a step's length.
    pub(crate) fn slide(&mut self) {
        let before = self.velocity();
        self.step();
        self.steps[1] += 1;
        let timestep = self.data.model_opt().timestep;
        // The step moved by the velocity that it had before the second half of the push.
        let gained = self.velocity() - before - self.pushed * timestep;
        let qpos = self.data.qpos_mut();
        qpos[0] -= gained.x * 0.5 * timestep;
        qpos[1] -= gained.y * 0.5 * timestep;
    }
}

/// Version of the MuJoCo library that is loaded, such as `3.17.0`.
pub fn mujoco_version() -> String {
    mujoco_rs::mujoco_version().to_string()
}

#[cfg(test)]
mod tests {
    use values::{Rig, Shape};

    use super::*;
    use crate::{World, scene::mjcf};

    #[test]
    fn a_model_loads_from_its_binary_as_it_was_compiled() {
        let rig = Rig::demo(Shape::Cylinder);
        let world = World::nominal().with("friction", 0.21);
        let scene = Scene::compile(&mjcf(&rig, &world).expect("valid"), 1.0).expect("compiles");
        let loaded = MjModel::from_buffer(&scene.to_mjb()).expect("loads");
        assert_eq!(loaded.pair_friction(), scene.0.pair_friction());
        assert_eq!(loaded.pair_solref(), scene.0.pair_solref());
    }
}
