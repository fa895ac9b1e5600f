"""docs/direct-hough.md names every constant of the engine and of `direct_hough` as it is."""

import ast
import importlib
import re
from pathlib import Path

import laserfeatures_plugins.direct_hough as plugin
import pytest

import laserfeatures as lf
from laserfeatures import engine
from laserfeatures.cli.parameters import parameters_of
from laserfeatures.registry import find_factory

PAGE = Path(__file__).parents[1] / "docs/direct-hough.md"
TEXT = PAGE.read_text()
# Rows such as | `A`, `B` | module | 1, 2 | ...
ROWS = re.findall(r"^\| (`[A-Z]\w*`(?:, `\w+`)*) \| (\w+) \| ([^|]+) \|", TEXT, re.MULTILINE)
TABLE = {
    (module, name.strip("`")): float(value)
    for names, module, values in ROWS
    for name, value in zip(names.split(", "), values.split(", "), strict=True)
}


def constants():
    """Return the numbers that modules name in upper case."""
    found = {}
    for package in (engine, plugin):
        for path in sorted(Path(package.__file__).parent.glob("*.py")):
            module = importlib.import_module(f"{package.__name__}.{path.stem}")
            for node in ast.parse(path.read_text()).body:
                targets = node.targets if isinstance(node, ast.Assign) else []
                for name in (n.id for t in targets for n in ast.walk(t) if isinstance(n, ast.Name)):
                    value = getattr(module, name)
                    if name.isupper() and isinstance(value, int | float):
                        found[path.stem, name] = value
    return found


def test_the_table_has_every_constant_with_its_value():
    assert pytest.approx(constants(), rel=5e-4) == TABLE


def test_numbers_in_the_text_are_those_of_the_table():
    told = re.findall(r"([\d.]+) \(`([A-Z_]+)`\)", TEXT)
    assert {"PRICE", "RETURN_PRICE", "ARC_PRICE", "STRAY_PRICE"} <= {name for _, name in told}
    for value, name in told:
        assert float(value) in {TABLE[key] for key in TABLE if key[1] == name}, name
    limits = lf.get_extractor("direct_hough").detector
    assert f"of {limits.min_points} to {limits.longest} returns" in TEXT
    assert limits.rounds == 1  # "once more"


def test_the_table_has_every_parameter_with_its_default():
    titles = {parameter.title for parameter in parameters_of(find_factory("direct_hough")).values()}
    assert set(re.findall(r"^\| `(\w+ = [^`]+)`", TEXT, re.MULTILINE)) == titles


def test_steps_have_the_numbers_of_the_code():
    code = Path(engine.__file__).with_name("explain.py").read_text()
    numbered = re.findall(r"^(\d)\. ", code, re.MULTILINE)
    headings = re.findall(r"^## (\d+)\. ", TEXT, re.MULTILINE)
    assert numbered == [str(n) for n in range(1, 9)]
    assert headings == [*numbered, "9", "10"]


def test_functions_that_the_page_names_exist():
    root = Path(lf.__file__).parent
    places = re.findall(r"`([\w/]+\.py): (\w+)`", TEXT)
    assert places
    for file, name in places:
        folder = root.parent / "plugins" if file.startswith("laserfeatures_plugins") else root
        assert re.search(rf"\b(def|class) {name}\b", (folder / file).read_text()), (file, name)


def test_links_and_pictures_exist():
    links = re.findall(r"\]\((?!https?:)([^)#]+)\)", TEXT)
    assert links.count("story_01.png") == 1
    for link in links:
        assert (PAGE.parent / link).is_file(), link
