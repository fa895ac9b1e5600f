import pytest
from cli_runs import fails, run

import laserfeatures as lf
from laserfeatures.cli.parameters import parameters_of
from laserfeatures.registry import find_factory


def test_names_one_a_line():
    result = run("extractors")
    assert result.exit_code == 0
    assert tuple(result.stdout.split()) == lf.list_extractors()


def test_a_name_shows_default_unit_and_meaning_of_every_parameter():
    text = run("extractors", "direct_hough").stdout
    detector = lf.get_extractor("direct_hough").detector
    assert all(f"  {name} = " in text for name in vars(detector))
    assert "theta_step = " in text
    assert " rad (" in text
    assert "segment_filter" in text
    assert "intersections" in text
    assert "paper" in text


@pytest.mark.parametrize("name", lf.list_extractors())
def test_every_parameter_has_a_meaning_inherited_ones_too(name):
    found = parameters_of(find_factory(name))
    assert {"range_sigma", "max_missed", "max_pole_radius"} <= found.keys()
    assert all(each.meaning and each.unit is not None for each in found.values())
    text = run("extractors", name).stdout
    assert all(f"  {each.title} " in text for each in found.values())


def test_own_parameters_come_before_inherited_ones():
    names = list(parameters_of(find_factory("direct_hough")))
    assert names[:3] == ["theta_step", "distance_step", "pair_distance"]
    assert names[3] == "range_sigma"


def test_a_preset_shows_its_own_defaults():
    plain = run("extractors", "direct_hough").stdout
    preset = run("extractors", "direct_hough", "--preset", "paper").stdout
    assert preset.startswith("direct_hough, preset paper: ")
    assert preset != plain


def test_a_wrong_name_is_one_line():
    assert "did you mean 'direct_hough'" in fails("extractors", "direct_hugh")
    assert "paper" in fails("extractors", "direct_hough", "--preset", "papr")
    assert "NAME" in fails("extractors", "--preset", "paper")
