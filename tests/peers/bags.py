"""Writes the log of a demo as PyPI's `rosbags` records it, in each form of a rosbag2 folder.

    bags.py LOG FOLDER    LOG is MCAP as carom writes it; FOLDER/FORM gets a bag, FOLDER/foreign one with types of its own
"""

import sys
from pathlib import Path

from mcap.reader import make_reader
from rosbags.rosbag2 import CompressionFormat, CompressionMode, StoragePlugin, Writer
from rosbags.typesys import Stores, get_types_from_msg, get_typestore

STORE = get_typestore(Stores.ROS2_HUMBLE)
FORMS = {
    "mcap": (StoragePlugin.MCAP, None),
    "db3": (StoragePlugin.SQLITE3, None),
    "mcap_messages": (StoragePlugin.MCAP, CompressionMode.MESSAGE),
    "db3_messages": (StoragePlugin.SQLITE3, CompressionMode.MESSAGE),
    "mcap_file": (StoragePlugin.MCAP, CompressionMode.FILE),
    "db3_file": (StoragePlugin.SQLITE3, CompressionMode.FILE),
}
FOREIGN = {
    "lab_msgs/msg/Seen": "builtin_interfaces/Time at\nstring<=8 label\nlab_msgs/Place[] places\n",
    "lab_msgs/msg/Place": "bool sure\nfloat64 x\nfloat64 y\n",
    "lab_msgs/msg/Push": "uint8[3] mode\nbuiltin_interfaces/Time at\nfloat64[2] velocity\n",
}


def main():
    log, folder = sys.argv[1:]
    with open(log, "rb") as file:
        messages = [(c.topic, s.name, m.log_time, m.data) for s, c, m in make_reader(file).iter_messages()]
    folder = Path(folder)
    for form, (plugin, mode) in FORMS.items():
        write(folder / form, plugin, mode, messages)
    split(folder / "split", messages)
    foreign(folder / "foreign", messages)


def write(path, plugin, mode, messages, store=STORE):
    writer = Writer(path, version=9, storage_plugin=plugin)
    if mode:
        writer.set_compression(mode, CompressionFormat.ZSTD)
    with writer:
        connections = {}
        for topic, kind, time, data in messages:
            if topic not in connections:
                connections[topic] = writer.add_connection(topic, kind, typestore=store)
            writer.write(connections[topic], time, data)


def split(path, messages):
    """As the recorder splits by size: files one after another, each with its own channels, listed in one metadata.yaml."""
    third = len(messages) // 3
    parts = [messages[:third], messages[third : 2 * third], messages[2 * third :]]
    path.mkdir()
    names = []
    for number, part in enumerate(parts):
        whole = path.parent / f"part_{number}"
        write(whole, StoragePlugin.MCAP, None, part)
        names.append(f"split_{number}.mcap")
        (whole / f"part_{number}.mcap").rename(path / names[-1])
        metadata = (whole / "metadata.yaml").read_text()
        (whole / "metadata.yaml").unlink()
        whole.rmdir()
    listed = "  relative_file_paths:\n" + "".join(f"  - {name}\n" for name in names)
    text = metadata.replace("  relative_file_paths:\n  - part_2.mcap\n", listed)
    assert text != metadata
    (path / "metadata.yaml").write_text(text)


def foreign(path, messages):
    """Types that no package of ROS has, with arrays and text before what is wanted."""
    store = get_typestore(Stores.EMPTY)
    time = {"builtin_interfaces/msg/Time": "int32 sec\nuint32 nanosec\n"}
    for name, text in (time | FOREIGN).items():
        store.register(get_types_from_msg(text, name))
    kinds = {name: store.types[name] for name in FOREIGN}
    made = []
    import numpy

    for topic, kind, at, data in messages:
        if kind.endswith("PointStamped"):
            read = STORE.deserialize_cdr(data, kind)
            place = kinds["lab_msgs/msg/Place"](True, read.point.x, read.point.y)
            name = "lab_msgs/msg/Seen"
            message = kinds[name](read.header.stamp, "cup", [place])
        elif kind.endswith("TwistStamped"):
            read = STORE.deserialize_cdr(data, kind)
            name = "lab_msgs/msg/Push"
            velocity = numpy.array([read.twist.linear.x, read.twist.linear.y])
            message = kinds[name](numpy.array([1, 2, 3], dtype=numpy.uint8), read.header.stamp, velocity)
        else:
            continue
        made.append((topic, name, at, bytes(store.serialize_cdr(message, name))))
    write(path, StoragePlugin.SQLITE3, None, made, store)


main()
