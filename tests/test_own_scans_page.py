"""The page on scans made from arrays runs as written, and finds the room that it makes."""

import re
from pathlib import Path

import numpy as np
import pytest

PAGE = (Path(__file__).parents[1] / "docs/own-scans.md").read_text()


def test_the_page_runs_and_finds_the_corners_of_its_room():
    names = {}
    for code in re.findall(r"```python\n(.*?)```", PAGE, re.DOTALL):
        exec(compile(code, "own-scans.md", "exec"), names)  # noqa: S102 - our own page
    for corners in (names["features"].corners, names["sure"]):
        found = corners.positions[np.argsort(corners.positions[:, 1])]
        assert found == pytest.approx(np.array([(2.0, -1.0), (2.0, 1.0)]), abs=0.01)
