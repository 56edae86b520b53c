"""Work on many processes, stopped, killed at random, under a real Slurm, and on very many strikes; the page that is committed.

    cluster.py CAROM FOLDER PAGE [--small] [--strikes N] [PART …]

Parts: shards, stopped, kills, slurm, many. Exits with 1 and says what does not hold.
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

import scaling
from checking import check, wrong
from slurm import Slurm

ROOT = Path(__file__).resolve().parent.parent.parent
PARTS = ["shards", "stopped", "kills", "slurm", "many"]
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
MANY = 2000 if words.small else 50_000
KILLS = 30 if words.small else 200
# No stage takes more than this share of the kills, so that each has its own.
MOST = KILLS // 4
rows = {}
# Ended from outside, it takes down what it set up.
signal.signal(signal.SIGTERM, lambda *_: sys.exit(1))


def line(command, out, *more, rig="rig", logs=None):
    return [CAROM, command, *(logs or [FOLDER / rig / "logs"]), "--rig", FOLDER / rig / "rig.toml", "--out", out, "--quiet", "--json", *map(str, more)]


def demo(rig, strikes):
    subprocess.run([CAROM, "demo", "--strikes", str(strikes), "--seed", "1", "--out", fresh(rig), "--quiet"], check=True, capture_output=True)


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
    demo("rig", STRIKES)
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


def stopped():
    """Three workers; one that is at a block is stopped, and its machine does not know: the others take its block again. It wakes up when they are gone."""
    out, began = fresh("stopped"), time.monotonic()
    workers = [Process(line("work", out, "--threads", 1, "--shard", f"{n}/3"), FOLDER / f"logs/stopped_{n}.json") for n in range(1, 4)]
    victim = None
    while victim is None:
        time.sleep(0.01)
        victim = next((worker for worker in workers if last_stage(out, worker.run.pid) == "solve"), None)
    os.kill(victim.run.pid, signal.SIGSTOP)
    is_held = last_stage(out, victim.run.pid) == "solve"
    others = [worker for worker in workers if worker is not victim]
    for worker in others:
        worker.ended()
    took = time.monotonic() - began
    said = subprocess.run([CAROM, "status", out], check=True, capture_output=True, text=True).stdout
    check("alive" in said and "computes solve" in said, "stopped: `carom status` says who is at which stage, and lives")
    os.kill(victim.run.pid, signal.SIGCONT)
    victim.ended()
    check([worker.code for worker in workers] == [0, 0, 0], "stopped: every worker ends with 0")
    gathered(out, "stopped")
    if is_held:
        rows["stopped"] = f"the two others ended after {took:.0f} s with every answer"


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


def many():
    """A run of very many strikes, for real; and on what it cost, with any number of workers, a simulation of it and of one twenty times as long."""
    demo("many_rig", MANY)
    logs = sorted((FOLDER / "many_rig/logs").iterdir())
    read, gather = [], []
    for count in [len(logs) // 5, len(logs)]:
        out = fresh("many")
        ended = []
        for command in ["work", "work", "run"]:
            process = Process(line(command, out, "--threads", 1, rig="many_rig", logs=logs[:count]), FOLDER / f"logs/many_{command}.json")
            process.ended()
            check(process.code == 0, f"{count} logs: `carom {command}` ends with {process.code}")
            ended.append(process)
            if len(ended) == 1:
                phases = scaling.phases(out)
        read.append(ended[1].seconds)
        gather.append(ended[2])
    strikes = MANY // 5, MANY
    check(gather[1].memory < 2000, f"{MANY} strikes: the gathering run holds {gather[1].memory:.0f} MB")

    def at(few, many, count):
        """On the line through both."""
        return many + (many - few) * (count - strikes[1]) / (strikes[1] - strikes[0])

    operations = scaling.file_system(FOLDER / "operations")
    slower = {name: 10 * seconds for name, seconds in operations.items()}
    table, alone = [], {}
    for workers in [1, 10, 100, 1000]:
        row, last = f"| {workers:,} |", None
        for times, costs in [(1, operations), (20, operations), (20, slower)]:
            reading, run = at(*read, times * MANY), at(*[one.seconds for one in gather], times * MANY)
            seconds, last = scaling.simulate(scaling.grown(phases, times), workers, reading, costs)
            first = alone.setdefault((times, costs["look"]), seconds + run)
            row += f" {seconds + run:,.0f} s | {first / (seconds + run):.1f} |"
            if times == 20 and costs is operations:
                where = f"reading every log {reading:.0f} s, " + ", ".join(f"`{stage}` {span:.0f} s" for stage, span in last.items()) + f", the run behind them {run:.0f} s"
        table.append(row)
        rows[f"where_{workers}"] = where
    rows["many"] = "\n".join(table)
    whole = sum(sum(seconds) for _, seconds in phases)
    rows["many_costs"] = f"{whole:.0f} s of jobs; a worker that finds every answer takes {read[1]:.1f} s, and the run that gathers them {gather[1].seconds:.1f} s and {gather[1].memory:.0f} MB ({read[0]:.1f} s, {gather[0].seconds:.1f} s and {gather[0].memory:.0f} MB with {strikes[0]:,} of the strikes)"
    rows["many_memory"] = f"{at(gather[0].memory, gather[1].memory, 20 * MANY) / 1000:.1f} GB"
    rows["operations"] = ", ".join(f"to {name} {1e6 * seconds:.0f} µs" for name, seconds in operations.items())


for file in ["work.yaml", "run.yaml"]:
    validated = subprocess.run([Path(sys.executable).parent / "kubernetes-validate", "--strict", ROOT / "pipeline/carom/cluster" / file], capture_output=True, text=True)
    check(validated.returncode == 0, f"{file}: {(validated.stdout + validated.stderr).strip()}")
alone = one()
for part in words.parts:
    {"shards": lambda: shards(alone), "stopped": stopped, "kills": kills, "slurm": slurm, "many": many}[part]()
print(json.dumps(rows, indent=1))
if wrong:
    sys.exit(f"{len(wrong)} of what was checked do not hold")
if words.parts == PARTS and not words.small:
    commit = subprocess.run(["git", "describe", "--always", "--dirty", "--abbrev=9", "--exclude=*"], cwd=ROOT, capture_output=True, text=True).stdout.strip()
    words.page.write_text((ROOT / "tests/peers/cluster.md").read_text().format(**rows, strikes=STRIKES, many_strikes=MANY, commit=commit, cores=os.cpu_count()))
