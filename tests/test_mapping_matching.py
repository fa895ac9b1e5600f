import math
from pathlib import Path

import numpy as np
import pytest

import laserfeatures as lf
from laserfeatures.mapping.matching import matched
from laserfeatures.mapping.reference import Reference
from laserfeatures.mapping.trajectory import Trajectory


def trajectory(stamps, holes=()):
    poses = np.arange(3.0 * len(stamps)).reshape(-1, 3)
    poses[list(holes)] = math.nan
    return Trajectory(stamps=np.array(stamps, dtype=float), poses=poses)


def match(stamps, others, holes=()):
    reference = Reference(trajectory(others, holes), Path("way.txt"), "poses")
    found = matched(trajectory(stamps), reference)
    return found.by, found.estimate.tolist(), found.reference.tolist()


def test_by_stamp_within_half_a_period():
    assert match([10, 11, 12, 13], [10.4, 11.6, 12.1, 13.4]) == ("stamp", [0, 2, 3], [0, 2, 3])
    assert match([10, 11, 12], [9.8, 10.05, 10.3, 10.55, 10.8, 11.05, 11.3]) == (
        *("stamp", [0, 1], [1, 5]),
    )
    assert match(np.arange(10, 12, 0.1), [10.02, 11.01]) == ("stamp", [0, 10], [0, 1])


def test_each_pose_of_the_reference_is_taken_once():
    by, mine, theirs = match([10, 10.5, 10.9, 12], [9, 10.7, 12.2, 13])
    assert by == "stamp"
    assert len(set(theirs)) == len(theirs) == len(mine)


def test_backward_stamps_are_matched_all_the_same():
    stamps = [10, 11, 12, 11.5, 12.5, 13.5]
    assert match(stamps, stamps) == ("stamp", [*range(6)], [*range(6)])


@pytest.mark.parametrize(
    "others",
    [
        [math.nan] * 3,
        [5, math.nan, 6],
        [5.0, 5.0, 5.0],
        [1e9, 1e9 + 1, 1e9 + 2],
        [12.0, 13.0, 14.0],  # one of three alike
    ],
)
def test_by_scan_where_stamps_do_not_tell(others):
    assert match([10, 11, 12], others) == ("scan", [0, 1, 2], [0, 1, 2])
    assert match(others, [10, 11, 12]) == ("scan", [0, 1, 2], [0, 1, 2])


def test_poses_that_are_not_known_are_left_out():
    assert match([10, 11, 12], [10, 11, 12], holes=[1]) == ("stamp", [0, 2], [0, 2])
    assert match([10, 11, 12], [math.nan] * 3, holes=[0]) == ("scan", [1, 2], [1, 2])


def test_a_short_overlap_is_better_than_nothing():
    assert match(np.arange(20), np.arange(17, 57)) == ("stamp", [17, 18, 19], [0, 1, 2])


def test_a_reference_of_another_log_is_named():
    with pytest.raises(
        lf.SourceError,
        match=r"way.txt: expected a reference .* 2 poses \(without stamps\) for 3 scans \(10.000 "
        r"to 12.000 s\): neither their times nor their numbers match",
    ):
        match([10, 11, 12], [math.nan] * 2)
    with pytest.raises(lf.SourceError, match=r"4 poses \(50.000 to 53.000 s\) for 3 scans"):
        match([10, 11, 12], [50, 51, 52, 53])


def test_pairs_are_cut_to_what_goes_together():
    estimate = trajectory([10, 11, 12])
    reference = Reference(trajectory([11, 12]), Path("way.txt"), "poses")
    mine, theirs = matched(estimate, reference).pairs(estimate, reference.trajectory)
    assert mine.stamps.tolist() == theirs.stamps.tolist() == [11, 12]
    assert mine.poses.tolist() == estimate.poses[1:].tolist()
