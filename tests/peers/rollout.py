"""`mujoco.rollout` of carom's own compiled model: as many fine steps from touch and as many steps of slide as carom's strikes take."""

import argparse
import json
import pathlib
import time

import mujoco
import numpy as np
from mujoco import rollout

from striking import load


def main():
    parser = argparse.ArgumentParser()
    parser.add_argument("folder")
    parser.add_argument("seconds", type=float)
    parser.add_argument("threads", type=int)
    parser.add_argument("fine", type=int)
    parser.add_argument("slides", type=int)
    args = parser.parse_args()
    shared = load(args.folder)
    model = mujoco.MjModel.from_binary_path(str(pathlib.Path(args.folder) / "model.mjb"))
    # What carom's strike sets in the model; its friction follows the slip, here it is that of half a metre a second.
    model.pair_solref[1] = shared["solref"]
    rate = 1.5 * shared["parameters"]["friction"] * 9.81 / 0.5
    model.pair_solreffriction[0] = [-1.0, -rate * model.pair_solimp[0, 0]]
    reach = shared["rig"]["object"]["radius"] + shared["rig"]["striker"]["radius"]
    data = mujoco.MjData(model)
    state = np.empty(mujoco.mj_stateSize(model, mujoco.mjtState.mjSTATE_FULLPHYSICS.value))
    touching = []
    for strike in shared["strikes"]:
        speed, angle = strike["command"]["speed"], strike["command"]["angle"]
        along = np.array([np.cos(angle), np.sin(angle)])
        mujoco.mj_resetData(model, data)
        data.qpos[:2] = strike["initial"]
        data.qpos[-2:] = strike["initial"] - along * (reach - 0.5 * shared["steps"][0] * speed)
        data.qvel[-2:] = along * speed
        mujoco.mj_getState(model, data, state, mujoco.mjtState.mjSTATE_FULLPHYSICS.value)
        touching.append(state.copy())
    touching = np.array(touching)
    datas = [mujoco.MjData(model) for _ in range(args.threads)]
    first_tip, first_speed = 1 + model.nq - 2, 1 + model.nq + model.nv - 2
    fine_out, slide_out = [np.empty((len(touching), steps, state.size)) for steps in (args.fine, args.slides)]
    rounds, begun = 0, time.perf_counter()
    with rollout.Rollout(nthread=args.threads if args.threads > 1 else 0) as pool:
        while time.perf_counter() < begun + args.seconds:
            model.opt.timestep = shared["steps"][0]
            pool.rollout(model, datas, touching, nstep=args.fine, state=fine_out)
            parted = fine_out[:, -1].copy()
            parted[:, first_tip : first_tip + 2] = [-10.0, 0.0]
            parted[:, first_speed : first_speed + 2] = 0.0
            model.opt.timestep = shared["steps"][1]
            pool.rollout(model, datas, parted, nstep=args.slides, state=slide_out)
            rounds += 1
    seconds = time.perf_counter() - begun
    slid = np.linalg.norm(slide_out[:, -1, 1:3] - touching[:, 1:3], axis=1)
    print(
        json.dumps(
            dict(
                seconds=seconds,
                strikes_per_second=rounds * len(touching) / seconds,
                step_ns=seconds * 1e9 / (rounds * len(touching) * (args.fine + args.slides)),
                mean_path=float(slid.mean()),
            )
        )
    )


if __name__ == "__main__":
    main()
