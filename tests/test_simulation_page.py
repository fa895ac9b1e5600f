"""The page on simulation does what it says, and leaves nothing out."""

import math
import re
from dataclasses import fields
from pathlib import Path

import pytest

from laserfeatures import Pose2D, simulation
from laserfeatures.errors import SourceError
from laserfeatures.simulation import Scanner, World
from laserfeatures.simulation.plan_reader import parse_plan

PAGE = (Path(__file__).parents[1] / "docs/simulation.md").read_text()
(PLAN,) = re.findall(r"```toml\n(.*?)```", PAGE, re.DOTALL)


def test_the_pages_example_prints_what_a_scan_shows(capsys):
    (code,) = re.findall(r"```python\n(.*?)```", PAGE, re.DOTALL)
    exec(compile(code, "simulation.md", "exec"), {})  # noqa: S102 - our own page
    returns, surfaces = map(int, re.findall(r"\d+", capsys.readouterr().out))
    assert 150 < returns <= 181
    assert 5 < surfaces < 30


def test_the_pages_plan_can_be_read():
    plan = parse_plan(PLAN, Path("plan.toml"))
    assert (len(plan.world.walls), len(plan.world.boxes), len(plan.world.poles)) == (6, 1, 1)
    assert plan.world.reflectivity.tolist() == [0.5] + 6 * [0.9] + [0.1]
    assert plan.world.boxes[0, 4] == math.radians(20)
    assert plan.drive.scanner == Scanner(outliers=0.02)


def test_the_pages_errors_are_those_that_come():
    named = re.search(r"^    (plan\.toml:.*)$", PAGE, re.MULTILINE)[1]
    with pytest.raises(SourceError) as error:
        parse_plan(PLAN.replace("[[0.6, 0.6]", "[[3, 1.8]"), Path("plan.toml"))
    assert str(error.value) == named
    inside = re.search(r"`(the sensor at .*?)`", PAGE)[1]
    with pytest.raises(ValueError, match=re.escape(inside)):
        Scanner().cast(World(boxes=[(1, 2, 1, 1, 0)]), Pose2D(1, 2, 0))


def test_the_tables_name_every_model_parameter_and_family():
    named = set(re.findall(r"^\| `(\w+)", PAGE, re.MULTILINE))
    basic = {"beams", "field_of_view", "range_max", "range_sigma"}
    parameters = {f.name for f in fields(Scanner)} - basic
    families = {name for name in simulation.__all__ if name.startswith("random_")}
    assert named == set(Scanner.MODELS) | parameters | families
    for name, scanner in ((name, Scanner.model(name)) for name in Scanner.MODELS):
        row = re.search(
            rf"^\| `{name}` \| (\d+) \| ([\d.]+)°, .* \| (\d+) m \| (\d+) mm", PAGE, re.MULTILINE
        )
        assert int(row[1]) == scanner.beams
        assert float(row[2]) == pytest.approx(math.degrees(scanner.field_of_view))
        assert float(row[3]) == scanner.range_max
        assert float(row[4]) == scanner.range_sigma * 1000
