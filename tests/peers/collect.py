"""A collection on the emulated arm that is ended by signals in the middle of a strike, and goes on.

Usage: collect.py MAKER ARM_EMULATOR CAROM FOLDER, of the maker xarm or ur
"""

import json
import math
import os
import pathlib
import resource
import shutil
import signal
import socket
import struct
import subprocess
import sys
import threading
import time

import rtde_receive

HOST = "127.0.0.1"
STOPPED = 4
NO_PROGRAM = 1
# A tip that is faster than this, in mm/s, and lower than this, in mm, strikes: travel is at most 100 mm/s.
STRIKING = 150.0
LOW = 25.0
# A machine may stall so often.
STALLS = 8


class Reports:
    """The arm's real-time report, as another program sees it."""

    def __init__(self, maker):
        self.is_stopped, self.speed, self.height = False, 0.0, 0.0
        if maker == "ur":
            self.stream = rtde_receive.RTDEReceiveInterface(HOST)
        else:
            self.stream = socket.create_connection((HOST, 30000), timeout=5)
        threading.Thread(target=self.read_ur if maker == "ur" else self.read, daemon=True).start()

    def read_ur(self):
        while self.stream.isConnected():
            self.height = self.stream.getActualTCPPose()[2] * 1e3
            self.speed = math.hypot(*self.stream.getActualTCPSpeed()[:3]) * 1e3
            self.is_stopped = self.stream.getRuntimeState() == NO_PROGRAM
            time.sleep(0.001)

    def read(self):
        waiting = b""
        while True:
            waiting += self.stream.recv(4096)
            while len(waiting) >= 804:
                frame, waiting = waiting[:804], waiting[804:]
                self.is_stopped = frame[12] & 0x0F == STOPPED
                self.height = struct.unpack_from("<f", frame, 472 + 8)[0]
                self.speed = math.hypot(*struct.unpack_from("<3f", frame, 496))

    def wait_for_strike(self, start):
        """A program that strikes now. One that a machine ends which stalls for longer than reports may be missing is started again."""
        for _ in range(STALLS):
            program = start(14)
            while program.poll() is None:
                if self.speed > STRIKING and self.height < LOW:
                    return program
                time.sleep(0.002)
            _, printed = program.communicate()
            assert "no report came for" in printed, f"it ended before it struck: {printed}"
            print(f"started again: {printed.splitlines()[-1]}")
        raise AssertionError("this machine stalls")


def rig(carom, folder, maker):
    subprocess.run([carom, "demo", "--strikes", "1", "--hide", "none", "--out", folder / "demo"], check=True)
    arm = """
base = [0.0, 0.0]
keep_out = 0.1
reach = [0.1, 0.9]
jerk = 100.0
strike_height = 0.02
travel_height = 0.1
tool_orientation = [3.14159265, 0.0, 0.0]
tool_offset = [0.0, 0.0, 0.1, 0.0, 0.0, 0.0]
payload = 0.3
"""
    lines = (folder / "demo/rig.toml").read_text().splitlines()
    at = next(i for i, line in enumerate(lines) if line.startswith("acceleration"))
    # A line of Universal Robots has no limit of jerk.
    lines[at] += arm if maker == "xarm" else arm.replace("jerk = 100.0\n", "")
    (folder / "rig.toml").write_text("\n".join(lines) + "\n")
    return folder / "rig.toml"


def main():
    maker, emulator, carom, folder = *sys.argv[1:4], pathlib.Path(sys.argv[4])
    shutil.rmtree(folder, ignore_errors=True)
    folder.mkdir(parents=True)
    os.environ["XDG_STATE_HOME"] = str(folder.resolve())
    file, logs = rig(carom, folder, maker), folder / "logs"
    command = [carom, "collect", "--rig", file, "--robot", f"{maker}:{HOST}", "--watch", f"ws://{HOST}:8765"]
    command += ["--out", logs, "--pause", "0.5", "--json", "--quiet"]
    unsigned = list(command)
    subprocess.run([carom, "key", "new", "--out", folder / "carom.key"], check=True)
    command += ["--key", folder / "carom.pub"]

    def start(strikes):
        return subprocess.Popen(
            command + ["--strikes", str(strikes)], stdout=subprocess.PIPE, stderr=subprocess.PIPE, text=True
        )

    def listen():
        arm = subprocess.Popen([emulator, maker, HOST, folder / "demo/truth.json"], stdout=subprocess.PIPE, text=True)
        assert "listens" in arm.stdout.readline()
        return arm

    arm = listen()
    try:
        reports = Reports(maker)
        full = subprocess.run(
            command + ["--strikes", "1"],
            capture_output=True,
            text=True,
            preexec_fn=lambda: resource.setrlimit(resource.RLIMIT_FSIZE, (1 << 20, 1 << 20)),
        )
        assert full.returncode == 1 and "room" in full.stderr, full
        refused = subprocess.run(unsigned + ["--strikes", "1"], capture_output=True, text=True)
        assert refused.returncode == 4 and "key" in refused.stderr, refused
        # Where nobody reads standard error, nobody would be told to step back.
        unread, deaf = os.pipe()
        os.close(unread)
        unheard = subprocess.run(command + ["--strikes", "1"], stdout=subprocess.DEVNULL, stderr=deaf)
        os.close(deaf)
        assert unheard.returncode == 4 and not list(logs.glob("*.mcap")), unheard
        assert reports.speed == 0.0
        print("standard error without a reader: nothing moves, exit code 4")
        # Where it is full and nobody takes it, nothing moves either, and the program still ends.
        unread, full = os.pipe()
        os.set_blocking(full, False)
        try:
            while os.write(full, b" "):
                pass
        except BlockingIOError:
            os.set_blocking(full, True)
        held = subprocess.Popen(command + ["--strikes", "1"], stdout=subprocess.DEVNULL, stderr=full)
        time.sleep(5)
        assert held.poll() is None and reports.speed == 0.0
        held.send_signal(signal.SIGTERM)
        code = held.wait(timeout=20)
        assert code == 1 and not list(logs.glob("*.mcap")), code
        os.close(unread)
        os.close(full)
        print("standard error that is full and that nobody takes: nothing moves, and a signal ends it, exit code 1")
        first = start(14)
        time.sleep(1.5)
        second = subprocess.run([folder / "other" if part == logs else part for part in command] + ["--strikes", "1"], capture_output=True, text=True)
        assert second.returncode == 75, second
        first.send_signal(signal.SIGINT)
        first.communicate(timeout=30)
        # Held after somebody was told to step back, as by a computer that sleeps: that is told again.
        held = subprocess.Popen(
            [part if part != "0.5" else "2" for part in command] + ["--strikes", "1"],
            stdout=subprocess.PIPE, stderr=subprocess.PIPE, text=True
        )
        told = 0
        for line in held.stderr:
            told += "the arm moves in" in line
            if told == 1 and "the arm moves in" in line:
                held.send_signal(signal.SIGSTOP)
                time.sleep(4)
                held.send_signal(signal.SIGCONT)
            if told > 1 or "moves now" in line:
                break
        assert told > 1, "the arm moves, and nobody was told since the program was held"
        held.send_signal(signal.SIGINT)
        held.communicate(timeout=30)
        print("held for 4 s after it was told to step back: that is told again")
        for name in (signal.SIGINT, signal.SIGTERM, signal.SIGHUP, signal.SIGQUIT, signal.SIGTSTP):
            program = reports.wait_for_strike(start)
            begun = time.time()
            program.send_signal(name)
            while not reports.is_stopped:
                assert time.time() - begun < 1.0, "the arm was not stopped"
                time.sleep(0.001)
            stopped = time.time() - begun
            _, printed = program.communicate(timeout=30)
            # With --quiet, too.
            assert "put the object near" in printed and "step back" in printed, printed
            assert program.returncode == 1, (program.returncode, printed)
            assert "signal" in printed, printed
            assert reports.speed == 0.0
            print(f"{name.name} in the middle of a strike: stopped {stopped * 1e3:.0f} ms after it, exit code 1")
        # The reader of standard error is gone in the middle of a strike, which is ended and kept; none follows.
        before = len(list(logs.glob("*.mcap")))
        program = reports.wait_for_strike(start)
        program.stderr.close()
        program.stdout.close()
        code = program.wait(timeout=60)
        assert code in (1, 4) and reports.speed == 0.0, code
        assert len(list(logs.glob("*.mcap"))) == before + 1
        print(f"the reader of standard error gone in the middle of a strike: it is kept, no other follows, exit code {code}")
        # Arm and camera die together: what a person must do is said before anything is waited for.
        program = reports.wait_for_strike(start)
        arm.kill()
        died = time.time()
        for line in program.stderr:
            if "emergency stop" in line.lower():
                break
        said = time.time() - died
        assert said < 1.0, f"the emergency stop was asked for {said:.1f} s late"
        program.communicate(timeout=60)
        assert program.returncode == 1, program.returncode
        print(f"arm and camera dead in the middle of a strike: the emergency stop asked for after {said * 1e3:.0f} ms")
        arm.wait()
        arm = listen()
        reports = Reports(maker)
        # Nobody can send a stop after kill -9: an xArm's controller ends the line that it was sent, one of Universal Robots stops it where
        # signs of life cease.
        program = reports.wait_for_strike(start)
        program.kill()
        program.wait()
        begun = time.time()
        while reports.speed > 0.0:
            assert time.time() - begun < 8.0, "the arm goes on"
            time.sleep(0.001)
        print(f"kill -9 in the middle of a strike: the arm rests after {(time.time() - begun) * 1e3:.0f} ms")
        assert maker == "xarm" or time.time() - begun < 1.0, "the controller did not stop it"
        # No log has this strike, which is told: where the object rests first it is not struck, until the hand has put it elsewhere.
        lost = 0
        # A machine that stalls for longer than reports may be missing ends a collection, too: the same command goes on.
        for stalls in range(STALLS):
            program = start(14)
            out, printed = program.communicate(timeout=300)
            lost += "no record of it was written" in printed
            if not (program.returncode == 1 and "no report came for" in printed):
                break
        print(f"ended by missing reports of a machine that stalled: {stalls} times")
        assert program.returncode in (0, 3), (program.returncode, printed)
        assert lost >= 1, f"a strike was lost, and nobody is told: {printed}"
        done = json.loads(out)
        assert done["strikes"] == 14 and pathlib.Path(done["session"]).exists(), done
        assert [path.name for path in logs.glob("*.mcap")] == ["session_000001.mcap"]
        print(f"after all of these the same command went on: {done}")
    finally:
        arm.send_signal(signal.SIGINT)
        print(arm.communicate(timeout=10)[0].strip())


if __name__ == "__main__":
    main()
