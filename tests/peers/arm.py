"""Drives the emulated xArm7 with the maker's own SDK, unchanged, and keeps the bytes that it sends for each call.

    arm.py EMULATOR FIXTURES    starts the emulator, drives it, writes `name hex` lines (or compares, with --check)
"""

import math
import subprocess
import sys
import time

from xarm.core.comm import base
from xarm.wrapper import XArmAPI

ADDRESS = "127.0.0.1"
SET_FEEDBACK = 254
HOME = [200.0, 0.0, 100.0, math.pi, 0.0, 0.0]

sent = []
write = base.Port.write


def recording_write(port, data):
    """Notes what goes out on the control port; the SDK itself is left as it is."""
    if port.port_type == "main-socket":
        sent.append(bytes(data))
    return write(port, data)


base.Port.write = recording_write


def main():
    emulator, fixtures, *rest = sys.argv[1:]
    process = subprocess.Popen([emulator, "xarm", ADDRESS], stdout=subprocess.PIPE, text=True)
    try:
        process.stdout.readline()
        calls, bytes_of = drive()
    finally:
        process.terminate()
        process.wait()
    text = "".join(f"{name} {frame}\n" for name, frame in sorted(bytes_of.items()))
    if "--check" in rest:
        with open(fixtures, encoding="utf-8") as file:
            assert file.read() == text, f"the SDK sends other bytes than {fixtures} holds:\n{text}"
    else:
        with open(fixtures, "w", encoding="utf-8") as file:
            file.write(text)
    print(f"{calls} calls of the SDK behave as it documents; {len(bytes_of)} frames {'compared with' if '--check' in rest else 'written to'} {fixtures}")


def drive():
    arm = XArmAPI(ADDRESS, is_radian=True, report_type="rich", check_joint_limit=False)
    calls = 0
    bytes_of = {}

    def call(name, function, *args, expected=0, **kwargs):
        """One call: its code, and the frame of its own register, numbered as if it were the first."""
        nonlocal calls
        before = len(sent)
        answer = function(*args, **kwargs)
        code = answer[0] if isinstance(answer, (tuple, list)) else answer
        assert code == expected, f"{name}: code {code}, expected {expected}"
        calls += 1
        if len(sent) > before:
            # Once reports flow, this SDK asks for heartbeats by protocol 3; a frame is otherwise the same.
            # A motion that is waited for asks to be told of its end first.
            own = next(frame for frame in sent[before:] if frame[6] != SET_FEEDBACK)
            bytes_of[name] = (b"\0\1\0\2" + own[4:]).hex()
        return answer

    def holds(name, is_so):
        nonlocal calls
        assert is_so, name
        calls += 1

    holds("connected", arm.connected)
    holds("axes", arm.axis == 7 and arm.device_type == 7)
    holds("firmware", arm.version_number == (2, 4, 0))
    call("get_version", arm.get_version)
    call("get_err_warn_code", arm.get_err_warn_code)
    call("motion_enable", arm.motion_enable, True)
    call("set_mode", arm.set_mode, 0)
    call("set_state_ready", arm.set_state, 0)
    state = call("get_state", arm.get_state)
    holds("ready", state[1] in (0, 2))
    call("set_tcp_jerk", arm.set_tcp_jerk, 100000)
    call("set_tcp_maxacc", arm.set_tcp_maxacc, 5000)
    pose = call("get_position", arm.get_position)
    holds("pose", max(abs(a - b) for a, b in zip(pose[1], HOME)) < 1e-3)
    time.sleep(0.5)
    holds("reports", abs(arm.position[2] - 100) < 1e-3 and arm.error_code == 0)
    holds("tool", abs(arm.tcp_offset[2] - 100) < 1e-3 and abs(arm.tcp_load[0] - 0.3) < 1e-6)

    holds("settings", arm.collision_sensitivity == 3 and arm.gravity_direction == [0.0, 0.0, -1.0] and arm.world_offset == [0.0] * 6)
    holds("modes", not (arm.is_simulation_robot or arm.is_reduced_mode or arm.is_fence_mode))
    holds("ramp", abs(arm.tcp_jerk - 100000) < 1 and abs(arm.tcp_acc_limit[1] - 5000) < 1)

    # A line, waited for: the tip is where it was commanded to be.
    line = dict(x=300, y=50, z=80, roll=math.pi, pitch=0, yaw=0, speed=200, mvacc=2000)
    call("set_position", arm.set_position, wait=True, timeout=10, **line)
    pose = call("get_position_after", arm.get_position)[1]
    holds("arrived", max(abs(a - b) for a, b in zip(pose, [300, 50, 80])) < 0.1)

    # A line, stopped in its middle: it rests on the way, and takes no motion before it is made ready again.
    call("set_position_back", arm.set_position, **{**line, "x": 600, "speed": 100})
    time.sleep(0.6)
    holds("moving", arm.get_state()[1] == 1)
    call("set_state_stop", arm.set_state, 4)
    time.sleep(0.5)
    holds("stopped", arm.get_state()[1] == 4)
    rest = arm.get_position()[1]
    holds("on the way", 305 < rest[0] < 590)
    time.sleep(0.3)
    holds("at rest", arm.get_position()[1] == rest)
    assert arm.set_position(wait=False, **line) != 0, "a stopped arm takes a motion"
    calls += 1
    call("motion_enable_again", arm.motion_enable, True)
    call("set_state_again", arm.set_state, 0)
    call("set_position_again", arm.set_position, wait=True, timeout=10, **line)
    holds("arrived again", abs(arm.get_position()[1][0] - 300) < 0.1)

    # The SDK's emergency stop stops.
    arm.set_position(**{**line, "x": 600, "speed": 100})
    time.sleep(0.4)
    arm.emergency_stop()
    time.sleep(0.3)
    rest = arm.get_position()[1]
    time.sleep(0.3)
    holds("emergency stop", arm.get_position()[1] == rest and rest[0] < 590)
    call("clean_error", arm.clean_error)
    call("clean_warn", arm.clean_warn)
    arm.disconnect()
    return calls, bytes_of


if __name__ == "__main__":
    main()
