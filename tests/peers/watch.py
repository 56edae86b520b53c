"""Servers of Foxglove's own SDK, whose live topics the executor's client must read: JSON, ROS 2's CDR, protobuf.

Those of the Python package run here; those of the Rust crate are a program of their own.

Usage: watch.py ARM_WATCH FOXGLOVE_SERVER
"""

import json
import math
import struct
import subprocess
import sys
import threading
import time

import foxglove
from foxglove.channels import PoseInFrameChannel
from foxglove.messages import Pose, PoseInFrame, Quaternion, Vector3

PLACE = (0.31, -0.07)
YAW = 0.02
POINT_STAMPED = """std_msgs/Header header
geometry_msgs/Point point
================================================================================
MSG: std_msgs/Header
builtin_interfaces/Time stamp
string frame_id
================================================================================
MSG: builtin_interfaces/Time
int32 sec
uint32 nanosec
================================================================================
MSG: geometry_msgs/Point
float64 x
float64 y
float64 z
"""


def as_json(context):
    channel = foxglove.Channel(
        "/object/centroid",
        schema={"type": "object"},
        context=context,
    )

    def publish(now):
        stamp = {"sec": int(now), "nanosec": int(now % 1 * 1e9)}
        point = {"x": PLACE[0], "y": PLACE[1], "z": 0.0}
        channel.log({"header": {"stamp": stamp, "frame_id": "table"}, "point": point})

    return publish


def as_cdr(context):
    channel = foxglove.Channel(
        "/object/centroid",
        schema=foxglove.Schema(
            name="geometry_msgs/msg/PointStamped",
            encoding="ros2msg",
            data=POINT_STAMPED.encode(),
        ),
        message_encoding="cdr",
        context=context,
    )

    def publish(now):
        header = struct.pack("<4siII6s6x", b"\0\1\0\0", int(now), int(now % 1 * 1e9), 6, b"table\0")
        channel.log(header + struct.pack("<3d", *PLACE, 0.0))

    return publish


def as_protobuf(context):
    channel = PoseInFrameChannel("/object/pose", context=context)

    def publish(_now):
        half = YAW / 2
        pose = Pose(
            position=Vector3(x=PLACE[0], y=PLACE[1], z=0.0),
            orientation=Quaternion(x=0.0, y=0.0, z=math.sin(half), w=math.cos(half)),
        )
        channel.log(PoseInFrame(frame_id="table", pose=pose))

    return publish


def check(server, name, watch, port):
    """What the executor reads of a server is where the object was published, in the encoding that it was published in."""
    url = f"ws://127.0.0.1:{port}"
    output = subprocess.run([watch, url], capture_output=True, text=True, timeout=30)
    assert output.returncode == 0, output.stderr
    seen = json.loads(output.stdout)
    assert abs(seen["x"] - PLACE[0]) < 1e-9 and abs(seen["y"] - PLACE[1]) < 1e-9, seen
    assert seen["encoding"] == name, seen
    assert seen["messages"] > 60 and seen["left_out"] is None, seen
    if name == "protobuf":
        assert abs(seen["yaw"] - YAW) < 1e-9, seen
    print(f"{server}, {name}: {seen}")


def of_package(watch, name, publisher):
    context = foxglove.Context()
    server = foxglove.start_server(name="a lab", port=0, context=context)
    publish = publisher(context)
    ends = threading.Event()

    def run():
        while not ends.is_set():
            publish(time.time())
            time.sleep(1 / 60)

    thread = threading.Thread(target=run)
    thread.start()
    try:
        check("foxglove-sdk of PyPI", name, watch, server.port)
    finally:
        ends.set()
        thread.join()
        server.stop()


def of_crate(watch, name, program):
    pipes = {"stdin": subprocess.PIPE, "stdout": subprocess.PIPE}
    with subprocess.Popen([program, name], text=True, **pipes) as server:
        try:
            check("crate foxglove", name, watch, int(server.stdout.readline()))
        finally:
            server.stdin.close()


def main():
    watch, program = sys.argv[1:]
    for name, publisher in [("json", as_json), ("cdr", as_cdr), ("protobuf", as_protobuf)]:
        of_package(watch, name, publisher)
        of_crate(watch, name, program)


if __name__ == "__main__":
    main()
