import math

import numpy as np
import pytest
from recordings import DATA, needs_recordings
from robots import PLAN_FILE

import laserfeatures as lf
from laserfeatures.mapping.matching import matched
from laserfeatures.mapping.measures import errors
from laserfeatures.mapping.reference import read_reference
from laserfeatures.mapping.trajectory import Trajectory
from laserfeatures.sources.simulated import readings_of

ARENA = DATA / "urg/brenner_robot4"


def odometry_of(path):
    with lf.open_source(path, poses="odometry") as log:
        scans = list(log)
    return Trajectory.of([scan.stamp for scan in scans], [scan.pose for scan in scans])


def test_a_tum_file(tmp_path):
    path = tmp_path / "way.txt"
    path.write_text("5 1 2 0 0 0 0 1\n6 1.5 2 0 0 0 0 1\n")
    reference = read_reference(path)
    assert reference.trajectory.poses.tolist() == [[1, 2, 0], [1.5, 2, 0]]
    assert reference.what == "a trajectory in TUM format"


def test_positions_from_overhead(tmp_path):
    path = tmp_path / "robot9_reference.txt"
    path.write_text("P 378 1850 1897\n\nP 494 1853 -7.5\n")
    (tmp_path / "robot8_reference.txt").write_text("P 1 2 3\n")
    (tmp_path / "robot9_scan.txt").write_text("S 1500 3 1000 15 2000\n")
    for where in (path, tmp_path):
        reference = read_reference(where)
        assert reference.path == path
        assert reference.trajectory.stamps.tolist() == [0.378, 0.494]
        assert reference.trajectory.poses[:, :2].tolist() == [[1.85, 1.897], [1.853, -0.0075]]
        assert np.isnan(reference.trajectory.poses[:, 2]).all()
        assert "overhead" in reference.what


@pytest.mark.parametrize(
    ("line", "complaint"),
    [
        ("P 500 1850", "expected P, milliseconds, x and y in mm, got 3 fields"),
        ("P 500 x 1850", "could not convert"),
        ("P 500 nan 1850", "finite"),
        ("S 500 1 1850", "expected P"),
    ],
)
def test_a_broken_position_is_named(tmp_path, line, complaint):
    path = tmp_path / "robot9_reference.txt"
    path.write_text(f"P 378 1850 1897\n{line}\n")
    with pytest.raises(lf.SourceError, match=rf"robot9_reference.txt:2: .*{complaint}"):
        read_reference(path)


def test_a_folder_without_a_reference_or_with_two_of_other_names(tmp_path):
    (tmp_path / "robot9_scan.txt").write_text("S 1500 3 1000 15 2000\n")
    (tmp_path / "empty").touch()
    with pytest.raises(lf.SourceError, match="one file with records P ms x y, got none"):
        read_reference(tmp_path)
    (tmp_path / "a").write_text("P 1 2 3\n")
    assert read_reference(tmp_path).path.name == "a"
    (tmp_path / "b").write_text("P 1 2 3\n")
    with pytest.raises(lf.SourceError, match="one file with records P ms x y, got a, b"):
        read_reference(tmp_path)


def test_a_table_and_one_without_poses(tmp_path):
    path = tmp_path / "scans.csv"
    path.write_text("stamp,x,y,theta,0,0.1\n1,2,3,0.5,1,1\n2,,,,1,1\n")
    poses = read_reference(path).trajectory.poses
    assert poses[0].tolist() == [2, 3, 0.5]
    assert np.isnan(poses[1]).all()
    path.write_text("stamp,x,y,theta,0,0.1\n1,,,,1,1\n2,,,,1,1\n")
    with pytest.raises(lf.SourceError, match="expected poses, got none in any of 2 scans"):
        read_reference(path)
    path.write_text("stamp,0,0.1\n1,1,1\n")
    with pytest.raises(lf.SourceError, match="more than odometry, got one with no poses"):
        read_reference(path)


def test_a_table_of_corrected_poses(tmp_path):
    path = tmp_path / "both.csv"
    path.write_text("# both\ni,t,odom_x,corr_x,corr_y,corr_th\n0,5.25,9,1,2,0.5\n1,6,9,3,4,-1\n")
    reference = read_reference(path)
    assert reference.trajectory.stamps.tolist() == [5.25, 6]
    assert reference.trajectory.poses.tolist() == [[1, 2, 0.5], [3, 4, -1]]
    path.write_text("i,t,corr_x,corr_y,corr_th\n0,5,1,2,0.5\n1,6,9\n")
    with pytest.raises(lf.SourceError, match=r"both.csv:3: expected 5 cells .* got 3"):
        read_reference(path)
    path.write_text("i,t,corr_x,corr_y,corr_th\n0,5,1,2,north\n")
    with pytest.raises(lf.SourceError, match=r"both.csv:2: expected numbers as t, corr_x"):
        read_reference(path)
    path.write_text("i,t,corr_x,corr_y,corr_th\n")
    with pytest.raises(lf.SourceError, match="expected rows of poses, got none"):
        read_reference(path)


def test_a_plan_is_its_own_truth(tmp_path):
    path = tmp_path / "room.toml"
    path.write_text(PLAN_FILE)
    reference = read_reference(path)
    assert reference.what == "the true poses of a simulated robot"
    truth = [reading.observation.pose for reading in readings_of(path)]
    assert reference.trajectory.poses[-1].tolist() == list(vars(truth[-1]).values())
    found = matched(odometry_of(path), reference)
    assert (found.by, len(found.estimate)) == ("stamp", len(truth))


@needs_recordings
def test_the_csail_run_is_matched_by_scan_as_its_stamps_are_cut():
    reference = read_reference(DATA / "sick/csail-corrected.log.gz")
    assert reference.what == "corrected poses"
    odometry = odometry_of(DATA / "sick/csail.corrected.gfs.gz")
    pairs = matched(odometry, reference)
    assert (pairs.by, len(pairs.estimate)) == ("scan", 406)
    apart = errors(*pairs.pairs(odometry, reference.trajectory))
    assert apart.ate_rmse == pytest.approx(8.67, abs=0.01)
    # the same poses beside their stamps
    table = read_reference(DATA / "derived/csail_odometry_and_corrected.csv")
    pairs = matched(odometry, table)
    assert (pairs.by, len(pairs.estimate)) == ("stamp", 406)
    again = errors(*pairs.pairs(odometry, table.trajectory))
    assert again.ate_rmse == pytest.approx(apart.ate_rmse, abs=1e-3)
    # the longer log of the same drive has stamps
    pairs = matched(odometry, read_reference(DATA / "sick/flirt_mit-cscail.log.gz"))
    assert pairs.by == "stamp"
    assert len(pairs.estimate) > 380


@needs_recordings
def test_the_arena_by_stamp_and_raw_odometry_refused():
    reference = read_reference(ARENA)
    assert len(reference.trajectory) == 278
    odometry = odometry_of(ARENA)
    pairs = matched(odometry, reference)
    assert pairs.by == "stamp"
    assert len(pairs.estimate) > 250
    assert errors(*pairs.pairs(odometry, reference.trajectory)).ate_rmse < 0.08
    for path in ("sick/csail.corrected.gfs.gz", "urg/breezy_exp1.dat.gz"):
        with pytest.raises(lf.SourceError, match="more than odometry, got one with raw odometry"):
            read_reference(DATA / path)
    assert math.isnan(reference.trajectory.poses[0, 2])
