import csv

import numpy as np
import pytest
from recordings import DATA, RECORDINGS, Recording, lines_of, needs_recordings

import laserfeatures as lf

pytestmark = needs_recordings


def read(path, **options):
    with lf.open_source(DATA / path, **options) as scans:
        return list(scans)


@pytest.mark.parametrize("recording", RECORDINGS, ids=lambda r: r.path.rpartition("/")[2])
class TestEachRecording:
    def test_scans_beams_and_stamps(self, recording: Recording):
        with lf.open_source(DATA / recording.path) as source:
            scans = list(source)
        assert (source.format, source.poses) == (recording.format, recording.poses)
        assert (source.skipped, source.first_error) == (0, None)
        assert len(scans) == recording.scans
        assert {scan.ranges.size for scan in scans} == {recording.beams}
        span = np.degrees(scans[0].angles[-1] - scans[0].angles[0])
        assert span == pytest.approx(recording.field_of_view, abs=0.006)
        assert all((scan.pose is None) == (recording.poses == "none") for scan in scans)
        stamps = np.array([scan.stamp for scan in scans])
        if recording.first_stamp is None:
            assert np.isnan(stamps).all()
        else:
            assert stamps[0] == pytest.approx(recording.first_stamp, rel=0, abs=1e-6)
            assert stamps[-1] == pytest.approx(recording.last_stamp, rel=0, abs=1e-6)
            assert (np.diff(stamps) > 0).all()

    def test_beams_are_one_read_only_array(self, recording: Recording):
        scans = read(recording.path)
        assert all(scan.angles is scans[0].angles for scan in scans)
        assert not scans[0].angles.flags.writeable


@pytest.mark.parametrize(
    "recording", [r for r in RECORDINGS if r.largest], ids=lambda r: r.path.rpartition("/")[2]
)
def test_no_returns_and_only_they_are_dropped(recording: Recording):
    scans = read(recording.path)
    assert sum(np.count_nonzero(~scan.valid) for scan in scans) == recording.no_returns
    assert max(scan.ranges[scan.valid].max() for scan in scans) == recording.largest


def test_poses_are_the_lasers_first_pose():
    scans = read("sick/flirt_mit-cscail.log.gz")
    assert scans[0].pose == lf.Pose2D(576.536523, 0.106594, -2.255213)
    scans = read("sick/aces-corrected.log.gz")
    assert scans[0].pose == lf.Pose2D(0.89706, -0.180771, -0.454003)
    scans = read("sick/csail.corrected.gfs.gz")
    assert scans[0].pose == lf.Pose2D(576.480680, -0.103068, -1.487635)


def test_raw_odometry_and_corrected_poses_are_those_of_the_derived_table():
    with (DATA / "derived/csail_odometry_and_corrected.csv").open() as file:
        rows = list(csv.DictReader(line for line in file if not line.startswith("#")))
    odometry = read("sick/csail.corrected.gfs.gz")
    corrected = read("sick/csail-corrected.log.gz")
    for kind, scans in (("odom", odometry), ("corr", corrected)):
        expected = [
            float(row[next(k for k in row if k.startswith(kind) and "x" in k)]) for row in rows
        ]
        assert [scan.pose.x for scan in scans] == pytest.approx(expected, abs=2e-3)


def test_directions_of_flaser_are_the_sick_grid():
    scan = read("sick/belgioioso-corrected.log.gz")[0]
    assert np.degrees(scan.angles) == pytest.approx(np.arange(-90, 90.25, 0.5))
    scan = read("sick/aces-corrected.log.gz")[0]
    assert np.degrees(scan.angles) == pytest.approx(np.arange(-90, 89.5, 1))


def test_directions_of_robotlaser_are_unrounded():
    scan = read("sick/flirt_mit-cscail.log.gz")[0]
    assert np.degrees(scan.angles[-1]) == pytest.approx(90, abs=1e-9)


def test_directions_of_the_urg():
    scan = read("urg/breezy_exp1.dat.gz")[0]
    assert scan.angles[384 - 44] == 0
    scan = read("urg/brenner_robot4")[0]
    assert scan.angles[330] == pytest.approx(-0.06981317)
    assert np.diff(scan.angles) == pytest.approx(0.006135923)


def test_the_brenner_square_is_two_metres_wide():
    """The README: every scan fits the walls of the square with a median residual of 6 mm."""
    points = read("urg/brenner_robot4")[0].points
    headings = np.radians(np.arange(209, 218, 0.5))
    shifts = np.arange(-0.12, 0.13, 0.01)
    best = np.inf
    for heading in headings:
        walls = lf.Pose2D(1.850, 1.897, heading).transform(points)
        x, y = (np.minimum(np.abs(v), np.abs(v - 2)) for v in (walls.T[..., None] + shifts))
        best = min(best, np.median(np.minimum(x[:, :, None], y[:, None, :]), axis=0).min())
    assert best < 0.008


def test_the_scan_file_alone_is_read_as_its_folder():
    alone = read("urg/brenner_robot4/robot4_scan.txt.gz")
    folder = read("urg/brenner_robot4")
    assert [scan.stamp for scan in alone] == [scan.stamp for scan in folder]


def test_rows_of_zeros_are_no_scans():
    lines = lines_of("urg/frm_g5_Scan1.csv.gz", b"", 50)
    assert len(lines) == 50
    filled = [line for line in lines if line.strip(b"0,\n")]
    assert len(filled) == len(read("urg/frm_g5_Scan1.csv.gz")) == 3


def test_bag_limits_are_the_messages():
    scans = read("rosbag/legtracker_demo_stationary_simple_environment.bag")
    ranges = np.concatenate([scan.ranges for scan in scans])
    assert np.isinf(ranges).mean() == pytest.approx(0.658, abs=5e-4)
    assert np.isnan(ranges).mean() == pytest.approx(0.007, abs=5e-4)
    assert scans[0].range_max == pytest.approx(5.6)
    assert all(np.isfinite(scan.points).all() for scan in scans)


def test_ros1_ros2_and_mcap_give_the_same_scans():
    ros1 = read("rosbag/legtracker_demo_stationary_simple_environment.bag")
    for path in ("ros2_converted/urg04lx_ros2_sqlite3", "ros2_converted/urg04lx_ros2_mcap"):
        ros2 = read(path)
        assert all(
            np.array_equal(a.ranges, b.ranges, equal_nan=True)
            for a, b in zip(ros1, ros2, strict=True)
        )
        assert np.array_equal(ros1[0].angles, ros2[0].angles)


def test_rplidar_turns_counter_clockwise():
    lines = [line.split() for line in lines_of("rplidar/tdt4856_points_8k_1.txt", b"34.9969", 1)]
    scan = read("rplidar/tdt4856_points_8k_1.txt")[0]
    beam = np.argmin(np.abs(scan.angles + np.radians(34.9969)))
    assert scan.angles[beam] == pytest.approx(-np.radians(34.9969), abs=1e-9)
    assert scan.ranges[beam] == float(lines[0][1]) / 1000
