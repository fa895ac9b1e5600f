"""What is odd about a log's odometry and stamps is named, and what is not odd is not."""

import math

import numpy as np
import pytest
from recordings import DATA, needs_recordings

import laserfeatures as lf
from laserfeatures.mapping.checks import oddities, together
from laserfeatures.mapping.trajectory import Trajectory

SCANS = 40
PERIOD = 0.5  # [s]
STEP = 0.3  # [m]


@pytest.fixture
def stamps():
    return PERIOD * np.arange(SCANS)


@pytest.fixture
def poses():
    way = STEP * np.arange(SCANS)
    return np.stack([way, 0 * way, np.linspace(0, 12 * math.pi, SCANS) % math.tau], axis=1)


def oddities_of(stamps, poses, **rest):
    return oddities(Trajectory(stamps=stamps, poses=poses), **rest)


def test_a_plain_drive_is_not_odd(stamps, poses):
    assert oddities_of(stamps, poses) == []


def test_unknown_stamps_are_not_odd(stamps, poses):
    assert oddities_of(np.full(SCANS, math.nan), poses) == []
    stamps[7:9] = math.nan
    assert oddities_of(stamps, poses) == []


def test_stamps_that_run_backwards_are_named(stamps, poses):
    stamps[20:] -= 4.5
    (line,) = oddities_of(stamps, poses)
    assert line.startswith("stamps run backwards from scan 19 to 20, by 4 s; ")
    stamps[30:] -= 1.5
    (line,) = oddities_of(stamps, poses)
    assert "from scan 19 to 20, by 4 s (the worst of 2 times)" in line


def test_a_gap_is_named_with_time_and_way(stamps, poses):
    stamps[11:] += 8.0
    (line,) = oddities_of(stamps, poses)
    assert "a gap of 8.5 s from scan 10 to 11" in line
    assert "odometry moved 0.3 m and turned 55 deg; 0.5 s is usual" in line


def test_a_gap_is_not_a_jump_if_the_robot_went_on_at_its_pace(stamps, poses):
    stamps[11:] += 8.0
    poses[11:, 0] += 4.8
    (line,) = oddities_of(stamps, poses)
    assert "a gap of 8.5 s from scan 10 to 11, in which odometry moved 5.1 m" in line


def test_odometry_that_goes_too_far_in_a_gap_jumps_too(stamps, poses):
    stamps[11:] += 8.0
    poses[11:, 0] += 40
    gap, jump = oddities_of(stamps, poses)
    assert "a gap of 8.5 s" in gap
    assert "odometry jumps from scan 10 to 11: it moved 40.3 m" in jump


@pytest.mark.parametrize("unknown", [False, True])
def test_odometry_that_is_reset_is_named(stamps, poses, unknown):
    if unknown:
        stamps[:] = math.nan
    poses[25:] -= poses[25]
    (line,) = oddities_of(stamps, poses)
    assert line.startswith("odometry jumps from scan 24 to 25: it moved 7.2 m and turned ")


def test_a_heading_that_jumps_is_named_but_not_one_that_wraps(stamps, poses):
    poses[:, 2] = math.pi - 1e-3
    poses[18:, 2] = -math.pi + 1e-3
    assert oddities_of(stamps, poses) == []
    poses[18:, 2] = 0.0
    (line,) = oddities_of(stamps, poses)
    assert "odometry jumps from scan 17 to 18: it moved 0.3 m and turned 180 deg" in line


def test_scans_have_their_numbers_in_the_log(stamps, poses):
    stamps[20:] -= 4.5
    (line,) = oddities_of(stamps, poses, scans=[*range(100, 120), *range(130, 150)])
    assert "from scan 119 to 130" in line


def test_one_scan_and_none_are_odd():
    assert "only one scan" in oddities_of([0.0], [(0.0, 0.0, 0.0)])[0]
    assert "no scan" in oddities_of([], np.empty((0, 3)))[0]


def test_two_scans_have_nothing_to_be_compared_with():
    assert oddities_of([0.0, 9.0], [(0.0, 0.0, 0.0), (3.0, 0.0, 0.0)]) == []


def test_notices_that_go_on_are_one():
    said = [(4, "lost"), (5, "lost"), (6, "found"), (7, "lost"), (9, "lost")]
    assert together(said) == [
        "scans 4 to 5: lost", "scan 6: found", "scan 7: lost", "scan 9: lost"
    ]  # fmt: skip
    assert together([]) == []


@needs_recordings
def test_the_odometry_of_a_real_log_is_not_odd():
    with lf.open_source(DATA / "sick/csail.corrected.gfs.gz") as log:
        scans = list(log)
    odometry = Trajectory.of([scan.stamp for scan in scans], [scan.pose for scan in scans])
    assert oddities(odometry) == []
