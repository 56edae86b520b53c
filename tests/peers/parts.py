"""What is measured: each part answers with its rows. `size(full, small)` chooses how large."""

import json
import pathlib
import shutil
import statistics

from measuring import CORES, ROOT, compared, in_turn, limited, megabytes, peer, row, run, spread

OUT = pathlib.Path("artifacts/runs/bench")
CAROM, STRIKE, BENCH = (f"target/debug/{name}" for name in ("carom", "strike", "bench"))


def demo(strikes, *options, name="demo"):
    """A folder of demo strikes, made once."""
    folder = OUT / f"{name}_{strikes}"
    if not (ROOT / folder / "truth.json").exists():
        run(CAROM, "demo", "--quiet", "--strikes", strikes, "--seed", 1, *options, "--out", folder)
    return folder


def logs(folder):
    return sorted((ROOT / folder / "logs").glob("*.mcap"))


def prepared(rig, name):
    """What the parts inside a process are given, made by this carom."""
    run(BENCH, "--threads", CORES, "prepare", OUT / name, rig / "rig.toml", *logs(rig))
    return OUT / name


def fresh(name):
    shutil.rmtree(ROOT / OUT / name, ignore_errors=True)
    return OUT / name


def carom_run(rig, out, *more):
    return run(CAROM, "run", "--json", "--quiet", *logs(rig), "--rig", rig / "rig.toml", "--out", fresh(out), *more)


def seconds(result):
    return result["seconds"]


def times(results):
    return [[result[key] for result in results] for key in ("wall", "cpu")]


def step(size):
    data, lasts = prepared(demo(size(500, 100)), "mixture"), size(3, 0.5)
    steps = run(BENCH, "step", data, 0.2)
    fine, slides = round(steps["fine_steps"]), round(steps["slide_steps"])

    def mine(threads):
        return lambda: run(BENCH, "--threads", threads, "step", data, lasts)

    def theirs(threads):
        return lambda: peer("rollout", data, lasts, threads, fine, slides)

    one, one_peer, two, two_peer = in_turn(size(5, 2), mine(1), theirs(1), mine(2), theirs(2))
    rows = []
    for threads, a, b in ((1, one, one_peer), (2, two, two_peer)):
        what = f"one simulated strike ({fine} fine and {slides} long steps), per step, {threads} thread{'s' * (threads > 1)}"
        name = "`mujoco.rollout` of carom's model, as many steps"
        rows.append(compared(what, a, name, b, lambda result: result["step_ns"], "µs", 1e-3))
    more = [
        [b["strikes_per_second"] / a["strikes_per_second"] for a, b in zip(*pair)] for pair in ((one, two), (one_peer, two_peer))
    ]
    free = [
        2 * b["strikes_per_second"] * b["wall"] / b["cpu"] / (a["strikes_per_second"] * a["wall"] / a["cpu"])
        for a, b in zip(one, two)
    ]
    rows.append(
        row(
            "simulated strikes a second, 2 threads",
            spread([result["strikes_per_second"] for result in two], "/s"),
            statistics.median(more[0]) >= 1.9,
            f"`mujoco.rollout`, 2 threads over 1: {spread(more[1], '×')}",
            f"2 threads over 1: {spread(more[0], '×')}; by processor time, as if both cores were free: {spread(free, '×')}",
            "≥ 1.9 ×",
        )
    )
    return rows


def solve(size):
    data = prepared(demo(size(500, 100)), "mixture")
    one, nlopt, all_, steps = in_turn(
        size(5, 2),
        lambda: run(BENCH, "solve", data),
        lambda: peer("paper", data, "solve", "chosen", size(100, 10)),
        lambda: run(BENCH, "--threads", CORES, "solve", data),
        lambda: run(BENCH, "--threads", CORES, "step", data, size(2, 0.5)),
    )
    mine, theirs = one[0], nlopt[0]
    accuracy = (
        f"within 1 mm: {mine['solved']} of {mine['targets']}, mean {mine['miss'] * 1e3:.2g} mm (with steps halved 95 % within "
        f"{mine['checked_p95'] * 1e3:.2g} mm); {theirs['solved']} of {theirs['targets']}, mean {theirs['miss'] * 1e3:.2g} mm"
    )
    name = "NLopt (BOBYQA, the squared miss) from a random start, Python"
    solves = [result["targets"] / result["seconds"] for result in all_]
    share = [a / (b["strikes_per_second"] / mine["simulations"]) for a, b in zip(solves, steps)]
    return [
        compared(
            "solve to 1 mm, per target, 1 thread", one, name, nlopt, lambda r: r["seconds"] / r["targets"], "ms", 1e3, 20, accuracy
        ),
        row(
            "simulations a solve",
            f"{mine['simulations']:.2f}",
            mine["simulations"] <= 3,
            f"{theirs['simulations']:.1f}",
            reach="≤ 3",
        ),
        row(
            f"solves a second, {CORES} threads",
            spread(solves, "/s"),
            statistics.median(share) >= 0.6,
            ratio=f"of what stepping allows: {spread(share, '%', 100)}",
            reach="≥ 60 %",
        ),
    ]


def train(size):
    data, epochs = prepared(demo(size(500, 100)), "mixture"), size(200, 20)
    threads = min(1, CORES, key=lambda threads: peer("paper", data, "train", 10, threads)["seconds"])
    mine, theirs = in_turn(
        size(5, 2),
        lambda: run(BENCH, "--threads", CORES, "train", data, epochs),
        lambda: peer("paper", data, "train", epochs, threads),
    )
    name = f"PyTorch on the CPU, {threads} thread (the quicker of 1 and {CORES}), imports not counted"
    accuracy = f"validation MAE {mine[0]['mae']:.4f}; {theirs[0]['mae']:.4f}"
    return [compared(f"training, {mine[0]['rows']} rows, {epochs} epochs", mine, name, theirs, seconds, "s", accuracy=accuracy)]


def ingest(size):
    rig = demo(size(500, 100))

    def mine(threads, *paths):
        options = ("--rig", rig / "rig.toml", "--out", fresh("ingest"), "--threads", threads, "--quiet")
        return run(CAROM, "ingest", *paths, *options)

    one, all_, theirs = in_turn(
        size(5, 2), lambda: mine(1, *logs(rig)), lambda: mine(CORES, *logs(rig)), lambda: peer("read_logs", *logs(rig))
    )
    megabyte = sum(path.stat().st_size for path in logs(rig)) / 1e6
    name = "`mcap` and `mcap-ros2-support`, the same messages decoded and no more, imports not counted"
    rows = [
        compared(
            f"ingest of {megabyte:.0f} MB in {len(logs(rig))} logs, {threads} thread{'s' * (threads > 1)}, from process start to tables",
            results,
            name,
            theirs,
            lambda result: result.get("seconds", result["wall"]),
            "s",
            least=30,
            accuracy=f"{theirs[0]['messages']:,} messages",
        )
        for threads, results in ((1, one), (CORES, all_))
    ]
    sizes, speeds, log = size((2e7, 2e8, 2e9), (2e6, 2e7)), [], ROOT / OUT / "large.mcap"
    for wanted in sizes:
        made = run(BENCH, "log", rig / "rig.toml", int(wanted), log)
        large = mine(CORES, log)
        log.unlink()
        speeds.append(made["bytes"] / large["wall"] / 1e6)
    fresh("ingest")
    rows.append(
        row(
            f"one log of {sizes[-1] / 1e9:g} GB ({made['strikes']:,} strikes)",
            f"{large['wall']:.1f} s",
            large["memory"] < 256e6 and speeds[-1] > 0.8 * speeds[0],
            ratio=", ".join(f"{wanted / 1e6:g} MB: {speed:.0f} MB/s" for wanted, speed in zip(sizes, speeds)),
            reach="linear, < 256 MB",
            memory=megabytes([large]),
        )
    )
    return rows


def strike(size):
    if not (ROOT / OUT / "run/latest").exists():
        carom_run(demo(size(500, 100)), "run")

    def plan():
        return run(STRIKE, "--artifacts", OUT / "run", "--from", 0.30, 0.0, "--to", 0.62, 0.06, "--json", "--quiet")

    batch, count = ROOT / OUT / "batch.jsonl", size(1000, 100)

    def plans(lines):
        targets = [{"from": [0.28 + 1e-4 * i, 0.02], "to": [0.60, 0.1 * (i % 7 - 3) / 3]} for i in range(lines)]
        batch.write_text("\n".join(map(json.dumps, targets)) + "\n")
        return run(STRIKE, "--artifacts", OUT / "run", "--batch", batch, "--quiet")

    plan()
    (alone,) = in_turn(size(21, 3), plan)
    first, all_ = in_turn(size(5, 2), lambda: plans(1), lambda: plans(count))
    wall, cpu = [[(b[key] - a[key]) / (count - 1) for a, b in zip(first, all_)] for key in ("wall", "cpu")]
    return [
        limited("`strike`, process start to plan", *times(alone), "ms", 1e3, 50, memory=megabytes(alone)),
        limited("`strike --batch`, a further target", wall, cpu, "ms", 1e3, 5),
    ]


def diagnose(size):
    data = prepared(demo(size(500, 100)), "mixture")
    (mine,) = in_turn(size(3, 1), lambda: run(BENCH, "--threads", CORES, "diagnose", data))
    what = f"diagnosis of {mine[0]['strikes']} strikes (its peers: BLIND.md)"
    return [limited(what, *times(mine), "s", 1.0, 20, ", ".join(mine[0]["effects"]), megabytes(mine))]


def sysid(size):
    rig = demo(size(500, 100), "--hide", "none", name="clean")
    data, strikes = prepared(rig, "clean"), size(50, 7)
    truth = json.loads((ROOT / rig / "truth.json").read_text())["friction"]
    rows = []
    for name, options in (("defaults", ()), ("`eps=1e-2`", ("--eps", 1e-2))):
        mine, theirs = in_turn(
            1,
            lambda: run(BENCH, "--threads", CORES, "sysid", data, strikes, "friction", "restitution", "contact_time"),
            lambda options=options: peer("mujoco_sysid", data, strikes, *options),
        )
        found, other = mine[0]["parameters"]["friction"], theirs[0]
        accuracy = (
            f"friction, truth {truth}: {found['value']:.4f} [{found['low']:.4f}, {found['high']:.4f}]; "
            f"{other['friction']:.4f} ± {other['half_width']:.1g}"
        )
        what = f"sysid, {strikes} strikes, 3 parameters"
        rows.append(compared(what, mine, f"`mujoco.sysid`, {name}", theirs, seconds, "s", least=10, accuracy=accuracy))
    return rows


def pipeline(size):
    count = size(500, 100)
    rig = demo(count)
    data = prepared(rig, "mixture")
    mine, bare = in_turn(
        size(3, 1), lambda: carom_run(rig, "run"), lambda: carom_run(rig, "run", "--without-effects")
    )
    diagnosis = lambda result: next(s["seconds"] for s in result["stages"] if s["name"] == "diagnose")
    walls = [result["wall"] for result in mine]
    wholes = {
        f"whole pipeline, {count} strikes, diagnosis and effects included": walls,
        f"whole pipeline, {count} strikes, as far as the paper's goes (`--without-effects`, less its `diagnose`)": [
            result["wall"] - diagnosis(result) for result in bare
        ],
    }
    stages = ", ".join(f"{stage['name']} {stage['seconds']:.2f}" for stage in mine[-1]["stages"])
    rows = [
        row(
            f"`carom run`, {count} strikes: all there is, diagnosis, effects, learning curve, report",
            spread(walls, "s"),
            accuracy=f"s: {stages}",
        )
    ]
    mae = f"validation MAE {run(BENCH, '--threads', CORES, 'train', data)['mae']:.4f}; "
    whole = None
    for variant, name, targets, sums in (
        ("chosen", "its steps chosen as carom's", count, 1000),
        ("written", "as written, steps of 0.2 ms", *size((20, 4), (4, 2))),
        ("default", "as written, MuJoCo's 2 ms", *size((60, 20), (4, 2))),
    ):
        slice_ = peer("paper", data, "pipeline", variant, targets, 50, sums)
        identified, solved, roughness = slice_["identified"], slice_["solved"], slice_["roughness"] * 1e3
        whole = whole or slice_
        sums, training = whole["identified"]["evaluations"], whole["trained"]
        parts = (
            identified["seconds"] / identified["evaluations"] * sums,
            solved["seconds"] / solved["targets"] * count,
            training["seconds"],
        )
        basis = "all measured"
        accuracy = f"{mae}{training['mae']:.4f}; "
        if slice_ is not whole:
            basis = f"extrapolated from {identified['evaluations']} of {sums} sums, {solved['targets']} of {count} solves and the training above"
            accuracy = ""
        least = 50 if variant == "written" else None
        for label, times in wholes.items():
            ratio = sum(parts) / statistics.median(times)
            rows.append(
                row(
                    label,
                    spread(times, "s"),
                    least and ratio >= least,
                    f"the paper's, {name}: {sum(parts):.0f} s (algorithm 2 {parts[0]:.0f}, algorithm 1 {parts[1]:.0f}, training {parts[2]:.1f}); {basis}",
                    f"{ratio:.3g} ×",
                    "≥ 50 ×" if least else "",
                    f"{accuracy}it solves {solved['solved']} of {solved['targets']} to 1 mm in a world whose stops jump by {roughness:.2g} mm",
                    f"{megabytes(mine)}; {megabytes([slice_])}",
                )
            )
    return rows


def nightly(size):
    many, few = size(5000, 200), 10
    rig = demo(many + few)
    added = logs(rig)[-1]

    def night():
        return run(CAROM, "nightly", ROOT / rig / "logs", "--rig", rig / "rig.toml", "--out", OUT / "nightly", "--quiet")

    fresh("nightly")
    aside = added.rename(added.with_suffix(".later"))
    try:
        whole = night()
    finally:
        aside.rename(added)
    more, nothing = night(), night()
    return [
        row(
            f"`carom nightly`, {few} new strikes on {many:,}",
            f"{more['wall']:.2f} s (nothing new: {nothing['wall']:.2f} s)",
            more["wall"] <= whole["wall"] / 20,
            f"its full run: {whole['wall']:.1f} s",
            f"1/{whole['wall'] / more['wall']:.3g}",
            "≤ 1/20",
            memory=f"{megabytes([more])}; {megabytes([whole])}",
        )
    ]


def growth(size):
    results = {}
    for count in size((500, 5000, 50000), (100, 200)):
        results[count] = carom_run(demo(count), "growth")
    for folder in ("growth", "demo_50000"):
        fresh(folder)
    (first, begun), (last, ended) = list(results.items())[0], list(results.items())[-1]
    more = (ended["wall"] / last) / (begun["wall"] / first)
    return [
        row(
            "`carom run`",
            ", ".join(f"{count:,} strikes: {result['wall']:.1f} s" for count, result in results.items()),
            more <= 1.1 and ended["memory"] < 1e9,
            ratio=f"{more:.2g} × the time a strike",
            reach="linear, < 1 GB",
            memory=", ".join(megabytes([result]) for result in results.values()),
        )
    ]


PARTS = {part.__name__: part for part in (step, solve, train, ingest, strike, diagnose, sysid, pipeline, nightly, growth)}
