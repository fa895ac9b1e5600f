import re
import shutil
import sqlite3
import subprocess
import sys
from contextlib import closing

import numpy as np
import pytest
from recordings import DATA, needs_recordings

import laserfeatures as lf

pytest.importorskip("rosbags", reason="rosbags (extra ros) is not installed")

from rosbags import rosbag1, rosbag2
from rosbags.rosbag2 import StoragePlugin
from rosbags.typesys import Stores, get_typestore

from laserfeatures.optional import install_line

NOETIC = get_typestore(Stores.ROS1_NOETIC)
HUMBLE = get_typestore(Stores.ROS2_HUMBLE)
LASER = "sensor_msgs/msg/LaserScan"


def message(store, ranges=(1.0, 2.0, 9.0), **fields):
    kinds = store.types
    stamp = kinds["builtin_interfaces/msg/Time"](sec=7, nanosec=500_000_000)
    seq = {"seq": 0} if store is NOETIC else {}
    values = {
        "header": kinds["std_msgs/msg/Header"](stamp=stamp, frame_id="laser", **seq),
        "angle_min": -0.5,
        "angle_max": 0.5,
        "angle_increment": 0.5,
        "time_increment": 0.0,
        "scan_time": 0.0,
        "range_min": 0.1,
        "range_max": 8.0,
        "ranges": np.array(ranges, dtype=np.float32),
        "intensities": np.array([], dtype=np.float32),
    }
    return kinds[LASER](**values | fields)


def write1(path, topics):
    with rosbag1.Writer(path) as writer:
        for topic, messages in topics.items():
            kind = LASER if messages else "std_msgs/msg/String"
            connection = writer.add_connection(topic, kind, typestore=NOETIC)
            for time, content in enumerate(messages, 1):
                writer.write(connection, time * 10**9, NOETIC.serialize_ros1(content, LASER))
    return path


def write2(path, messages, plugin=StoragePlugin.SQLITE3):
    with rosbag2.Writer(path, version=9, storage_plugin=plugin) as writer:
        connection = writer.add_connection("/scan", LASER, typestore=HUMBLE)
        for time, content in enumerate(messages, 1):
            writer.write(connection, time * 10**9, HUMBLE.serialize_cdr(content, LASER))
    return path


def read(path, **options):
    with lf.open_source(path, **options) as source:
        return source, list(source)


def test_a_message(tmp_path):
    source, (scan,) = read(write1(tmp_path / "a.bag", {"/scan": [message(NOETIC)]}))
    assert (source.format, source.poses) == ("rosbag1", "none")
    assert (scan.stamp, scan.range_min, scan.range_max) == (7.5, pytest.approx(0.1), 8)
    assert (scan.angles.tolist(), scan.ranges.tolist()) == ([-0.5, 0, 0.5], [1, 2, 9])
    assert scan.valid.tolist() == [True, True, False]


@pytest.mark.parametrize("plugin", list(StoragePlugin))
def test_ros2_bags_as_folder_and_file(tmp_path, plugin):
    folder = write2(tmp_path / "a", [message(HUMBLE)] * 3, plugin)
    assert len(read(folder)[1]) == 3
    (file,) = (path for path in folder.iterdir() if path.suffix != ".yaml")
    assert len(read(file)[1]) == 3


def test_descending_beams_are_reversed(tmp_path):
    turned = message(NOETIC, angle_min=0.5, angle_max=-0.5, angle_increment=-0.5)
    _, (scan,) = read(write1(tmp_path / "a.bag", {"/scan": [turned]}))
    assert (scan.angles.tolist(), scan.ranges.tolist()) == ([-0.5, 0, 0.5], [9, 2, 1])


def test_a_stamp_of_zero_gives_way_to_the_bags(tmp_path):
    no_stamp = message(NOETIC)
    no_stamp.header.stamp.sec = no_stamp.header.stamp.nanosec = 0
    _, scans = read(write1(tmp_path / "a.bag", {"/scan": [no_stamp] * 2}))
    assert [scan.stamp for scan in scans] == [1, 2]


def test_limits_that_say_nothing(tmp_path):
    unlimited = message(NOETIC, range_min=np.nan, range_max=0.0)
    _, (scan,) = read(write1(tmp_path / "a.bag", {"/scan": [unlimited]}))
    assert (scan.range_min, scan.range_max) == (0, np.inf)
    _, (scan,) = read(tmp_path / "a.bag", range_max=1.5)
    assert scan.valid.tolist() == [True, False, False]


def test_no_laser_topic(tmp_path):
    path = write1(tmp_path / "a.bag", {"/chatter": [], "/other": []})
    with pytest.raises(lf.SourceError, match="got only others: /chatter, /other") as error:
        read(path)
    assert LASER in str(error.value)


def test_several_laser_topics(tmp_path):
    both = {"/front": [message(NOETIC)], "/rear": [message(NOETIC)] * 2}
    path = write1(tmp_path / "a.bag", both)
    with pytest.raises(lf.SourceError, match=r"got /front, /rear; .*--topic"):
        read(path)
    assert len(read(path, topic="/rear")[1]) == 2
    with pytest.raises(lf.SourceError, match=r"topic /top, got /front, /rear"):
        read(path, topic="/top")


def test_a_broken_message_is_named_or_skipped(tmp_path):
    broken = message(NOETIC, angle_increment=np.nan)
    path = write1(tmp_path / "a.bag", {"/scan": [message(NOETIC), broken, message(NOETIC)]})
    with pytest.raises(lf.SourceError, match=r"a.bag:/scan:message 2: .* distinct directions"):
        read(path)
    source, scans = read(path, on_error="skip")
    assert (len(scans), source.skipped) == (2, 1)
    assert "message 2" in source.first_error


def test_names_that_rosbags_does_not_take(tmp_path):
    path = write1(tmp_path / "a.bag", {"/scan": [message(NOETIC)]})
    with pytest.raises(lf.SourceError, match=r"ends with .bag; rename it"):
        read(path.rename(tmp_path / "a.recording"))
    folder = write2(tmp_path / "b", [message(HUMBLE)])
    with pytest.raises(lf.SourceError, match=r"not named .bag; rename it"):
        read(folder.rename(tmp_path / "b.bag"))


def test_a_cut_bag(tmp_path):
    path = write1(tmp_path / "a.bag", {"/scan": [message(NOETIC)] * 9})
    whole = path.read_bytes()
    path.write_bytes(whole[:-100])  # within the index, which is not needed
    source, scans = read(path)
    assert len(scans) == 9
    assert re.match(r"byte \d+: the recording was cut here, ", *source.notices)
    path.write_bytes(whole[:5000])  # within the only chunk
    source, scans = read(path)
    assert 1 <= len(scans) < 9
    assert re.match(r"byte \d+: the recording was cut here, ", *source.notices)
    path.write_bytes(whole[:4100])
    with pytest.raises(lf.SourceError, match=r"a.bag: expected a topic of type .*none"):
        read(path)


def test_a_folder_without_its_data(tmp_path):
    folder = write2(tmp_path / "b", [message(HUMBLE)])
    next(folder.glob("*.db3")).unlink()
    with pytest.raises(lf.SourceError, match=r"the bag cannot be read: .*missing"):
        read(folder)


def run(code):
    command = [sys.executable, "-c", code]
    return subprocess.run(command, capture_output=True, text=True, check=True).stdout  # noqa: S603 - our own code


def test_without_rosbags_the_extra_is_named(tmp_path):
    path = write1(tmp_path / "a.bag", {"/scan": [message(NOETIC)]})
    said = run(
        "import sys; sys.modules['rosbags'] = None; import laserfeatures as lf\n"
        f"try: lf.open_source({str(path)!r})\n"
        "except lf.MissingDependencyError as error: print(error)"
    )
    assert said == f"reading bags needs rosbags: {install_line('ros')}\n"


def test_rosbags_is_imported_only_for_bags():
    assert run("import sys, laserfeatures; print('rosbags' in sys.modules)") == "False\n"


@needs_recordings
def test_a_ros2_folder_by_another_name(tmp_path):
    folder = shutil.copytree(DATA / "ros2_converted/urg04lx_ros2_mcap", tmp_path / "renamed")
    assert len(read(folder)[1]) == 1265


@needs_recordings
def test_a_ros2_bag_without_message_definitions(tmp_path):
    file = "urg04lx_ros2_sqlite3.db3"
    copy = shutil.copy(DATA / "ros2_converted/urg04lx_ros2_sqlite3" / file, tmp_path)
    with closing(sqlite3.connect(copy)) as database, database:
        database.execute("DELETE FROM message_definitions")
    assert len(read(copy)[1]) == 1265
