"""The paper's pipeline as its algorithms 1 and 2 and section 3.4.1 read: NLopt around MuJoCo, and a residual network in PyTorch."""

import argparse
import json
import time

import nlopt
import numpy as np

from striking import Striker, load, roughness

EPSILON = 1e-3  # Algorithm 1's threshold, in m.
RESTARTS = 5
EVALUATIONS = 1000  # Algorithm 2 has no end where hardware differs from simulation by more than its threshold.

# How the motion is stepped: lengths in s, and how long tip and object touch.
STEPS = {
    "default": dict(steps=2e-3, contact=0.04),  # The whole motion, in MuJoCo's default step.
    "written": dict(steps=2e-4, contact=0.04),  # The longest of 2, 1, 0.5, 0.2 ms with which stops scatter by less than 1 mm.
    "chosen": dict(steps=(1e-4, 8e-3)),  # From touch, finely through the contact, coarsely through the slide.
}
# The quickest of BOBYQA, COBYLA, Nelder-Mead and SBPLX, on the miss or its square.
ALGORITHM = {"default": (nlopt.LN_COBYLA, 1), "written": (nlopt.LN_BOBYQA, 2), "chosen": (nlopt.LN_BOBYQA, 2)}


def solve_one(striker, algorithm, initial, target, rng):
    """Algorithm 1: speed and angle from a random start, again from another where NLopt ends above the threshold."""

    algorithm, power = algorithm

    def miss(x, _gradient):
        return float(np.linalg.norm(striker.strike(initial, x[0], x[1]) - target)) ** power

    for _ in range(RESTARTS):
        optimizer = nlopt.opt(algorithm, 2)
        optimizer.set_lower_bounds([0.1, -1.5])
        optimizer.set_upper_bounds([2.0, 1.5])
        optimizer.set_initial_step([0.1, 0.2])
        optimizer.set_min_objective(miss)
        optimizer.set_stopval(EPSILON**power)
        optimizer.set_xtol_rel(1e-5)
        optimizer.set_maxeval(100)
        x = optimizer.optimize([rng.uniform(0.4, 1.0), rng.uniform(-0.8, 0.8)])
        value = optimizer.last_optimum_value() ** (1 / power)
        if value < EPSILON:
            break
    return x, value


def solve(shared, striker, variant, targets):
    rng, begun = np.random.default_rng(0), time.perf_counter()
    chosen = shared["strikes"][:targets]
    found = [
        solve_one(striker, ALGORITHM[variant], np.array(strike["initial"]), np.array(strike["stop"]), rng) for strike in chosen
    ]
    seconds = time.perf_counter() - begun
    solved = [value for _, value in found if value < EPSILON]
    return dict(
        seconds=seconds,
        targets=len(found),
        solved=len(solved),
        simulations=striker.simulations / len(found),
        miss=float(np.mean(solved)),
        commands=[list(x) for x, _ in found],
    )


def parameters(model):
    """What algorithm 2 frees: where it lies in the compiled model, and its bounds."""
    feet, strike, thing = slice(0, 4), model.pair("strike").id, model.geom("object").id
    body = model.body("object").id
    # One sliding coefficient for both directions, one torsional and one rolling.
    entries = [
        (model.pair_friction, (feet, slice(0, 2)), (0.02, 1.0)),
        (model.pair_friction, (feet, 2), (0.0, 0.02)),
        (model.pair_friction, (feet, slice(3, 5)), (0.0, 0.01)),
    ]
    stiffness, damping = model.pair_solref[strike]
    # Restitution is no parameter of MuJoCo: the damping of a direct solref is.
    entries += [
        (model.pair_solref, (strike, 0), (1.5 * stiffness, 0.7 * stiffness)),
        (model.pair_solref, (strike, 1), (2.5 * damping, 0.3 * damping)),
    ]
    bounds = [(0.5, 0.999), (0.5, 0.999), (1e-4, 1e-2), (0.1, 0.9), (1.0, 5.0)]
    entries += [(model.pair_solimp, (strike, i), bound) for i, bound in enumerate(bounds)]
    entries += [
        (model.geom_fluid, (thing, 1 + i), bound)
        for i, bound in enumerate([(0.0, 5.0), (0.0, 5.0), (0.0, 10.0), (0.0, 5.0), (0.0, 5.0)])
    ]
    entries += [
        (model.body_inertia, (body, i), (0.5 * model.body_inertia[body, i], 2.0 * model.body_inertia[body, i])) for i in range(3)
    ]
    return entries


def identify(shared, striker, strikes, evaluations):
    """Algorithm 2: all of the paper's parameters at once, from final positions."""
    entries = parameters(striker.model)
    low, high = np.array([bound for _, _, bound in entries]).T
    chosen = [strike for strike in shared["strikes"] if strike["split"] == "train"][:strikes]
    count = 0

    def put(x):
        for (array, place, _), value in zip(entries, x):
            array[place] = value

    def error(x, _gradient):
        nonlocal count
        count += 1
        put(low + x * (high - low))
        return sum(
            float(np.linalg.norm(striker.strike(np.array(s["initial"]), s["command"]["speed"], s["command"]["angle"]) - s["stop"]))
            for s in chosen
        )

    start = [float(np.clip((np.mean(array[place]) - l) / (h - l), 0.0, 1.0)) for (array, place, _), l, h in zip(entries, low, high)]
    start[0] = (0.30 - low[0]) / (high[0] - low[0])  # Carom's nominal friction.
    optimizer = nlopt.opt(nlopt.LN_BOBYQA, len(entries))
    optimizer.set_lower_bounds(0.0)
    optimizer.set_upper_bounds(1.0)
    optimizer.set_initial_step(0.1)
    optimizer.set_min_objective(error)
    optimizer.set_ftol_rel(1e-4)
    optimizer.set_maxeval(evaluations)
    begun = time.perf_counter()
    x = optimizer.optimize(start)
    seconds = time.perf_counter() - begun
    best = low + x * (high - low)
    put(best)
    return dict(
        seconds=seconds,
        strikes=len(chosen),
        evaluations=count,
        mean_error=optimizer.last_optimum_value() / len(chosen),
        friction=float(best[0]),
    )


def train(rows, epochs, stop_after, least_steps=13, threads=1):
    """Section 3.4.1, with the rows' own split: 4-128-64-32-2, batch norm, dropout, Adam, batches of 32."""
    import torch
    from torch import nn

    torch.set_num_threads(threads)
    # The first step of an optimizer imports more of PyTorch.
    warm = nn.Linear(2, 2)
    optimizer = torch.optim.Adam(warm.parameters(), fused=True)
    warm(torch.ones(2, 2)).sum().backward()
    optimizer.step()
    torch.manual_seed(0)
    columns = np.array([[*row["path"], row["speed_sim"], row["angle_sim"], row["d_speed"], row["d_angle"]] for row in rows])
    split = np.array([row["split"] for row in rows])
    begun = time.perf_counter()
    learn = columns[split == "train"]
    mean, deviation = learn.mean(0), learn.std(0)
    scaled = torch.tensor((columns - mean) / deviation, dtype=torch.float32)
    learn, judge = scaled[split == "train"], scaled[split == "validation"]
    model = nn.Sequential(
        nn.Linear(4, 128),
        nn.ReLU(),
        nn.BatchNorm1d(128),
        nn.Linear(128, 64),
        nn.ReLU(),
        nn.Linear(64, 32),
        nn.ReLU(),
        nn.Dropout(0.05),
        nn.Linear(32, 2),
    )
    optimizer = torch.optim.Adam(model.parameters(), lr=1e-3, fused=True)
    schedule = torch.optim.lr_scheduler.ReduceLROnPlateau(optimizer, factor=0.5, patience=4, min_lr=1e-6, threshold=0.0)
    loss_of = nn.MSELoss()
    best, since, passes = np.inf, 0, max(1, -(-least_steps // -(-len(learn) // 32)))
    for epoch in range(epochs):
        model.train()
        for _ in range(passes):
            # Indexing the tensor is several times quicker than a DataLoader at this size.
            for batch in torch.randperm(len(learn)).split(32):
                if len(batch) > 1:
                    optimizer.zero_grad(set_to_none=True)
                    loss_of(model(learn[batch, :4]), learn[batch, 4:]).backward()
                    optimizer.step()
        model.eval()
        with torch.inference_mode():
            error = (model(judge[:, :4]) - judge[:, 4:]).abs()
        value = float(error.mean())
        schedule.step(value)
        if value < best:
            best, since, mae = value, 0, float((error.numpy() * deviation[4:]).mean())
        else:
            since += 1
            if since >= stop_after:
                break
    return dict(seconds=time.perf_counter() - begun, epochs=epoch + 1, rows=len(learn), mae=mae)


def pipeline(shared, variant, targets, strikes, evaluations):
    """A slice of every part, from which the whole is extrapolated: the time of `targets` solves, of `evaluations` of algorithm 2's sum
    over `strikes` strikes, and of one training on residuals of the targets solved."""
    striker = Striker(shared, **STEPS[variant])
    identified = identify(shared, striker, strikes, evaluations)
    striker.simulations = 0
    solved = solve(shared, striker, variant, targets)
    rows = [
        dict(
            path=np.subtract(strike["stop"], strike["initial"]),
            speed_sim=v,
            angle_sim=a,
            split=strike["split"],
            d_speed=strike["command"]["speed"] - v,
            d_angle=strike["command"]["angle"] - a,
        )
        for strike, (v, a) in zip(shared["strikes"], solved.pop("commands"))
    ]
    trained = train(rows, 500, 20) if len(rows) >= 100 else None
    return dict(roughness=roughness(shared, **STEPS[variant]), identified=identified, solved=solved, trained=trained)


def main():
    parser = argparse.ArgumentParser()
    parser.add_argument("folder")
    parts = parser.add_subparsers(dest="part", required=True)
    part = parts.add_parser("solve")
    part.add_argument("variant", choices=STEPS)
    part.add_argument("targets", type=int)
    part = parts.add_parser("train")
    part.add_argument("epochs", type=int)
    part.add_argument("threads", type=int)
    part = parts.add_parser("pipeline")
    part.add_argument("variant", choices=STEPS)
    part.add_argument("targets", type=int)
    part.add_argument("strikes", type=int)
    part.add_argument("evaluations", type=int)
    args = parser.parse_args()
    shared = load(args.folder)
    if args.part == "solve":
        answer = solve(shared, Striker(shared, **STEPS[args.variant]), args.variant, args.targets)
        del answer["commands"]
    elif args.part == "train":
        answer = train(shared["residuals"], args.epochs, args.epochs + 1, threads=args.threads)
    else:
        answer = pipeline(shared, args.variant, args.targets, args.strikes, args.evaluations)
    print(json.dumps(answer))


if __name__ == "__main__":
    main()
