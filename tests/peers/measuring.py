"""Processes in turn, and what they gave as a row of the table."""

import json
import os
import pathlib
import statistics
import subprocess
import sys
import tempfile
import time

HERE = pathlib.Path(__file__).parent
ROOT = HERE.parent.parent
CORES = os.cpu_count()


def run(*command):
    """The JSON object on a process's last line, with its `wall` and `cpu` time (s) and peak `memory` (bytes), as the kernel counts."""
    command = [str(word) for word in command]
    with tempfile.TemporaryFile() as errors:
        begun = time.perf_counter()
        child = subprocess.Popen(command, stdout=subprocess.PIPE, stderr=errors, cwd=ROOT)
        output = child.stdout.read().decode()
        _, status, usage = os.wait4(child.pid, 0)
        wall = time.perf_counter() - begun
        child.returncode = os.waitstatus_to_exitcode(status)
        errors.seek(0)
        # 3: done, but some input was rejected; 4: refused by a gate, as a night is that is no better than the one before.
        if child.returncode not in (0, 3, 4):
            printed = errors.read().decode()[-2000:]
            sys.exit(f"failed to measure: `{' '.join(command)}` ended with {child.returncode}: {printed}")
    last = (output.strip().splitlines() or [""])[-1]
    answer = json.loads(last) if last.startswith("{") else {}
    return {**answer, "wall": wall, "cpu": usage.ru_utime + usage.ru_stime, "memory": usage.ru_maxrss * 1024}


def peer(name, *words):
    return run(sys.executable, HERE / f"{name}.py", *words)


def in_turn(runs, *measurements):
    """The results of each measurement: all of them once, and again, so that a machine that slows down slows all."""
    rounds = [[measure() for measure in measurements] for _ in range(runs)]
    return [list(results) for results in zip(*rounds)]


def spread(values, unit, scale=1.0):
    """Median, and least to greatest where there are several."""

    def shown(value):
        return f"{value:,.0f}" if abs(value) >= 1000 else f"{value:.3g}"

    values = [value * scale for value in values]
    around = f" [{shown(min(values))}, {shown(max(values))}]" if len(values) > 1 else ""
    return f"{shown(statistics.median(values))}{around} {unit}"


def megabytes(results):
    return f"{max(result['memory'] for result in results) / 1e6:,.0f} MB"


def row(what, carom, met=None, peer="", ratio="", reach="", accuracy="", memory=""):
    """A line of the table; `met` says whether `reach` was, none where nothing was to be."""
    return {
        "what": what,
        "carom": carom,
        "peer": peer,
        "ratio": ratio,
        "reach": reach,
        "met": met,
        "accuracy": accuracy,
        "memory": memory,
    }


def compared(what, mine, name, theirs, cost, unit, scale=1.0, least=1.0, accuracy=""):
    """A line whose ratio is the peer's cost over carom's, run by run; its median must be `least`. `cost` is of a result."""
    costs, other = [cost(result) for result in mine], [cost(result) for result in theirs]
    ratios = [b / a for a, b in zip(costs, other)]
    return row(
        what,
        spread(costs, unit, scale),
        statistics.median(ratios) >= least,
        f"{name}: {spread(other, unit, scale)}",
        spread(ratios, "×"),
        f"≥ {least:g} ×",
        accuracy,
        f"{megabytes(mine)}; {megabytes(theirs)}",
    )


def limited(what, values, cpu, unit, scale, most, accuracy="", memory=""):
    """A line whose median must be at most `most`, in the unit shown; `cpu` is the processor time of the same, whatever ran beside."""
    met = statistics.median(values) * scale <= most
    beside = f"processor time {spread(cpu, unit, scale)}"
    return row(what, spread(values, unit, scale), met, ratio=beside, reach=f"≤ {most:g} {unit}", accuracy=accuracy, memory=memory)
