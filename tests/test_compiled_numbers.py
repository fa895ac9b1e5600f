"""Kernels are compiled once, whatever kinds of numbers scans and parameters are given as."""

import importlib
import math
import pkgutil
from dataclasses import dataclass, fields
from typing import NamedTuple

import laserfeatures_plugins
import numpy as np
import pytest
from cli_runs import fails, run
from numba import config

import laserfeatures
import laserfeatures as lf
from laserfeatures import compiled
from laserfeatures.engine import WallDetector
from laserfeatures.noise_model import NoiseModel, RangeNoise
from laserfeatures.pipeline import Pipeline
from laserfeatures.simulation import Scanner, hallway

pytestmark = pytest.mark.skipif(config.DISABLE_JIT, reason="without JIT nothing is compiled")


def all_kernels():
    """Return all kernels of the package and its plugins."""
    found = {}
    for package in (laserfeatures, laserfeatures_plugins):
        for module in pkgutil.walk_packages(package.__path__, f"{package.__name__}."):
            if not module.name.endswith("__main__"):
                for value in vars(importlib.import_module(module.name)).values():
                    if isinstance(value, compiled._Kernel):
                        found[id(value)] = value
    return list(found.values())


KERNELS = all_kernels()


def variants():
    """Return how many variants of kernels there are in this process."""
    return sum(len(kernel.overloads) for kernel in KERNELS)


def scan(number=float, **limits):
    world, path = hallway()
    made = Scanner().scan(world, path[0], np.random.default_rng(0))
    limits = {"range_min": 0.0, "range_max": 4.0, "stamp": 1.0} | limits
    given = {name: number(value) for name, value in limits.items()}
    return lf.LaserScan(angles=made.angles, ranges=made.ranges, **given)


NUMBERS = (int, np.float32, np.float64, np.int64, np.uint8, np.array, np.float16)


@pytest.mark.parametrize("name", ["direct_hough", "region_growing", "kanade_tomasi"])
def test_numbers_of_any_kind_in_a_scan_compile_nothing(name):
    extractor, model = lf.get_extractor(name), NoiseModel()
    expected = extractor(scan())
    model.feed(scan())
    before = variants()
    for number in NUMBERS:
        given = scan(number)
        assert {type(v) for v in (given.range_min, given.range_max, given.stamp)} == {float}
        found = extractor(given)
        assert np.array_equal(found.corners.positions, expected.corners.positions)
        model.feed(given)
    uniform = lf.LaserScan.uniform(scan().ranges, -1, np.float32(0.01), range_max=4)
    extractor(uniform)
    odd = np.frombuffer(b"\0" + expected.scan.ranges.tobytes(), np.uint8)[1:].view(np.float64)
    assert not odd.flags.aligned
    extractor(lf.LaserScan(angles=expected.scan.angles, ranges=odd))
    assert variants() == before


@pytest.mark.parametrize("value", [True, np.True_, "4", None, 4j, [4.0], np.array([4.0]), 10**400])
@pytest.mark.parametrize("field", ["range_min", "range_max", "stamp"])
def test_what_is_no_number_in_a_scan_is_one_line(field, value):
    with pytest.raises(ValueError, match=f"^{field} must be a number[^\n]*, got [^\n]*$"):
        lf.LaserScan(angles=[0.0], ranges=[1.0], **{field: value})


@dataclass(frozen=True, kw_only=True)
class Careless(WallDetector):
    """A third party's, which checks nothing."""

    max_gap: "float" = 1
    own: "float" = 2

    def __post_init__(self):
        pass


def test_third_parties_parameters_of_any_kind_compile_nothing(monkeypatch):
    monkeypatch.setitem(lf.registry._registered, "careless", Careless)
    lf.get_extractor("direct_hough")(scan(), noise=RangeNoise(sigma=0.01))
    before = variants()
    for number in (int, np.float32, np.int64, float):
        extractor = lf.get_extractor(
            "careless", max_gap=number(1), range_sigma=number(1), min_points=np.int16(5)
        )
        assert {type(extractor.detector.max_gap), type(extractor.detector.own)} == {float}
        extractor(scan())
        Careless(max_gap=number(1), min_points=np.int16(5))(scan())  # without a pipeline
    assert variants() == before


@pytest.mark.parametrize("value", [4.0, math.inf, 10**30, "4", True])
def test_third_parties_parameters_are_checked_when_they_are_given(value, monkeypatch):
    monkeypatch.setitem(lf.registry._registered, "careless", Careless)
    says = f"^min_points must be a whole number under [^\n]*, got {value!r}$"
    with pytest.raises(ValueError, match=says.replace("**", r"\*\*")):
        lf.get_extractor("careless", min_points=value)
    with pytest.raises(ValueError, match=says):
        Pipeline(name="x", detector=Careless(min_points=value))


class Pair(NamedTuple):
    a: float
    b: int


@compiled.kernel
def total(x: float, n: int, pair: Pair, more: tuple[float, bool]) -> float:
    return x + n + pair.a + pair.b + more[0]


@pytest.mark.parametrize("number", [int, float, np.float32, np.int32, bool, np.bool_])
def test_a_kernel_has_one_variant_whatever_it_is_called_with(number):
    one = number(1)
    count = 1 if number in {float, np.float32} else one
    assert total(one, count, Pair(one, count), (one, True)) == 5.0
    assert total(1.0, 1, Pair(1.0, 1), (1.0, True)) == 5.0
    assert len(total.overloads) == 1


def test_every_number_that_a_kernel_is_given_is_annotated():
    for kernel in KERNELS:
        assert None not in kernel._hints(), kernel
    assert {field.name for field in fields(Careless)} > {"own"}


def test_warm_up_compiles_all_that_python_calls():
    result = run("warm-up")
    assert result.exit_code == 0, result.stderr
    rows = [line.split() for line in result.stdout.splitlines()]
    assert [row[0] for row in rows] == [*lf.list_extractors(), "SLAM"]
    assert all(row[2] == "s" and float(row[1]) >= 0 for row in rows)
    left = {kernel.__name__ for kernel in KERNELS if not kernel.overloads}
    assert left <= {"bins_on", "is_gap"}  # only tests call them from Python


def test_warm_up_of_some_and_of_broken_ones(monkeypatch):
    def broken():
        raise OSError("no such luck")

    monkeypatch.setitem(lf.registry._registered, "broken", broken)
    assert "extractor 'broken' cannot be made" in fails("warm-up", "broken")
    assert "did you mean 'ransac'" in fails("warm-up", "ransc")
    assert run("warm-up", "ransac").stdout.startswith("ransac ")
    monkeypatch.setattr("laserfeatures.list_extractors", lambda: ("broken", "ransac"))
    result = run("warm-up")
    assert result.exit_code == 0
    assert "laserfeatures: broken is left out: extractor 'broken' cannot be made" in result.stderr
    assert [line.split()[0] for line in result.stdout.splitlines()] == ["ransac", "SLAM"]
