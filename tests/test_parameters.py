"""Parameters are checked by type and size, whatever extractor or stage they are of."""

import math
from dataclasses import fields

import numpy as np
import pytest
from contract import CASES, Case
from scenes import scan_of

import laserfeatures as lf
from laserfeatures import Intersections, SegmentFilter
from laserfeatures.noise_model import NoiseModel, RangeNoise
from laserfeatures.registry import find_factory

OWNERS = {
    **{str(case): find_factory(case.name, case.preset) for case in CASES},
    "segment_filter": SegmentFilter,
    "intersections": Intersections,
    "range_noise": lambda **given: RangeNoise(**{"sigma": 0.01, **given}),
}
MADE = {name: make() for name, make in OWNERS.items()}
PARAMETERS = [
    pytest.param(name, field, id=f"{name}-{field.name}")
    for name, made in MADE.items()
    for field in fields(made)
]
every_parameter = pytest.mark.parametrize(("owner", "field"), PARAMETERS)
HUGE = 10**400  # a float holds no such number
NUMBERS = ("1cm", True, np.True_, [0.1], np.array(0.1), 0.1j, HUGE)
# For each type: what the message says, and what it is said of.
WRONG = {
    int: ("a whole number under 2", ("4", 4.0, 4.5, math.nan, math.inf, None, True, [4], 2**63)),
    float: ("a number", (*NUMBERS, None)),
    float | None: ("a number", NUMBERS),
    bool: ("True or False", ("yes", 1, 0.0, None)),
    tuple[int, int]: (
        "two odd numbers",
        ("21,11", "ab", 21, None, (21.0, 11), (True, 11), (21, 11, 1), (21, "1"), (math.inf, 11)),
    ),
}
SCALARS = {
    int: (np.int64, np.int16, np.uint64),
    float: (np.float64, np.float32),
    bool: (np.bool_,),
    tuple: (np.array, list),
}


def test_every_parameter_is_of_a_type_that_is_checked():
    assert {field.type for _, field in (param.values for param in PARAMETERS)} == set(WRONG)


@every_parameter
def test_a_value_of_another_type_is_named_with_what_is_expected(owner, field):
    says, values = WRONG[field.type]
    for value in values:
        with pytest.raises(ValueError, match=f"^{field.name} must be {says}[^\n]*, got ") as error:
            OWNERS[owner](**{field.name: value})
        assert str(error.value).endswith(repr(value))


@pytest.mark.parametrize(
    ("name", "unit", "value"),
    [
        ("theta_step", " [rad]", "1deg"),
        ("distance_step", " [m]", "2cm"),
        ("range_sigma", " [m]", "1cm"),  # of the class that it extends
        ("range_sigma_relative", "", "1%"),
    ],
)
def test_a_number_with_a_unit_is_told_which_unit_it_is_to_be_in(name, unit, value):
    with pytest.raises(ValueError, match="must be a number") as error:
        lf.get_extractor("direct_hough", **{name: value})
    assert str(error.value) == f"{name} must be a number{unit}, got {value!r}"


@every_parameter
def test_what_is_no_number_at_all_is_refused(owner, field):
    for value in (math.nan, np.float64("nan"), -1):
        with pytest.raises(ValueError, match=f"^{field.name} "):
            OWNERS[owner](**{field.name: value})


@every_parameter
def test_scalars_of_numpy_become_numbers_of_python(owner, field):
    default = getattr(MADE[owner], field.name)
    # What is left out by default is given in full; a share of the range needs what it adds to.
    besides = {"range_sigma": 0.01} if field.name == "range_sigma_relative" else {}
    value = 0.01 if default is None else default
    for scalar in SCALARS[type(value)]:
        given = scalar(value)
        found = getattr(OWNERS[owner](**{field.name: given}, **besides), field.name)
        assert type(found) is type(value)
        assert found == pytest.approx(value, rel=1e-6)


@pytest.mark.parametrize("case", CASES, ids=str)
def test_with_scalars_of_numpy_the_same_is_found(case):
    scan = scan_of([(2, -1), (2, 1.2)], [(2, 1.2), (-1, 1.2)], sigma=0.003)
    kinds = {int: np.uint8, float: np.float64, bool: np.bool_, tuple: np.array}
    plain = case.make()
    given = {
        field.name: kinds[type(value)](value)
        for field in fields(plain.detector)
        if (value := getattr(plain.detector, field.name)) is not None
        and not (isinstance(value, int) and value > 255)
    }
    found, expected = case.make(**given)(scan), plain(scan)
    assert len(expected.corners)
    np.testing.assert_array_equal(found.corners.positions, expected.corners.positions)
    np.testing.assert_array_equal(found.lines.theta, expected.lines.theta)


LARGE = [
    pytest.param(case, field.name, id=f"{case}-{field.name}")
    for case in CASES
    for field in fields(MADE[str(case)])
    if field.type is int and field.name != "scales"  # of an image there are no more than 8
]


@pytest.mark.parametrize(("case", "name"), LARGE)
def test_the_largest_whole_numbers_are_no_trouble(case, name):
    scan = scan_of([(2, -1), (2, 1.2)], [(2, 1.2), (-1, 1.2)], sigma=0.003)
    most = 2**63 - 1 if name == "seed" else 2**31 - 1
    if name == "window":  # of samples, wider than the scan
        with pytest.raises(ValueError, match=f"window is {most} beams, the scan has only"):
            case.make(**{name: most})(scan)
        return
    found = case.make(**{name: most})(scan)
    assert len(found.lines) <= 2 + 6 * case.literal
    with pytest.raises(ValueError, match=f"^{name} must be a whole number under 2"):
        case.make(**{name: most + 1})


def test_a_window_wider_than_the_plane_of_votes_leaves_one_peak():
    scan = scan_of([(2, -1), (2, 1.2)], [(2, 1.2), (-1, 1.2)], sigma=0.003)
    wide = Case("direct_hough", "paper").make(neighborhood=(2**20 + 1, 2**31 - 1))
    assert len(wide(scan).lines) == 1


@pytest.mark.parametrize("memory", ["3", 2.5, math.inf, math.nan, True, None])
def test_the_memory_of_a_noise_model_is_a_whole_number(memory):
    with pytest.raises(ValueError, match=r"^memory must be a whole number under 2\*\*31, got "):
        NoiseModel(memory=memory)
    assert NoiseModel(memory=np.int64(30)).memory == 30


def test_limits_are_told_after_types():
    with pytest.raises(ValueError, match=r"^seed must be >= 0, got -"):
        lf.get_extractor("ransac", seed=-(2**70))
