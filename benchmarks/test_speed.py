"""Time every extractor and its peers on the same scans; check each result before it is timed.

Run ``python -m pytest benchmarks/test_speed.py``. Ours are timed from the polar scan to corners,
on a scan of which nothing has been computed yet; the peers from Cartesian points, or from the image
that `raster_hough` draws, to lines.
"""

from itertools import cycle

import contest
import cv2
import numpy as np
import peers
import pytest
from speed_all import TARGET_BEAMS, TARGETS, all_extractors, makers_of, turns

import laserfeatures as lf

ROUNDS = 600
SLOW_ROUNDS = 20  # of what takes milliseconds
NOISES = 25  # scans from each pose: a processor learns the branches of a scan it sees repeatedly
TARGET = 0.4  # of the peer's time
RIGHT = 0.97  # of the scans must be without a fault: four standard deviations do happen
PAPER_WALLS = 0.6  # of the walls that the paper's raw bins must meet, within two bins
PEER_WALLS = 2  # of each scan's that a peer must meet, within two bins
JUNCTIONS = 0.9  # of the corners in sight that an extractor of points must find
PEERS = peers.FAST | peers.SLOW
EXTRACTORS = all_extractors()


@pytest.fixture(scope="module", params=contest.SENSORS, ids=lambda beams: f"{beams}beams")
def cases(request):
    return contest.room_cases(contest.SENSORS[request.param], noises=NOISES)


@pytest.mark.parametrize("name", EXTRACTORS)
def test_extractor(benchmark, name, cases):
    extractor = EXTRACTORS[name]
    check(name, [extractor(case.scan) for case in cases], cases)
    scans = cycle([case.scan for case in cases])
    benchmark.group = f"{len(cases[0].scan)} beams"
    benchmark.pedantic(extractor, setup=lambda: ((contest.fresh(next(scans)),), {}), rounds=ROUNDS)


@pytest.mark.parametrize("name", PEERS)
def test_peer(benchmark, name, cases):
    chosen = cases[:: 1 if name in peers.FAST else NOISES]
    calls = [PEERS[name](case) for case in chosen]
    for (call, read), case in zip(calls, chosen, strict=True):
        assert contest.walls_met(*read(call()), case.truth)[0] >= PEER_WALLS
    ready = cycle([call for call, _ in calls])
    benchmark.group = f"{len(cases[0].scan)} beams"
    rounds = ROUNDS if name in peers.FAST else SLOW_ROUNDS
    benchmark.pedantic(lambda call: call(), setup=lambda: ((next(ready),), {}), rounds=rounds)


def check(name, results, cases):
    """Check what an extractor found: all walls and corners, unless it cannot by its nature.

    The paper's lines are raw bins, and it stops at eight; an extractor of points has no lines.
    """
    pairs = list(zip(results, cases, strict=True))
    if name == "preset paper":
        met = [
            contest.walls_met(found.lines.theta, found.lines.d, case.truth)[0]
            for found, case in pairs
        ]
        assert sum(met) >= PAPER_WALLS * sum(case.truth.theta.size for case in cases)
    elif not any(len(found.lines) for found in results):
        near = [contest.nearest(case.junctions, found.corners) for found, case in pairs]
        assert np.mean(np.concatenate(near) < contest.CORNER_LIMIT) >= JUNCTIONS
    else:
        wrong = [fault for found, case in pairs if (fault := contest.faults(found, case))]
        assert len(wrong) <= (1 - RIGHT) * len(cases), wrong


def test_the_peers_get_the_image_and_the_arguments_of_raster_hough(monkeypatch, cases):
    scan = cases[0].scan
    picture = peers.picture_of(scan)
    seen = []
    real = cv2.HoughLines
    monkeypatch.setattr(cv2, "HoughLines", lambda *args: seen.append(args) or real(*args))
    EXTRACTORS["raster_hough"](scan)
    call, _ = peers.bare_hough(cases[0])
    call()
    (own, *rest), (image, *others) = seen
    np.testing.assert_array_equal(own, picture.image)
    np.testing.assert_array_equal(image, picture.image)
    assert rest == others


def test_target(cases):
    extractor = lf.get_extractor("direct_hough")
    for case in cases:
        extractor(case.scan)  # compile, if nothing has been compiled yet
    seconds = contest.interleaved(
        contest.contenders(extractor, cases, [contest.sensor_range]), ROUNDS
    )
    mine, peer = np.median(seconds, axis=1)
    assert mine <= TARGET * peer, f"{mine / peer:.2f} of the peer's time: {mine:.2e} s"


@pytest.mark.parametrize("beams", TARGET_BEAMS)
@pytest.mark.parametrize(
    ("name", "other", "limit", "false"),
    [(name, other, limit, false) for name, other, limit, shares in TARGETS for false in shares],
)
def test_target_of(name, other, limit, false, beams):
    cases = contest.room_cases(contest.SENSORS[beams], noises=NOISES, outliers=false)
    ours = {each: EXTRACTORS[each] for each in (name, other) if each in EXTRACTORS}
    rivals = {each: PEERS[each] for each in (other,) if each in PEERS}
    medians = turns(makers_of(cases, ours, rivals), ROUNDS)
    ratio = medians[name] / medians[other]
    assert ratio <= limit, f"{ratio:.2f} of the time of {other}: {medians[name]:.2e} s"
