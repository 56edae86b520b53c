"""OpenCV's marker detector on a log's images: corners to a fraction of a pixel, then the pose by `solvePnP`, or the corners at the known height."""

import json
import pathlib
import sys
import time
import tomllib

import cv2
import numpy as np
from mcap.reader import make_reader

cv2.setNumThreads(1)


def images(log, topic):
    with open(log, "rb") as file:
        for _, _, message in make_reader(file).iter_messages(topics=[topic]):
            # A JPEG ends its sensor_msgs/CompressedImage.
            data = message.data[message.data.index(b"\xff\xd8") :]
            yield cv2.imdecode(np.frombuffer(data, np.uint8), cv2.IMREAD_GRAYSCALE)


def turned(orientation):
    x, y, z, w = orientation
    return np.array(
        [
            [1 - 2 * (y * y + z * z), 2 * (x * y - z * w), 2 * (x * z + y * w)],
            [2 * (x * y + z * w), 1 - 2 * (x * x + z * z), 2 * (y * z - x * w)],
            [2 * (x * z - y * w), 2 * (y * z + x * w), 1 - 2 * (x * x + y * y)],
        ]
    )


def object_at(centre, yaw, marker):
    """The object's centre and yaw from the marker's."""
    yaw -= marker["yaw"]
    c, s = np.cos(yaw), np.sin(yaw)
    x, y = marker["offset"]
    return [centre[0] - c * x + s * y, centre[1] - s * x - c * y, yaw]


def main():
    folder = pathlib.Path(sys.argv[1])
    rig = tomllib.loads((folder / "rig.toml").read_text())
    camera, marker = rig["camera"], rig["object"]["marker"]
    height = 2 * rig["object"].get("half_height", 0) or 2 * rig["object"]["half_size"][2]
    fx, fy, cx, cy = camera["matrix"]
    matrix, lens = np.array([[fx, 0, cx], [0, fy, cy], [0, 0, 1]]), np.array(camera["distortion"])
    axes, place = turned(camera["orientation"]), np.array(camera["position"])
    settings = cv2.aruco.DetectorParameters()
    settings.cornerRefinementMethod = cv2.aruco.CORNER_REFINE_SUBPIX
    book = cv2.aruco.getPredefinedDictionary(getattr(cv2.aruco, marker["dictionary"]))
    detector = cv2.aruco.ArucoDetector(book, settings)
    half = marker["size"] / 2
    square = np.array([[-half, half, 0], [half, half, 0], [half, -half, 0], [-half, -half, 0]])
    seen, begun = [], time.perf_counter()
    for image in images(folder / "log.mcap", rig["topics"]["image"]["name"]):
        corners, ids, _ = detector.detectMarkers(image)
        mine = [] if ids is None else [c[0] for c, i in zip(corners, ids.flatten()) if i == marker["id"]]
        if len(mine) != 1:
            seen.append(None)
            continue
        _, turn, move = cv2.solvePnP(square, mine[0].astype(float), matrix, lens, flags=cv2.SOLVEPNP_IPPE_SQUARE)
        rotation = axes @ cv2.Rodrigues(turn)[0]
        pnp = object_at(place + axes @ move[:, 0], np.arctan2(rotation[1, 0], rotation[0, 0]), marker)
        rays = np.c_[cv2.undistortPoints(mine[0][:, None].astype(float), matrix, lens)[:, 0], np.ones(4)] @ axes.T
        points = place[:2] + ((height - place[2]) / rays[:, 2:]) * rays[:, :2]
        right = points[1] + points[2] - points[0] - points[3]
        seen.append([pnp, object_at(points.mean(0), np.arctan2(right[1], right[0]), marker)])
    print(json.dumps({"found": seen, "seconds": time.perf_counter() - begun}))


main()
