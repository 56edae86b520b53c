//! The scene as MJCF text: a table, an object on its foot, a striker's tip.
//!
//! The object slides on planar joints and one foot, so it neither rocks nor hops: MuJoCo's convex cone would lift a
//! contact during the impact, and an object on a free joint flies a little. The foot is sunk into the table by a fixed
//! depth, and its spring is set once so that it carries just the weight. Its friction in x, y and turning forms an
//! ellipsoid: the limit surface of planar sliding (Howe and Cutkosky 1996). A ball may turn freely.
//! The cone is elliptic (MuJoCo's default pyramid is anisotropic), every contact an explicit pair (no mixing by maximum).

use values::{Object, Rig, Shape, Solid, Tip};

use crate::{Base, GRAVITY, World, WorldError};

/// Mass of the striker in kg: its motion is prescribed, so any mass far above the object's does.
const STRIKER_MASS: f64 = 1000.0;
/// Least friction that MuJoCo accepts.
const LEAST_FRICTION: f64 = 1e-5;
/// Radius of the foot in m.
const FOOT: f64 = 0.002;
/// Depth in m to which the object's foot reaches into the table: with [`LOAD_IMPEDANCE`] it stands for the weight.
const SINK: f64 = 0.001;
/// Depth in m to which a ball's foot reaches into the table: smaller, for the ball rolls on what is left of its radius.
const BALL_SINK: f64 = 1e-5;
/// Impedance of the contacts with the table: so soft that the slip does not change the load.
pub(crate) const LOAD_IMPEDANCE: f64 = 0.001;
/// How much harder than the load friction is held, so that the object stops within a step.
const IMPEDANCE_RATIO: f64 = 1e4;
/// Density in kg/m³ of air at 20 °C. It has no viscosity: MuJoCo's drag by that is Stokes', of creeping flow, 7e-4/s for a puck of 12 g, which
/// planar form does not have.
const AIR: f64 = 1.2;

/// Moments of inertia of the uniform shape, in kg·m².
fn inertia(object: &Object) -> [f64; 3] {
    let m = object.mass;
    match object.solid {
        Solid::Cylinder {
            radius: r,
            half_height,
        } => {
            let h = 2.0 * half_height;
            let side = m * (3.0 * r * r + h * h) / 12.0;
            [side, side, 0.5 * m * r * r]
        }
        Solid::Box {
            half_size: [x, y, z],
        } => [
            m * (y * y + z * z) / 3.0,
            m * (x * x + z * z) / 3.0,
            m * (x * x + y * y) / 3.0,
        ],
        Solid::Sphere { radius } => [0.4 * m * radius.powi(2); 3],
    }
}

fn body_geom(object: &Object) -> String {
    match object.solid {
        Solid::Cylinder {
            radius,
            half_height,
        } => format!(r#"type="cylinder" size="{radius} {half_height}""#),
        Solid::Box {
            half_size: [x, y, z],
        } => format!(r#"type="box" size="{x} {y} {z}""#),
        Solid::Sphere { radius } => format!(r#"type="sphere" size="{radius}""#),
    }
}

/// The MJCF text of a rig in a world, for MuJoCo and its viewer. Tip and object have no spring and damper yet, nor do effects act in it: a
/// strike sets both ([`crate::Worker::strike`]).
///
/// # Errors
/// A parameter that the world should hold and does not.
pub fn mjcf(rig: &Rig, world: &World) -> Result<String, WorldError> {
    let value = |name: &str| world.value(name);
    let height = rig.object.solid.half_height();
    let [ix, iy, iz] = inertia(&rig.object);
    let (ix, iy, iz) = (
        ix * value("inertia_x")?,
        iy * value("inertia_y")?,
        iz * value("inertia_z")?,
    );
    // MuJoCo wants each moment at most the sum of the others; scaled ones need not be those of a rigid body.
    let joints = if rig.object.shape() == Shape::Sphere {
        r#"<joint name="turn" type="ball"/>"#
    } else {
        r#"<joint name="turn" type="hinge" axis="0 0 1"/>"#
    };
    let dmin = value("solimp_dmin")?;
    let solimp = format!(
        "{dmin} {} {} {} {}",
        value("solimp_dmax")?.max(dmin),
        value("solimp_width")?,
        value("solimp_midpoint")?,
        value("solimp_power")?
    );
    let (slide, rolling) = (value("friction")?, value("rolling_friction")?);
    let torsion = (slide * Base::new(rig, world)?.arm).max(LEAST_FRICTION);
    let (foot, condim, foot_radius) = match rig.object.shape() {
        Shape::Sphere => ("object", 6, 0.0),
        Shape::Cylinder | Shape::Box => ("foot", 4, FOOT),
    };
    let foot_height = foot_radius - SINK - height;
    let rolling = rolling.max(LEAST_FRICTION);
    let tip = match rig.striker.tip {
        Tip::Sphere => format!(r#"type="sphere" size="{}""#, rig.striker.radius),
        Tip::Cylinder => format!(r#"type="capsule" size="{} {}""#, rig.striker.radius, height),
    };
    let fluid = format!(
        "{} {} {} {} {}",
        value("fluid_blunt_drag")?,
        value("fluid_slender_drag")?,
        value("fluid_angular_drag")?,
        value("fluid_kutta_lift")?,
        value("fluid_magnus_lift")?
    );
    let tip_friction = value("tip_friction")?;
    Ok(format!(
        r#"<mujoco>
  <compiler boundmass="0" boundinertia="0" balanceinertia="true"/>
  <option gravity="0 0 -{GRAVITY}" cone="elliptic" solver="Newton" iterations="50" tolerance="1e-10" impratio="{IMPEDANCE_RATIO}" integrator="Euler" density="{AIR}">
    <flag autoreset="disable" eulerdamp="disable" energy="disable" island="disable"/>
  </option>
  <default><geom contype="0" conaffinity="0" mass="0"/></default>
  <worldbody>
    <geom name="table" type="plane" size="0 0 1"/>
    <body name="object" pos="0 0 {object_height}">
      <inertial pos="0 0 0" mass="{mass}" diaginertia="{ix} {iy} {iz}"/>
      <joint name="object_x" type="slide" axis="1 0 0"/>
      <joint name="object_y" type="slide" axis="0 1 0"/>
      {joints}
      <geom name="object" {body} fluidshape="ellipsoid" fluidcoef="{fluid}"/>
      <geom name="foot" type="sphere" size="{FOOT}" pos="0 0 {foot_height}"/>
    </body>
    <body name="striker" pos="0 0 {height}" gravcomp="1">
      <inertial pos="0 0 0" mass="{STRIKER_MASS}" diaginertia="1 1 1"/>
      <joint name="striker_x" type="slide" axis="1 0 0"/>
      <joint name="striker_y" type="slide" axis="0 1 0"/>
      <geom name="tip" {tip}/>
    </body>
  </worldbody>
  <contact>
    <pair geom1="table" geom2="{foot}" condim="{condim}" friction="{slide} {slide} {torsion} {rolling} {rolling}" solref="-1e6 -1" solimp="{LOAD_IMPEDANCE} {LOAD_IMPEDANCE}"/>
    <pair geom1="tip" geom2="object" condim="3" friction="{tip_friction} {tip_friction} 0 0 0" solref="-1000 -1" solimp="{solimp}"/>
  </contact>
</mujoco>"#,
        // A ball is its own foot.
        object_height = if rig.object.shape() == Shape::Sphere {
            height - BALL_SINK
        } else {
            height
        },
        mass = rig.object.mass,
        body = body_geom(&rig.object),
    ))
}
