"""The Python readers of MCAP on the two topics that carom reads: stamps and coordinates of every message."""

import json
import sys
import time

from mcap_ros2.reader import read_ros2_messages


def main():
    count, begun = 0, time.perf_counter()
    for path in sys.argv[1:]:
        centroids, commands = [], []
        for message in read_ros2_messages(path, topics=["/object/centroid", "/striker/command"]):
            content = message.ros_msg
            stamp = content.header.stamp.sec * 1_000_000_000 + content.header.stamp.nanosec
            if message.channel.topic == "/object/centroid":
                centroids.append((stamp, content.point.x, content.point.y))
            else:
                commands.append((stamp, content.twist.linear.x, content.twist.linear.y))
        count += len(centroids) + len(commands)
    print(json.dumps(dict(seconds=time.perf_counter() - begun, messages=count)))


if __name__ == "__main__":
    main()
