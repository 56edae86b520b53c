"""Work on many processes, stopped, killed at random, under a real Slurm, and on very many strikes; the page that is committed.

    cluster.py CAROM FOLDER PAGE [--small] [--strikes N] [PART …]

Parts: shards, stopped, kills, slurm, many, objects; the page is written once all have run with this commit. Exits with 1 and says what does not
hold.
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

import objects
import scaling
from checking import check, wrong
from slurm import NODES, Slurm

ROOT = Path(__file__).resolve().parent.parent.parent
PARTS = ["shards", "stopped", "kills", "slurm", "many", "objects"]
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

    def submit(cluster, out, array, rig):
        arguments = [str(word) for word in line("work", "OUT", rig=rig)[2:5]]
        options = ["sbatch", "--parsable", "--cpus-per-task=1", f"--output={FOLDER}/logs/slurm_%A_%a.log"]
        work = cluster.call(*options, f"--array=1-{array}", scripts / "work.sbatch", *arguments, "--out", out).strip()
        return work, cluster.call(*options, f"--dependency=afterok:{work}", scripts / "run.sbatch", *arguments, "--out", out).strip()

    def wait(cluster, job, act=lambda: None):
        while cluster.states(job):
            time.sleep(1)
            act()

    with Slurm(FOLDER / "slurm", CAROM.parent) as cluster:
        out, began = fresh("slurm_8"), time.monotonic()
        _, run = submit(cluster, out, 8, "rig")
        wait(cluster, run)
        check(version(out) == version(FOLDER / "one"), "Slurm, array of 8 and the run behind it: the bytes of one machine's version")
        rows["slurm_8"] = f"array of 8, then the run: {time.monotonic() - began:.0f} s, equal bytes"

        # Enough work that nodes are lost again and again.
        demo("many_rig", MANY)
        alone = Process(line("run", fresh("many_one"), rig="many_rig"), FOLDER / "logs/many_one.json")
        alone.ended()
        check(alone.code == 0, f"{MANY} strikes: the run ends with {alone.code}")
        out, began, array = fresh("slurm_lost"), time.monotonic(), 16 if words.small else 64
        work, run = submit(cluster, out, array, "many_rig")
        dice, lost, tasks, last = random.Random(3), 0, 0, time.monotonic()

        def lose():
            """Every 20 s a node is lost, and comes back when Slurm has seen that; what it had is queued again at once."""
            nonlocal lost, tasks, last
            running = {state.split()[2] for state in cluster.states(work) if "RUNNING" in state}
            if running and time.monotonic() - last > 20:
                node = dice.choice(sorted(running))
                tasks += cluster.lose(node)
                lost, last = lost + 1, time.monotonic()
                while "down" not in cluster.state(node) and "*" not in cluster.state(node):
                    time.sleep(1)
                cluster.start(node)
            # Two minutes' rest, and a launch that failed because its node was lost in that moment: Slurm drains the node and holds the task,
            # and an administrator takes both back.
            for node in NODES:
                if "drain" in cluster.state(node):
                    cluster.tell("update", f"NodeName={node}", "State=RESUME")
            for state in cluster.states(work):
                task = state.split()[0]
                if "BeginTime" in state:
                    cluster.tell("update", f"JobId={task}", "StartTime=now")
                elif "held" in state.lower():
                    cluster.tell("release", task)

        wait(cluster, run, lose)
        check(lost > 0 and tasks > 0, f"Slurm: {lost} nodes were lost with {tasks} workers on them")
        check(version(out) == version(FOLDER / "many_one"), f"Slurm, array of {array} with nodes lost: the bytes of one machine's version")
        rows["slurm_lost"] = f"{MANY:,} strikes, array of {array}, {lost} nodes lost with {tasks} workers at work: {time.monotonic() - began:.0f} s, equal bytes"


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


class Publisher:
    """A folder with a version that no other folder has."""

    def __init__(self, store, number):
        self.store, self.out = store, FOLDER / f"objects/publisher_{number}"
        command = [CAROM, "run", FOLDER / "objects/rig/logs", "--rig", FOLDER / "objects/rig/rig.toml", "--seed", str(number), "--out", self.out, "--quiet"]
        subprocess.run(command, capture_output=True)
        self.hash = json.loads((self.out / "versions/v0001/manifest.json").read_text())["sha256"]

    def push(self, place, *more, through=True):
        command = [CAROM, "artifacts", "push", f"s3://bucket/{place}", "--artifacts", self.out, *more]
        return subprocess.Popen(command, env=self.store.env(FOLDER / "objects", through), stdout=subprocess.PIPE, stderr=subprocess.PIPE, text=True)


def ended(process):
    out, errors = process.communicate()
    with open(FOLDER / "logs/objects.log", "a") as log:
        log.write(f"{process.args[1:3]} ended with {process.returncode}\n{out}{errors}\n")
    return process.returncode, out + errors


def in_use(store, place):
    """The hash of the whole version that `latest` names there, checked file by file; or what is wrong."""
    folder = f"{place}/versions/{store.get(place + '/latest').decode().strip()}"
    manifest = json.loads(store.get(f"{folder}/manifest.json"))
    whole = all(hashlib.sha256(store.get(f"{folder}/{name}")).hexdigest() == file["sha256"] for name, file in manifest["files"].items())
    return manifest["sha256"] if whole else "half a version"


def strike(store, place, data, *more, through=True):
    command = [CAROM.parent / "strike", "--artifacts", f"s3://bucket/{place}", "--from", "0.30", "0", "--to", "0.62", "0.06", *more]
    return subprocess.Popen(command, env=store.env(FOLDER / "objects", through, XDG_DATA_HOME=str(data)), stdout=subprocess.PIPE, stderr=subprocess.PIPE, text=True)


def remote():
    """Logs in an object store, and versions that are put there and copied from there, with faults in between."""
    shutil.rmtree(FOLDER / "objects", ignore_errors=True)
    rig, image = FOLDER / "objects/rig", (20 if words.small else 200) << 20
    subprocess.run([CAROM, "demo", "--strikes", "200", "--seed", "3", "--out", rig, "--quiet"], check=True, capture_output=True)
    with objects.Store(sys.executable) as store:
        reads(store, rig, image)
        first, *publishers = [Publisher(store, number) for number in range(7)]
        races(store, first, publishers)
        faults(store, first, publishers[0])
        told(store, first)
    everything = [path for path in [*(FOLDER / "objects").rglob("*"), FOLDER / "logs/objects.log"] if path.is_file()]
    found = [path for path in everything for secret in (objects.KEY, objects.SECRET) if secret.encode() in path.read_bytes()]
    check(not found, f"objects: credentials are in none of {len(everything)} files and messages {found or ''}")
    rows["secrets"] = f"in none of {len(everything)} files of runs, copies and messages"


def reads(store, rig, image):
    logs = sorted((rig / "logs").glob("*.mcap"))
    held = sum(map(objects.held, logs))
    objects.enlarge(logs[0], 9, image)
    line = [CAROM, "run", "--rig", rig / "rig.toml", "--quiet"]
    check(subprocess.run([*line, rig / "logs", "--out", FOLDER / "objects/local"], capture_output=True).returncode == 0, "objects: the run on local logs")
    for log in logs:
        store.put(f"logs/{log.name}", log.read_bytes())

    def run(out):
        store.faults()
        code, said = ended(subprocess.Popen([*line, "s3://bucket/logs", "--out", FOLDER / out], env=store.env(FOLDER / "objects"), stdout=subprocess.PIPE, stderr=subprocess.PIPE, text=True))
        check(code == 0 and version(FOLDER / out) == version(FOLDER / "objects/local"), f"objects: {out}: the bytes of local logs' version {said if code else ''}")
        return store.counts()[1]

    whole = run("objects/unhashed")
    sums = "".join(f"{hashlib.sha256(log.read_bytes()).hexdigest()}  {log.name}\n" for log in logs)
    store.put("logs/SHA256SUMS", sums.encode())
    moved, again = run("objects/hashed"), run("objects/hashed")
    share, size = moved / held, logs[0].stat().st_size
    check(share <= 1.2, f"objects: {share:.2f} of the bytes of the wanted topics' chunks were moved, of logs with {size >> 20} MB of images")
    rows["objects_read"] = f"| {len(logs)}, one with {size / 1e6:.0f} MB in 9 topics of images | {held / 1e6:.2f} MB | {moved / 1e6:.2f} MB | {share:.2f} | {whole / 1e6:.0f} MB | {again / 1e3:.1f} kB | equal |"
    print(rows["objects_read"], flush=True)


def races(store, first, publishers):
    count, winners, codes, began, before = 10 if words.small else 100, Counter(), Counter(), time.monotonic(), ""
    for race in range(count):
        place = f"races_{race // 10}"
        if race % 10 == 0:
            check(ended(first.push(place, through=False))[0] == 0, f"objects: {place} begins")
        before = store.get(f"{place}/latest").decode().strip()
        # Whoever won the last time has nothing to publish.
        racers = [publisher for publisher in [first, *publishers] if publisher.hash != in_use(store, place)][:6]
        running = [publisher.push(place, "--over", before, through=False) for publisher in racers]
        results = [ended(process) for process in running]
        won = [publisher for publisher, (code, _) in zip(racers, results) if code == 0]
        is_right = len(won) == 1 and in_use(store, place) == won[0].hash
        is_right = is_right and all(code == 4 and "is in use now" in said for code, said in results if code)
        if not is_right:
            check(False, f"objects: race {race}: {results}")
        winners[len(won)] += 1
        codes.update(code for code, _ in results)
    check(winners == {1: count}, f"objects: {count} races of 6 publishers: winners {dict(winners)}")
    rows["races"] = f"{count} races of 6 publishers in {time.monotonic() - began:.0f} s: one won each, and its version is in use, whole; the others ended with 4 and said which version is"


def faults(store, first, second):
    """Each fault at each request of a publication and of a load: once, and from there on."""
    hashes, outcomes, half, lost = (first.hash, second.hash), Counter(), 0, 0
    cases = [(fault, False) for fault in objects.FAULTS] + [("reset", True), ("503", True)]
    for fault, stays in cases:
        number, did = 1, True
        while did:
            place, did = f"faults_{fault}_{stays}_{number}", False
            store.faults()
            begun = ended(first.push(place))
            if begun[0]:
                check(False, f"objects: {place} begins: {begun}")

            def plan(request, method, path):
                nonlocal did
                is_it = request >= number if stays else request == number
                is_it = is_it and (fault != "stale" or "list-type" in path)
                did |= is_it or (fault == "stale" and request >= number)
                return fault if is_it else None

            store.faults(plan)
            code, said = ended(second.push(place))
            store.faults()
            now = in_use(store, place)
            half += now not in hashes
            lost += (code == 0) != (now == second.hash) and not stays
            lost += code != 0 and not stays
            lost += stays and code == 0 and now != second.hash
            outcomes[f"publish, {'from there on' if stays else 'once'}: {'done' if code == 0 else 'failed'}"] += 1
            # A load of that place, into nothing, and over a copy.
            kept = FOLDER / "objects/copies" / place
            store.faults(plan)
            code, said = ended(strike(store, place, kept))
            store.faults()
            half += any(path for path in kept.rglob("versions/v*") if not (path / "manifest.json").exists())
            lost += code != 0 and not stays
            outcomes[f"load, {'from there on' if stays else 'once'}: {'done' if code == 0 else 'failed'}"] += 1
            number += 1
    place, kept = "faults_503_False_1", FOLDER / "objects/copies/offline"
    check(ended(strike(store, place, kept))[0] == 0, "objects: a copy is made")
    for fault in ["reset", "503"]:
        store.faults(lambda *_: fault)
        code, said = ended(strike(store, place, kept))
        check(code == 0 and "is used, the last that was copied" in said, f"objects: offline by {fault}, it strikes with the copy and says so {'' if code == 0 else said}")
    store.faults()
    check(half == 0, f"objects: half versions under faults: {half}")
    check(lost == 0, f"objects: publications lost under faults: {lost}")
    rows["faults"] = "; ".join(f"{name} {count}" for name, count in sorted(outcomes.items()))
    rows["faults_total"] = f"{sum(outcomes.values())} cases"


def told(store, first):
    """What is said of what a person can mend, without the store's own words, which have a key's name in them."""
    said = "<Error><Code>{}</Code><AWSAccessKeyId>" + objects.KEY + "</AWSAccessKeyId></Error>"
    for code, status, word in [("RequestTimeTooSkewed", 403, "clock"), ("SignatureDoesNotMatch", 403, "AWS_SECRET_ACCESS_KEY"), ("InvalidAccessKeyId", 403, "AWS_ACCESS_KEY_ID"), ("AccessDenied", 403, "allow")]:
        store.faults(lambda *_: (status, [], said.format(code).encode()))
        ended_with, text = ended(first.push("told"))
        check(ended_with == 1 and word in text, f"objects: {code} is told with how to mend it: {text.strip()}")
    store.faults()
    code, text = ended(subprocess.Popen([CAROM, "artifacts", "push", "s3://no-such-bucket/x", "--artifacts", first.out], env=store.env(FOLDER / "objects"), stdout=subprocess.PIPE, stderr=subprocess.PIPE, text=True))
    check(code == 1 and "bucket" in text, f"objects: no bucket: {text.strip()}")
    code, text = ended(strike(store, "nothing/here", FOLDER / "objects/copies/none"))
    check(code == 2 and "latest" in text, f"objects: no version: {text.strip()}")
    secret = f"s3://{objects.KEY}:{objects.SECRET.replace('+', '')}@bucket/x"
    code, text = ended(subprocess.Popen([CAROM, "artifacts", "push", secret, "--artifacts", first.out], stdout=subprocess.PIPE, stderr=subprocess.PIPE, text=True))
    check(code == 2 and "environment" in text, f"objects: credentials in a URL are refused: {text.strip()}")


for file in ["work.yaml", "run.yaml"]:
    validated = subprocess.run([Path(sys.executable).parent / "kubernetes-validate", "--strict", ROOT / "pipeline/carom/cluster" / file], capture_output=True, text=True)
    check(validated.returncode == 0, f"{file}: {(validated.stdout + validated.stderr).strip()}")
commit = subprocess.run(["git", "describe", "--always", "--dirty", "--abbrev=9", "--exclude=*"], cwd=ROOT, capture_output=True, text=True).stdout.strip()
# Parts may be run one by one: a page is of one commit.
kept = FOLDER / f"rows_{commit}_{STRIKES}.json"
if kept.exists():
    rows.update(json.loads(kept.read_text()))
alone = one()
for part in words.parts:
    {"shards": lambda: shards(alone), "stopped": stopped, "kills": kills, "slurm": slurm, "many": many, "objects": remote}[part]()
    rows.setdefault("parts", []).append(part)
    if not wrong:
        kept.write_text(json.dumps(rows))
print(json.dumps(rows, indent=1))
if wrong:
    sys.exit(f"{len(wrong)} of what was checked do not hold")
if set(rows["parts"]) == set(PARTS) and not words.small:
    words.page.write_text((ROOT / "tests/peers/cluster.md").read_text().format(**rows, strikes=STRIKES, many_strikes=MANY, commit=commit, cores=os.cpu_count()))
