"""No kernel reads beyond an array, or what was freed: both would tell something at random."""

import ast
import os
import subprocess
import sys
from pathlib import Path

import numpy as np
import pytest
from scenes import TURN, look, needs_compiler, random_room

import laserfeatures as lf
from laserfeatures import engine
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


def dying_records(source):
    """Return the names of records that are used after the last use of the array they are of.

    A record does not keep its array alive, and what writes a record before it is read finds nothing
    amiss in freed memory until something else is put there. A record that is taken in a loop is
    fine, where the array was made before that: the next turn needs it.
    """
    found = []
    for function in (n for n in ast.walk(ast.parse(source)) if isinstance(n, ast.FunctionDef)):
        names = [n for n in ast.walk(function) if isinstance(n, ast.Name)]
        last = {name.id: max(n.lineno for n in names if n.id == name.id) for name in names}
        given = [n for n in ast.walk(function) if isinstance(n, ast.Assign)]
        made = {
            each.targets[0].id: each.lineno
            for each in given
            if isinstance(each.targets[0], ast.Name)
            and isinstance(each.value, ast.Call)
            and "WALL" in ast.unparse(each.value)
        }
        loops = [n for n in ast.walk(function) if isinstance(n, ast.For | ast.While)]
        for each in given:
            target, value = each.targets[0], each.value
            if not isinstance(target, ast.Name) or not isinstance(value, ast.Subscript):
                continue
            array = ast.unparse(value.value)
            kept = [n for n in loops if made.get(array, 0) < n.lineno < each.lineno <= n.end_lineno]
            if array in made and not kept and last[array] < last[target.id]:
                found.append(target.id)
    return found


@pytest.mark.parametrize(
    "path", sorted(Path(engine.__file__).parent.glob("*.py")), ids=lambda path: path.stem
)
def test_no_record_outlives_its_array(path):
    assert dying_records(path.read_text()) == []


def test_a_record_that_outlives_its_array_is_seen():
    trap = """
def merge(walls):
    room = np.zeros(1, WALL)
    both = room[0]
    for a in range(3):
        solve(both)
"""
    anew = trap.replace("    both = room[0]\n", "").replace(
        "solve(both)", "both = room[0]; solve(both)"
    )
    assert dying_records(trap) == ["both"]
    assert dying_records(trap + "    return room\n") == []
    assert dying_records(anew) == []
