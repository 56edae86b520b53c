"""`make bench`: carom and its peers in turn on the same strikes, and the page tests/BENCH.md.

Every measurement is a process of its own, whose peak memory the kernel counts; times are taken inside it where a part has nothing
to do with starting up. What a part gave is kept, and measured again only if the part is named: the page can be made part by part.
"""

import argparse
import importlib.metadata
import json
import os
import pathlib
import shutil
import statistics
import subprocess
import sys
import tempfile
import time

HERE = pathlib.Path(__file__).parent
ROOT = HERE.parent.parent
OUT = pathlib.Path("artifacts/runs/bench")
CAROM, STRIKE, BENCH = (f"target/debug/{name}" for name in ("carom", "strike", "bench"))
CORES = os.cpu_count()


def run(*command):
    """The JSON object on a process's last line, its wall time (s) and peak memory (bytes)."""
    command = [str(word) for word in command]
    with tempfile.TemporaryFile() as errors:
        begun = time.perf_counter()
        child = subprocess.Popen(command, stdout=subprocess.PIPE, stderr=errors, cwd=ROOT)
        output = child.stdout.read().decode()
        _, status, usage = os.wait4(child.pid, 0)
        wall = time.perf_counter() - begun
        child.returncode = os.waitstatus_to_exitcode(status)
        errors.seek(0)
        # 3: done, but some input was rejected.
        if child.returncode not in (0, 3):
            sys.exit(
                f"failed to measure: `{' '.join(command)}` ended with {child.returncode}: {errors.read().decode()[-2000:]}"
            )
    last = (output.strip().splitlines() or [""])[-1]
    answer = json.loads(last) if last.startswith("{") else {}
    return {**answer, "wall": wall, "memory": usage.ru_maxrss * 1024}


def peer(name, *words):
    return run(sys.executable, HERE / f"{name}.py", *words)


def in_turn(runs, *measurements):
    """Each of the measurements once, and again: a machine that slows down slows all of them."""
    rounds = [[measure() for measure in measurements] for _ in range(runs)]
    return [list(column) for column in zip(*rounds)]


def spread(values, unit, scale=1.0):
    """Median, and least to greatest where there are several."""
    values = [value * scale for value in values]
    shown = lambda value: f"{value:,.3g}" if abs(value) < 1000 else f"{value:,.0f}"
    range_ = f" [{shown(min(values))}, {shown(max(values))}]" if len(values) > 1 else ""
    return f"{shown(statistics.median(values))}{range_} {unit}".strip()


def column(results, key):
    return [result[key] for result in results]


def ratios(over, under):
    return [a / b for a, b in zip(over, under)]


def megabytes(results):
    return f"{max(column(results, 'memory')) / 1e6:,.0f} MB"


def row(what, carom, other, ratio, reach, met, accuracy="", memory=""):
    """One line of the table. `ratio` is the list that is to be at least (or, with `met`, whatever) what `reach` says."""
    return dict(what=what, carom=carom, peer=other, ratio=ratio, reach=reach, met=met, accuracy=accuracy, memory=memory)


def at_least(values, least):
    return statistics.median(values) >= least


def demo(strikes, *options, name=None):
    """A folder of demo strikes, made once."""
    folder = OUT / (name or f"demo_{strikes}")
    if not (ROOT / folder / "truth.json").exists():
        run(CAROM, "demo", "--quiet", "--strikes", strikes, "--seed", 1, *options, "--out", folder)
    return folder


def logs(folder):
    return sorted((ROOT / folder / "logs").glob("*.mcap"))


def prepared(strikes, *options, name):
    """What the parts inside a process are given, made by this carom."""
    rig = demo(strikes, *options, name=f"rig_{name}_{strikes}")
    run(BENCH, "--threads", CORES, "prepare", OUT / name, rig / "rig.toml", *logs(rig))
    return OUT / name


def fresh(name):
    shutil.rmtree(ROOT / OUT / name, ignore_errors=True)
    return OUT / name


# The parts: each measures and answers with its rows.


def step(size):
    data = prepared(size(500, 100), name="mixture")
    seconds = size(3, 0.5)
    steps = run(BENCH, "step", data, 0.2)
    count = round(steps["fine_steps"]), round(steps["slide_steps"])
    strikes = lambda threads: lambda: run(BENCH, "--threads", threads, "step", data, seconds)
    rollout = lambda threads: lambda: peer("rollout", data, seconds, threads, *count)
    one, one_peer, two, two_peer = in_turn(size(5, 2), strikes(1), rollout(1), strikes(2), rollout(2))
    rows = []
    for name, mine, theirs in (("1 thread", one, one_peer), ("2 threads", two, two_peer)):
        quicker = ratios(column(theirs, "step_ns"), column(mine, "step_ns"))
        rows.append(
            row(
                f"one simulated strike, {count[0]} fine and {count[1]} long steps, {name}, per step",
                spread(column(mine, "step_ns"), "µs", 1e-3),
                f"`mujoco.rollout`, carom's model: {spread(column(theirs, 'step_ns'), 'µs', 1e-3)}",
                spread(quicker, "×"),
                "≥ 1 ×",
                at_least(quicker, 1),
                "the same model and lengths of steps",
                f"{megabytes(mine)}; {megabytes(theirs)}",
            )
        )
    more = ratios(column(two, "strikes_per_second"), column(one, "strikes_per_second"))
    more_peer = ratios(column(two_peer, "strikes_per_second"), column(one_peer, "strikes_per_second"))
    rows.append(
        row(
            "simulated strikes a second, 2 threads over 1",
            spread(column(two, "strikes_per_second"), "/s"),
            f"`mujoco.rollout`: {spread(more_peer, '×')}",
            spread(more, "×"),
            "≥ 1.9 ×",
            at_least(more, 1.9),
        )
    )
    return rows


def solve(size):
    data = prepared(size(500, 100), name="mixture")
    targets = size(100, 10)
    one, nlopt, all_, steps = in_turn(
        size(5, 2),
        lambda: run(BENCH, "--threads", 1, "solve", data),
        lambda: peer("paper", data, "solve", "chosen", targets),
        lambda: run(BENCH, "--threads", CORES, "solve", data),
        lambda: run(BENCH, "--threads", CORES, "step", data, size(2, 0.5)),
    )
    each = lambda results: [result["seconds"] / result["targets"] for result in results]
    quicker = ratios(each(nlopt), each(one))
    mine, theirs = one[0], nlopt[0]
    possible = [s["strikes_per_second"] / a["simulations"] for s, a in zip(steps, all_)]
    share = [a["targets"] / a["seconds"] / limit for a, limit in zip(all_, possible)]
    return [
        row(
            "solve to 1 mm, per target, 1 thread",
            spread(each(one), "ms", 1e3),
            f"NLopt (BOBYQA, the squared miss) from a random start, Python: {spread(each(nlopt), 'ms', 1e3)}",
            spread(quicker, "×"),
            "≥ 20 ×",
            at_least(quicker, 20),
            f"within 1 mm: {mine['solved']} of {mine['targets']}, mean miss {mine['miss'] * 1e3:.2g} mm, with steps halved 95 % within {mine['checked_p95'] * 1e3:.2g} mm; "
            f"{theirs['solved']} of {theirs['targets']}, {theirs['miss'] * 1e3:.2g} mm",
            f"{megabytes(one)}; {megabytes(nlopt)}",
        ),
        row(
            "simulations a solve",
            f"{mine['simulations']:.2f}",
            f"{theirs['simulations']:.1f}",
            "",
            "≤ 3",
            mine["simulations"] <= 3,
        ),
        row(
            f"solves a second of what stepping alone allows, {CORES} threads",
            spread([a["targets"] / a["seconds"] for a in all_], "/s"),
            "",
            spread(share, "%", 100),
            "≥ 60 %",
            at_least(share, 0.6),
        ),
    ]


def sysid(size):
    data = prepared(size(500, 100), "--hide", "none", name="clean")
    truth = json.loads((ROOT / OUT / f"rig_clean_{size(500, 100)}/truth.json").read_text())["friction"]
    strikes, free = size(50, 7), ("friction", "restitution", "contact_time")
    rows = []
    for name, options in (("defaults", ()), ("`eps=1e-2`", ("--eps", 1e-2))):
        mine, theirs = in_turn(
            1,
            lambda: run(BENCH, "--threads", CORES, "sysid", data, strikes, *free),
            lambda: peer("mujoco_sysid", data, strikes, *options),
        )
        quicker = ratios(column(theirs, "seconds"), column(mine, "seconds"))
        found = mine[0]["parameters"]["friction"]
        rows.append(
            row(
                f"sysid, {strikes} strikes, 3 parameters",
                spread(column(mine, "seconds"), "s"),
                f"`mujoco.sysid`, {name}: {spread(column(theirs, 'seconds'), 's')}",
                spread(quicker, "×"),
                "≥ 10 ×",
                at_least(quicker, 10),
                f"friction, truth {truth}: {found['value']:.4f} [{found['low']:.4f}, {found['high']:.4f}]; {theirs[0]['friction']:.4f} ± {theirs[0]['half_width']:.1g}",
                f"{megabytes(mine)}; {megabytes(theirs)}",
            )
        )
    return rows


def ingest(size):
    rig = demo(size(500, 100))
    size_of = sum(path.stat().st_size for path in logs(rig))
    reads = lambda threads: (
        lambda: run(
            CAROM, "--quiet", "--threads", threads, "ingest", *logs(rig), "--rig", rig / "rig.toml", "--out", fresh("ingest")
        )
    )
    one, all_, theirs = in_turn(size(5, 2), reads(1), reads(CORES), lambda: peer("read_logs", *logs(rig)))
    rows = []
    for name, mine in (("1 thread", one), (f"{CORES} threads", all_)):
        quicker = ratios(column(theirs, "seconds"), column(mine, "wall"))
        rows.append(
            row(
                f"ingest of {size_of / 1e6:.0f} MB in {len(logs(rig))} logs, {name}: process start, strikes found, tables written",
                spread(column(mine, "wall"), "s"),
                f"`mcap`, `mcap-ros2-support`, the same messages decoded, imports not counted: {spread(column(theirs, 'seconds'), 's')}",
                spread(quicker, "×"),
                "≥ 30 ×",
                at_least(quicker, 30),
                f"{theirs[0]['messages']:,} messages",
                f"{megabytes(mine)}; {megabytes(theirs)}",
            )
        )
    sizes, a_second = size((2e7, 2e8, 2e9), (2e6, 2e7)), []
    for bytes_ in sizes:
        log = OUT / "large.mcap"
        made = run(BENCH, "log", rig / "rig.toml", int(bytes_), log)
        mine = run(CAROM, "--quiet", "--threads", CORES, "ingest", log, "--rig", rig / "rig.toml", "--out", fresh("ingest"))
        (ROOT / log).unlink()
        a_second.append(made["bytes"] / mine["wall"] / 1e6)
    fresh("ingest")
    rows.append(
        row(
            f"one log of {sizes[-1] / 1e9:g} GB ({made['strikes']:,} strikes)",
            f"{mine['wall']:.1f} s",
            "",
            " → ".join(f"{speed:.0f}" for speed in a_second)
            + " MB/s at "
            + ", ".join(f"{bytes_ / 1e6:g}" for bytes_ in sizes)
            + " MB",
            "linear, < 256 MB",
            mine["memory"] < 256e6 and a_second[-1] > 0.8 * a_second[0],
            "",
            megabytes([mine]),
        )
    )
    return rows


def train(size):
    data = prepared(size(500, 100), name="mixture")
    epochs = size(200, 20)
    mine, one, all_ = in_turn(
        size(5, 2),
        lambda: run(BENCH, "--threads", CORES, "train", data, epochs),
        lambda: peer("paper", data, "train", epochs, 1),
        lambda: peer("paper", data, "train", epochs, CORES),
    )
    threads, theirs = min(((1, one), (CORES, all_)), key=lambda pair: statistics.median(column(pair[1], "seconds")))
    quicker = ratios(column(theirs, "seconds"), column(mine, "seconds"))
    return [
        row(
            f"training, {mine[0]['rows']} rows, {epochs} epochs",
            spread(column(mine, "seconds"), "s"),
            f"PyTorch on the CPU, {threads} thread (the quicker of 1 and {CORES}), imports not counted: "
            f"{spread(column(theirs, 'seconds'), 's')}",
            spread(quicker, "×"),
            "≥ 1 ×",
            at_least(quicker, 1),
            f"validation MAE {mine[0]['mae']:.4f}; {theirs[0]['mae']:.4f}",
            f"{megabytes(mine)}; {megabytes(theirs)}",
        )
    ]


def diagnose(size):
    data = prepared(size(500, 100), name="mixture")
    (mine,) = in_turn(size(3, 1), lambda: run(BENCH, "--threads", CORES, "diagnose", data))
    return [
        row(
            f"diagnosis of {mine[0]['strikes']} strikes, {CORES} threads",
            spread(column(mine, "seconds"), "s"),
            "(peers: tests/BLIND.md)",
            "",
            "≤ 20 s",
            statistics.median(column(mine, "seconds")) <= 20,
            ", ".join(mine[0]["effects"]),
            megabytes(mine),
        )
    ]


def full_run(rig, name="run", *options):
    return run(CAROM, "run", "--json", "--quiet", *options, *logs(rig), "--rig", rig / "rig.toml", "--out", fresh(name))


def pipeline(size):
    rig = demo(size(500, 100))
    count = size(500, 100)
    data = prepared(count, name="mixture")
    (mine,) = in_turn(size(3, 1), lambda: full_run(rig))
    seconds = statistics.median(column(mine, "wall"))
    mae = run(BENCH, "--threads", CORES, "train", data)["mae"]
    evaluations = None
    rows = []
    for variant, name, slice_ in (
        ("chosen", "its steps chosen as carom's, run whole", (count, 50, 1000)),
        ("written", "as written, in steps of 0.2 ms", size((20, 50, 4), (4, 5, 2))),
        ("default", "as written, in MuJoCo's default steps of 2 ms", size((60, 50, 20), (4, 5, 2))),
    ):
        theirs = peer("paper", data, "pipeline", variant, *slice_)
        identified, solved = theirs["identified"], theirs["solved"]
        if evaluations is None:
            evaluations, trained = identified["evaluations"], theirs["trained"]
        parts = (
            identified["seconds"] / identified["evaluations"] * evaluations,
            solved["seconds"] / solved["targets"] * count,
            trained["seconds"],
        )
        told = (
            "measured"
            if variant == "chosen"
            else f"extrapolated from {identified['evaluations']} of {evaluations} sums and {solved['targets']} of {count} solves"
        )
        rows.append(
            row(
                f"whole pipeline, {count} strikes: `carom run` with diagnosis, effects, learning curve, evaluation and report",
                spread(column(mine, "wall"), "s"),
                f"the paper's, {name}: {sum(parts):.0f} s (algorithm 2 {parts[0]:.0f}, algorithm 1 {parts[1]:.0f}, training {parts[2]:.1f}), {told}",
                f"{sum(parts) / seconds:.3g} ×",
                "≥ 50 ×" if variant == "written" else "",
                sum(parts) / seconds >= 50 if variant == "written" else None,
                f"validation MAE {mae:.4f}; "
                + (f"{trained['mae']:.4f}, " if variant == "chosen" else "")
                + f"{solved['solved']} of {solved['targets']} within 1 mm of its own world, whose stops "
                f"jump by {theirs['roughness'] * 1e3:.2g} mm",
                f"{megabytes(mine)}; {theirs['memory'] / 1e6:,.0f} MB",
            )
        )
    return rows


def strike(size):
    rig = demo(size(500, 100))
    if not (ROOT / OUT / "run/latest").exists():
        full_run(rig)
    plan = lambda: run(STRIKE, "--artifacts", OUT / "run", "--from", 0.30, 0.0, "--to", 0.62, 0.06, "--json", "--quiet")
    plan()
    (mine,) = in_turn(size(21, 3), plan)
    lines = [
        json.dumps({"from": [0.28 + 0.0001 * i, 0.02], "to": [0.60, 0.1 * (i % 7 - 3) / 3]}) for i in range(size(1000, 100))
    ]
    batch = ROOT / OUT / "batch.jsonl"
    rows, each = [], []
    for _ in range(size(5, 2)):
        took = []
        for count in (1, len(lines)):
            batch.write_text("\n".join(lines[:count]) + "\n")
            took.append(run(STRIKE, "--artifacts", OUT / "run", "--batch", batch, "--quiet")["wall"])
        each.append((took[1] - took[0]) / (len(lines) - 1))
    return [
        row(
            "`strike`, process start to plan",
            spread(column(mine, "wall"), "ms", 1e3),
            "",
            "",
            "≤ 50 ms",
            statistics.median(column(mine, "wall")) <= 0.050,
            f"simulated miss of the plan under 1 mm",
            megabytes(mine),
        ),
        row("`strike --batch`, a further target", spread(each, "ms", 1e3), "", "", "≤ 5 ms", statistics.median(each) <= 0.005),
    ]


def nightly(size):
    many, few = size((5000, 10), (200, 10))
    rig = demo(many + few)
    added = logs(rig)[-1]
    night = lambda: run(CAROM, "nightly", "--quiet", ROOT / rig / "logs", "--rig", rig / "rig.toml", "--out", OUT / "nightly")
    fresh("nightly")
    aside = added.with_suffix(".later")
    added.rename(aside)
    try:
        whole = night()
    finally:
        aside.rename(added)
    more = night()
    nothing = night()
    return [
        row(
            f"`carom nightly`, {few} new strikes on {many:,}",
            f"{more['wall']:.2f} s",
            f"a full run: {whole['wall']:.1f} s",
            f"1/{whole['wall'] / more['wall']:.3g}",
            "≤ 1/20",
            more["wall"] <= whole["wall"] / 20,
            f"nothing new: {nothing['wall']:.2f} s",
            f"{megabytes([more])}; {megabytes([whole])}",
        )
    ]


def growth(size):
    counts, results = size((500, 5000, 50000), (100, 200)), []
    for count in counts:
        rig = demo(count)
        results.append((count, full_run(rig, f"growth")))
        fresh("growth")
    (first, begun), (last, ended) = results[0], results[-1]
    more = (ended["wall"] / last) / (begun["wall"] / first)
    return [
        row(
            f"`carom run` from {first} to {last:,} strikes",
            ", ".join(f"{count:,}: {result['wall']:.1f} s" for count, result in results),
            "",
            f"{more:.2g} × the time per strike",
            "linear, < 1 GB",
            more <= 1.1 and ended["memory"] < 1e9,
            "",
            ", ".join(megabytes([result]) for _, result in results),
        )
    ]


PARTS = {part.__name__: part for part in (step, solve, train, ingest, strike, diagnose, sysid, pipeline, nightly, growth)}


def output(*command):
    return subprocess.run(command, capture_output=True, text=True, cwd=ROOT, check=True).stdout.strip()


def page(results):
    """The page of all that was measured."""
    version = importlib.metadata.version
    packages = ", ".join(
        f"{name} {version(name)}" for name in ("mujoco", "nlopt", "torch", "mcap", "mcap-ros2-support", "numpy")
    )
    memory = os.sysconf("SC_PAGE_SIZE") * os.sysconf("SC_PHYS_PAGES") / 2**30
    lines = [
        (HERE / "page.md").read_text().strip(),
        "",
        "| part | carom | peer | ratio | to reach | | accuracy: carom; peer | peak memory |",
        "|---|---|---|---|---|---|---|---|",
    ]
    for name in PARTS:
        for line in results.get(name, {}).get("rows", []):
            met = {True: "yes", False: "**missed**", None: ""}[line["met"]]
            lines.append(
                "| "
                + " | ".join(
                    [
                        line["what"],
                        line["carom"],
                        line["peer"],
                        line["ratio"],
                        line["reach"],
                        met,
                        line["accuracy"],
                        line["memory"],
                    ]
                )
                + " |"
            )
    missed = [line["what"] for name in PARTS for line in results.get(name, {}).get("rows", []) if line["met"] is False]
    lines += [
        "",
        f"Missed: {'; '.join(missed) or 'none'}.",
        "",
        "## Made with",
        "",
        "| part | command | commit | load of the machine before |",
        "|---|---|---|---|",
    ]
    lines += [
        f"| {name} | `{result['command']}` | {result['commit']} | {result['load']:.1f} |"
        for name in PARTS
        if (result := results.get(name))
    ]
    missing = [name for name in PARTS if name not in results]
    lines += [
        "",
        f"{CORES} cores, {memory:.0f} GB of memory, {sys.platform}; Python {sys.version.split()[0]}, {packages}; {output('rustc', '--version').split(' (')[0]}.",
    ]
    return "\n".join(lines + ([f"Not measured: {', '.join(missing)}."] if missing else [])) + "\n"


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument(
        "parts", nargs="*", help=f"measured anew; all that are missing where none is named. Of {', '.join(PARTS)}"
    )
    parser.add_argument(
        "--small", action="store_true", help="few strikes and runs, to try the harness; writes its page beside the outcomes"
    )
    args = parser.parse_args()
    unknown = [name for name in args.parts if name not in PARTS]
    if unknown:
        parser.error(f"no part is called {', '.join(unknown)}; there are {', '.join(PARTS)}")
    kept = ROOT / OUT / ("small.json" if args.small else "outcomes.json")
    results = json.loads(kept.read_text()) if kept.exists() else {}
    size = lambda large, small: small if args.small else large
    for name in args.parts or [name for name in PARTS if name not in results]:
        print(f"bench: {name}", file=sys.stderr, flush=True)
        load = os.getloadavg()[0]
        rows = PARTS[name](size)
        command = f"make bench PARTS={name}" + (" SMALL=1" if args.small else "")
        results[name] = dict(rows=rows, command=command, commit=output("git", "rev-parse", "--short", "HEAD"), load=load)
        kept.write_text(json.dumps(results, indent=1))
        for line in rows:
            print(
                f"  {line['what']}: {line['carom']}; {line['peer']}; {line['ratio']} ({line['reach']})",
                file=sys.stderr,
                flush=True,
            )
    (ROOT / (OUT / "small.md" if args.small else "tests/BENCH.md")).write_text(page(results))


if __name__ == "__main__":
    main()
