"""A strike in MuJoCo as a Python user would write it, tuned: what the peers simulate with.

An object on planar joints and four feet slides on a table with an elliptic cone, struck by a heavy tip that motors drive along
the trapezoid of the paper's section 3.1. Every number of the scene can be set in the compiled model. SI units.
"""

import json
import math
import pathlib

import mujoco
import numpy as np

TIP_MASS = 1000.0
SCENE = """<mujoco>
  <option cone="elliptic" timestep="{timestep}" density="1.2" viscosity="1.8e-5"/>
  <default><geom contype="0" conaffinity="0"/></default>
  <worldbody>
    <geom name="table" type="plane" size="0 0 1"/>
    <body name="object" pos="0 0 {half_height}">
      <joint name="object_x" type="slide" axis="1 0 0"/>
      <joint name="object_y" type="slide" axis="0 1 0"/>
      <joint name="object_z" type="slide" axis="0 0 1"/>
      <joint name="object_turn" type="hinge" axis="0 0 1"/>
      <geom name="object" type="cylinder" size="{radius} {half_height}" mass="{mass}" fluidshape="ellipsoid"/>
      <geom name="foot0" type="sphere" size="0.002" pos="{foot} 0 {foot_height}" mass="0"/>
      <geom name="foot1" type="sphere" size="0.002" pos="-{foot} 0 {foot_height}" mass="0"/>
      <geom name="foot2" type="sphere" size="0.002" pos="0 {foot} {foot_height}" mass="0"/>
      <geom name="foot3" type="sphere" size="0.002" pos="0 -{foot} {foot_height}" mass="0"/>
    </body>
    <body name="tip" pos="0 0 {half_height}" gravcomp="1">
      <joint name="tip_x" type="slide" axis="1 0 0"/>
      <joint name="tip_y" type="slide" axis="0 1 0"/>
      <geom name="tip" type="sphere" size="{tip_radius}" mass="1000"/>
    </body>
  </worldbody>
  <contact>
    <pair geom1="table" geom2="foot0" friction="{friction} {friction}"/>
    <pair geom1="table" geom2="foot1" friction="{friction} {friction}"/>
    <pair geom1="table" geom2="foot2" friction="{friction} {friction}"/>
    <pair geom1="table" geom2="foot3" friction="{friction} {friction}"/>
    <pair name="strike" geom1="tip" geom2="object" friction="{tip_friction} {tip_friction}" solref="{stiffness} {damping}" solimp="0.99 0.99 0.001 0.5 2"/>
  </contact>
  <actuator><motor joint="tip_x"/><motor joint="tip_y"/></actuator>
  <sensor><jointpos name="x" joint="object_x"/><jointpos name="y" joint="object_y"/></sensor>
</mujoco>"""


def load(folder):
    """What `bench prepare` wrote: rig, parameters of carom's identified world, strikes, residuals."""
    return json.loads((pathlib.Path(folder) / "input.json").read_text())


def scene(shared, timestep, contact):
    """The MJCF of carom's rig and world in this file's terms."""
    thing, world = shared["rig"]["object"], shared["parameters"]
    longer = contact / world["contact_time"]
    stiffness, damping = shared["solref"][0] / longer**2, shared["solref"][1] / longer
    return SCENE.format(
        timestep=timestep,
        radius=thing["radius"],
        half_height=thing["half_height"],
        mass=thing["mass"],
        # Friction at two thirds of the radius resists turning as that of an even pressure on the base.
        foot=thing["radius"] * 2 / 3,
        foot_height=0.002 - thing["half_height"],
        tip_radius=shared["rig"]["striker"]["radius"],
        friction=world["friction"],
        tip_friction=world["tip_friction"],
        stiffness=stiffness,
        damping=damping,
    )


class Striker:
    """One model and its data. `steps`: (contact, slide) in s; a strike then starts with the tip touching the object.
    With one number the whole motion is simulated from the arm's start in steps of that length, as the paper reads."""

    EVERY = 10  # Steps between two looks at whether the object rests.

    def __init__(self, shared, steps, contact=None):
        self.steps = steps if isinstance(steps, tuple) else (steps, steps)
        self.whole = not isinstance(steps, tuple)
        # Through fewer than some 22 steps a contact gains energy.
        self.contact = max(contact or shared["parameters"]["contact_time"], 22 * self.steps[0])
        self.model = mujoco.MjModel.from_xml_string(scene(shared, self.steps[0], self.contact))
        self.data = mujoco.MjData(self.model)
        self.acceleration = shared["rig"]["robot"]["acceleration"]
        self.reach = shared["rig"]["object"]["radius"] + shared["rig"]["striker"]["radius"]
        self.simulations = 0

    def start(self, initial, speed, angle, back=0.0):
        """At rest before the impact, the tip `back` metres from touching and, unless it has a way to go, as fast as it strikes."""
        along = np.array([math.cos(angle), math.sin(angle)])
        mujoco.mj_resetData(self.model, self.data)
        self.data.qpos[:2] = initial
        # Half a step deep, so that rounding does not decide when the contact begins.
        self.data.qpos[4:] = initial - along * (self.reach + (back or -0.5 * speed * self.steps[0]))
        self.data.qvel[4:] = along * speed if back == 0.0 else 0.0
        return along

    def advance(self, seconds, force):
        self.data.ctrl[:] = force
        mujoco.mj_step(self.model, self.data, max(1, round(seconds / self.model.opt.timestep)))

    def strike(self, initial, speed, angle):
        """Where the object stops."""
        self.simulations += 1
        self.model.opt.timestep = self.steps[0]
        brake = speed / self.acceleration
        force = TIP_MASS * self.acceleration
        if self.whole:
            along = self.start(initial, speed, angle, 0.5 * speed * brake + 0.010)
            self.advance(brake, force * along)
            self.advance(0.010 / speed, 0.0)
        else:
            along = self.start(initial, speed, angle)
        self.advance(2 * self.contact, 0.0)
        self.model.opt.timestep = self.steps[1]
        self.advance(brake, -force * along)
        self.data.qvel[4:] = 0.0
        self.data.ctrl[:] = 0.0
        velocity = self.data.qvel[:2]
        while velocity[0] ** 2 + velocity[1] ** 2 > 1e-6 and self.data.time < 20.0:
            mujoco.mj_step(self.model, self.data, self.EVERY)
        return self.data.qpos[:2].copy()


def roughness(shared, steps, contact=None, strikes=8):
    """By how much stops scatter about a smooth function of the speed, in m: where the impact falls between two steps shows."""
    scatter = []
    for strike in shared["strikes"][:strikes]:
        speeds = strike["command"]["speed"] * np.linspace(0.98, 1.02, 21)
        striker = Striker(shared, steps, contact)
        ranges = [
            np.linalg.norm(striker.strike(strike["initial"], speed, strike["command"]["angle"]) - strike["initial"])
            for speed in speeds
        ]
        left = ranges - np.polyval(np.polyfit(speeds, ranges, 2), speeds)
        scatter.append(np.std(left))
    return float(np.sqrt(np.mean(np.square(scatter))))
