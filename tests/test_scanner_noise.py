import math
from dataclasses import replace

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from scenes import ORIGIN, wall

from laserfeatures import Pose2D
from laserfeatures.simulation import Scanner, World, hallway, random_room
from laserfeatures.simulation.raycast import cast, cos_incidence

PERFECT = Scanner(range_sigma=0.0)
NARROW = Scanner(beams=3, field_of_view=1e-3, range_sigma=0.0)
EVERYTHING = {
    "relative_sigma": 0.002,
    "incidence_sigma": 0.003,
    "dark_sigma": 0.02,
    "dropouts": 0.05,
    "outliers": 0.05,
    "beam_width": 0.01,
    "resolution": 0.001,
    "range_min": 0.1,
}


def spread(scanner, world, pose=ORIGIN, scans=1500):
    """Return the standard deviation of each beam's range over many scans."""
    rng = np.random.default_rng(5)
    return np.std([scanner.scan(world, pose, rng).ranges for _ in range(scans)], axis=0)


def front(distance, *, turn=0.0, reflectivity=0.9):
    """Return a wall through (distance, 0) that the x axis meets at `turn` off its normal."""
    return World(
        walls=[wall(turn, distance * math.cos(turn), -50, 50)], reflectivity=[reflectivity]
    )


def test_without_effects_the_noise_is_one_normal_number_a_beam():
    world, poses = hallway()
    ranges, _ = Scanner().cast(world, poses[0])
    rng, own = np.random.default_rng(8), np.random.default_rng(8)
    for _ in range(3):  # and nothing else is drawn between two scans
        scan = Scanner().scan(world, poses[0], rng)
        np.testing.assert_array_equal(scan.ranges, ranges + own.normal(0.0, 0.005, 181))


@pytest.mark.parametrize("distance", [2.0, 8.0])
def test_relative_noise_is_added_in_quadrature(distance):
    scanner = replace(NARROW, range_sigma=0.005, relative_sigma=0.002)
    expected = math.hypot(0.005, 0.002 * distance)
    np.testing.assert_allclose(spread(scanner, front(distance)), expected, rtol=0.08)


@pytest.mark.parametrize(
    ("degrees", "factor"), [(0, 0.0), (45, 1.0), (70, math.tan(math.radians(70)))]
)
def test_incidence_noise_grows_with_the_tangent(degrees, factor):
    scanner = replace(NARROW, incidence_sigma=0.004)
    got = spread(scanner, front(3.0, turn=math.radians(degrees)))
    np.testing.assert_allclose(got, 0.004 * factor, rtol=0.08, atol=1e-5)


def test_all_deviations_are_added_in_quadrature():
    scanner = replace(
        NARROW, range_sigma=0.003, relative_sigma=0.001, incidence_sigma=0.004, dark_sigma=0.005
    )
    expected = math.sqrt(0.003**2 + 0.003**2 + 0.004**2 + 0.005**2)
    got = spread(scanner, front(3.0, turn=math.pi / 4, reflectivity=0.5))
    np.testing.assert_allclose(got, expected, rtol=0.08)


def test_incidence_noise_stays_finite_along_a_wall():
    got = spread(replace(NARROW, incidence_sigma=0.004), front(3.0, turn=math.radians(89.9)))
    np.testing.assert_allclose(got, 0.004 * math.tan(math.radians(80)), rtol=0.08)


def test_a_pole_is_met_obliquely_at_its_edge():
    world = World(poles=[(3.0, 0.0, 0.5)])
    angles = np.array([0.0, math.asin(0.25 / 3), math.asin(0.499999 / 3)])
    _, surface = cast(world, np.zeros(2), angles)
    got = cos_incidence(world, np.zeros(2), angles, surface)
    np.testing.assert_allclose(got, [1.0, math.sqrt(0.75), 0.0], atol=3e-3)


@pytest.mark.parametrize(("share", "factor"), [(1.0, 0.0), (0.5, 1.0), (0.1, 9.0)])
def test_dark_surfaces_are_measured_worse(share, factor):
    got = spread(replace(NARROW, dark_sigma=0.002), front(3.0, reflectivity=share))
    np.testing.assert_allclose(got, 0.002 * factor, rtol=0.08, atol=1e-9)


def test_the_colour_is_that_of_the_surface_hit():
    world = World(
        walls=[wall(0.0, 5.0, -50, 50)],
        boxes=[(2.0, 1.0, 0.4, 0.8, 0.0)],
        poles=[(2.0, -1.0, 0.3)],
        reflectivity=[1.0, 0.5, 0.1],
    )
    scanner = Scanner(
        beams=3, field_of_view=2 * math.atan2(1.0, 2.0), range_sigma=0.0, dark_sigma=0.002
    )
    got = spread(scanner, world)
    np.testing.assert_allclose(got, [0.018, 0.0, 0.002], rtol=0.08, atol=1e-9)


def test_as_many_beams_drop_out_and_err_as_asked_for():
    world, poses = hallway()
    scanner = replace(PERFECT, dropouts=0.1, outliers=0.2, range_max=30.0)
    rng = np.random.default_rng(1)
    seen = [scanner.observe(world, poses[0], rng) for _ in range(300)]
    ranges = np.array([s.scan.ranges for s in seen])
    surface = np.array([s.surface for s in seen])
    true, hit = scanner.cast(world, poses[0])
    lost, wrong = np.isinf(ranges), np.isfinite(ranges) & (ranges != true)
    assert lost.mean() == pytest.approx(0.1, abs=0.005)
    assert wrong.mean() == pytest.approx(0.9 * 0.2, abs=0.007)
    np.testing.assert_array_equal(surface, np.where(lost | wrong, -1, hit))
    assert 0.3 <= ranges[wrong].min() < 0.31
    assert 9.99 < ranges[wrong].max() < 10.0
    assert ranges[wrong].mean() == pytest.approx(5.15, abs=0.1)


def test_outliers_stay_within_the_limits():
    scanner = replace(PERFECT, outliers=1.0, range_min=2.0, range_max=4.0)
    seen = scanner.observe(*_first_of_the_hallway(), np.random.default_rng(1))
    assert seen.scan.valid.all()
    assert (seen.surface == -1).all()


def _first_of_the_hallway():
    world, poses = hallway()
    return world, poses[0]


def test_ranges_come_in_steps():
    scanner = Scanner(resolution=0.01)
    ranges = scanner.scan(*_first_of_the_hallway(), np.random.default_rng(1)).ranges
    fine = Scanner().scan(*_first_of_the_hallway(), np.random.default_rng(1)).ranges
    np.testing.assert_allclose(ranges / 0.01, np.round(ranges / 0.01), atol=1e-9)
    assert 0.004 < abs(ranges - fine).max() <= 0.005 + 1e-12


def test_what_is_too_near_gives_no_return():
    world = World(walls=[wall(0.0, 1.0, -50, 50)])
    seen = replace(PERFECT, range_min=1.2).observe(world, ORIGIN, np.random.default_rng(0))
    near = 1 / np.cos(PERFECT.angles) < 1.2
    assert near.any()
    np.testing.assert_array_equal(seen.surface == -1, near | (seen.scan.ranges >= 10))


def test_a_beam_on_an_edge_shows_the_mean_of_its_footprint():
    # The nearer wall covers the first tenth of the middle beam's footprint.
    near_end = 2.0 * math.tan(0.01 * (0.1 - 0.5))
    world = World(walls=[[(2.0, -5.0), (2.0, near_end)], [(6.0, -9.0), (6.0, 9.0)]])
    scanner = Scanner(beams=3, field_of_view=0.1, range_sigma=0.0, beam_width=0.01)
    seen = scanner.observe(world, ORIGIN, np.random.default_rng(0))
    assert seen.scan.ranges[1] == pytest.approx(0.1 * 2.0 + 0.9 * 6.0, abs=2e-3)
    assert seen.surface.tolist() == [0, -1, 1]
    true, _ = scanner.cast(world, ORIGIN)
    np.testing.assert_array_equal(seen.scan.ranges[[0, 2]], true[[0, 2]])


def test_a_pole_thinner_than_the_footprint_mixes_with_the_wall_behind():
    world = World(walls=[wall(0.0, 4.0, -9, 9)], poles=[(2.0, 0.0, 0.005)])
    scanner = Scanner(beams=3, field_of_view=0.1, range_sigma=0.0, beam_width=0.01)
    seen = scanner.observe(world, ORIGIN, np.random.default_rng(0))
    assert seen.scan.ranges[1] == pytest.approx((2.0 + 4.0) / 2, abs=0.01)  # half of it is pole
    assert seen.surface.tolist() == [0, -1, 0]


@pytest.mark.parametrize("lean", [0.0, 1.0, 1.4])
@pytest.mark.parametrize("convex", [True, False])
def test_where_two_surfaces_meet_no_pixel_is_mixed(lean, convex):
    sign = 1 if convex else -1
    corner, c, s = (3.0, 0.0), math.cos(lean), math.sin(lean)
    far = 3 + 2 * sign * s
    world = World(walls=[[corner, (far, 2 * c)], [(far, -2 * c), corner]])
    scanner = Scanner(beams=51, field_of_view=0.1, range_sigma=0.0, beam_width=0.01)
    seen = scanner.observe(world, ORIGIN, np.random.default_rng(0))
    np.testing.assert_array_equal(seen.scan.ranges, scanner.cast(world, ORIGIN)[0])
    assert set(seen.surface) <= {0, 1}


@pytest.mark.parametrize(("end", "surface"), [(0.004, 0), (-0.004, -1)])
def test_a_beam_that_half_misses_shows_what_its_middle_does(end, surface):
    world = World(walls=[[(2.0, -5.0), (2.0, end)]])
    scanner = Scanner(beams=3, field_of_view=0.1, range_sigma=0.0, beam_width=0.01)
    seen = scanner.observe(world, ORIGIN, np.random.default_rng(0))
    assert seen.surface.tolist() == [0, surface, -1]
    assert seen.scan.ranges[1] == (2.0 if surface == 0 else math.inf)


@given(st.integers(0, 300))
def test_a_mixed_pixel_lies_between_what_its_footprint_covers(seed):
    world, pose = random_room(seed, poles=3)
    scanner = Scanner(beams=181, range_sigma=0.0, range_max=50.0, beam_width=0.015)
    seen = scanner.observe(world, pose, np.random.default_rng(0))
    across = np.array([
        scanner.cast(world, Pose2D(pose.x, pose.y, pose.theta + off))[0]
        for off in np.linspace(-0.0075, 0.0075, 41)
    ])  # fmt: skip
    slack = 0.05 * across.max(axis=0)
    assert (seen.scan.ranges >= across.min(axis=0) - slack).all()
    assert (seen.scan.ranges <= across.max(axis=0) + slack).all()


@given(st.integers(0, 10**6), st.sampled_from(sorted(EVERYTHING)))
def test_everything_on_the_same_seed_gives_the_same_scan(seed, left_out):
    world, pose = random_room(seed % 50, poles=3)
    scanner = Scanner(**{k: v for k, v in EVERYTHING.items() if k != left_out})
    first, second = (scanner.observe(world, pose, np.random.default_rng(seed)) for _ in range(2))
    np.testing.assert_array_equal(first.scan.ranges, second.scan.ranges)
    np.testing.assert_array_equal(first.surface, second.surface)


@pytest.mark.parametrize("name", sorted(EVERYTHING))
def test_switching_an_effect_on_leaves_the_others_as_they_were(name):
    world, pose = random_room(3, poles=3)
    others = {k: v for k, v in EVERYTHING.items() if k != name}
    rngs = np.random.default_rng(4), np.random.default_rng(4)
    for _ in range(3):  # the generators stay in step from scan to scan
        without = Scanner(**others).observe(world, pose, rngs[0])
        with_it = Scanner(**{**others, name: EVERYTHING[name]}).observe(world, pose, rngs[1])
        lost = np.isinf(without.scan.ranges), np.isinf(with_it.scan.ranges)
        assert (lost[1] | ~lost[0]).all()
        if name in {"dropouts", "outliers"}:
            same = (without.scan.ranges == with_it.scan.ranges).mean()
            assert 0.8 < same < 1.0
        elif name.endswith("sigma"):
            np.testing.assert_array_equal(without.surface == -1, with_it.surface == -1)
            assert (without.scan.ranges != with_it.scan.ranges).any()
    assert rngs[0].random() == rngs[1].random()


@pytest.mark.parametrize("effect", [{"dropouts": 0.1}, {"outliers": 0.1}])
def test_drop_outs_and_outliers_leave_the_noise_of_later_scans_alone(effect):
    world, poses = hallway()
    rngs = np.random.default_rng(4), np.random.default_rng(4)
    for pose in poses:
        plain = Scanner().scan(world, pose, rngs[0])
        seen = Scanner(**effect).observe(world, pose, rngs[1])
        kept = seen.surface >= 0
        assert 100 < kept.sum() < 181
        np.testing.assert_array_equal(seen.scan.ranges[kept], plain.ranges[kept])


@pytest.mark.parametrize(
    ("parameters", "message"),
    [
        ({"range_min": -1.0}, r"range_min must be >= 0 m and less than range_max, got -1\.0"),
        ({"range_min": 11.0}, r"range_min must be >= 0 m and less than range_max, got 11\.0"),
        ({"relative_sigma": -1.0}, r"relative_sigma must be >= 0, got -1\.0"),
        ({"incidence_sigma": math.nan}, "incidence_sigma must be >= 0 m, got nan"),
        ({"dark_sigma": math.inf}, "dark_sigma must be >= 0 m, got inf"),
        ({"resolution": -0.1}, r"resolution must be >= 0 m, got -0\.1"),
        ({"dropouts": 1.1}, r"dropouts must be in \[0, 1\], got 1\.1"),
        ({"outliers": -0.1}, r"outliers must be in \[0, 1\], got -0\.1"),
        ({"beam_width": 4.0}, r"beam_width must be in \[0, pi\) rad, got 4\.0"),
        ({"outliers": 0.1, "range_max": 0.2}, r"outliers need a range of view beyond 0\.3 m"),
    ],
)
def test_noise_that_makes_no_sense_is_refused(parameters, message):
    with pytest.raises(ValueError, match=message):
        Scanner(**parameters)


def test_the_models_have_the_papers_figures():
    lms, urg = Scanner.model("lms200"), Scanner.model("urg04lx_ug01")
    assert (lms.beams, lms.range_max, lms.range_sigma) == (181, 10.0, 0.005)
    assert np.degrees(lms.angles[[0, -1]]).tolist() == [-90, 90]
    assert (urg.beams, urg.range_max, urg.range_sigma) == (667, 4.0, 0.005)
    np.testing.assert_allclose(np.degrees(np.diff(urg.angles)), 0.36)
    assert 240 - 0.36 < math.degrees(urg.field_of_view) <= 240
    assert Scanner.model("lms200", outliers=0.1) == Scanner(outliers=0.1)


def test_an_unknown_model_is_named_with_the_near_ones():
    with pytest.raises(ValueError, match="no scanner 'lms100'; did you mean 'lms200'"):
        Scanner.model("lms100")
    with pytest.raises(TypeError, match="beam"):
        Scanner.model("lms200", beam=3)
