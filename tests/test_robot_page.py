"""What docs/robot.md and docs/office.toml say."""

import re
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest
from test_robot import errors, off_path

from laserfeatures.simulation import random_office, read_plan
from laserfeatures.simulation.robot import drive

ROOT = Path(__file__).parents[1]
PAGE = (ROOT / "docs/robot.md").read_text()
OFFICE = ROOT / "docs/office.toml"


def test_the_pages_python_runs(monkeypatch, capsys):
    monkeypatch.chdir(ROOT)
    (code,) = re.findall(r"```python\n(.*?)```", PAGE, re.DOTALL)
    exec(compile(code, "robot.md", "exec"), {})  # noqa: S102 - our own page
    assert re.fullmatch(r"after 2\d\d s odometry is \d+\.\d m off; .*\n", capsys.readouterr().out)


@pytest.mark.parametrize("plan", [read_plan(OFFICE), random_office(5)], ids=["office", "random"])
def test_an_office_is_driven_through_on_a_loop_of_60_metres(plan):
    plan = replace(plan, drive=replace(plan.drive, scan_rate=2.0))
    readings = list(drive(plan))
    points = np.array([(r.truth.x, r.truth.y) for r in readings])
    assert np.linalg.norm(np.diff(points, axis=0), axis=1).sum() > 60
    assert off_path(readings, plan.drive.waypoints) < 0.1
    assert errors(readings).max() > 1
