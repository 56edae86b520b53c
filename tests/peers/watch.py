"""Servers of Foxglove's own SDK, whose live topics the executor's client must read: JSON, ROS 2's CDR, protobuf.

Usage: watch.py ARM_WATCH
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


def main():
    watch = sys.argv[1]
    for name, make in [("json", as_json), ("cdr", as_cdr), ("protobuf", as_protobuf)]:
        context = foxglove.Context()
        server = foxglove.start_server(name="a lab", port=0, context=context)
        publish = make(context)
        ends = threading.Event()

        def run():
            while not ends.is_set():
                publish(time.time())
                time.sleep(1 / 60)

        thread = threading.Thread(target=run)
        thread.start()
        try:
            url = f"ws://127.0.0.1:{server.port}"
            output = subprocess.run([watch, url], capture_output=True, text=True, timeout=30)
        finally:
            ends.set()
            thread.join()
            server.stop()
        assert output.returncode == 0, output.stderr
        seen = json.loads(output.stdout)
        assert abs(seen["x"] - PLACE[0]) < 1e-9 and abs(seen["y"] - PLACE[1]) < 1e-9, seen
        assert seen["encoding"] == name, seen
        assert seen["messages"] > 60 and seen["left_out"] is None, seen
        if name == "protobuf":
            assert abs(seen["yaw"] - YAW) < 1e-9, seen
        print(f"foxglove-sdk, {name}: {seen}")


if __name__ == "__main__":
    main()
