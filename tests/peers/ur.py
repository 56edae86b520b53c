"""Reads the emulated controller of Universal Robots with ur-rtde's receive and dashboard interfaces, unchanged, while a script moves it.

    ur.py EMULATOR
"""

import math
import socket
import subprocess
import sys
import time

from dashboard_client import DashboardClient
from rtde_receive import RTDEReceiveInterface

ADDRESS = "127.0.0.1"
RUNNING, NORMAL = 7, 1


def main():
    process = subprocess.Popen([sys.argv[1], "ur", ADDRESS], stdout=subprocess.PIPE, text=True)
    try:
        process.stdout.readline()
        print(f"{read()} answers of the emulator are what ur-rtde documents")
    finally:
        process.terminate()
        process.wait()


def read():
    checks = 0

    def holds(name, is_so):
        nonlocal checks
        assert is_so, name
        checks += 1

    dashboard = DashboardClient(ADDRESS)
    dashboard.connect()
    holds("dashboard", dashboard.isConnected())
    holds("robot mode", "RUNNING" in dashboard.robotmode())
    holds("safety mode", "NORMAL" in dashboard.safetymode())
    holds("remote control", dashboard.isInRemoteControl())
    holds("version", "5.11" in dashboard.polyscopeVersion())
    holds("serial number", len(dashboard.getSerialNumber()) > 3)
    holds("idle", not dashboard.running())

    receive = RTDEReceiveInterface(ADDRESS)
    holds("RTDE", receive.isConnected())
    holds("running", receive.getRobotMode() == RUNNING)
    holds("normal", receive.getSafetyMode() == NORMAL)
    home = receive.getActualTCPPose()
    holds("pose", math.dist(home, [0.2, 0.0, 0.1, math.pi, 0.0, 0.0]) < 1e-6)
    begun = receive.getTimestamp()
    time.sleep(0.5)
    holds("clock", abs(receive.getTimestamp() - begun - 0.5) < 0.1)

    script = socket.create_connection((ADDRESS, 30001))
    script.sendall(b"def go():\n  movel(p[0.5,0.05,0.1,3.141593,0,0], a=1.0, v=0.2)\nend\n")
    time.sleep(0.7)
    speed = receive.getActualTCPSpeed()
    holds("moves", abs(math.hypot(*speed[:3]) - 0.2) < 1e-3)
    holds("a program runs", receive.getRuntimeState() == 2)
    script.sendall(b"def halt():\n  stopl(8.0)\nend\n")
    time.sleep(0.3)
    rest = receive.getActualTCPPose()
    time.sleep(0.2)
    holds("stopped", receive.getActualTCPPose() == rest and 0.25 < rest[0] < 0.45)
    script.sendall(b"def go():\n  movel(p[0.3,0.0,0.1,3.141593,0,0], a=1.0, v=0.2)\nend\n")
    time.sleep(2.0)
    holds("arrived", math.dist(receive.getActualTCPPose()[:3], [0.3, 0.0, 0.1]) < 1e-6)
    receive.disconnect()
    dashboard.disconnect()
    return checks


if __name__ == "__main__":
    main()
