"""Damaged copies of the real logs: a SourceError or valid scans, and nothing silently lost."""

import gzip
import io
import zipfile

import numpy as np
import pytest
from hypothesis import HealthCheck, assume, given, settings
from hypothesis import strategies as st
from recordings import DATA, lines_of, needs_recordings

import laserfeatures as lf

pytestmark = needs_recordings

EXCERPTS = {  # log, first word and number of its scan lines
    "flaser": ("sick/orebro-corrected.log.gz", b"FLASER", 6),
    "robotlaser": ("sick/flirt_mit-cscail.log.gz", b"ROBOTLASER1", 3),
    "gfs": ("sick/csail.corrected.gfs.gz", b"LASER_READING", 3),
    "brenner": ("urg/brenner_robot4/robot4_scan.txt.gz", b"S", 3),
    "breezy": ("urg/breezy_exp1.dat.gz", b"", 3),
    "urg_csv": ("urg/frm_g5_Scan1.csv.gz", b"", 3),
    "rplidar": ("rplidar/tdt4856_points_8k_1.txt", b"", 200),
}
damage = settings(
    max_examples=150, deadline=None, suppress_health_check=[HealthCheck.function_scoped_fixture]
)
places = st.floats(0, 1, exclude_max=True)
flips = st.lists(st.tuples(places, st.integers(1, 255)), min_size=1, max_size=5)


@pytest.fixture(scope="module", params=EXCERPTS)
def excerpt(request):
    lines = lines_of(*EXCERPTS[request.param])
    return request.param, [line for line in lines if not line.startswith(b"#")]


@pytest.fixture
def path(tmp_path):
    return tmp_path / "damaged"


def read(path, on_error="raise"):
    """Return the valid scans before the first error, the number skipped, and the error."""
    scans = []
    try:
        with lf.open_source(path, on_error=on_error) as source:
            try:
                scans.extend(source)
            except lf.SourceError as error:
                return scans, source.skipped, error
            return scans, source.skipped, None
    except lf.SourceError as error:
        return scans, 0, error
    finally:
        for scan in scans:
            assert isinstance(scan, lf.LaserScan)
            assert np.isfinite(scan.points).all()


def read_both_ways(path, content):
    """Check what holds for every damage; return the scans and skips of on_error="skip"."""
    path.write_bytes(content)
    strict, skipped, error = read(path)
    assert skipped == 0
    scans, skipped, fatal = read(path, "skip")
    assert fatal is None or not scans
    assert len(strict) <= len(scans)
    assert all(
        np.array_equal(a.ranges, b.ranges, equal_nan=True)
        for a, b in zip(strict, scans, strict=False)
    )
    if error is None:
        assert skipped == 0
        assert len(strict) == len(scans)
    else:
        assert skipped or fatal
        assert "\n" not in str(error)
        assert str(path) in str(error)
    return scans, skipped, fatal


def flip(content, at):
    damaged = bytearray(content)
    for place, mask in at:
        damaged[int(place * len(damaged))] ^= mask
    return bytes(damaged)


@damage
@given(place=places)
def test_a_cut_log(excerpt, path, place):
    name, lines = excerpt
    content = b"".join(lines)
    cut = content[: int(place * len(content))]
    scans, skipped, fatal = read_both_ways(path, cut)
    if name != "rplidar" and not fatal:
        whole = cut.count(b"\n")
        assert whole <= len(scans) + skipped <= whole + 1
        assert len(scans) >= whole


@damage
@given(flips=flips)
def test_flipped_bytes(excerpt, path, flips):
    name, lines = excerpt
    content = flip(b"".join(lines), flips)
    scans, skipped, fatal = read_both_ways(path, content)
    if name in {"flaser", "robotlaser", "gfs"} and not fatal:
        word = EXCERPTS[name][1]
        assert len(scans) + skipped >= sum(
            line.startswith(word + b" ") for line in content.split(b"\n")
        )


@damage
@given(data=st.data())
def test_deleted_tokens_and_doubled_lines(excerpt, path, data):
    name, lines = excerpt
    separator = b"," if name == "urg_csv" else b" "
    hurt = data.draw(st.integers(0, len(lines) - 1))
    tokens = lines[hurt].replace(separator, b" ").split()
    first = data.draw(st.integers(1, len(tokens) - 1))
    del tokens[first : first + data.draw(st.integers(1, 9))]
    line = separator.join(tokens) + b"\n"
    # A record without its three last fields is one of the older kind, without times.
    assume(name != "flaser" or first < len(tokens))
    doubled = data.draw(st.integers(0, len(lines) - 1))
    content = b"".join([*lines[:hurt], line, *lines[hurt + 1 :], lines[doubled]])
    scans, skipped, fatal = read_both_ways(path, content)
    if name != "rplidar" and not fatal:
        assert len(scans) + skipped == len(lines) + 1
        assert skipped == 1


@damage
@given(place=places, flips=st.one_of(st.just([]), flips))
def test_damaged_gzip(excerpt, path, place, flips):
    _, lines = excerpt
    packed = flip(gzip.compress(b"".join(lines), mtime=0), flips)
    read_both_ways(path, packed[: int(place * len(packed)) + 1] if not flips else packed)


@damage
@given(place=places)
def test_scans_before_a_cut_in_gzip_are_given(path, place):
    lines = lines_of(*EXCERPTS["flaser"])
    packed = gzip.compress(b"".join(lines), mtime=0)
    cut = packed[: int(place * len(packed))]
    path.write_bytes(cut)
    unpacked = io.BytesIO()
    try:
        with gzip.open(io.BytesIO(cut)) as stream:
            while byte := stream.read(1):
                unpacked.write(byte)
    except EOFError:
        pass
    scans, _, error = read(path)
    assert error is not None
    assert len(scans) == unpacked.getvalue().count(b"\n")


@damage
@given(place=places, flips=st.one_of(st.just([]), flips), packed=st.booleans())
def test_damaged_npz(path, place, flips, packed):
    content = io.BytesIO()
    (np.savez_compressed if packed else np.savez)(
        content,
        ranges=np.linspace(1, 9, 30).reshape(3, 10),
        angles=np.arange(10) / 10,
        stamps=[1, 2, 3],
    )
    damaged = flip(content.getvalue(), flips)
    read_both_ways(path, damaged if flips else damaged[: int(place * len(damaged))])


def test_a_npz_member_that_is_no_array(path):
    with zipfile.ZipFile(path, "w") as archive:
        archive.writestr("ranges.npy", b"\x93NUMPY\x01\x00v\x00{'descr': '<f8', 'shape': (")
        archive.writestr("angles.npy", b"")
    _, _, error = read(path)
    assert "expected a .npz archive" in str(error)


BAGS = [
    "rosbag/cartographer_data_hokuyo.bag",
    "ros2_converted/urg04lx_ros2_mcap/urg04lx_ros2_mcap.mcap",
    "ros2_converted/urg04lx_ros2_sqlite3/urg04lx_ros2_sqlite3.db3",
]


@pytest.mark.parametrize("bag", BAGS)
@settings(
    max_examples=25, deadline=None, suppress_health_check=[HealthCheck.function_scoped_fixture]
)
@given(
    place=places,
    flips=st.lists(st.tuples(places, st.integers(1, 255)), min_size=20, max_size=60),
    cut=st.booleans(),
)
def test_damaged_bags(tmp_path, bag, place, flips, cut):
    pytest.importorskip("rosbags", reason="rosbags (extra ros) is not installed")
    content = (DATA / bag).read_bytes()
    damaged = content[: int(place * len(content))] if cut else flip(content, flips)
    read_both_ways(tmp_path / f"damaged.{bag.rpartition('.')[2]}", damaged)
