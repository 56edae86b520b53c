"""How long a run takes with any number of workers: a simulation of its events, on measured costs of jobs and of a file system.

As `carom work` does, workers go through the phases of a run in their order: whoever is free takes the dearest job that is left, and nobody goes on
before every answer of a phase is there. All operations on files are served by one file system, one after another.
"""

import fcntl
import heapq
import json
import os
import time
from concurrent.futures import ProcessPoolExecutor

# As a worker's: the pauses of one that waits, in s.
PAUSES = [0.02, 0.5]


def phases(out):
    """Of a worker that did everything: each phase of its run, with the seconds of its jobs."""
    (log,) = (out / "cache/work/workers").glob("*.jsonl")
    found = []
    for event in map(json.loads, log.read_text().splitlines()):
        if event["event"] == "found":
            found.append((event["stage"], []))
        elif event["event"] == "done":
            found[-1][1].append(event["seconds"])
    return [(stage, seconds) for stage, seconds in found if seconds]


def look(folder, _):
    with open(folder / "answer", "rb") as file:
        file.read()


def claim(folder, number):
    with open(folder / f"claim_{number % 100}", "a") as file:
        fcntl.flock(file, fcntl.LOCK_EX)


def write(folder, number):
    with open(folder / "aside", "wb") as file:
        file.write(bytes(10_000))
        os.fsync(file.fileno())
    os.rename(folder / "aside", folder / f"answer_{number % 100}")


def repeated(operation, folder, seconds):
    folder.mkdir(parents=True, exist_ok=True)
    (folder / "answer").write_bytes(bytes(10_000))
    began, count = time.monotonic(), 0
    while time.monotonic() - began < seconds:
        operation(folder, count)
        count += 1
    return count / (time.monotonic() - began)


def file_system(folder):
    """Seconds that one operation takes of a file system which as many processes as there are cores use at once."""
    cores = os.cpu_count()
    with ProcessPoolExecutor(cores) as pool:
        rate = lambda one: sum(pool.map(repeated, [one] * cores, [folder / str(core) for core in range(cores)], [2.0] * cores))
        return {one.__name__: 1 / rate(one) for one in (look, claim, write)}


def simulate(phases, workers, reading, costs):
    """Time of a run in s, and how much of it each phase took. `reading`: what every worker computes by itself, whoever else works."""
    served = 0.0

    def serve(at, seconds):
        """When the file system has done what was asked of it at this time."""
        nonlocal served
        served = max(served, at) + seconds
        return served

    queues = [sorted(seconds) for _, seconds in phases]
    left = [len(queue) for queue in queues]
    ends = [0.0] * len(phases)
    # When, who, in which phase, what next: it comes, is free, has computed, or waits so long.
    events = [(reading, worker, 0, "comes", 0.0) for worker in range(workers)]
    heapq.heapify(events)
    last = 0.0
    while events:
        at, worker, phase, what, pause = heapq.heappop(events)
        if phase == len(phases):
            last = max(last, at)
            continue
        if what == "comes":
            # It looks for every answer of the phase.
            at, what = serve(at, len(phases[phase][1]) * costs["look"]), "free"
        elif what == "computed":
            at, what = serve(at, costs["write"]), "free"
            left[phase] -= 1
            ends[phase] = max(ends[phase], at)
        elif queues[phase]:
            at, what = serve(at, costs["claim"]) + queues[phase].pop(), "computed"
        elif left[phase] == 0 and at >= ends[phase]:
            # What others answered it reads.
            at, phase, what, pause = serve(at, len(phases[phase][1]) * costs["look"]), phase + 1, "comes", 0.0
        else:
            pause = min(2 * pause, PAUSES[1]) or PAUSES[0]
            at = serve(at, costs["look"] + costs["claim"]) + pause
        heapq.heappush(events, (at, worker, phase, what, pause))
    spans = {}
    for (stage, _), begins, end in zip(phases, [reading, *ends], ends):
        spans[stage] = spans.get(stage, 0.0) + end - begins
    return last, spans


def grown(phases, times):
    """The phases with so many times as many logs. Beyond 8,000 strikes a share is learnt from, so that nothing else grows."""
    return [(stage, seconds * times if stage in ("ingest", "track") else seconds) for stage, seconds in phases]
