//! The one place that reaches into MuJoCo's memory: a model and its data, owned by one worker.
#![expect(unsafe_code, reason = "a compiled model's contact parameters are changed in place, never recompiled a step")]

use mujoco_rs::prelude::{MjData, MjModel};
use values::Point;

use crate::WorldError;

/// Number of the striker's pair: the last of the scene.
fn striker_pair(model: &MjModel) -> usize {
    model.pair_solref().len() - 1
}

/// A compiled scene; shared between threads.
pub(crate) struct Scene(MjModel);

impl Scene {
    /// Compiles MJCF text.
    pub(crate) fn compile(mjcf: &str) -> Result<Self, WorldError> {
        MjModel::from_xml_string(mjcf).map(Self).map_err(|error| WorldError::Compile(error.to_string()))
    }

    /// A worker's own copy of model and data.
    pub(crate) fn engine(&self) -> Engine {
        let data = MjData::new(Box::new(self.0.clone()));
        Engine { nv_object: data.model().nv() as usize - 2, base_friction: self.0.pair_friction().to_vec(), data }
    }
}

/// Model and data of one worker.
pub(crate) struct Engine {
    data: MjData<Box<MjModel>>,
    nv_object: usize,
    base_friction: Vec<[f64; 5]>,
}

impl Engine {
    /// Back to the scene's initial state, all at rest.
    pub(crate) fn reset(&mut self) {
        self.data.reset();
    }

    /// Length of the next steps, in s.
    pub(crate) fn set_timestep(&mut self, timestep: f64) {
        self.data.model_opt_mut().timestep = timestep;
    }

    /// Spring and damper between tip and object.
    pub(crate) fn set_strike_solref(&mut self, solref: [f64; 2]) {
        // SAFETY: only values of an existing pair change; no size, address or index does.
        let model = unsafe { self.data.model_mut() };
        let pair = striker_pair(model);
        model.pair_solref_mut()[pair] = solref;
    }

    /// Scales the friction between object and table.
    pub(crate) fn scale_friction(&mut self, factor: f64) {
        // SAFETY: as above.
        let model = unsafe { self.data.model_mut() };
        let pairs = striker_pair(model);
        for (friction, base) in model.pair_friction_mut()[..pairs].iter_mut().zip(&self.base_friction) {
            // MuJoCo wants friction above zero.
            friction[0] = (base[0] * factor).max(1e-5);
            friction[1] = friction[0];
        }
    }

    /// Places the object, keeping its height.
    pub(crate) fn place_object(&mut self, position: Point) {
        let qpos = self.data.qpos_mut();
        qpos[0] = position.x;
        qpos[1] = position.y;
    }

    /// Height of the object above its initial one, in m.
    pub(crate) fn height(&self) -> f64 {
        self.data.qpos()[2]
    }

    /// Sets the height of the object above its initial one, in m.
    pub(crate) fn set_height(&mut self, height: f64) {
        self.data.qpos_mut()[2] = height;
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

    /// Rate of turning about the vertical, in rad/s.
    pub(crate) fn spin(&self) -> f64 {
        self.data.qvel()[self.nv_object - 1]
    }

    /// Force on the object's centre, in N.
    pub(crate) fn push(&mut self, force: Point) {
        let applied = self.data.qfrc_applied_mut();
        applied[0] = force.x;
        applied[1] = force.y;
    }

    /// Whether tip and object touched in the last step. The tip is the scene's last geom.
    pub(crate) fn tip_touches(&self) -> bool {
        let tip = self.data.model().ngeom() as i32 - 1;
        self.data.contact().iter().any(|contact| contact.geom.contains(&tip))
    }

    /// One step; the object's planar position moves by the mean of old and new velocity, which is exact under
    /// constant deceleration where MuJoCo's semi-implicit Euler step is off by half a step's length.
    pub(crate) fn step(&mut self) {
        let timestep = self.data.model_opt().timestep;
        let before = self.velocity();
        self.data.step();
        let gained = (self.velocity() - before) * (0.5 * timestep);
        let qpos = self.data.qpos_mut();
        qpos[0] -= gained.x;
        qpos[1] -= gained.y;
    }
}

/// Version of the MuJoCo library that is loaded, such as `3.17.0`.
pub fn mujoco_version() -> String {
    mujoco_rs::mujoco_version().to_string()
}
