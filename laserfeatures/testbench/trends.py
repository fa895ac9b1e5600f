"""What a larger neighbourhood changes, in the paper's Table I and in ours."""

from collections.abc import Mapping, Sequence
from itertools import pairwise
from typing import Any

SHOWN = {"tp_percent": "TP", "fp_percent": "FP"}
STILL = 0.5  # [%]; a smaller change is none


def trends(rows: Sequence[Mapping[str, Any]]) -> list[dict[str, Any]]:
    """Return the change of TP and FP from each row to the next of the same resolution.

    Parameters
    ----------
    rows : sequence of mapping
        As `Table1Result.rows`.

    Returns
    -------
    list of dict
        "resolution", "from" and "to" (the windows), the paper's and our changes of both [%], and
        under "same" which of them go the same way, or stay within half a percent in both.
    """
    steps = []
    for before, after in pairwise(rows):
        if _resolution(before) != _resolution(after):
            continue
        step: dict[str, Any] = {
            "resolution": "{:g}°, {:g} cm".format(*_resolution(after)),
            "from": "{} x {}".format(*before["neighborhood"]),
            "to": "{} x {}".format(*after["neighborhood"]),
        }
        same = []
        for key, name in SHOWN.items():
            papers = after["paper"][key] - before["paper"][key]
            ours = after[key] - before[key]
            step[f"{name}_paper"], step[f"{name}_ours"] = f"{papers:+.1f}", f"{ours:+.1f}"
            same += [name] * (_way(papers) == _way(ours))
        steps.append(step | {"same": ", ".join(same) or "none"})
    return steps


def _resolution(row: Mapping[str, Any]) -> tuple[float, float]:
    return row["theta_step"], row["distance_step"]


def _way(change: float) -> int:
    """Return 1 where something grows, -1 where it falls, 0 where it stays."""
    return 0 if abs(change) < STILL else 1 if change > 0 else -1
