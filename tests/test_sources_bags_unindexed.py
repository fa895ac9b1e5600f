"""Bags whose index is missing, partial or of an old writer, and bags that were cut."""

import importlib
import re
import sqlite3
import struct
import sys
from contextlib import closing

import numpy as np
import pytest

import laserfeatures as lf

pytest.importorskip("rosbags", reason="rosbags (extra ros) is not installed")

from mcap_files import chunk, described, message, written
from rosbags import rosbag1
from rosbags.rosbag2 import StoragePlugin
from test_sources_bags import HUMBLE, LASER, NOETIC, read, write1, write2
from test_sources_bags import message as scan_message


def scans_at(*times):
    return b"".join(message(time, scan_message(HUMBLE)) for time in times)


def stamps(path, **options):
    source, scans = read(path, **options)
    assert source.skipped == 0
    return len(scans), list(source.notices)


@pytest.mark.parametrize("profile", ["ros2", "", "custom"])
def test_mcap_chunks_are_read_without_an_index(tmp_path, profile):
    parts = [chunk(described() + scans_at(1, 2, 3), 1), chunk(scans_at(4, 5), 4)]
    path = written(tmp_path / "a.mcap", parts, profile=profile, stated=5)
    assert stamps(path) == (5, [])


def test_mcap_chunks_that_the_index_does_not_list(tmp_path):
    first = chunk(described() + scans_at(1, 2), 1)
    parts = [first, chunk(scans_at(3, 4), 3)]
    listed = [(1, 8 + 9 + 12, len(first), len(first) - 9 - 40)]
    path = written(tmp_path / "a.mcap", parts, stated=4, indexed=listed)
    assert stamps(path) == (4, [])


def test_mcap_messages_outside_of_chunks_and_chunks_out_of_order(tmp_path):
    no_stamp = scan_message(HUMBLE)
    no_stamp.header.stamp.sec = no_stamp.header.stamp.nanosec = 0
    second = 10**9
    late, early, loose = (message(time * second, no_stamp) for time in (3, 1, 2))
    parts = [described(), chunk(late, 3 * second), loose, chunk(early, second)]
    _, scans = read(written(tmp_path / "a.mcap", parts, stated=3))
    assert [scan.stamp for scan in scans] == [1, 2, 3]


def test_mcap_with_fewer_messages_than_it_says(tmp_path):
    path = written(tmp_path / "a.mcap", [chunk(described() + scans_at(1, 2), 1)], stated=6)
    assert stamps(path) == (2, ["expected 6 messages of /scan as the file says, got 2"])


def test_a_cut_mcap_is_read_as_far_as_it_goes(tmp_path):
    parts = [chunk(described() + scans_at(1, 2), 1), chunk(scans_at(3, 4), 3)]
    path = written(tmp_path / "a.mcap", parts)
    whole = path.read_bytes()
    one = len(scans_at(4))
    path.write_bytes(whole[: -13 - one // 2])  # 13 bytes follow the chunk
    count, (notice,) = stamps(path)
    assert count == 3
    assert re.match(r"byte \d+: the recording was cut here, \d+ bytes into a chunk", notice)


def test_a_damaged_chunk_is_named_or_skipped(tmp_path):
    parts = [chunk(described() + scans_at(1), 1), chunk(scans_at(2), 2, crc=1)]
    path = written(tmp_path / "a.mcap", [*parts, chunk(scans_at(3), 3)], stated=3)
    with pytest.raises(lf.SourceError, match=r"a.mcap:byte \d+: expected a chunk that fits"):
        read(path)
    source, scans = read(path, on_error="skip")
    assert (len(scans), source.skipped) == (2, 1)


def test_a_chunk_that_says_it_is_huge_is_not_unpacked(tmp_path):
    path = written(tmp_path / "a.mcap", [chunk(described() + scans_at(1), 1, size=1 << 40)])
    with pytest.raises(lf.SourceError, match="none"):
        read(path)


def test_a_folder_with_a_cut_mcap(tmp_path):
    folder = write2(tmp_path / "a", [scan_message(HUMBLE)] * 3, StoragePlugin.MCAP)
    (file,) = folder.glob("*.mcap")
    file.write_bytes(file.read_bytes()[:-60])
    count, (notice,) = stamps(folder)
    assert count == 3
    assert "the recording was cut here" in notice


def test_a_folder_whose_database_lacks_messages(tmp_path):
    folder = write2(tmp_path / "a", [scan_message(HUMBLE)] * 3)
    about = folder / "metadata.yaml"
    about.write_text(about.read_text().replace("message_count: 3", "message_count: 8"))
    assert stamps(folder) == (3, ["expected 8 messages of /scan as the bag says, got 3"])


def unindexed(path):
    """A ROS 1 bag as it stands while it is being recorded."""
    write1(path, {"/scan": [scan_message(NOETIC)] * 4})
    data = path.read_bytes()
    at = data.index(b"index_pos=") + len(b"index_pos=")
    (index,) = struct.unpack_from("<Q", data, at)
    path.write_bytes(data[:at] + bytes(8) + data[at + 8 : index])
    return path


def test_a_ros1_bag_without_an_index(tmp_path):
    assert stamps(unindexed(tmp_path / "a.bag")) == (4, [])


def test_a_ros1_bag_of_an_old_writer_gives_wrong_lengths_of_its_index(tmp_path):
    path = write1(tmp_path / "a.bag", {"/scan": [scan_message(NOETIC)] * 4})
    data = path.read_bytes()
    right = struct.pack("<I", 4 * 12)
    at = data.index(right, data.index(b"op=\x04"))
    path.write_bytes(data[:at] + struct.pack("<I", 80) + data[at + 4 :])
    assert stamps(path) == (4, [])


def test_messages_packed_with_zstd_need_the_folder(tmp_path):
    folder = write2(tmp_path / "a", [scan_message(HUMBLE)])
    (file,) = folder.glob("*.db3")
    with closing(sqlite3.connect(file)) as database, database:
        database.execute("UPDATE messages SET data = ?", (b"\x28\xb5\x2f\xfd" + bytes(9),))
    with pytest.raises(lf.SourceError, match=r"packed with zstd, .* pass the folder, .*a"):
        read(file)


@pytest.mark.parametrize(
    ("count", "last", "said"),
    [(3, 0.5, False), (3, 1.0, False), (3, 0.9, False), (3, 1.3, True), (3, 0.2, True)],
)
def test_an_angle_max_that_contradicts_is_named(tmp_path, caplog, count, last, said):
    message = scan_message(NOETIC, ranges=(1.0,) * count, angle_max=last)
    source, _ = read(write1(tmp_path / "a.bag", {"/scan": [message] * 3}))
    told = [r.getMessage() for r in caplog.records]
    assert (len(told), len(source.notices)) == (said, said)
    if said:
        degrees = 180 / 3.141592653589793
        assert f"angle_max is {last * degrees:.2f} deg" in told[0]
        assert "2 x angle_increment is 28.65 deg" in told[0]


@pytest.mark.parametrize("name", ["BZ2", "LZ4"])
def test_packed_chunks_of_a_ros1_bag(tmp_path, name):
    path = tmp_path / "a.bag"
    writer = rosbag1.Writer(path)
    writer.set_compression(rosbag1.Writer.CompressionFormat[name])
    with writer:
        connection = writer.add_connection("/scan", LASER, typestore=NOETIC)
        rng = np.random.default_rng(0)
        for time in range(1, 1000):
            ranges = rng.random(900).astype(np.float32)
            content = scan_message(NOETIC, ranges=ranges, angle_increment=0.001, angle_max=0.4)
            writer.write(connection, time * 10**9, NOETIC.serialize_ros1(content, LASER))
    assert stamps(path) == (999, [])
    whole = path.read_bytes()
    path.write_bytes(whole[: len(whole) * 3 // 5])
    count, (notice,) = stamps(path)
    assert 200 < count < 999
    assert "was cut here" in notice


@pytest.mark.parametrize("kind", ["lz4", "zstd"])
def test_packed_chunks_of_an_mcap(tmp_path, kind):
    pack = {
        "lz4": importlib.import_module("lz4.frame").compress,
        "zstd": importlib.import_module(
            "compression.zstd" if sys.version_info >= (3, 14) else "backports.zstd"
        ).compress,
    }[kind]
    parts = [
        chunk(described() + scans_at(1, 2), 1, pack=pack, compression=kind),
        chunk(scans_at(3), 3, pack=pack, compression=kind),
    ]
    path = written(tmp_path / "a.mcap", parts, stated=3)
    assert stamps(path) == (3, [])
    bomb = chunk(bytes(1 << 26), 3, size=1000, pack=pack, compression=kind)
    path = written(tmp_path / "b.mcap", [parts[0], bomb], stated=3)
    with pytest.raises(lf.SourceError, match="expected a chunk of 1000 bytes, got more"):
        read(path)
    odd = chunk(scans_at(3), 3, compression="xz")
    with pytest.raises(lf.SourceError, match=r"expected chunks packed with .* got 'xz'"):
        read(written(tmp_path / "c.mcap", [parts[0], odd], stated=3))
