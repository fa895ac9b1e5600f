"""No-returns that only the log as a whole shows, in logs of all kinds."""

import numpy as np
import pytest
from click.testing import CliRunner

import laserfeatures as lf
from laserfeatures.cli import main

ANGLES = np.linspace(-np.pi / 2, np.pi / 2, 361)


def corridor(scans=30, *, sigma=0.01, seed=0):
    """Return ranges between two walls that drift, and which beams get no return."""
    rng = np.random.default_rng(seed)
    left = 1.5 + 0.02 * np.arange(scans)[:, None]
    away = np.abs(np.sin(ANGLES))
    ranges = np.where(ANGLES > 0, left, 3.5 - left) / np.maximum(away, 1e-3)
    ranges += rng.normal(0, sigma, ranges.shape)
    return ranges, ranges > 7.0, rng


def read(path, ranges, **limits):
    np.savez(path, ranges=ranges, angles=ANGLES, **limits)
    with lf.open_source(path) as source:
        return source, np.array([scan.valid for scan in source])


@pytest.fixture
def path(tmp_path):
    return tmp_path / "log.npz"


@pytest.mark.parametrize("value", [5.6 + 2, 8.0, 12.0, 50.0, 51.2])
def test_one_value_again_and_again(path, value):
    ranges, silent, _ = corridor()
    ranges[silent] = value
    source, valid = read(path, ranges)
    assert np.array_equal(valid, ~silent)
    assert source.no_return == value
    assert "taken for no return" in source.notices[0]


def test_values_from_50_to_51_m(path):
    ranges, silent, rng = corridor()
    ranges[silent] = np.round(rng.uniform(50.0, 51.2, silent.sum()), 2)
    ranges[:, 5::9] = 50.5  # as glass on all sides
    silent[:, 5::9] = True
    assert np.array_equal(read(path, ranges)[1], ~silent)


@pytest.mark.parametrize("cut", [False, True])
@pytest.mark.parametrize("sigma", [0.01, 0.03])
def test_a_limit_with_noise(path, sigma, cut):
    ranges, silent, rng = corridor()
    ranges[silent] = 10 + rng.normal(0, sigma, silent.sum())
    if cut:
        ranges = np.minimum(ranges, 10.0)
    source, valid = read(path, ranges, range_max=10.0)
    assert np.array_equal(valid, ~silent)
    assert 9.8 < source.no_return < 10


def test_walls_just_below_the_limit_stay(path):
    ranges, silent, rng = corridor()
    ranges[silent] = 10.0
    end = np.abs(ANGLES) < 0.2  # a wall across, 9.8 m ahead
    ranges[:, end] = 9.8 / np.cos(ANGLES[end]) + rng.normal(0, 0.01, (len(ranges), end.sum()))
    _, valid = read(path, ranges, range_max=10.0)
    assert valid[:, end].mean() > 0.8
    far = ranges.copy()
    far[:, end] *= 5  # through a door, 49 m
    far[:, ~end] = np.minimum(far[:, ~end], 6.0 + rng.normal(0, 0.01, far[:, ~end].shape))
    _, valid = read(path, far)
    assert valid.all()


def test_range_max_overrides(path):
    ranges, silent, _ = corridor()
    ranges[silent] = 8.0
    np.savez(path, ranges=ranges, angles=ANGLES)
    with lf.open_source(path, range_max=20) as source:
        assert all(scan.valid.all() for scan in source)
        assert source.no_return is None


def info(path, *options):
    run = CliRunner().invoke(main, ["info", str(path), *options])
    assert run.exit_code == 0, run.output
    return run.output


def test_info_says_what_was_taken_and_what_it_cannot_judge(path):
    ranges, silent, _ = corridor()
    ranges[silent] = 8.0
    np.savez(path, ranges=ranges, angles=ANGLES)
    assert "no return         8 m and beyond (--range-max" in info(path)
    assert f"notice            {silent.sum()} ranges of 8 m" in info(path, "--range-max", "20m")
    np.savez(path, ranges=corridor()[0], angles=ANGLES)
    assert "notice" not in info(path, "--range-max", "20m")
    np.savez(path, ranges=corridor()[0] * 30, angles=ANGLES)
    assert "are they metres?" in info(path)
