"""ROS 1 bags, ROS 2 bags and MCAP: the sensor_msgs/LaserScan messages of one topic.

Messages are read with the rosbags package (extra `ros`). The stamp is the header's, or the bag's
where that is 0; the limits are the message's. The scans have no pose. A bag without an index, or
that was cut, is read as far as it goes.
"""

import math
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path
from typing import TYPE_CHECKING, cast

import numpy as np

from laserfeatures.data import LaserScan
from laserfeatures.errors import LaserFeaturesError, SourceError, shown
from laserfeatures.optional import optional
from laserfeatures.sources.bag_messages import NEED, WALK, Bag, Indexed, Walked
from laserfeatures.sources.beams import contradiction, even_scan
from laserfeatures.sources.files import read_head
from laserfeatures.sources.log import Log, Scans

if TYPE_CHECKING:
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
    with _translated(log.path), _open(log) as bag:
        topic = _choose(log, bag)
        for number, (time, data) in enumerate(_messages(log, bag, topic), 1):
            try:
                message = cast("Message", bag.read(data))
                scan = _scan(log, message, time)
            except SourceError:
                raise
            except Exception as error:  # noqa: BLE001 - a damaged message fails in many ways
                where = f"{topic}:message {number}"
                log.broken(where, f"expected a LaserScan message, got {error}", error)
                continue
            yield scan


@contextmanager
def _translated(path: Path) -> Iterator[None]:
    """Turn whatever is raised about a damaged bag into a SourceError."""
    try:
        yield
    except LaserFeaturesError:
        raise
    except Exception as error:
        text = shown(str(error)) or type(error).__name__
        raise SourceError(
            f"{path}: the bag cannot be read: {text}; if a recording was cut, "
            "`rosbag reindex` or `ros2 bag reindex` may mend it"
        ) from error


@contextmanager
def _open(log: Log) -> Iterator[Bag]:
    highlevel = optional("rosbags.highlevel", NEED, "ros")
    types = optional("rosbags.typesys", NEED, "ros")
    _check_name(log.path)
    files = _files(log.path)
    if files:
        yield Walked(log, files)
        return
    store = types.get_typestore(types.Stores.LATEST)
    with highlevel.AnyReader([log.path], default_typestore=store) as reader:
        yield Indexed(log, reader)


def _files(path: Path) -> list[Path]:
    """Return the files that are read without rosbags' index; none where they are databases."""
    if not path.is_dir():
        return [path] if path.suffix in WALK else []
    yaml = optional("ruamel.yaml", "reading bags needs rosbags", "ros").YAML(typ="safe")
    about = yaml.load((path / "metadata.yaml").read_text())["rosbag2_bagfile_information"]
    files = [path / Path(name).name for name in about["relative_file_paths"]]
    missing = ", ".join(file.name for file in files if not file.exists())
    if missing:
        raise SourceError(
            f"{path}: the bag cannot be read: files that metadata.yaml names are missing: {missing}"
        )
    packed = (about.get("compression_mode") or "none").lower() != "none"
    return [] if packed or any(file.suffix not in WALK for file in files) else files


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


def _choose(log: Log, bag: Bag) -> str:
    """Return the topic to read."""
    found = bag.topics()
    topics = sorted({topic for topic, kind in found if kind == SCAN_TYPE})
    if log.topic is not None:
        if log.topic in topics:
            return log.topic
        raise SourceError(
            f"{log.path}: expected the LaserScan topic {log.topic}, "
            f"got {shown(', '.join(topics)) or 'none'}; choose one of these with topic= (--topic)"
        )
    if not topics:
        others = shown(", ".join(sorted({topic for topic, _ in found}))) or "none"
        raise SourceError(
            f"{log.path}: expected a topic of type {SCAN_TYPE}, got only others: {others}; "
            "record the laser's topic"
        )
    if len(topics) > 1:
        raise SourceError(
            f"{log.path}: expected one LaserScan topic, got {shown(', '.join(topics))}; "
            "choose one with topic= (--topic)"
        )
    return topics[0]


def _messages(log: Log, bag: Bag, topic: str) -> Iterator[tuple[int, bytes]]:
    """Yield the topic's messages up to the end or the first damage."""
    number = 0
    try:
        for number, message in enumerate(bag.messages(topic, SCAN_TYPE), 1):  # noqa: B007 - named below
            yield message
    except SourceError:
        raise
    except Exception as error:  # noqa: BLE001 - rosbags lets many kinds through
        problem = f"the bag is damaged from here on ({type(error).__name__}: {error})"
        log.broken(f"{topic}:message {number + 1}", problem, error)


def _scan(log: Log, message: "Message", time: int) -> LaserScan:
    ranges = np.array(message.ranges, dtype=np.float64)
    ranges.flags.writeable = False
    stamp = message.header.stamp.sec + message.header.stamp.nanosec / 1e9
    stated = float(message.range_max)
    first, step = float(message.angle_min), float(message.angle_increment)
    said = contradiction(first, step, ranges.size, float(message.angle_max))
    if said:
        log.notice("angle_max", said)
    return even_scan(
        ranges,
        first,
        step,
        range_min=max(float(message.range_min), 0.0) if math.isfinite(message.range_min) else 0.0,
        range_max=log.range_max or (stated if stated > 0 else math.inf),
        stamp=stamp or time / 1e9,
    )
