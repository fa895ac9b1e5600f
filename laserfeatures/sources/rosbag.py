"""ROS 1 bags, ROS 2 bags and MCAP: the sensor_msgs/LaserScan messages of one topic.

Read with the rosbags package (extra `ros`). The stamp is the header's, or the bag's where that is
0; the limits are the message's. The scans have no pose.
"""

import math
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path
from typing import TYPE_CHECKING, cast

import numpy as np

from laserfeatures.data import LaserScan
from laserfeatures.errors import LaserFeaturesError, SourceError
from laserfeatures.optional import optional
from laserfeatures.sources.beams import even_scan
from laserfeatures.sources.files import read_head
from laserfeatures.sources.log import Log, Scans

if TYPE_CHECKING:
    from rosbags.highlevel import AnyReader
    from rosbags.interfaces import Connection
    from rosbags.typesys.stores.latest import sensor_msgs__msg__LaserScan as Message

SCAN_TYPE = "sensor_msgs/msg/LaserScan"
MAGIC = {".bag": b"#ROSBAG V2.0", ".db3": b"SQLite format 3\0", ".mcap": b"\x89MCAP0\r\n"}


def read_bag(log: Log) -> Scans:
    """Yield the scans of a bag.

    Raises
    ------
    MissingDependencyError
        If rosbags is not installed.
    SourceError
        If the bag cannot be read, or does not say which topic.
    """
    with _translated(log.path), _open(log.path) as reader:
        topic = _choose(log, reader)
        messages = _messages(log, reader, topic)
        for number, (connection, time, data) in enumerate(messages, 1):
            where = f"{connection.topic}:message {number}"
            try:
                message = cast("Message", reader.deserialize(data, connection.msgtype))
                scan = _scan(message, time, log.range_max)
            except Exception as error:  # noqa: BLE001 - a damaged message fails in many ways
                log.broken(where, f"expected a LaserScan message, got {error}", error)
                continue
            yield scan


@contextmanager
def _translated(path: Path) -> Iterator[None]:
    """Turn whatever rosbags raises about a damaged bag into a SourceError."""
    try:
        yield
    except LaserFeaturesError:
        raise
    except Exception as error:
        text = " ".join(str(error).split()) or type(error).__name__
        raise SourceError(
            f"{path}: the bag cannot be read: {text}; if a recording was cut, "
            "`rosbag reindex` or `ros2 bag reindex` may mend it"
        ) from error


def _open(path: Path) -> "AnyReader":
    highlevel = optional("rosbags.highlevel", "reading bags needs rosbags", "ros")
    types = optional("rosbags.typesys", "reading bags needs rosbags", "ros")
    _check_name(path)
    store = types.get_typestore(types.Stores.LATEST)
    reader: AnyReader = highlevel.AnyReader([path], default_typestore=store)
    return reader


def _check_name(path: Path) -> None:
    """Check that the name ends as the content wants: rosbags goes by the name."""
    if path.is_dir():
        if path.suffix == ".bag":
            raise SourceError(f"{path}: expected a folder not named .bag; rename it")
        return
    head = read_head(path)
    wanted = next((suffix for suffix, magic in MAGIC.items() if head.startswith(magic)), None)
    if wanted is None:
        raise SourceError(f"{path}: expected a ROS 1 or ROS 2 bag or MCAP, got {head[:16]!r}")
    if path.suffix != wanted:
        raise SourceError(f"{path}: expected a name that ends with {wanted}; rename it")


def _choose(log: Log, reader: "AnyReader") -> str:
    """Return the topic to read."""
    topics = sorted({c.topic for c in reader.connections if c.msgtype == SCAN_TYPE})
    if log.topic is not None:
        if log.topic in topics:
            return log.topic
        raise SourceError(
            f"{log.path}: expected the LaserScan topic {log.topic}, "
            f"got {', '.join(topics) or 'none'}; choose one of these with topic= (--topic)"
        )
    if not topics:
        others = ", ".join(sorted({c.topic for c in reader.connections})) or "none"
        raise SourceError(
            f"{log.path}: expected a topic of type {SCAN_TYPE}, got only others: {others}; "
            "record the laser's topic"
        )
    if len(topics) > 1:
        raise SourceError(
            f"{log.path}: expected one LaserScan topic, got {', '.join(topics)}; "
            "choose one with topic= (--topic)"
        )
    return topics[0]


def _messages(
    log: Log, reader: "AnyReader", topic: str
) -> Iterator[tuple["Connection", int, bytes]]:
    """Yield the topic's messages up to the end or the first damage."""
    connections = [c for c in reader.connections if c.topic == topic and c.msgtype == SCAN_TYPE]
    number = 0
    try:
        for number, message in enumerate(reader.messages(connections), 1):  # noqa: B007 - named below
            yield message
    except Exception as error:  # noqa: BLE001 - rosbags lets many kinds through
        problem = f"the bag is damaged from here on ({type(error).__name__}: {error})"
        log.broken(f"{topic}:message {number + 1}", problem, error)


def _scan(message: "Message", time: int, range_max: float | None) -> LaserScan:
    ranges = np.array(message.ranges, dtype=np.float64)
    ranges.flags.writeable = False
    stamp = message.header.stamp.sec + message.header.stamp.nanosec / 1e9
    stated = float(message.range_max)
    return even_scan(
        ranges,
        float(message.angle_min),
        float(message.angle_increment),
        range_min=max(float(message.range_min), 0.0) if math.isfinite(message.range_min) else 0.0,
        range_max=range_max or (stated if stated > 0 else math.inf),
        stamp=stamp or time / 1e9,
    )
