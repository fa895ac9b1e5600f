"""Poses by the wheel ticks of the breezy and brenner logs."""

import math

import numpy as np
import pytest
from recordings import DATA, needs_recordings, unpacked
from scipy.spatial import cKDTree

import laserfeatures as lf
from laserfeatures.poses import compose

ARENA = "urg/brenner_robot4"
ROVER = "urg/breezy_exp1.dat.gz"


def read(path, **options):
    with lf.open_source(path, **options) as source:
        scans = list(source)
    return source, scans


def breezy(*rows):
    """Return a log of (seconds, left, right)."""
    ranges = " ".join(["2000"] * 682)
    other = " ".join(["0"] * 21)
    return "".join(f"{int(t * 1e6)} 0 {left} {right} {other} {ranges}\n" for t, left, right in rows)


def test_breezy_ticks_are_the_scanners_way(tmp_path):
    path = tmp_path / "rover.dat"
    path.write_text(breezy((1, 0, 0), (2, 2000, 2000), (3, 2000, 2000), (4, 1500, 2500)))
    source, scans = read(path)
    assert source.poses == "odometry"
    turn = math.tau * 0.077
    # The counts of 0.15 s before each scan's own.
    assert scans[0].pose == lf.Pose2D(0, 0, 0)
    assert scans[1].pose.x == pytest.approx(0.85 * turn)
    assert scans[2].pose.x == pytest.approx(turn)
    theta = 0.85 * (turn / 2) / 0.33
    pose = compose(lf.Pose2D(turn - 0.145, 0, theta), lf.Pose2D(0.145, 0, 0))
    assert vars(scans[3].pose) == pytest.approx(vars(pose))


def test_a_breezy_jump_or_a_tick_that_is_no_number_is_named(tmp_path):
    path = tmp_path / "rover.dat"
    path.write_text(
        breezy((1, 5, 5), (2, 10, 10), (3, 9e6, 10), (4, 9e6 + 5, 15)).replace(".0", "")
    )
    with pytest.raises(lf.SourceError, match=r"rover.dat:3: .* left wheel, got 8999990 .*from 10"):
        read(path)
    source, scans = read(path, on_error="skip")
    assert (len(scans), source.skipped) == (3, 1)
    assert scans[2].pose.x < 0.01
    path.write_text(breezy((1, 5, 5), (2, "x", 10)))
    with pytest.raises(lf.SourceError, match=r":2: expected ticks of both wheels: .*'x'"):
        read(path)


@needs_recordings
def test_breezy_walls_line_up_by_the_poses():
    _, scans = read(DATA / ROVER)

    def apart(poses):
        found = []
        for i in range(0, len(scans) - 3, 25):
            here, there = (poses[k].transform(scans[k].points) for k in (i, i + 3))
            found.append(np.minimum(cKDTree(here).query(there)[0], 0.3).mean())
        return np.mean(found)

    poses = [scan.pose for scan in scans]
    mirrored = [lf.Pose2D(p.x, -p.y, -p.theta) for p in poses]
    still = [lf.Pose2D(0, 0, 0)] * len(scans)
    assert 2 * apart(poses) < min(apart(mirrored), apart(still))
    way = np.hypot(*np.diff([(p.x, p.y) for p in poses], axis=0).T).sum()
    assert way == pytest.approx(46, abs=1)


@needs_recordings
def test_brenner_poses_are_in_the_frame_of_the_arena():
    """By the walls' directions, which are those of x and y, and by the overhead positions."""
    _, scans = read(DATA / ARENA)
    assert scans[0].pose == lf.Pose2D(1.85, 1.897, pytest.approx(math.radians(213) - math.tau))
    off = []
    for scan in scans:
        points = scan.pose.transform(scan.points) @ [1, 1j]
        chords = points[20:] - points[:-20]
        chords = chords[np.abs(chords) < 0.4]
        off.append(np.angle(np.sum(chords**4 / np.abs(chords) ** 3)) / 4)
    assert np.degrees(np.median(np.abs(off))) < 4
    assert np.degrees(np.max(np.abs(off))) < 12
    lines = unpacked(f"{ARENA}/robot4_reference.txt.gz").split(b"\n")
    overhead = np.array([line.split()[2:] for line in lines if line], dtype=float) / 1000
    found = np.array([(scan.pose.x, scan.pose.y) for scan in scans])
    assert np.sqrt(((found - overhead) ** 2).sum(axis=1).mean()) < 0.12


def arena(folder, motors, name="robot9_motors.txt"):
    scans = "".join(f"S {ms} 3 1000 1000 1000\n" for ms in (500, 1500, 2500))
    (folder / "robot9_scan.txt").write_text(scans)
    (folder / name).write_text(motors)
    return folder / "robot9_scan.txt"


MOTORS = "M {} {} 0 0 0 {} 0 0\n"


def test_the_motors_file_is_found_by_the_scan_files_name(tmp_path):
    path = arena(
        tmp_path,
        MOTORS.format(50, 10, 7)
        + MOTORS.format(1050, 1010, 1007)
        + MOTORS.format(1900, 1010, 1007),
    )
    for where in (path, tmp_path):
        source, scans = read(where)
        assert source.poses == "odometry"
        ways = [math.dist((s.pose.x, s.pose.y), (1.85, 1.897)) for s in scans]
        assert ways == pytest.approx([0, 0.349, 0.349])  # scans are 0.45 s late
    source, scans = read(arena(tmp_path, "no motors"))
    assert (source.poses, scans[0].pose) == ("none", None)
    (tmp_path / "robot9_motors.txt").unlink()
    source, scans = read(arena(tmp_path, MOTORS.format(50, 10, 7), "robot8_motors.txt"))
    assert (source.poses, scans[0].pose) == ("none", None)


def test_scans_after_the_last_ticks_have_no_pose(tmp_path):
    _, scans = read(arena(tmp_path, MOTORS.format(50, 0, 0) + MOTORS.format(700, 0, 0)))
    assert [scan.pose is None for scan in scans] == [False, False, True]


@pytest.mark.parametrize(
    ("line", "complaint"),
    [
        ("M 700 0\n", "expected M, milliseconds and at least 5 more fields, got 3"),
        ("S 700 0 0 0 0 0 0\n", "start with 'S 700 0'"),
        (MOTORS.format(1, 0, 0), r"expected a time after 0.05 s, got 0.001 s"),
        (MOTORS.format(700, "y", 0), "could not convert"),
        (MOTORS.format(700, 0, 65530), "of the right wheel, got 65530"),
    ],
)
def test_damaged_motor_lines_are_named_or_skipped(tmp_path, line, complaint):
    path = arena(tmp_path, MOTORS.format(50, 0, 0) + line + MOTORS.format(1700, 0, 0))
    with pytest.raises(lf.SourceError, match=f"robot9_motors.txt:2: .*{complaint}"):
        read(path)
    source, scans = read(path, on_error="skip")
    skipped = 2 if "65530" in line else 1  # there and back again
    assert (len(scans), source.skipped) == (3, skipped)


def test_motors_without_a_whole_line_are_refused(tmp_path):
    path = arena(tmp_path, MOTORS.format(50, "z", 0))
    with pytest.raises(lf.SourceError, match=r"robot9_motors.txt: expected records M"):
        read(path, on_error="skip")
