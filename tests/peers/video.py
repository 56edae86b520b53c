"""Encodes the frames of a folder, in order of their names, as H.264 in Annex B, as foxglove.CompressedVideo demands it: no B-frames, an
access unit delimiter before every image, parameter sets before every key frame. Needs PyPI's av: `python video.py FOLDER OUT.h264 [KEY]`."""

import fractions
import pathlib
import sys

import av


class Encoder:
    """Of images of one size, a key frame every KEY; with other words for x264."""

    def __init__(self, width, height, key, words=None):
        self.encoder = av.codec.CodecContext.create("libx264", "w")
        self.encoder.width, self.encoder.height, self.encoder.pix_fmt = width, height, "yuv420p"
        self.encoder.framerate = 60
        self.encoder.time_base = fractions.Fraction(1, 60)
        self.encoder.options = {"preset": "medium", "tune": "zerolatency", "crf": "18", "bf": "0", "g": str(key), "x264-params": "aud=1:repeat-headers=1:scenecut=0:colormatrix=smpte170m"}
        self.encoder.options = self.encoder.options | (words or {})
        self.number = 0

    def add(self, image):
        """The bytes of an image, a `VideoFrame`."""
        image = image.reformat(format="yuv420p")
        image.pts, image.pict_type = self.number, av.video.frame.PictureType.NONE
        self.number += 1
        return b"".join(bytes(packet) for packet in self.encoder.encode(image))

    def rest(self):
        """The bytes that are left in the end: none without latency."""
        return b"".join(bytes(packet) for packet in self.encoder.encode(None))


def main(folder, out, key="6"):
    files = sorted(path for path in pathlib.Path(folder).iterdir() if path.suffix in (".png", ".jpg"))
    images = [next(av.open(str(path)).decode(video=0)) for path in files]
    encoder = Encoder(images[0].width, images[0].height, key)
    pathlib.Path(out).write_bytes(b"".join(map(encoder.add, images)) + encoder.rest())


if __name__ == "__main__":
    main(*sys.argv[1:])
