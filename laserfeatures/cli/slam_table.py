"""The summary of a run of SLAM on a terminal."""

from collections.abc import Iterator, Mapping
from math import degrees
from typing import Any

import click

from laserfeatures.testbench.output import cell

ERRORS = {
    "ate_rmse": ("ATE, rms", "m"),
    "ate_max": ("ATE, worst", "m"),
    "rpe_translation": ("RPE over 1 m", "m"),
    "rpe_rotation": ("RPE over 1 m", "deg"),
    "rpe_scan_translation": ("RPE, scan to scan", "m"),
    "rpe_scan_rotation": ("RPE, scan to scan", "deg"),
}


def print_summary(found: Mapping[str, Any]) -> None:
    """Print a summary, aligned."""
    rows = list(_rows(found))
    width = max(len(name) for name, _ in rows)
    for name, value in rows:
        click.echo(f"{name:<{width}}  {value}")
    if found["matched_by"]:
        click.echo()
        for line in _errors(found):
            click.echo(line)


def _rows(found: Mapping[str, Any]) -> Iterator[tuple[str, str]]:
    time = f" in {found['seconds']:.1f} s" if found["seconds"] is not None else ""
    yield "source", f"{found['source']} ({found['format']})"
    yield "scans", f"{found['scans']}{time}"
    yield "extractor", found["extractor"]
    kinds = [_count(found["corners"], "corner"), _count(found["walls"], "wall")]
    yield "landmarks", f"{found['landmarks']}: {', '.join(kinds)}"
    yield "way", f"{found['way']:.1f} m by SLAM, {found['odometry_way']:.1f} m by odometry"
    yield (
        "step",
        f"{found['median_step_ms']:.2f} ms (median), {found['worst_step_ms']:.2f} ms (worst)",
    )
    yield "NIS", f"{cell(found['nis_per_degree'])} a degree of freedom (1 is right, more too sure)"


def _errors(found: Mapping[str, Any]) -> Iterator[str]:
    yield f"{'':<24}{'SLAM':>10}{'odometry':>10}"
    for name, (title, unit) in ERRORS.items():
        pair = [found[name], found[f"odometry_{name}"]]
        if unit == "deg":
            pair = [value if value is None else degrees(value) for value in pair]
        cells = "".join(f"{cell(value):>10}" for value in pair)
        yield f"{f'{title} [{unit}]':<24}{cells}"
    yield f"{_count(found['matched_poses'], 'pose')} matched by {found['matched_by']}"


def _count(number: int, what: str) -> str:
    return f"{number} {what}{'s' * (number != 1)}"
