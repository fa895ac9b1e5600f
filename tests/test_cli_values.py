import math
from typing import Literal

import pytest

from laserfeatures.cli.values import describe, parse


@pytest.mark.parametrize(
    ("text", "unit", "value"),
    [
        ("1deg", "rad", math.radians(1)),
        ("0.5rad", "rad", 0.5),
        ("2cm", "m", 0.02),
        ("2 cm", "m", 0.02),
        ("7cm", "m", 0.07),
        ("-3mm", "m", -0.003),
        ("1e-2m", "m", 0.01),
        (".5", "m", 0.5),
        ("250ms", "s", 0.25),
        ("inf", "m", math.inf),
        ("3", "", 3.0),
        ("2cm", None, 0.02),
    ],
)
def test_a_quantity_comes_in_si_units(text, unit, value):
    parsed = parse(text, float, unit)
    assert parsed == value
    assert type(parsed) is float


@pytest.mark.parametrize(
    ("text", "kind", "value"),
    [
        ("7", int, 7),
        ("1e3", int, 1000),
        ("true", bool, True),
        ("No", bool, False),
        ("none", float | None, None),
        ("0.5", float | None, 0.5),
        ("11,21", tuple[int, int], (11, 21)),
        ("1,2,3", tuple[float, ...], (1.0, 2.0, 3.0)),
        ("best", Literal["best", "fast"], "best"),
        ("name", str, "name"),
        ("auto", int | str, "auto"),
    ],
)
def test_the_annotation_decides_what_a_text_is(text, kind, value):
    parsed = parse(text, kind, "")
    assert parsed == value
    assert type(parsed) is type(value)


@pytest.mark.parametrize(
    ("text", "value"),
    [
        ("3", 3),
        ("3.0", 3.0),
        ("3cm", 0.03),
        ("true", True),
        ("none", None),
        ("11, 21", (11, 21)),
        ("x", "x"),
    ],
)
def test_without_annotation_the_form_decides(text, value):
    parsed = parse(text, object)
    assert parsed == value
    assert type(parsed) is type(value)


@pytest.mark.parametrize(
    ("text", "kind", "unit", "reason"),
    [
        ("2cm", float, "rad", "is an angle [rad], got the length '2cm'"),
        ("2deg", float, "m", "is a length [m], got the angle '2deg'"),
        ("2deg", int, "cells", "is a number without a unit, got the angle '2deg'"),
        ("2in", float, "m", "has no unit 'in'"),
        ("abc", float, "m", "must be a number [m], got 'abc'"),
        ("nan", float, "m", "must be a number [m], got 'nan'"),
        ("none", float, "m", "must be a number [m], got 'none'"),
        ("true", int, "", "must be a number, got 'true'"),
        ("2.5", int, "", "must be a whole number, got '2.5'"),
        ("inf", int, "", "must be a whole number, got 'inf'"),
        ("maybe", bool, "", "must be one of true, yes"),
        ("slow", Literal["best", "fast"], "", "must be one of best, fast, got 'slow'"),
        ("11", tuple[int, int], "", "must be 2 values with commas between, got '11'"),
        ("11,x", tuple[int, int], "", "must be a number, got 'x'"),
    ],
)
def test_what_does_not_fit_says_what_would(text, kind, unit, reason):
    with pytest.raises(ValueError, match=r"^(is|has|must)") as error:
        parse(text, kind, unit)
    assert reason in str(error.value)


@pytest.mark.parametrize(
    ("value", "unit", "text"),
    [
        (math.radians(1), "rad", "0.0174533 rad (1 deg)"),
        (0.02, "m", "0.02 m"),
        (3, "", "3"),
        (True, "", "true"),
        (None, "m", "none [m]"),
        (None, "", "none"),
        ((11, 21), "cells", "11,21 cells"),
        ("best", None, "best"),
    ],
)
def test_a_default_is_described_as_it_would_be_typed(value, unit, text):
    assert describe(value, unit) == text
