"""A log of large messages with its rig file, to see what memory it takes: FOLDER NAME. A red disc moves over a grey table with noise."""

import json
import pathlib
import struct
import sys

import cv2
import numpy as np
from av import VideoFrame
from mcap.writer import CompressionType, Writer

from video import Encoder

PLAIN, ZSTD = CompressionType.NONE, CompressionType.ZSTD
# Width, height, frames, encoding, bytes of a chunk, its compression, and bytes of a message of another topic behind each frame.
LOGS = {
    "raw 3840 × 2160, a frame a chunk": (3840, 2160, 8, "rgb8", 1, PLAIN, 0),
    "raw 3840 × 2160, two frames a chunk": (3840, 2160, 8, "rgb8", 26_000_000, PLAIN, 0),
    "the same, zstd": (3840, 2160, 8, "rgb8", 26_000_000, ZSTD, 0),
    "raw 1920 × 1080, nine frames a chunk": (1920, 1080, 36, "rgb8", 55_000_000, PLAIN, 0),
    "the same of 1920 × 1080, zstd": (1920, 1080, 36, "rgb8", 55_000_000, ZSTD, 0),
    "raw 1280 × 720, chunks of 60 MB": (1280, 720, 60, "rgb8", 58_000_000, PLAIN, 0),
    "JPEG 3840 × 2160, all in one chunk": (3840, 2160, 40, "jpeg", 60_000_000, PLAIN, 0),
    "progressive JPEG 3840 × 2160": (3840, 2160, 12, "progressive", 1, PLAIN, 0),
    "JPEG 1280 × 720 and point clouds of 60 MB": (1280, 720, 12, "jpeg", 1, PLAIN, 60_000_000),
    "JPEG 1280 × 720 and point clouds of 1 MB, chunks of 60 MB": (1280, 720, 150, "jpeg", 60_000_000, PLAIN, 1_000_000),
    "raw 4600 × 3450": (4600, 3450, 6, "rgb8", 1, PLAIN, 0),
    "JPEG 7000 × 4150, nearly the largest that is read": (7000, 4150, 6, "jpeg", 1, PLAIN, 0),
    "progressive JPEG 4600 × 3000": (4600, 3000, 6, "progressive", 1, PLAIN, 0),
    "PNG 4400 × 2500": (4400, 2500, 4, "png", 1, PLAIN, 0),
    "H.264 3840 × 2160, 1 reference image, in one slice": (3840, 2160, 24, "h264:1", 1, PLAIN, 0),
    "H.264 2560 × 1440, 6 reference images, in slices": (2560, 1440, 24, "h264:6", 1, PLAIN, 0),
    "H.264 1920 × 1080, 12 reference images, in slices": (1920, 1080, 40, "h264:12", 1, PLAIN, 0),
}
RIG = """[object]
shape = "cylinder"
radius = 0.03
half_height = 0.005
mass = 0.1
colour = {{ hue = [340.0, 20.0], saturation = [0.4, 1.0], value = [0.13, 1.0] }}
[striker]
tip = "sphere"
radius = 0.012
[table]
x = [0.10, 1.00]
y = [-0.60, 0.60]
[camera]
rate = 30.0
noise = 0.0007
centre = [0.5, 0.0]
matrix = [{f}, {f}, {x}, {y}]
distortion = [0.0, 0.0, 0.0, 0.0, 0.0]
position = [0.5, 0.0, 1.2]
orientation = [0.7071067811865476, -0.7071067811865476, 0.0, 0.0]
exposure = 0.0
readout = 0.0
[robot]
speed = [0.4, 1.0]
angle = [-0.80, 0.80]
acceleration = 5.0
[topics.image]
name = "/camera/image"
"""


def cdr(*fields):
    """Numbers of four bytes, texts and bytes, as CDR has them."""
    message = bytearray()
    for field in fields:
        if isinstance(field, bool):
            message += bytes([field])
            continue
        message += bytes(-len(message) % 4)
        if isinstance(field, int):
            message += struct.pack("<I", field)
        else:
            data = field.encode() + b"\0" if isinstance(field, str) else field
            message += struct.pack("<I", len(data)) + data
    return b"\0\1\0\0" + bytes(message)


def main():
    folder, name = pathlib.Path(sys.argv[1]), sys.argv[2]
    width, height, frames, encoding, chunk, compression, cloud = LOGS[name]
    folder.mkdir(parents=True, exist_ok=True)
    focal = 0.9 * width
    (folder / "rig.toml").write_text(RIG.format(f=focal, x=width / 2, y=height / 2))
    is_raw = encoding == "rgb8"
    encoding, _, references = encoding.partition(":")
    words = {"refs": references} | ({"threads": "1"} if "one slice" in name else {})
    video = Encoder(width, height, frames, words) if references else None
    rng = np.random.default_rng(1)
    table = (150 + 2 * rng.normal(size=(height, width, 3))).clip(0, 255).astype(np.uint8)
    with open(folder / "log.mcap", "wb") as file:
        writer = Writer(file, chunk_size=chunk, compression=compression)
        writer.start()
        kind = "foxglove_msgs/msg/CompressedVideo" if video else f"sensor_msgs/msg/{'Image' if is_raw else 'CompressedImage'}"
        schema = writer.register_schema(kind, "ros2msg", b"")
        images = writer.register_channel("/camera/image", "cdr", schema)
        clouds = writer.register_channel("/points", "cdr", writer.register_schema("sensor_msgs/msg/PointCloud2", "ros2msg", b""))
        for number in range(frames):
            image = table.copy()
            at = round(width * (0.5 + 0.6 * (number / frames - 0.5))), height // 2
            cv2.circle(image, at, round(0.03 * focal / 1.19), (46, 42, 196), -1, cv2.LINE_AA)
            stamp = 1_700_000_000_000_000_000 + number * 33_333_333
            begin = (*divmod(stamp, 1_000_000_000), "camera")
            if is_raw:
                data = cdr(*begin, height, width, "rgb8", False, 3 * width, image[..., ::-1].tobytes())
            elif video:
                data = cdr(*begin, video.add(VideoFrame.from_ndarray(image, format="bgr24")), "h264")
            else:
                words = [cv2.IMWRITE_JPEG_QUALITY, 90, cv2.IMWRITE_JPEG_PROGRESSIVE, int(encoding == "progressive")]
                kind, words = ("png", []) if encoding == "png" else ("jpg", words)
                data = cdr(*begin, kind, cv2.imencode(f".{kind}", image, words)[1].tobytes())
            writer.add_message(images, stamp, data, stamp)
            if cloud:
                writer.add_message(clouds, stamp, rng.bytes(cloud), stamp)
        writer.finish()
    print(json.dumps({"frames": frames}))


if __name__ == "__main__":
    main()
