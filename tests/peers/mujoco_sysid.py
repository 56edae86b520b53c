"""`mujoco.sysid` on the strikes that carom identifies from: friction, spring and damper of the impact, from whole tracks."""

import argparse
import json
import logging
import time

import mujoco
import numpy as np
from mujoco import sysid

from striking import Striker, load, scene

CONTACT, STEP = 0.011, 5e-4  # A rollout has one step length; the contact is made as long as it needs (see striking.py).


def main():
    parser = argparse.ArgumentParser()
    parser.add_argument("folder")
    parser.add_argument("strikes", type=int)
    parser.add_argument("--eps", type=float, help="step of the finite differences in place of the default")
    args = parser.parse_args()
    logging.disable(logging.WARNING)
    shared = load(args.folder)
    shared["parameters"]["friction"] = 0.30  # Carom's nominal value: where both begin.
    chosen = [strike for strike in shared["strikes"] if strike["split"] == "train"][: args.strikes]

    striker = Striker(shared, (STEP, STEP), CONTACT)
    spec = mujoco.MjSpec.from_string(scene(shared, STEP, CONTACT))
    states, controls, tracks = [], [], []
    for strike in chosen:
        speed = strike["command"]["speed"]
        along = striker.start(np.array(strike["initial"]), speed, strike["command"]["angle"])
        states.append(sysid.create_initial_state(striker.model, striker.data.qpos, striker.data.qvel))
        track = np.array([strike["track"][key] for key in "txy"]).T
        # A track begins with the first frame that has moved, the rollout with the touch: the early frames' line gives the time.
        early = np.linalg.norm(track[:4, 1:] - strike["initial"], axis=1)
        track[:, 0] += np.polyval(np.polyfit(early, track[:4, 0], 1), 0.0) * -1.0
        times = np.arange(0.0, track[-1, 0], STEP)
        braking = (times > 2 * CONTACT) & (times < 2 * CONTACT + speed / striker.acceleration)
        controls.append(sysid.TimeSeries(times, np.outer(braking, -1000.0 * striker.acceleration * along)))
        tracks.append(sysid.TimeSeries.from_names(track[:, 0], track[:, 1:], striker.model))
    sequences = sysid.ModelSequences("strikes", spec, [strike["id"] for strike in chosen], states, controls, tracks)

    stiffness, damping = striker.model.pair("strike").solref

    def slide(spec, parameter):
        for pair in spec.pairs:
            if pair.name != "strike":
                pair.friction[0:2] = parameter.value[0]

    def spring(spec, parameter):
        spec.pair("strike").solref[0] = stiffness * parameter.value[0]

    def damper(spec, parameter):
        spec.pair("strike").solref[1] = damping * parameter.value[0]

    parameters = sysid.ParameterDict()
    parameters.add(sysid.Parameter("friction", 0.30, 0.02, 1.0, modifier=slide))
    parameters.add(sysid.Parameter("spring", 1.0, 0.7, 1.5, modifier=spring))
    parameters.add(sysid.Parameter("damper", 1.0, 0.3, 2.5, modifier=damper))
    residual = sysid.build_residual_fn(models_sequences=[sequences])
    options = {} if args.eps is None else {"eps": args.eps}
    begun = time.perf_counter()
    fitted, result = sysid.optimize(parameters, residual, verbose=False, **options)
    seconds = time.perf_counter() - begun
    _, intervals = sysid.calculate_intervals(residual(result.x, fitted)[0], result.jac)
    print(
        json.dumps(
            dict(
                seconds=seconds,
                strikes=len(chosen),
                friction=float(fitted["friction"].value[0]),
                half_width=float(intervals[0]),
                spring=float(fitted["spring"].value[0]),
                damper=float(fitted["damper"].value[0]),
            )
        )
    )


if __name__ == "__main__":
    main()
