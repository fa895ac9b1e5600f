"""``laserfeatures info``: what a log holds."""

import math
from array import array
from collections import Counter
from dataclasses import dataclass, field
from typing import Any

import click
import numpy as np

import laserfeatures as lf
from laserfeatures.arrays import FloatArray, IntArray
from laserfeatures.cli.scans import opened, progress, source_options
from laserfeatures.errors import shown


@click.command()
@source_options
def info(source: str, **reading: Any) -> None:
    """Say what SOURCE holds.

    Its format, number of scans, beams, field of view, range limits, share of invalid readings, rate
    and what its poses are; what is taken for no return, which records are passed over, and what
    the log leaves open ("notice"). The whole log is read.
    """
    summary = Summary()
    with (
        opened(source, told=False, **reading) as scans,
        progress(scans, length=None, to_stdout=False) as bar,
    ):
        for scan in bar:
            summary.add(scan)
        rows = [("format", scans.format), *summary.rows(), ("poses", scans.poses)]
        if scans.no_return is not None:
            rows.append(
                ("no return", f"{scans.no_return:g} m and beyond (--range-max says otherwise)")
            )
        if scans.passed_over:
            counts = scans.passed_over.items()
            rows.append(("passed over", ", ".join(f"{count} {word}" for word, count in counts)))
        rows += [("notice", text) for text in (*scans.notices, *summary.doubts())]
    width = max(len(name) for name, _ in rows)
    for name, value in rows:
        click.echo(f"{name:<{width}}  {shown(value, 600)}")


LONGEST, SHORTEST, FAR = 100_000, 4_000, 30_000  # [mm]; ranges beyond the first count as such


@dataclass
class Summary:
    """What is counted over the scans of a log."""

    scans: int = 0
    readings: int = 0
    valid: int = 0
    nearest: float = math.inf
    farthest: float = 0.0
    stamps: "array[float]" = field(default_factory=lambda: array("d"))  # 8 bytes a scan
    beams: Counter[int] = field(default_factory=Counter)
    views: Counter[str] = field(default_factory=Counter)
    limits: Counter[str] = field(default_factory=Counter)
    millimetres: IntArray = field(default_factory=lambda: np.zeros(LONGEST + 1, np.int64))

    def add(self, scan: lf.LaserScan) -> None:
        """Count a scan."""
        self.scans += 1
        self.readings += len(scan)
        self.valid += scan.beams.size
        ranges = scan.ranges[scan.beams]
        self.nearest = min(self.nearest, float(ranges.min(initial=math.inf)))
        self.farthest = max(self.farthest, float(ranges.max(initial=0.0)))
        self.stamps.append(scan.stamp)
        self.beams[len(scan)] += 1
        self.views[_view(scan)] += 1
        cells = np.minimum(np.round(ranges * 1000), LONGEST).astype(np.int64)
        self.millimetres += np.bincount(cells, minlength=LONGEST + 1)
        self.limits[f"{scan.range_min:g} to {scan.range_max:g} m"] += 1

    def rows(self) -> list[tuple[str, str]]:
        """Return the names and values to print."""
        invalid = f"{1 - self.valid / self.readings:.1%}" if self.readings else "-"
        return [
            ("scans", str(self.scans)),
            ("beams", _most_common(self.beams)),
            ("field of view", _most_common(self.views)),
            ("range limits", _most_common(self.limits)),
            ("ranges seen", f"{self.nearest:.3f} to {self.farthest:.3f} m" if self.valid else "-"),
            ("invalid readings", invalid),
            ("time", _time(np.array(self.stamps))),
        ]

    def doubts(self) -> list[str]:
        """Return what the ranges leave open."""
        found = []
        total = int(self.millimetres.sum())
        i = int(np.argmax(self.millimetres[SHORTEST:-1])) + SHORTEST
        many = int(self.millimetres[i])
        around = int(self.millimetres[int(i * 0.99) : int(i * 1.01) + 2].sum()) - many
        if many >= 20 and many >= 5 * around and many <= 0.9 * total:
            found.append(
                f"{many} ranges of {i / 1000:g} m, and hardly any near it: is that no return? If "
                f"nothing farther counts, give --range-max {i / 1000:g}m"
            )
        if total and np.searchsorted(np.cumsum(self.millimetres), total / 2) > FAR:
            found.append(
                f"half of the ranges are beyond {FAR / 1000:g} m: are they metres? The range unit "
                "may be another"
            )
        return found


def _view(scan: lf.LaserScan) -> str:
    if len(scan) < 2:
        return "one beam" if len(scan) else "no beam"
    first, last = math.degrees(scan.angles[0]), math.degrees(scan.angles[-1])
    step = (last - first) / (len(scan) - 1)
    return f"{last - first:.1f} deg ({first:.1f} to {last:.1f}), a beam every {step:.2f} deg"


def _most_common(counts: Counter[Any]) -> str:
    if not counts:
        return "-"
    value, _ = counts.most_common(1)[0]
    others = len(counts) - 1
    return f"{value}" + (f" (and {others} other{'s' * (others > 1)})" if others else "")


def _time(stamps: FloatArray) -> str:
    steps = np.diff(stamps[np.isfinite(stamps)])
    if not steps.size:
        return "no time stamps"
    step = float(np.median(steps))
    rate = f"{1 / step:.3g} scans/s (median)" if step > 0 else "rate unknown"
    back = int((steps < 0).sum())
    note = f", {back} step{'s' * (back > 1)} back in time" if back else ""
    return f"{steps.sum():.1f} s, {rate}{note}"
