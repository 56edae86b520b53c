"""Work on many processes, killed at random, under a real Slurm; the page that is committed.

    cluster.py CAROM FOLDER PAGE [--small] [--strikes N] [PART …]

Parts: shards, kills, slurm. Exits with 1 and says what does not hold.
"""

import argparse
import hashlib
import json
import os
import random
import shutil
import signal
import subprocess
import sys
import time
from collections import Counter
from pathlib import Path

from checking import check, wrong
from slurm import Slurm

ROOT = Path(__file__).resolve().parent.parent.parent
PARTS = ["shards", "kills", "slurm"]
words = argparse.ArgumentParser()
words.add_argument("carom", type=Path)
words.add_argument("folder", type=Path)
words.add_argument("page", type=Path)
words.add_argument("--small", action="store_true")
words.add_argument("--strikes", type=int, default=5000)
words.add_argument("parts", nargs="*", default=PARTS)
words = words.parse_intermixed_args()
CAROM, FOLDER = words.carom.resolve(), words.folder.resolve()
STRIKES = 200 if words.small else words.strikes
KILLS = 30 if words.small else 200
# No stage takes more than this share of the kills, so that each has its own.
MOST = KILLS // 4
rows = {}
# Ended from outside, it takes down what it set up.
signal.signal(signal.SIGTERM, lambda *_: sys.exit(1))


def line(command, out, *more):
    return [CAROM, command, FOLDER / "rig/logs", "--rig", FOLDER / "rig/rig.toml", "--out", out, "--quiet", "--json", *map(str, more)]


class Process:
    """A command in the background, with what it cost."""

    def __init__(self, command, log):
        log.parent.mkdir(parents=True, exist_ok=True)
        self.log = log
        self.run = subprocess.Popen(command, stdout=open(log, "w"), stderr=open(log.with_suffix(".errors"), "w"))
        self.code = None

    def ended(self, options=0):
        """Whether it has; then with its exit code and its processor time in s."""
        if self.code is None:
            pid, status, usage = os.wait4(self.run.pid, options)
            if pid == 0:
                return False
            self.code = self.run.returncode = os.waitstatus_to_exitcode(status)
            self.seconds = usage.ru_utime + usage.ru_stime
            self.memory = usage.ru_maxrss / 1024
        return True

    def said(self):
        return json.loads(self.log.read_text())


def fresh(name):
    shutil.rmtree(FOLDER / name, ignore_errors=True)
    return FOLDER / name


def version(out):
    """One hash over all files of the version in use, signatures aside."""
    folder = out / "versions" / (out / "latest").read_text().strip()
    whole = hashlib.sha256()
    for path in sorted(folder.iterdir()):
        whole.update(path.name.encode() + b"\0" + path.read_bytes())
    return whole.hexdigest()


def computed(said):
    return Counter({stage["name"]: stage["computed"] for stage in said["stages"]})


def gathered(out, name):
    """The run after the work: it computes nothing, and publishes the bytes of one machine."""
    run = Process(line("run", out), FOLDER / f"logs/{name}.json")
    run.ended()
    check(run.code == 0, f"{name}: the run ends with {run.code}")
    count = sum(computed(run.said()).values())
    check(count == 0, f"{name}: the run computes {count} answers")
    check(version(out) == version(FOLDER / "one"), f"{name}: the bytes of one machine's version")
    return run


def one():
    """One process alone: what all others are compared with."""
    shutil.rmtree(FOLDER / "rig", ignore_errors=True)
    subprocess.run([CAROM, "demo", "--strikes", str(STRIKES), "--seed", "1", "--out", FOLDER / "rig", "--quiet"], check=True, capture_output=True)
    run = Process(line("run", fresh("one"), "--threads", 1), FOLDER / "logs/one.json")
    began = time.monotonic()
    run.ended()
    check(run.code == 0, f"one process: the run ends with {run.code}")
    rows["one"] = f"| 1 process (one thread) | {time.monotonic() - began:.0f} s | {run.seconds:.1f} s | 1 | {run.memory:.0f} MB | |"
    return run


def shards(alone):
    for count in [2, 8, 64]:
        out, began = fresh(f"shards_{count}"), time.monotonic()
        workers = [Process(line("work", out, "--threads", 1, "--shard", f"{n}/{count}"), FOLDER / f"logs/{count}_{n}.json") for n in range(1, count + 1)]
        for worker in workers:
            worker.ended()
        took = time.monotonic() - began
        codes = Counter(worker.code for worker in workers)
        check(codes == {0: count}, f"{count} shards: ended with {dict(codes)}")
        done = sum((computed(worker.said()) for worker in workers), Counter())
        check(done == +computed(alone.said()), f"{count} shards: each answer was computed once")
        run = gathered(out, f"shards_{count}")
        seconds = sum(worker.seconds for worker in workers) + run.seconds
        most = max(worker.memory for worker in workers)
        rows[f"shards_{count}"] = f"| {count} shards, then the run | {took:.0f} s | {seconds:.1f} s | {seconds / alone.seconds:.2f} | {most:.0f} MB | equal |"
        print(rows[f"shards_{count}"], flush=True)


def last_stage(out, process):
    """What a worker computes, by its own log; none before its first job."""
    for log in (out / "cache/work/workers").glob(f"*_{process}_*.jsonl"):
        events = [json.loads(text) for text in log.read_text().splitlines() if text.endswith("}")]
        took = [event for event in events if event["event"] in ("took", "done")]
        if took and took[-1]["event"] == "took":
            return took[-1]["stage"]
    return None


def kills():
    """Eight workers; while they work, one after another is killed in the midst of a job, and another takes its place. Again from nothing, until
    there were enough."""
    dice, began, killed, total, runs = random.Random(7), time.monotonic(), Counter(), 0, 0
    while total < KILLS:
        out, number, slots, codes = fresh("kills"), 0, {}, Counter()
        runs += 1
        while not codes[0] or slots:
            for worker in [worker for worker in slots if worker.ended(os.WNOHANG)]:
                codes[worker.code] += 1
                stage = slots.pop(worker)
                if worker.code == -signal.SIGKILL:
                    killed[stage] += 1
            while len(slots) < 8 and not codes[0]:
                number += 1
                slots[Process(line("work", out, "--threads", 1, "--shard", f"{number % 8 + 1}/8"), FOLDER / f"logs/killed_{number}.json")] = None
            time.sleep(dice.uniform(0, 0.1))
            at_work = [worker for worker in slots if slots[worker] is None]
            victim = dice.choice(at_work) if at_work else None
            stage = victim and last_stage(out, victim.run.pid)
            if stage and sum(killed.values()) < KILLS and killed[stage] < MOST * runs:
                slots[victim] = stage
                os.kill(victim.run.pid, signal.SIGKILL)
        total += codes[-signal.SIGKILL]
        failed = {code: count for code, count in codes.items() if code not in (0, -signal.SIGKILL)}
        check(not failed, f"kills: no worker failed {failed or ''}")
        status = json.loads(subprocess.run([CAROM, "status", out, "--json"], check=True, capture_output=True, text=True).stdout)
        states = Counter(worker["state"] for worker in status["workers"])
        check(states["killed"] == codes[-signal.SIGKILL], f"kills: `carom status` tells {dict(states)}")
        gathered(out, "kills")
        left = [*out.rglob("*.partial"), *(out / "cache").rglob("*.parts")]
        check(not left, f"kills: nothing is left aside {left or ''}")
    rows["kills"] = ", ".join(f"{count} in `{stage}`" for stage, count in killed.most_common())
    rows["kills_total"] = f"{total} kills in {time.monotonic() - began:.0f} s, in {runs} runs from nothing"


def slurm():
    scripts = ROOT / "pipeline/carom/cluster"
    arguments = [str(word) for word in line("work", "OUT")[2:5]]

    def submit(cluster, out, array):
        options = ["sbatch", "--parsable", "--cpus-per-task=1", f"--output={FOLDER}/logs/slurm_%A_%a.log"]
        work = cluster.call(*options, f"--array=1-{array}", scripts / "work.sbatch", *arguments, "--out", out).strip()
        return work, cluster.call(*options, f"--dependency=afterok:{work}", scripts / "run.sbatch", *arguments, "--out", out).strip()

    def wait(cluster, job, act=lambda: None):
        while cluster.states(job):
            time.sleep(1)
            act()

    with Slurm(FOLDER / "slurm", CAROM.parent) as cluster:
        out, began = fresh("slurm_8"), time.monotonic()
        _, run = submit(cluster, out, 8)
        wait(cluster, run)
        check(version(out) == version(FOLDER / "one"), "Slurm, array of 8 and the run behind it: the bytes of one machine's version")
        rows["slurm_8"] = f"array of 8, then the run: {time.monotonic() - began:.0f} s, equal bytes"

        out, began, array = fresh("slurm_lost"), time.monotonic(), 16 if words.small else 64
        work, run = submit(cluster, out, array)
        dice, lost, tasks, last = random.Random(3), 0, 0, time.monotonic()

        def lose():
            """Every 20 s a node is lost, and comes back when Slurm has seen that; what it had is queued again at once."""
            nonlocal lost, tasks, last
            running = {state.split()[2] for state in cluster.states(work) if "RUNNING" in state}
            if running and time.monotonic() - last > 20:
                node = dice.choice(sorted(running))
                tasks += cluster.lose(node)
                lost, last = lost + 1, time.monotonic()
                while "down" not in cluster.call("sinfo", "--noheader", "--Node", f"--nodes={node}", "--format=%T"):
                    time.sleep(1)
                cluster.start(node)
            # Two minutes' rest, and a launch that failed because its node was lost in that moment, which an administrator releases.
            for state in cluster.states(work):
                task = state.split()[0]
                if "BeginTime" in state:
                    cluster.tell("update", f"JobId={task}", "StartTime=now")
                elif "held" in state.lower():
                    cluster.tell("release", task)

        wait(cluster, run, lose)
        check(lost > 0 and tasks > 0, f"Slurm: {lost} nodes were lost with {tasks} workers on them")
        check(version(out) == version(FOLDER / "one"), f"Slurm, array of {array} with nodes lost: the bytes of one machine's version")
        rows["slurm_lost"] = f"array of {array}, {lost} nodes lost with {tasks} workers at work: {time.monotonic() - began:.0f} s, equal bytes"


for file in ["work.yaml", "run.yaml"]:
    validated = subprocess.run([Path(sys.executable).parent / "kubernetes-validate", "--strict", ROOT / "pipeline/carom/cluster" / file], capture_output=True, text=True)
    check(validated.returncode == 0, f"{file}: {(validated.stdout + validated.stderr).strip()}")
alone = one()
for part in words.parts:
    {"shards": lambda: shards(alone), "kills": kills, "slurm": slurm}[part]()
print(json.dumps(rows, indent=1))
if wrong:
    sys.exit(f"{len(wrong)} of what was checked do not hold")
if words.parts == PARTS and not words.small:
    commit = subprocess.run(["git", "describe", "--always", "--dirty", "--abbrev=9", "--exclude=*"], cwd=ROOT, capture_output=True, text=True).stdout.strip()
    words.page.write_text((ROOT / "tests/peers/cluster.md").read_text().format(**rows, strikes=STRIKES, commit=commit, cores=os.cpu_count()))
