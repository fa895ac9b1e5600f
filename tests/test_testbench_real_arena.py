"""The truth of the recorded arena, and what becomes of bad input."""

import gzip
import math

import numpy as np
import pytest
from recordings import DATA, needs_recordings

from laserfeatures.errors import SourceError
from laserfeatures.evaluation import match_corners, oracle
from laserfeatures.sources import open_source
from laserfeatures.testbench.real import arena
from laserfeatures.testbench.real.recordings import RECORDINGS, Recording, load

FOLDER = DATA / "urg/brenner_robot4"


@pytest.fixture(scope="module")
def scans():
    with open_source(FOLDER) as source:
        return list(source)


@needs_recordings
def test_the_arena_is_as_docs_benchmarks_has_it(scans):
    sample = scans[:30]  # each is looked for near the one before
    poses = arena.first_poses(sample, FOLDER / arena.REFERENCE)
    (side, scaled_side, scale), _, count = arena.calibrate(sample, poses)
    assert side == pytest.approx(1.950, abs=0.02)
    assert scaled_side == pytest.approx(1.963, abs=0.02)
    assert scale == pytest.approx(1.0206, abs=0.01)
    assert 5 < count <= 30
    seen = arena.sights(sample, poses, side)
    assert np.median([sight.residual for sight in seen]) < 0.008
    assert arena.share_on_poles(seen, side, FOLDER / arena.LANDMARKS) > 0.6


@needs_recordings
def test_the_views_of_the_arena_have_its_sides_and_corners(scans):
    views = arena.views(FOLDER, scans[:30])
    for view in views:
        truth = view.truth
        assert 2 <= truth.theta.size <= 4
        assert len(truth.corners) == {2: 1, 3: 2, 4: 4}[truth.theta.size]
        assert view.unsure.shape == (0, 2)
        assert np.array_equal(view.known, view.scan.valid)
        counts = np.bincount(truth.line[truth.line >= 0])
        assert counts.min() >= arena.MIN_BEAMS
        points = (view.scan.ranges[:, None] * view.scan.directions)[truth.line >= 0]
        line = truth.line[truth.line >= 0]
        off = points[:, 0] * np.cos(truth.theta[line]) + points[:, 1] * np.sin(truth.theta[line])
        assert abs(off - truth.d[line]).max() <= arena.ON_WALL + 1e-9
        for i in range(truth.theta.size):
            turns = (truth.theta - truth.theta[i]) / (math.pi / 2)
            assert turns == pytest.approx(turns.round(), abs=1e-6)
    found = sum(
        len(match_corners(oracle(v.scan, v.truth).corners.positions, v.truth.corners)[0])
        for v in views
    )
    assert found > 0.9 * sum(len(view.truth.corners) for view in views)


@needs_recordings
def test_every_recording_of_table_2_is_there():
    assert all((DATA / recording.path).exists() for recording in RECORDINGS)


@needs_recordings
def test_scans_that_are_not_where_the_reference_says_are_an_error(scans, tmp_path):
    rows = arena.numbers(FOLDER / arena.REFERENCE, b"P") + np.array((0, 450, -300))
    lines = [b"P %d %d %d\n" % tuple(row) for row in rows.astype(int)]
    path = tmp_path / "moved.txt.gz"
    path.write_bytes(gzip.compress(b"".join(lines)))
    with pytest.raises(SourceError, match=r"moved\.txt\.gz: expected scan 0 to fit the square"):
        arena.first_poses(scans[:1], path)


@pytest.mark.parametrize(
    ("content", "problem"),
    [
        (None, "No such file"),
        (b"no gzip", "expected gzipped lines"),
        (gzip.compress(b"P 1 2 3\n" * 1000, mtime=0)[:-20], "expected gzipped lines"),
        (gzip.compress(b"P 1 two 3\n", mtime=0), "expected gzipped lines of numbers"),
        (gzip.compress(b"P 1 2 3\nP 4\n", mtime=0), "expected gzipped lines of numbers"),
        (gzip.compress(b"L 1 2 3\n", mtime=0), "lines that start with 'P', got none"),
    ],
    ids=["missing", "plain", "cut", "word", "short", "other"],
)
def test_a_damaged_reference_is_named(tmp_path, content, problem):
    path = tmp_path / "reference.txt.gz"
    if content is not None:
        path.write_bytes(content)
    with pytest.raises(SourceError, match=r"reference\.txt\.gz: expected") as caught:
        arena.numbers(path, b"P")
    assert problem in str(caught.value)
    assert "\n" not in str(caught.value)


def test_poses_of_odometry_are_no_truth(tmp_path):
    line = "FLASER 4 1 1 1 1 0 0 0 0 0 0 1.0 host 1.0\n"
    (tmp_path / "raw.log").write_text(line * 3)
    with pytest.raises(SourceError, match=r"raw\.log: expected corrected poses .*'odometry'"):
        load(tmp_path, Recording("raw", "raw.log", "map"))
