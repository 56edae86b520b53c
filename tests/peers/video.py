"""Encodes the frames of a folder, in order of their names, as H.264 in Annex B, as foxglove.CompressedVideo demands it: no B-frames, an
access unit delimiter before every image, parameter sets before every key frame. Needs PyPI's av: `python video.py FOLDER OUT.h264 [KEY]`."""

import fractions
import pathlib
import sys

import av

folder, out, key = pathlib.Path(sys.argv[1]), pathlib.Path(sys.argv[2]), (sys.argv[3:] or ["6"])[0]
files = sorted(path for path in folder.iterdir() if path.suffix in (".png", ".jpg"))
images = [next(av.open(str(path)).decode(video=0)) for path in files]
encoder = av.codec.CodecContext.create("libx264", "w")
encoder.width, encoder.height, encoder.pix_fmt = images[0].width, images[0].height, "yuv420p"
encoder.framerate = 60
encoder.time_base = fractions.Fraction(1, 60)
encoder.options = {"preset": "medium", "tune": "zerolatency", "crf": "18", "bf": "0", "g": key, "x264-params": "aud=1:repeat-headers=1:scenecut=0:colormatrix=smpte170m"}
data = b""
for number, image in enumerate(images):
    image = image.reformat(format="yuv420p")
    image.pts, image.pict_type = number, av.video.frame.PictureType.NONE
    data += b"".join(bytes(packet) for packet in encoder.encode(image))
data += b"".join(bytes(packet) for packet in encoder.encode(None))
out.write_bytes(data)
