"""No kernel reads beyond an array, or what was freed: both would tell something at random."""

import os
import subprocess
import sys
from pathlib import Path

import numpy as np
from scenes import TURN, look, needs_compiler, random_room

import laserfeatures as lf
from laserfeatures.simulation import World

SCANS = 36
NAMES = [name for name in lf.list_extractors() if name != "kanade_tomasi"]

pytestmark = needs_compiler


def random_scan(seed):
    """Return a scan of a room with poles and a half column, open or a ring, with false beams."""
    rng = np.random.default_rng(seed)
    world, pose = random_room(rng)
    poles = [(*rng.uniform(0.3, 3.5, 2), rng.uniform(0.05, 0.5)) for _ in range(3)]
    poles = [p for p in poles if np.hypot(p[0] - pose.x, p[1] - pose.y) > p[2] + 0.3]
    world = World(walls=world.walls, poles=[*poles, (-0.01, -0.01, 0.25)])
    beams = int(rng.choice([3, 20, 90, 361, 720]))
    view = TURN * (beams - 1) / beams if seed % 2 else rng.uniform(1.0, 5.0)
    sigma = rng.choice([0.0, 0.003, 0.02])
    scan, _ = look(world, sigma=sigma, seed=seed, beams=beams, view=view, pose=pose)
    ranges = scan.ranges.copy()
    false = rng.random(beams) < rng.choice([0.0, 0.05, 0.5])
    ranges[false] = rng.uniform(0.1, 12.0, false.sum())
    return lf.LaserScan(angles=scan.angles, ranges=ranges, range_max=30.0)


def numbers():
    """Return all that each extractor finds in each scan, in one array."""
    found = []
    for name in NAMES:
        extractor = lf.get_extractor(name)
        for seed in range(SCANS):
            features = extractor(random_scan(seed))
            lines, corners = features.lines, features.corners
            found += [lines.theta, lines.d, lines.evidence, corners.positions, corners.evidence]
            found += [features.segments.endpoints, [len(lines), len(corners)]]
    return np.concatenate([np.ravel(each) for each in found])


def test_kernels_keep_to_their_arrays_and_to_memory_that_is_theirs(tmp_path):
    here = Path(__file__).parent
    out = tmp_path / "found.npy"
    code = f"import numpy, test_engine_memory as t; numpy.save({str(out)!r}, t.numbers())"
    environment = os.environ | {
        "NUMBA_BOUNDSCHECK": "1",
        "NUMBA_CACHE_DIR": str(tmp_path / "cache"),  # what is compiled so is for this test alone
        "MALLOC_PERTURB_": "165",  # glibc: what is freed, or not filled in, is not what it was
        "PYTHONPATH": os.pathsep.join([str(here), *sys.path]),
    }
    done = subprocess.run(  # noqa: S603 - our own interpreter and code
        [sys.executable, "-c", code], env=environment, capture_output=True, text=True, check=False
    )
    assert done.returncode == 0, done.stderr[-2000:]
    found, expected = np.load(out), numbers()
    assert len(expected) > 4000
    assert len(found) == len(expected)
    np.testing.assert_allclose(found, expected, rtol=1e-6, atol=1e-6)


def test_the_scans_have_something_round_and_walls_of_all_sizes():
    features = [lf.get_extractor("direct_hough")(random_scan(seed)) for seed in range(SCANS)]
    support = np.concatenate([each.lines.support for each in features])
    assert support.min() < 6
    assert support.max() > 60
