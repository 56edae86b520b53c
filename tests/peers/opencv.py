"""OpenCV on a folder of frames: the colour's range in HSV, or GrabCut from it, then contours and moments, on one thread."""

import json
import pathlib
import sys
import time

import cv2
import numpy as np

cv2.setNumThreads(1)
# The colour of the frames' object, in OpenCV's units (degrees / 2, 0 to 255).
LOW, HIGH = ((0, 115, 38), (10, 255, 255)), ((170, 115, 38), (180, 255, 255))
MARGIN = 12  # px about the object in which GrabCut works
ROUNDS = 5  # of GrabCut


def mask_of(image):
    hsv = cv2.cvtColor(image, cv2.COLOR_BGR2HSV)
    return cv2.bitwise_or(cv2.inRange(hsv, *LOW), cv2.inRange(hsv, *HIGH))


def largest(mask):
    contours, _ = cv2.findContours(mask, cv2.RETR_EXTERNAL, cv2.CHAIN_APPROX_NONE)
    return max(contours, key=cv2.contourArea, default=None)


def hsv(image):
    mask = mask_of(image)
    contour = largest(mask)
    if contour is None:
        return None
    left, top, width, height = cv2.boundingRect(contour)
    return moments(mask[top : top + height, left : left + width], left, top)


def grabcut(image):
    mask = mask_of(image)
    contour = largest(mask)
    if contour is None:
        return None
    left, top, width, height = cv2.boundingRect(contour)
    rows = slice(max(top - MARGIN, 0), top + height + MARGIN)
    columns = slice(max(left - MARGIN, 0), left + width + MARGIN)
    seen = mask[rows, columns]
    sure = cv2.erode(seen, np.ones((5, 5), np.uint8))
    near = cv2.dilate(seen, np.ones((5, 5), np.uint8))
    labels = np.full(seen.shape, cv2.GC_BGD, np.uint8)
    labels[near > 0] = cv2.GC_PR_BGD
    labels[seen > 0] = cv2.GC_PR_FGD
    labels[sure > 0] = cv2.GC_FGD
    models = np.zeros((1, 65)), np.zeros((1, 65))
    cv2.grabCut(np.ascontiguousarray(image[rows, columns]), labels, None, *models, ROUNDS, cv2.GC_INIT_WITH_MASK)
    object_ = np.isin(labels, (cv2.GC_FGD, cv2.GC_PR_FGD)).astype(np.uint8)
    return moments(object_, columns.start, rows.start)


def moments(mask, left, top):
    sums = cv2.moments(mask, binaryImage=True)
    return [sums["m10"] / sums["m00"] + left, sums["m01"] / sums["m00"] + top] if sums["m00"] else None


def main():
    folder, method, rounds = pathlib.Path(sys.argv[1]), {"hsv": hsv, "grabcut": grabcut}[sys.argv[2]], int(sys.argv[3])
    truth = json.loads((folder / "truth.json").read_text())
    files = [np.frombuffer((folder / frame["file"]).read_bytes(), np.uint8) for frame in truth]
    begun = time.perf_counter()
    for _ in range(rounds):
        found = [method(cv2.imdecode(data, cv2.IMREAD_COLOR)) for data in files]
    seconds = time.perf_counter() - begun

    # On the table, as if the centroid lay on it.
    camera = json.loads((folder / "rig.json").read_text())["camera"]
    fx, fy, cx, cy = camera["matrix"]
    matrix = np.array([[fx, 0, cx], [0, fy, cy], [0, 0, 1]])
    x, y, z, w = camera["orientation"]
    turned = np.array(
        [
            [1 - 2 * (y * y + z * z), 2 * (x * y - z * w), 2 * (x * z + y * w)],
            [2 * (x * y + z * w), 1 - 2 * (x * x + z * z), 2 * (y * z - x * w)],
            [2 * (x * z - y * w), 2 * (y * z + x * w), 1 - 2 * (x * x + y * y)],
        ]
    )
    places = []
    for pixel in found:
        if pixel is None:
            places.append(None)
            continue
        u, v = cv2.undistortPoints(np.array([[pixel]]), matrix, np.array(camera.get("distortion") or [0.0] * 5))[0, 0]
        ray = turned @ (u, v, 1.0)
        along = -camera["position"][2] / ray[2]
        places.append([camera["position"][i] + along * ray[i] for i in (0, 1)])
    pairs = [None if pixel is None else [pixel, place] for pixel, place in zip(found, places)]
    print(json.dumps({"seconds": seconds, "frames": rounds * len(files), "found": pairs}))


main()
