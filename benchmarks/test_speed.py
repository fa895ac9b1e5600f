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

ROUNDS = 300
TARGET = 0.4  # of the peer's time


@pytest.fixture(scope="module")
def extractor():
    return lf.get_extractor("direct_hough")


@pytest.fixture(params=contest.SENSORS, ids=lambda beams: f"{beams}beams")
def cases(request):
    return contest.room_cases(contest.SENSORS[request.param])


def test_direct_hough(benchmark, extractor, cases):
    assert [contest.faults(extractor(case.scan), case) for case in cases] == [[]] * len(cases)
    scans = cycle([case.scan for case in cases])
    benchmark.group = f"{len(cases[0].scan)} beams"
    benchmark.pedantic(extractor, setup=lambda: ((contest.fresh(next(scans)),), {}), rounds=ROUNDS)


def test_opencv(benchmark, cases):
    calls = [contest.peer_call(case.scan) for case in cases]
    for call, case in zip(calls, cases, strict=True):
        walls, _ = contest.peer_walls(call(), case.truth)
        assert walls >= 2
    turns = cycle(calls)
    benchmark.group = f"{len(cases[0].scan)} beams"
    benchmark.pedantic(lambda call: call(), setup=lambda: ((next(turns),), {}), rounds=ROUNDS)


def test_target(extractor, cases):
    calls = [contest.peer_call(case.scan) for case in cases]

    def ours(k):
        scan = contest.fresh(cases[k % len(cases)].scan)
        return lambda: extractor(scan)

    seconds = contest.interleaved([ours, lambda k: calls[k % len(calls)]], ROUNDS)
    mine, peer = np.median(seconds, axis=1)
    assert mine <= TARGET * peer, f"{mine / peer:.2f} of the peer's time: {mine:.2e} s"
