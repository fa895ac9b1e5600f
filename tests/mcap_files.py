"""MCAP files with whatever is right or wrong about them."""

import struct
import zlib

from rosbags.typesys import Stores, get_typestore

LASER = "sensor_msgs/msg/LaserScan"
HUMBLE = get_typestore(Stores.ROS2_HUMBLE)
MAGIC = b"\x89MCAP0\r\n"


def text(value):
    data = value if isinstance(value, bytes) else value.encode()
    return struct.pack("<I", len(data)) + data


def record(kind, content):
    return struct.pack("<BQ", kind, len(content)) + content


def described(topic="/scan", encoding="cdr"):
    definition, _ = HUMBLE.generate_msgdef(LASER, ros_version=2)
    schema = struct.pack("<H", 1) + text(LASER) + text("ros2msg") + text(definition)
    channel = struct.pack("<HH", 1, 1) + text(topic) + text(encoding) + text(b"")
    return record(3, schema) + record(4, channel)


def message(time, scan):
    return record(5, struct.pack("<HIQQ", 1, 0, time, time) + HUMBLE.serialize_cdr(scan, LASER))


def chunk(content, begin, *, size=None, crc=None, pack=bytes, compression=""):
    crc = zlib.crc32(content) if crc is None else crc
    size = len(content) if size is None else size
    head = struct.pack("<QQQI", begin, begin, size, crc)
    content = pack(content)
    return record(6, head + text(compression) + struct.pack("<Q", len(content)) + content)


def summary(stated, *, indexed=(), start=0):
    """The records after the data; an index of each chunk: (begin, place, length, content)."""
    statistics = struct.pack("<QHIIIIQQ", stated, 1, 1, 0, 0, len(indexed), 0, 0)
    counts = struct.pack("<HQ", 1, stated)
    content = described() + record(11, statistics + struct.pack("<I", len(counts)) + counts)
    for begin, place, length, size in indexed:
        index = struct.pack("<QQQQ", begin, begin, place, length) + text(b"")
        index += struct.pack("<Q", 0) + text("") + struct.pack("<QQ", size, size)
        content += record(8, index)
    return content + record(2, struct.pack("<QQI", start, 0, 0)) + MAGIC


def written(path, parts, *, profile="ros2", stated=None, indexed=()):
    """Write a file; `parts` are records, `stated` how many messages the summary says there are."""
    data = MAGIC + record(1, text(profile) + text("test")) + b"".join(parts)
    end = record(15, bytes(4))
    if stated is not None:
        end += summary(stated, indexed=indexed, start=len(data) + len(end))
    path.write_bytes(data + end)
    return path
