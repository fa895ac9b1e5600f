"""Time `direct_hough` beside OpenCV's Hough transform of the same points.

Run ``python -m pytest benchmarks/test_speed.py``. Each result is checked before it is timed. Ours
is timed from the polar scan to the corners, on a scan of which nothing has been computed yet; the
peer from Cartesian points to lines.
"""

from itertools import cycle

import contest
import numpy as np
import pytest

import laserfeatures as lf

ROUNDS = 600
NOISES = 25  # scans from each pose: a processor learns the branches of a scan it sees repeatedly
TARGET = 0.4  # of the peer's time
RIGHT = 0.97  # of the scans must be without a fault: four standard deviations do happen


@pytest.fixture(scope="module")
def extractor():
    return lf.get_extractor("direct_hough")


@pytest.fixture(params=contest.SENSORS, ids=lambda beams: f"{beams}beams")
def cases(request):
    return contest.room_cases(contest.SENSORS[request.param], noises=NOISES)


def test_direct_hough(benchmark, extractor, cases):
    wrong = [fault for case in cases if (fault := contest.faults(extractor(case.scan), case))]
    assert len(wrong) <= (1 - RIGHT) * len(cases), wrong
    scans = cycle([case.scan for case in cases])
    benchmark.group = f"{len(cases[0].scan)} beams"
    benchmark.pedantic(extractor, setup=lambda: ((contest.fresh(next(scans)),), {}), rounds=ROUNDS)


def test_opencv(benchmark, cases):
    calls = [contest.peer_call(case.scan, contest.sensor_range(case.scan)) for case in cases]
    for call, case in zip(calls, cases, strict=True):
        walls, _ = contest.peer_walls(call(), case.truth)
        assert walls >= 2
    turns = cycle(calls)
    benchmark.group = f"{len(cases[0].scan)} beams"
    benchmark.pedantic(lambda call: call(), setup=lambda: ((next(turns),), {}), rounds=ROUNDS)


def test_target(extractor, cases):
    for case in cases:
        extractor(case.scan)  # compile, if nothing has been compiled yet
    seconds = contest.interleaved(
        contest.contenders(extractor, cases, [contest.sensor_range]), ROUNDS
    )
    mine, peer = np.median(seconds, axis=1)
    assert mine <= TARGET * peer, f"{mine / peer:.2f} of the peer's time: {mine:.2e} s"
