"""docs/extractors.md has a section on every extractor, and names parameters as they are."""

import re
from pathlib import Path

import pytest

import laserfeatures as lf
from laserfeatures.cli.parameters import parameters_of
from laserfeatures.registry import find_factory

PAGE = Path(__file__).parents[1] / "docs/extractors.md"
TEXT = PAGE.read_text()
SECTIONS = dict(re.findall(r"^## `(\w+)`\n(.*?)(?=^## |\Z)", TEXT, re.MULTILINE | re.DOTALL))


def test_the_first_table_and_the_sections_are_of_all_extractors():
    table = set(re.findall(r"^\| `(\w+)`", TEXT, re.MULTILINE))
    assert table == set(SECTIONS) == set(lf.list_extractors())


@pytest.mark.parametrize("name", lf.list_extractors())
def test_a_section_has_parameters_with_their_defaults_figures_and_a_picture(name):
    titles = {parameter.title for parameter in parameters_of(find_factory(name)).values()}
    named = set(re.findall(r"`(\w+ = [^`]+)`", SECTIONS[name]))
    assert named
    assert named <= titles
    assert f"<!-- measured: {name} -->\nMeasured: " in SECTIONS[name]
    assert f"](extractor_{name}.png)" in SECTIONS[name]


def test_the_table_of_figures_has_a_row_for_each():
    (table,) = re.findall(r"<!-- measured: all -->\n(.*?)<!-- /measured -->", TEXT, re.DOTALL)
    assert set(re.findall(r"^\| (\w+) \|", table, re.MULTILINE)) >= set(lf.list_extractors())


def test_links_and_pictures_exist():
    links = re.findall(r"\]\((?!https?:)([^)#]+)\)", TEXT)
    assert any(link.endswith(".png") for link in links)
    for link in links:
        assert (PAGE.parent / link).is_file(), link
