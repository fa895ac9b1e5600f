import functools
import inspect
from dataclasses import dataclass

import click
import pytest

from laserfeatures import registry
from laserfeatures.cli.parameters import all_parameters, parameters_of, parse_assignments


@dataclass(frozen=True, kw_only=True)
class Detector:
    """Find nothing.

    Parameters
    ----------
    step : float
        Angular step, over
        two lines [rad].
    near, far : float
        Limits of [0, 1] and more [m].
    count : int
        How many.

    Returns
    -------
    fake : int
        No parameter [s].
    """

    step: float = 0.5
    near: float = 0.1
    far: float | None = None
    count: int = 3
    secret: float = 1.0

    stages = {"segment_filter": {"max_error": 0.123}}  # noqa: RUF012 - read only


@dataclass(frozen=True, kw_only=True)
class Finer(Detector):
    """Find less.

    Parameters
    ----------
    far : float
        Told anew [m].
    """

    step: float = 0.25


def function(step, *, width: "Unknown" = 2, **rest):  # noqa: F821 - a plugin may have such
    """Make a detector, without any section."""


@pytest.fixture
def detector(monkeypatch):
    monkeypatch.setitem(registry._registered, "nothing", Detector)


def test_signature_and_docstring_make_the_parameters():
    found = parameters_of(Detector)
    assert list(found) == ["step", "near", "far", "count", "secret"]
    assert found["step"].meaning == "Angular step, over two lines."
    assert [found[name].unit for name in found] == ["rad", "m", "m", "", None]
    assert found["far"].meaning == found["near"].meaning == "Limits of [0, 1] and more."
    assert found["far"].kind == float | None
    assert found["step"].title == "step = 0.5 rad (28.65 deg)"


def test_a_class_inherits_what_its_bases_tell():
    found = parameters_of(Finer)
    assert list(found) == ["far", "step", "near", "count", "secret"]  # its own first
    assert found["step"].default == 0.25
    assert found["step"].unit == "rad"
    assert found["far"].meaning == "Told anew."


def test_a_partial_changes_defaults_only():
    found = parameters_of(functools.partial(Detector, step=0.75))
    assert found["step"].default == 0.75
    assert found["step"].unit == "rad"


def test_a_plain_function_will_do():
    found = parameters_of(function)
    assert list(found) == ["step", "width"]
    assert found["step"].default is inspect.Parameter.empty
    assert found["step"].title == "step (required)"
    assert found["width"].unit is None


@pytest.mark.usefixtures("detector")
def test_own_defaults_of_a_stage_are_told():
    assert all_parameters(Detector)["segment_filter.max_error"].default == 0.123


@pytest.mark.usefixtures("detector")
def test_assignments_become_arguments():
    chosen = parse_assignments("nothing", ("step=10deg", "count=7", "step=20deg", "far=none"))
    assert chosen == {
        "preset": None,
        "step": pytest.approx(0.349066, abs=1e-6),
        "count": 7,
        "far": None,
    }


@pytest.mark.usefixtures("detector")
def test_a_stage_keeps_what_the_extractor_asks_of_it():
    kind = type(parse_assignments("nothing", ("intersections.max_distance=5m",))["intersections"])
    assert kind.__name__ == "Intersections"
    stage = parse_assignments("nothing", ("segment_filter.min_points=9",))["segment_filter"]
    assert stage.min_points == 9
    assert stage.max_error == 0.123


@pytest.mark.usefixtures("detector")
@pytest.mark.parametrize(
    ("assignment", "reason"),
    [
        ("step", "--param takes name=value, got 'step'"),
        ("=1", "--param takes name=value, got '=1'"),
        ("step=", "--param takes name=value, got 'step='"),
        ("stpe=1", "nothing has no parameter 'stpe'; did you mean 'step'?"),
        ("segment_filter.max_eror=1", "did you mean 'segment_filter.max_error'"),
        ("segment_filter=1", "nothing has no parameter 'segment_filter'"),
        ("step=1m", "step is an angle [rad], got the length '1m'"),
        ("segment_filter.max_error=1deg", "segment_filter.max_error is a length [m]"),
    ],
)
def test_a_wrong_assignment_says_what_would_be_right(assignment, reason):
    with pytest.raises(click.ClickException) as error:
        parse_assignments("nothing", (assignment,))
    assert reason in error.value.message
