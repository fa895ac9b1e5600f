"""A map goes to JSON and comes back; a damaged one is refused in one line."""

import json
import math

import numpy as np
import pytest

import laserfeatures as lf
from laserfeatures.mapping.map_file import map_json, read_map
from laserfeatures.slam import Landmark

CORNER = Landmark(
    kind="corner",
    values=np.array([1.25, -math.pi]),
    covariance=np.array([[1e-4, 2e-5], [2e-5, 3e-4]]),
    ends=np.array([[1.25, -math.pi], [1.25, -math.pi]]),
    sightings=17,
)
WALL = Landmark(
    kind="wall",
    values=np.array([math.pi / 3, -2.0]),
    covariance=np.array([[1e-6, -1e-7], [-1e-7, 1e-5]]),
    ends=np.array([[0.1, 0.2], [3.0, 1 / 3]]),
    sightings=4,
)


@pytest.fixture
def path(tmp_path):
    path = tmp_path / "map.json"
    path.write_text(map_json([CORNER, WALL]), encoding="utf-8")
    return path


def changed(path, change):
    whole = json.loads(path.read_text())
    change(whole)
    path.write_text(json.dumps(whole))


def refused(path):
    with pytest.raises(lf.SourceError) as caught:
        read_map(path)
    text = str(caught.value)
    assert text.startswith(f"{path}: ")
    assert "\n" not in text
    return text.removeprefix(f"{path}: ")


def test_a_map_comes_back_with_all_its_digits(path):
    for landmark, back in zip([CORNER, WALL], read_map(path), strict=True):
        assert (back.kind, back.sightings) == (landmark.kind, landmark.sightings)
        for name in ("values", "covariance", "ends"):
            np.testing.assert_array_equal(getattr(back, name), getattr(landmark, name))


def test_the_format_is_the_documented_one(path):
    whole = json.loads(path.read_text(), parse_constant=pytest.fail)
    assert list(whole) == ["format", "version", "units", "frame", "landmarks"]
    assert (whole["format"], whole["version"]) == ("laserfeatures map", 1)
    assert whole["units"] == {"length": "m", "angle": "rad"}
    corner, wall = whole["landmarks"]
    assert list(corner) == ["kind", "x", "y", "covariance", "sightings"]
    assert (corner["x"], corner["y"]) == (1.25, -math.pi)
    assert list(wall) == ["kind", "theta", "d", "covariance", "ends", "sightings"]
    assert (wall["theta"], wall["d"]) == (math.pi / 3, -2.0)


def test_an_empty_map_is_a_map(tmp_path):
    path = tmp_path / "map.json"
    path.write_text(map_json([]))
    assert read_map(path) == ()


def test_numbers_that_json_does_not_know_are_not_written():
    lost = Landmark(
        kind="corner", values=np.array([math.nan, 0]), covariance=np.eye(2),
        ends=np.zeros((2, 2)), sightings=1,
    )  # fmt: skip
    with pytest.raises(ValueError, match="not JSON compliant"):
        map_json([lost])


@pytest.mark.parametrize(
    ("name", "value", "message"),
    [
        ("kind", "door", "landmark 1: expected kind corner or wall, got door"),
        ("theta", "a", "landmark 1: expected numbers as theta, got a"),
        ("theta", [1, 2], "landmark 1: expected a finite number as theta, got [1, 2]"),
        ("ends", [[1, 2]], "landmark 1: expected 2 x 2 finite numbers as ends, got [[1, 2]]"),
        ("covariance", None, "landmark 1: expected 2 x 2 finite numbers as covariance, got None"),
        ("sightings", 0, "landmark 1: expected sightings, a whole number of 1 or more, got 0.0"),
    ],
)
def test_a_wrong_field_is_named(path, name, value, message):
    changed(path, lambda whole: whole["landmarks"][1].update({name: value}))
    assert refused(path) == message


def test_a_missing_field_is_named(path):
    changed(path, lambda whole: whole["landmarks"][1].pop("d"))
    assert refused(path).startswith("landmark 1: expected a field 'd', got kind, theta, ")


def test_what_is_no_map_is_refused(path):
    changed(path, lambda whole: whole.update(version=2))
    assert "of version 1, got ('laserfeatures map', 2)" in refused(path)
    path.write_text("[1]")
    assert refused(path) == "expected format 'laserfeatures map' of version 1, got [1]"
    path.write_text(map_json([CORNER]).replace("1.25", "NaN"))
    assert refused(path) == "expected a map as JSON: NaN is no JSON number"
    path.write_text(map_json([CORNER])[:-9])
    assert "expected a map as JSON: " in refused(path)
    path.write_bytes(b"\xff\xfe{}")
    assert "expected a map as JSON: " in refused(path)
    path.unlink()
    assert refused(path) == "No such file or directory"
    changed_list = map_json([]).replace("[]", "7")
    path.write_text(changed_list)
    assert refused(path) == "expected a list 'landmarks', got 7"
