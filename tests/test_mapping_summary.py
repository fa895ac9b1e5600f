"""A run's figures, by hand and against a reference."""

import json
import math
from pathlib import Path

import numpy as np
import pytest

from laserfeatures.mapping.against import against
from laserfeatures.mapping.matching import matched
from laserfeatures.mapping.reference import Reference
from laserfeatures.mapping.run import Run
from laserfeatures.mapping.summary import summary, way
from laserfeatures.mapping.trajectory import Trajectory
from laserfeatures.slam import Landmark
from laserfeatures.testbench.output import to_json

QUARTER = math.pi / 2
SIDE = 5  # poses a side of the square
TURN = math.radians(30)


def square(size):
    """Return poses (17, 3) around a square, which look where they go."""
    steps = np.repeat(np.arange(4), SIDE - 1)
    x = np.concatenate([[0.0], np.cumsum(np.cos(QUARTER * steps))])
    y = np.concatenate([[0.0], np.cumsum(np.sin(QUARTER * steps))])
    heading = QUARTER * np.append(steps, 3)
    return np.stack([size * x / (SIDE - 1), size * y / (SIDE - 1), heading], axis=1)


def landmark(kind):
    return Landmark(kind=kind, values=np.ones(2), covariance=np.eye(2), ends=np.eye(2), sightings=1)


def a_run(estimate, odometry, stamps=None, **rest):
    count = len(estimate)
    given = {
        "covariances": np.tile(np.diag([9e-4, 16e-4, 4e-4]), (count, 1, 1)),
        "matched": np.arange(count),
        "landmarks": np.arange(count),
        "nis": 3.0 * np.arange(count),
        "seconds": 1e-3 * (1 + np.arange(count)),
        "map": (landmark("corner"), landmark("wall"), landmark("corner")),
        "points": [np.empty((0, 2))] * count,
        "notices": [],
    } | rest
    stamps = 10.0 + np.arange(count) if stamps is None else stamps
    return Run(
        estimate=Trajectory(stamps=stamps, poses=estimate),
        odometry=Trajectory(stamps=stamps, poses=odometry),
        **given,
    )


def test_what_is_counted():
    run = a_run(square(4.0), square(8.0))
    found = summary(run, None, ["odd"], extractor="ransac")
    assert next(iter(found)) == "extractor"
    assert (found["scans"], found["seconds"]) == (17, 16.0)
    assert (found["landmarks"], found["corners"], found["walls"]) == (3, 2, 1)
    assert (found["way"], found["odometry_way"]) == pytest.approx((16, 32))
    assert (found["median_step_ms"], found["worst_step_ms"]) == pytest.approx((9, 17))
    assert found["nis_per_degree"] == pytest.approx(1.5)
    assert found["notices"] == ["odd"]
    np.testing.assert_allclose(found["steps"]["position_deviation"], 0.05)
    np.testing.assert_allclose(found["steps"]["heading_deviation"], 0.02)
    for name in ("ate_rmse", "odometry_ate_rmse", "rpe_rotation", "matched_by", "matched_poses"):
        assert found[name] is None


def test_errors_are_those_of_both_trajectories_and_of_the_matched_poses():
    truth = square(4.0)
    c, s = math.cos(TURN), math.sin(TURN)
    turned = truth @ np.array([[c, s, 0], [-s, c, 0], [0, 0, 1]]) + (7, -3, TURN)
    run = a_run(turned, square(8.0))
    other = Trajectory(stamps=10.0 + np.arange(16), poses=truth[:16])
    reference = Reference(other, Path("truth.txt"), "the truth")
    held = against(run, reference, matched(run.estimate, reference))
    found = summary(run, held)
    assert (found["matched_by"], found["matched_poses"]) == ("stamp", 16)
    assert found["ate_rmse"] == pytest.approx(0, abs=1e-9)
    assert found["rpe_rotation"] == pytest.approx(0, abs=1e-6)
    # Twice too large a square: each place is as far off the middle as it should be, once more.
    middle = truth[:16, :2].mean(axis=0)
    off = np.linalg.norm(truth[:16, :2] - middle, axis=1)
    assert found["odometry_ate_rmse"] == pytest.approx(np.sqrt((off**2).mean()))
    assert found["odometry_ate_max"] == pytest.approx(off.max())
    assert found["odometry_rpe_translation"] == pytest.approx(1)
    np.testing.assert_allclose(held.way, turned[:16, :2], atol=1e-9)


def test_what_is_not_known_is_null_in_json():
    stamps = np.full(17, math.nan)
    run = a_run(square(4.0), square(4.0), stamps, matched=np.zeros(17, dtype=int))
    found = json.loads(to_json(summary(run)), parse_constant=pytest.fail)
    assert found["seconds"] is None
    assert found["nis_per_degree"] is None
    assert found["steps"]["stamp"] == [None] * 17


def test_one_pose_is_no_way():
    assert way(np.zeros((1, 3))) == 0
