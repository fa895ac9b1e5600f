import gzip
import math

import numpy as np
import pytest

import laserfeatures as lf


def read(path, content, **options):
    path.write_bytes(content.encode() if isinstance(content, str) else content)
    with lf.open_source(path, **options) as source:
        return source, list(source)


@pytest.fixture
def path(tmp_path):
    return tmp_path / "table"


def test_a_wide_table(path):
    text = "# a comment\nstamp,x,y,theta,-0.1,0.0,0.1\n5,1,2,0.5,3.5,,inf\n\n,,,,0,nan,2\n"
    source, (first, second) = read(path, text)
    assert (source.format, source.poses) == ("csv", "odometry")
    assert first.angles.tolist() == [-0.1, 0, 0.1]
    assert (first.stamp, first.pose) == (5, lf.Pose2D(1, 2, 0.5))
    assert first.valid.tolist() == [True, False, False]
    assert math.isnan(second.stamp)
    assert second.pose is None
    assert second.valid.tolist() == [False, False, True]
    assert second.angles is first.angles


def test_a_wide_table_of_decreasing_angles_without_poses(path):
    source, (scan,) = read(path, "stamp,0.2,0.1\n5,1,2\n")
    assert source.poses == "none"
    assert (scan.angles.tolist(), scan.ranges.tolist()) == ([0.1, 0.2], [2, 1])
    assert scan.pose is None


def test_a_long_table(path):
    text = '"scan","stamp","angle","range"\n0,5,0.2,1\n0,5,0.1,2\n1,6,0.3,\n'
    source, (first, second) = read(path, text)
    assert (source.format, source.poses) == ("csv", "none")
    assert (first.angles.tolist(), first.ranges.tolist(), first.stamp) == ([0.1, 0.2], [2, 1], 5)
    assert (second.angles.tolist(), second.valid.tolist(), second.stamp) == ([0.3], [False], 6)


def test_a_long_table_is_cut_by_stamps_or_not_at_all(path):
    _, scans = read(path, "stamp,range,angle\n5,1,0.1\n5,2,0.2\n6,1,0.1\n")
    assert [scan.ranges.size for scan in scans] == [2, 1]
    _, scans = read(path, "range,angle\r\n1,0.1\r\n2,0.2\r\n1,0.3\r\n", range_max=2)
    assert [scan.ranges.size for scan in scans] == [3]
    assert scans[0].valid.tolist() == [True, False, True]


@pytest.mark.parametrize(
    "header", ["1,2,3", "0.1,0.2", "a,b", "angle,range,colour", "stamp,x,0.1", "x,y,theta,0.1"]
)
def test_a_table_without_the_wanted_header_says_which(path, header):
    with pytest.raises(lf.SourceError, match="expected the header 'angle,range'") as error:
        read(path, f"{header}\n1,2,3\n")
    assert header in str(error.value)


@pytest.mark.parametrize("header", ["stamp,0.1,0.3,0.2", "stamp,0,7", "stamp,nan", "stamp,1,1"])
def test_directions_must_be_in_order_within_a_turn(path, header):
    with pytest.raises(lf.SourceError, match="in order and within one turn"):
        read(path, f"{header}\n1,2,3\n")


@pytest.mark.parametrize(
    ("text", "line", "complaint"),
    [
        ("stamp,0.1\n1,2\n1,2,3\n1,2\n", "3", "expected 2 cells as in the header, got 3"),
        ("stamp,0.1\n1,2\n1,z\n1,2\n", "3", "could not convert string to float"),
        ("angle,range,scan\n0.1,2,0\nz,2,0\n0,2,1\n", "3", "could not convert"),
        ("angle,range,scan\n0.1,2,0\n,2,0\n0,2,1\n", "3", "expected an angle in radians"),
        ("angle,range,scan\n0.1,2,0\n1,2,1\n1,2,1\n0,2,2\n", "5", "strictly increasing"),
        ("angle,range,scan\n0.1,2,0\n1,2,1\n0.1,2,2\n0.1,2,2\n", "end", "strictly increasing"),
    ],
)
def test_a_broken_row_is_named_or_skipped(path, text, line, complaint):
    with pytest.raises(lf.SourceError, match=complaint) as error:
        read(path, text)
    assert f"{path}:{line}: " in str(error.value)
    source, scans = read(path, text, on_error="skip")
    assert (len(scans), source.skipped) == (2, 1)


def npz(path, **arrays):
    np.savez(path.with_suffix(".npz"), **arrays)
    return path.with_suffix(".npz").read_bytes()


def test_an_archive(path):
    ranges = [[1.0, 2.0, 0.05], [3.0, math.nan, 9.0]]
    content = npz(
        path,
        ranges=ranges,
        angles=[-0.1, 0, 0.1],
        stamps=[5, 6],
        range_min=0.1,
        range_max=8,
        poses=[[1, 2, 0.5], [math.nan] * 3],
        something_else=["a"],
    )
    source, (first, second) = read(path, content)
    assert (source.format, source.poses) == ("npz", "odometry")
    assert (first.stamp, first.pose) == (5, lf.Pose2D(1, 2, 0.5))
    assert first.valid.tolist() == [True, True, False]
    assert second.valid.tolist() == [True, False, False]
    assert second.pose is None
    source, scans = read(path, gzip.compress(content), range_max=2)
    assert (source.format, scans[0].valid.tolist()) == ("npz", [True, False, False])


def test_an_archive_of_one_scan_with_decreasing_angles(path):
    source, (scan,) = read(path, npz(path, ranges=[1.0, 2.0], angles=[0.2, 0.1]))
    assert (scan.angles.tolist(), scan.ranges.tolist()) == ([0.1, 0.2], [2, 1])
    assert source.poses == "none"
    assert math.isnan(scan.stamp)


@pytest.mark.parametrize(
    ("arrays", "complaint"),
    [
        ({"ranges": [1.0]}, "expected the arrays ranges and angles, got ranges"),
        ({}, "expected the arrays ranges and angles, got none"),
        ({"ranges": np.ones((3, 2)), "angles": [0.0]}, "angles must have shape"),
        ({"ranges": np.ones((3, 2, 2)), "angles": [0.0, 1]}, "ranges must have shape"),
        ({"ranges": np.ones((3, 2)), "angles": [0.0, 1], "stamps": [1]}, "stamps must have shape"),
        ({"ranges": ["a"], "angles": [0.0]}, "array of type <U1"),
        ({"ranges": [1j], "angles": [0.0]}, "array of type complex128"),
        ({"ranges": np.array([None]), "angles": [0.0]}, "Object arrays cannot be loaded"),
        ({"ranges": [1.0, 2], "angles": [0.0, 0]}, "strictly increasing"),
        ({"ranges": [1.0, 2], "angles": [0.0, 1], "range_min": 9, "range_max": 8}, "limits"),
        ({"ranges": np.ones((0, 2)), "angles": [0.0, 1]}, "expected laser scans, got none"),
    ],
)
def test_an_archive_that_does_not_fit(path, arrays, complaint):
    with pytest.raises(lf.SourceError, match=complaint) as error:
        read(path, npz(path, **arrays))
    assert str(path) in str(error.value)


def test_breezy_and_brenner_records_that_do_not_fit(path):
    good = " ".join(["1000000", *["0"] * 24, *["20"] * 682]) + "\n"
    source, (scan,) = read(path, good)
    assert (source.format, scan.stamp, scan.valid.all()) == ("breezyslam", 1, True)
    with pytest.raises(lf.SourceError, match=":2: expected 25 fields and 682 ranges, got 706"):
        read(path, good + good[:-4] + "\n" + good)
    source, scans = read(path, good + good.replace("20\n", "x\n") + good, on_error="skip")
    assert (len(scans), source.skipped) == (2, 1)
    source, (scan,) = read(path, "S 1500 3 1000 15 2000\n")
    assert (source.format, scan.stamp, scan.valid.tolist()) == ("brenner", 1.5, [True, False, True])
    with pytest.raises(lf.SourceError, match="as many ranges, got 5 fields that start with 'S 15"):
        read(path, "S 1500 3 1000 15\n")


def test_rows_of_the_urg(path):
    row = ",".join(["1000"] * 682)
    zeros = ",".join(["0"] * 682)
    source, scans = read(path, f"{row}\n{zeros}\n{row}\n{zeros}\n")
    assert (source.format, len(scans), source.skipped) == ("urg_csv", 2, 0)
    with pytest.raises(lf.SourceError, match=":2: expected 682 ranges in mm, got 681"):
        read(path, f"{row}\n{row[5:]}\n")


def test_rplidar_turns(path):
    text = "".join(f"{a % 360} {1000 + a} 15\n" for a in range(10, 10 + 800, 2))
    source, scans = read(path, text)
    assert source.format == "rplidar"
    assert [scan.ranges.size for scan in scans] == [180, 180, 40]
    assert scans[0].angles[-1] == pytest.approx(np.pi, abs=1e-9)
    assert np.diff(scans[0].angles) == pytest.approx(np.radians(2))
    assert scans[1].ranges.min() == pytest.approx(1.370)
    with pytest.raises(lf.SourceError, match="expected 5 measurements as #COUNT= says, got 2"):
        read(path, "#COUNT=5\n1 1000 15\n2 1000 15\n")[1]
    _, (scan,) = read(path, "#RPLIDAR\n1 1000 15\n1 1001 15\n1 1002 15\n2 0 0\n")
    assert scan.ranges.tolist() == [0, 1, 1.001, 1.002]
    assert scan.valid.sum() == 3
