"""The page on evaluation does what it says, and leaves nothing out."""

import re
from dataclasses import fields
from pathlib import Path

from laserfeatures.evaluation import Score

PAGE = (Path(__file__).parents[1] / "docs/evaluation.md").read_text()


def test_the_pages_example_prints_scores_near_the_oracles(capsys):
    (code,) = re.findall(r"```python\n(.*?)```", PAGE, re.DOTALL)
    exec(compile(code, "evaluation.md", "exec"), {})  # noqa: S102 - our own page
    printed = capsys.readouterr().out
    assert re.match(r"TP \d+\.\d %, FP \d+\.\d %, F1 [01]\.\d{3}\nthat is [01]\.\d{3} of", printed)
    assert 0.9 < float(re.search(r"that is (\S+)", printed).group(1)) < 1.1


def test_the_table_names_everything_that_a_score_has():
    properties = {name for name, value in vars(Score).items() if isinstance(value, property)}
    named = re.findall(r"^\| `(\w+)`", PAGE, re.MULTILINE)
    assert len(named) == len(set(named))
    assert set(named) == properties | {item.name for item in fields(Score)}
