"""Figures as CSV, JSON and cells of a table."""

import csv
import io
import json
import math
import re
from pathlib import Path

import numpy as np
import pytest

from laserfeatures.testbench.output import cell, finite, to_csv, to_json, to_table

DOCS = Path(__file__).parents[1] / "docs"
ROWS = [
    {"name": "a", "count": 3, "share": math.nan, "window": [1, 21], "paper": {"count": 4}},
    {"name": "b", "count": np.int64(5), "share": np.float64(0.25), "window": (3, 5), "paper": {}},
]


def test_json_has_null_for_what_is_not_finite():
    text = to_json({"a": math.nan, "b": [math.inf, 1.5], "c": np.array([[1, 2], [3, 4]])})
    assert json.loads(text, parse_constant=pytest.fail) == {
        "a": None,
        "b": [None, 1.5],
        "c": [[1, 2], [3, 4]],
    }


def test_csv_has_a_column_for_each_part():
    read = list(csv.DictReader(io.StringIO(to_csv([ROWS[0], ROWS[1] | {"paper": {"count": 6}}]))))
    assert list(read[0]) == ["name", "count", "share", "window", "paper_count"]
    assert read[0] == {
        "name": "a", "count": "3", "share": "", "window": "1 21", "paper_count": "4",
    }  # fmt: skip
    assert read[1]["share"] == "0.25"


def test_csv_refuses_rows_that_differ():
    with pytest.raises(ValueError, match="surplus"):
        to_csv([{"a": 1}, {"a": 1, "surplus": 2}])


@pytest.mark.parametrize(
    ("value", "name", "text"),
    [
        (None, "", "-"),
        (math.nan, "", "-"),
        (12, "", "12"),
        (0.0, "", "0.0"),
        (0.012345, "", "0.0123"),
        (1234.5, "", "1234"),
        (99.96, "tp_percent", "100.0"),
        (0.0, "fp_percent", "0.0"),
        ("text", "", "text"),
    ],
)
def test_cells(value, name, text):
    assert cell(value, name) == text


def test_a_table_is_headed_by_the_keys():
    table = to_table([{"row": "a", "tp_percent": 50.04}], text=1)
    assert table.header == ["row", "tp_percent"]
    assert table.rows == [["a", "50.0"]]
    assert table.text == {0}


def test_finite_leaves_plain_values_as_they_are():
    value = {"a": [1, "x", None, True], "b": 2.5}
    assert finite(value) == value


def test_the_page_counts_the_trends_as_the_table_has_them():
    text = (DOCS / "reproduction.md").read_text()
    raised, lowered, falls, rises = map(
        int,
        re.search(
            r"In (\d+) of 12 steps, as in all 12.*In (\d+) of 12 steps, .* falls in (\d+) of them "
            r"and rises in (\d+)",
            text,
            re.DOTALL,
        ).groups(),
    )
    with (DOCS / "testbench/table1_trends.csv").open() as file:
        steps = list(csv.DictReader(file))
    assert len(steps) == 12
    assert all(float(step["TP_paper"]) > 0 for step in steps)
    assert sum(float(step["TP_ours"]) > 0 for step in steps) == raised
    assert sum(float(step["FP_ours"]) < 0 for step in steps) == lowered
    assert sum(float(step["FP_paper"]) < 0 for step in steps) == falls
    assert sum(float(step["FP_paper"]) > 0 for step in steps) == rises
