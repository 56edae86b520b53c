"""What viewers see of a run: `viewers.py CAROM RUN FOLDER BIN`.

Has carom write views of RUN into FOLDER, reads them with mcap and protobuf, and with Rerun (`BIN/rerun`): converts, verifies and prints them, and
takes pictures where a software renderer of Vulkan is installed (Debian's `mesa-vulkan-drivers`). Exits with 1 and says what does not hold.
"""

import collections
import io
import json
import math
import os
import struct
import sys
import tomllib
from pathlib import Path

import av
from checking import call, check, finish
from foxglove_schemas_protobuf.CompressedVideo_pb2 import CompressedVideo
from mcap.reader import make_reader
from mcap.writer import Writer
from mcap_protobuf.decoder import DecoderFactory
from mcap_protobuf.schema import build_file_descriptor_set
from video import Encoder

carom, run, folder, tools = sys.argv[1], sys.argv[2], Path(sys.argv[3]), Path(sys.argv[4])
folder.mkdir(parents=True, exist_ok=True)


def rerun(*command, **expected):
    return call(tools / "rerun", *command, **expected)


rerun("analytics", "disable")

# A view of all, and one of a single strike.
everything, single = folder / "view.mcap", folder / "single.mcap"
shown = json.loads(call(carom, "view", run, "-o", everything, "--json").stdout)["shown"]
asked = "SELECT strike_id, xf, yf, x0, y0, speed FROM strikes ORDER BY t_start"
strikes = {row["strike_id"]: row for row in json.loads(call(carom, "query", run, asked, "--json").stdout)}
check(shown["strikes"] == len(strikes), f"all of {len(strikes)} strikes are shown, {everything.stat().st_size / 1e6:.1f} MB, {shown['duration']:.0f} s")
first = next(iter(strikes))
call(carom, "view", run, "--strike", first, "-o", single)
call(carom, "view", run, "--strike", "no-such", "-o", single, expected=2)
# An .rrd is made by Rerun's own program, where there is one.
own = folder / "own.rrd"
own.unlink(missing_ok=True)
path, os.environ["PATH"] = os.environ["PATH"], ""
call(carom, "view", run, "--strike", first, "-o", own, expected=2)
check(not own.exists(), "without Rerun's program there is no .rrd")
os.environ["PATH"] = f"{tools}:{path}"
call(carom, "view", run, "--strike", first, "-o", own)
rerun("rrd", "verify", own)

# By MCAP's and protobuf's own readers.
topics = collections.Counter()
schemas, seen, ends, last = {}, [], {}, 0
now = None
with open(everything, "rb") as file:
    reader = make_reader(file, decoder_factories=[DecoderFactory()])
    for schema, channel, message, decoded in reader.iter_decoded_messages(log_time_order=False):
        check(message.log_time >= last, "messages are in order of time") if message.log_time < last else None
        last = message.log_time
        topics[channel.topic] += 1
        schemas[channel.topic] = schema.name
        if schema.name == "strike.Strike":
            seen.append(decoded.strike_id)
            now = decoded
        elif schema.name == "foxglove.FrameTransforms":
            ends[now.strike_id] = {t.child_frame_id: t.translation for t in decoded.transforms}
        elif schema.name == "foxglove.SceneUpdate" and channel.topic in ("/carom/sysid", "/carom/effect"):
            name = channel.topic.rsplit("/", 1)[1]
            error = getattr(now, f"{name}_error")
            arrows = decoded.entities[0].arrows
            length = arrows[0].shaft_length + arrows[0].head_length if arrows else 0.0
            if abs(length - error) > 1e-5:
                check(False, f"the arrow of {now.strike_id} is as long as the {name} error: {length} {error}")
        elif schema.name == "foxglove.PointCloud":
            names = [field.name for field in decoded.fields]
            if names != ["x", "y", "z", "red", "green", "blue", "alpha"] or len(decoded.data) % decoded.point_stride:
                check(False, f"a cloud has places and colours: {names}")
            places = [struct.unpack_from("<3f", decoded.data, at) for at in range(0, len(decoded.data), decoded.point_stride)]
            if not all(map(math.isfinite, (number for place in places for number in place))):
                check(False, f"places of {channel.topic} are finite")
check(seen == list(strikes), "strikes follow each other in the order in which they were made")
for topic in sorted(topics):
    print(f"       {topics[topic]:7} {schemas[topic]:26} {topic}")
for needed in ("foxglove.SceneUpdate", "foxglove.FrameTransforms", "foxglove.PointCloud", "foxglove.Log", "motion.Motion"):
    check(needed in schemas.values(), f"there are messages of {needed}")
stopped = {one: row for one, row in strikes.items() if row["xf"] is not None}
far = max(math.dist((ends[one]["measured"].x, ends[one]["measured"].y), (row["xf"], row["yf"])) for one, row in stopped.items())
check(far < 1e-9, f"measured objects end where strikes.parquet has their stops ({far:.1e} m)")

# A run that starts from a camera's images: these are beside its strikes. So few give a candidate.
camera = folder / "camera"
if not (camera / "strikes.parquet").exists():
    call(carom, "demo", "--strikes", "12", "--seed", "3", "--hide", "none", "--camera", "--out", camera / "rig")
    call(carom, "run", camera / "rig/logs", "--rig", camera / "rig/rig.toml", "--out", camera, expected=4)


def as_video(log, out, topic):
    """The log with the images of a topic as H.264 in `foxglove.CompressedVideo`, a key frame every 30."""
    encoder, channels = None, {}
    with open(log, "rb") as file, open(out, "wb") as written:
        writer = Writer(written)
        writer.start()
        schema = CompressedVideo.DESCRIPTOR
        schema = writer.register_schema(schema.full_name, "protobuf", build_file_descriptor_set(CompressedVideo).SerializeToString())
        video = writer.register_channel(topic, "protobuf", schema)
        reader = make_reader(file)
        for its, channel, message in reader.iter_messages():
            data, place = message.data, channels.get(channel.id, video if channel.topic == topic else None)
            if place is None:
                its = writer.register_schema(its.name, its.encoding, its.data)
                place = channels[channel.id] = writer.register_channel(channel.topic, channel.message_encoding, its, channel.metadata)
            if channel.topic == topic:
                image = next(av.open(io.BytesIO(data[data.index(b"\xff\xd8") :])).decode(video=0))
                encoder = encoder or Encoder(image.width, image.height, 30)
                said = CompressedVideo(frame_id="camera", data=encoder.add(image), format="h264")
                # Little-endian CDR begins with the stamp.
                said.timestamp.seconds, said.timestamp.nanos = struct.unpack_from("<iI", data, 4)
                data = said.SerializeToString()
            writer.add_message(place, message.log_time, data, message.publish_time)
        for metadata in reader.iter_metadata():
            writer.add_metadata(metadata.name, metadata.metadata)
        writer.finish()
    check(not encoder.rest(), f"{encoder.number} images as H.264: {log.stat().st_size / 1e6:.1f} MB are {out.stat().st_size / 1e6:.1f} MB")


def show(run, stem):
    """Views of a run with images, of all and of its first strike."""
    whole, first = folder / f"{stem}.mcap", folder / f"{stem}_single.mcap"
    shown = json.loads(call(carom, "view", run, "-o", whole, "--json").stdout)["shown"]
    asked = "SELECT strike_id FROM strikes ORDER BY t_start LIMIT 1"
    (strike,) = (row["strike_id"] for row in json.loads(call(carom, "query", run, asked, "--json").stdout))
    call(carom, "view", run, "--strike", strike, "-o", first)
    taken, images, last = [], 0, 0
    with open(whole, "rb") as file:
        reader = make_reader(file, decoder_factories=[DecoderFactory()])
        for schema, channel, message, decoded in reader.iter_decoded_messages(log_time_order=False):
            check(False, "images are in order of time") if message.log_time < last else None
            last = message.log_time
            if schema.name == "strike.Strike":
                taken.append(0)
            elif schema.name == "foxglove.CompressedImage":
                taken[-1] += 1
                images += 1
                if decoded.format != "jpeg" or not decoded.data.startswith(b"\xff\xd8") or decoded.timestamp.ToNanoseconds() != message.log_time:
                    check(False, f"an image is a JPEG with its stamp: {decoded.format}")
    check(images == shown["images"] and min(taken) > 10, f"{stem}: {images} images, {min(taken)} to {max(taken)} of each of {len(taken)} strikes, {whole.stat().st_size / 1e6:.1f} MB")
    return whole, first, images


filmed, filmed_single, images = show(camera, "filmed")

# The same camera's images as video: each is shown beside the same strikes.
video = folder / "video"
if not (video / "strikes.parquet").exists():
    (video / "rig/logs").mkdir(parents=True, exist_ok=True)
    rig = (camera / "rig/rig.toml").read_text()
    (video / "rig/rig.toml").write_text(rig)
    for log in sorted((camera / "rig/logs").glob("*.mcap")):
        as_video(log, video / "rig/logs" / log.name, tomllib.loads(rig)["topics"]["image"]["name"])
    call(carom, "run", video / "rig/logs", "--rig", video / "rig/rig.toml", "--out", video, expected=4)
recorded, recorded_single, of_video = show(video, "video")
# Compression moves centroids by a fraction of a pixel: a track may begin or end an image earlier.
check(abs(of_video - images) <= 24, f"as many images of the video as of the JPEGs, but for two of a strike: {of_video}, {images}")

# By Rerun.
rerun("mcap", "check", "--full", everything)
for view in (everything, single, filmed, filmed_single, recorded, recorded_single):
    rrd = view.with_suffix(".rrd")
    rrd.unlink(missing_ok=True)
    rerun("mcap", "convert", view, "-o", rrd)
    rerun("rrd", "verify", rrd)
    (folder / f"{view.stem}.txt").write_text(rerun("rrd", "print", "-v", rrd).stdout)
text = (folder / "view.txt").read_text()
for part in ("Points3D:positions", "Points3D:colors", "Transform3D:translation", "CoordinateFrame:frame", "TextLog:text"):
    check(part in text, f"Rerun draws {part}")
for view in (filmed, recorded):
    text = (folder / f"{view.stem}.txt").read_text()
    for part in ("EncodedImage:blob", "Pinhole:image_from_camera"):
        check(part in text, f"Rerun draws {part} of {view.name}")
cut = folder / "cut.mcap"
cut.write_bytes(single.read_bytes()[:-1000])
rerun("mcap", "check", "--full", cut, expected=1)

# Pictures.
drivers = list(Path("/usr/share/vulkan/icd.d").glob("lvp_icd*.json"))
if drivers:
    os.environ["VK_ICD_FILENAMES"] = str(drivers[0])
    for view in (single, filmed_single, recorded_single):
        picture = view.with_suffix(".png")
        picture.unlink(missing_ok=True)
        rerun("--headless", "--renderer", "vulkan", "--bind", "127.0.0.1", "--window-size", "1400x900", "--screenshot-to", picture, view)
        check(picture.exists(), f"a picture: {picture}")
else:
    print("       no picture: no software renderer of Vulkan is installed")
finish()
