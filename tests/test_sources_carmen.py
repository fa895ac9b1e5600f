import gzip
import math
import tracemalloc

import numpy as np
import pytest

import laserfeatures as lf

TAIL = "1 2 0.5 3 4 0.6 12.5 host 13.5"


def flaser(ranges, tail=TAIL):
    return f"FLASER {len(ranges)} {' '.join(map(str, ranges))} {tail}\n"


def robotlaser(ranges, start=-1.570796, fov=3.141593, res=0.017453, range_max=50.0, remissions=()):
    values = " ".join(map(str, ranges))
    more = " ".join(map(str, [len(remissions), *remissions]))
    return (
        f"ROBOTLASER1 0 {start} {fov} {res} {range_max} 0.01 0 {len(ranges)} {values} {more} "
        "1 2 0.5 3 4 0.6 0 0 0 0 0 12.5 host 13.5\n"
    )


def read(path, text, **options):
    path.write_text(text)
    with lf.open_source(path, **options) as source:
        return source, list(source)


@pytest.fixture
def path(tmp_path):
    return tmp_path / "a.clf"


def test_a_flaser_record(path):
    source, (scan,) = read(path, flaser([1.5, 2.0, 0.0]))
    assert (source.format, source.poses) == ("carmen", "odometry")
    assert scan.ranges.tolist() == [1.5, 2, 0]
    assert np.degrees(scan.angles) == pytest.approx([-90, 0, 90])
    assert scan.pose == lf.Pose2D(1, 2, 0.5)
    assert scan.stamp == 12.5
    assert scan.valid.tolist() == [True, True, False]


def test_a_robotlaser_record_with_remissions(path):
    _, (scan,) = read(path, robotlaser([3.0] * 181, remissions=[7, 8]))
    assert np.degrees(scan.angles) == pytest.approx(np.arange(-90, 91))
    assert (scan.pose, scan.stamp, scan.range_max) == (lf.Pose2D(1, 2, 0.5), 12.5, 50)


def test_a_robotlaser_of_another_sensor(path):
    _, (scan,) = read(path, robotlaser([3.0] * 682, -2.086214, 4.178466, 0.006136, 5.6))
    assert scan.angles[0] == -2.086214
    assert np.diff(scan.angles) == pytest.approx(0.006136)


def test_a_record_without_times_has_no_stamp(path):
    _, (scan,) = read(path, flaser([1.0, 2.0], "1 2 0.5 3 4 0.6"))
    assert math.isnan(scan.stamp)


@pytest.mark.parametrize("stamp", ["1.01893e+09", "nan"])
def test_a_cut_stamp_is_no_stamp(path, stamp):
    _, (scan,) = read(path, flaser([1.0, 2.0], f"1 2 0.5 3 4 0.6 {stamp} host 1"))
    assert math.isnan(scan.stamp)


def test_a_stamp_in_scientific_notation_with_enough_digits_stays(path):
    _, (scan,) = read(path, flaser([1.0, 2.0], "1 2 0.5 3 4 0.6 1.134864629895e+09 host 1"))
    assert scan.stamp == 1134864629.895


def test_zeros_throughout_are_no_stamps_but_a_first_zero_is(path):
    zero = flaser([1.0, 2.0], "1 2 0.5 3 4 0.6 0 host 0")
    _, scans = read(path, zero + zero)
    assert all(math.isnan(scan.stamp) for scan in scans)
    _, scans = read(path, zero + flaser([1.0, 2.0]))
    assert [scan.stamp for scan in scans] == [0, 12.5]


@pytest.mark.parametrize("word", ["NEFF 0.5", "VERTEX2 0 1 2 3", "EDGE2 0 1"])
def test_records_of_slam_programs_make_poses_corrected(path, word):
    source, _ = read(path, flaser([1.0]) + word + "\n")
    assert source.poses == "corrected"


def test_other_records_are_passed_over(path):
    others = "# comment\nPARAM robot_use_laser on nohost 0\nODOM 0 0 0 0 0 0 1 h 1\nRLASER 1 2\n\n"
    source, scans = read(path, others + flaser([1.0]) + "SYNC x\nRAWLASER1 5\nIMU 3\n#PARAM\n")
    assert (len(scans), source.skipped) == (1, 0)


def test_field_of_view_replaces_what_is_not_said(path):
    _, (scan,) = read(path, flaser([1.0] * 541), field_of_view=math.radians(270))
    assert np.degrees(scan.angles) == pytest.approx(np.arange(-135, 135.25, 0.5))
    _, (scan,) = read(path, robotlaser([1.0] * 3, fov=99), field_of_view=1.0)
    assert scan.angles == pytest.approx([-0.5, 0, 0.5])


@pytest.mark.parametrize("beams", [0, 1, 2, 100_000])
def test_any_number_of_beams(path, beams):
    _, (scan,) = read(path, flaser(np.full(beams, 2.5)))
    assert scan.ranges.size == beams


def test_all_nan(path):
    _, (scan,) = read(path, flaser([math.nan] * 181))
    assert not scan.valid.any()


@pytest.mark.parametrize(
    ("record", "complaint"),
    [
        (flaser([1.0, 2.0])[:-9] + "\n", "FLASER of 2 ranges: expected 8 or 11 fields"),
        (flaser([1.0, "x"]), "ranges in m: could not convert string to float: b'x'"),
        (flaser([1.0], "1 nan 0.5 3 4 0.6 1 h 1"), "finite pose x, y, theta"),
        (flaser([1.0], "1 2 0.5 3 4 0.6 now h 1"), "expected a time in s"),
        ("FLASER two 1 2\n", "expected how many values follow as field 1, got two"),
        ("FLASER -2 1 2\n", "expected how many values follow as field 1, got -2"),
        ("FLASER\n", "expected how many values follow as field 1, got nothing"),
        ("FLASWR 1 2.0 1 2 3 4 5 6\n", "expected a record such as FLASER or ROBOTLASER1"),
        ("FLA", "expected a record such as FLASER or ROBOTLASER1, got 'FLA'"),
        ("\x00\x01 2\n", "expected a record such as FLASER"),
        (robotlaser([1.0] * 3, fov=1.0, res=1.0, start=9e99), "distinct directions"),
        (robotlaser([1.0] * 90), "field of view that fits 90 beams"),
        (robotlaser([1.0] * 3, res="x"), "start, fov, res, maxrange"),
        (robotlaser([1.0] * 181)[:-30] + "\n", "ROBOTLASER1 of 181 ranges: expected 196 fields"),
        ("ROBOTLASER1 0 1\n", "expected how many values follow as field 8"),
    ],
)
def test_a_broken_record_is_named_or_skipped(path, record, complaint):
    good = flaser([1.0, 2.0])
    text = f"{good}NEFF 1\n{record}" + (good if record.endswith("\n") else "")
    with pytest.raises(lf.SourceError) as error:
        read(path, text)
    assert f"{path}:3: " in str(error.value)
    assert complaint in str(error.value)
    assert "on_error='skip'" in str(error.value)
    assert "\n" not in str(error.value)
    assert isinstance(error.value.__cause__, ValueError)
    source, scans = read(path, text, on_error="skip")
    assert source.skipped == 1
    assert complaint in source.first_error
    assert len(scans) == text.count(good)


def test_scans_before_a_broken_record_come_first(path):
    good = flaser([1.0, 2.0])
    path.write_text(good * 700 + "FLASER 3\n" + good)
    with lf.open_source(path) as source:
        scans = [next(source) for _ in range(700)]
        with pytest.raises(lf.SourceError, match=":701:"):
            next(source)
        assert next(source, None) is None
    assert len(scans) == 700


def test_cut_gzip_names_the_line_and_loses_nothing_before(tmp_path):
    path = tmp_path / "a.log"
    rng = np.random.default_rng(0)
    text = "".join(flaser(np.round(rng.uniform(1, 9, 181), 2)) for _ in range(50))
    packed = gzip.compress(text.encode())
    path.write_bytes(packed[: len(packed) // 2])  # gzip, though its name does not say so
    with lf.open_source(path) as source:
        scans = []
        with pytest.raises(lf.SourceError, match="cut or damaged") as error:
            scans.extend(source)
    with lf.open_source(path, on_error="skip") as source:
        scans = list(source)
    assert 10 < len(scans) < 40
    assert f"{path}:{len(scans) + 1}: " in str(error.value)
    assert source.skipped == 1
    assert "cut or damaged" in source.first_error


def test_gfs(tmp_path):
    path = tmp_path / "a.gfs"
    source, (scan,) = read(path, "FRAME 0\nLASER_READING 2 1.5 2.5 1 2 0.5 77.25\nNEFF 1\n")
    assert (source.format, source.poses) == ("gfs", "odometry")
    assert (scan.stamp, scan.pose, scan.ranges.tolist()) == (
        77.25,
        lf.Pose2D(1, 2, 0.5),
        [1.5, 2.5],
    )
    with pytest.raises(lf.SourceError, match=":2: LASER_READING of 2 ranges: expected 6 fields"):
        read(path, "FRAME 0\nLASER_READING 2 1.5 2.5 1 2 0.5\n")
    with pytest.raises(lf.SourceError, match=":2: expected a record such as LASER_READING"):
        read(path, "ODO_UPDATE 0\nLASER_READIN 2 1.5 2.5 1 2 0.5 3\n")


def test_memory_does_not_grow_with_the_log(tmp_path):
    peaks = []
    rng = np.random.default_rng(0)
    lines = [flaser(np.round(rng.uniform(1, 9, 61), 2)) for _ in range(100)]
    for repeats in (20, 200):
        path = tmp_path / f"{repeats}.log"
        with path.open("w") as file:
            for _ in range(repeats):
                file.writelines(lines)
        tracemalloc.start()
        with lf.open_source(path) as source:
            assert sum(1 for _ in source) == 100 * repeats
        peaks.append(tracemalloc.get_traced_memory()[1])
        tracemalloc.stop()
    assert peaks[1] < 1.1 * peaks[0]
    assert peaks[1] < 20e6


def rawlaser(number, ranges, start=-1.570796, fov=3.141593, res=0.017453):
    values = " ".join(map(str, ranges))
    return (
        f"RAWLASER{number} 0 {start} {fov} {res} 81.0 0.01 0 {len(ranges)} {values} 0 "
        "12.5 host 13.5\n"
    )


@pytest.mark.parametrize("number", [1, 2, 3, 4])
def test_raw_records_are_read_where_there_are_no_others(path, number):
    text = "ODOM 0 0 0 0 0 0 1 h 1\n" + rawlaser(number, [2.0] * 181) * 2
    source, (scan, _) = read(path, text)
    assert (source.poses, source.passed_over, source.notices) == ("none", {"ODOM": 1}, ())
    assert np.degrees(scan.angles) == pytest.approx(np.arange(-90, 91))
    assert (scan.pose, scan.stamp, scan.range_max) == (None, 12.5, 81)
    with pytest.raises(lf.SourceError, match="expected RAWLASER1 with"):
        read(path, rawlaser(1, [2.0] * 3))


def test_one_laser_is_read_and_the_records_of_others_are_counted(path):
    rear = robotlaser([2.0] * 181).replace("ROBOTLASER1", "ROBOTLASER2")
    raw = rawlaser(1, [2.0] * 181)
    source, scans = read(path, rear * 2 + raw)
    assert ([len(scan) for scan in scans], source.poses) == ([181, 181], "odometry")
    assert scans[0].pose == lf.Pose2D(1, 2, 0.5)
    assert source.passed_over == {"RAWLASER1": 1}
    source, scans = read(path, raw * 3 + rear * 2 + flaser([1.0] * 180))
    assert [len(scan) for scan in scans] == [180]
    assert source.passed_over == {"RAWLASER1": 3, "ROBOTLASER2": 2}
    source, scans = read(path, rawlaser(3, [2.0] * 181) + raw)
    assert source.passed_over == {"RAWLASER3": 1}
    source, scans = read(path, flaser([1.0] * 180).replace("FLASER", "RLASER"))
    assert [len(scan) for scan in scans] == [180]


@pytest.mark.parametrize("beams", [1081, 682, 360, 180, 181, 361])
def test_a_field_of_view_that_is_guessed_is_told(path, beams):
    source, _ = read(path, flaser([2.0] * beams) * 2)
    assert len(source.notices) == (beams in {1081, 682, 360})
    assert all(f"FLASER of {beams} beams" in text for text in source.notices)
    source, (scan,) = read(path, flaser([2.0] * beams), field_of_view=(-0.5, 1.0))
    assert source.notices == ()
    assert (scan.angles[0], scan.angles[-1]) == (-0.5, pytest.approx(1.0))
    with pytest.raises(ValueError, match="field_of_view must be in"):
        read(path, flaser([2.0] * beams), field_of_view=(1.0, -0.5))
