"""``laserfeatures noise``: the noise of a sensor's ranges, told from a log."""

from collections.abc import Iterable
from dataclasses import asdict, dataclass, field
from math import floor, isfinite, log10
from typing import TYPE_CHECKING, Any

import click
import numpy as np

import laserfeatures as lf
from laserfeatures.cli.output import complete_file
from laserfeatures.cli.scans import opened, progress, source_options
from laserfeatures.testbench.output import to_json

if TYPE_CHECKING:
    from laserfeatures.noise_model import NoiseModel, RangeNoise

SETTLED = 50  # scans; what is said of the steadiness begins there


@click.command()
@source_options
@click.option(
    "--every",
    type=click.IntRange(min=1),
    default=1,
    metavar="N",
    help="Take every N-th scan; else all.",
)
@click.option("--json", "json_file", type=click.Path(), metavar="FILE", help="Write the numbers.")
def noise(source: str, every: int, json_file: str | None, **reading: Any) -> None:
    """Tell the noise of the ranges in SOURCE, as 'extract' and others come to take it.

    The variance of a range r is sigma^2 + (relative r)^2; roughness is how far long walls are off
    planes beyond that. Behind each is its standard error. The correlation is how alike the
    errors of neighbouring beams are; beyond 0.1 it keeps walls in one piece. How steady the noise
    is tell the median factors by which it changes at the mean range: from one estimate to the next,
    every 10 scans, once 50 have been seen; and from scan to scan where each tells it by itself.

    \b
    Examples:
      laserfeatures noise example:office
      laserfeatures noise run.log.gz --every 5 --json noise.json
      laserfeatures noise urg:///dev/ttyACM0?seconds=20
    """  # noqa: D301 - click's mark for lines to keep is a backspace
    from laserfeatures.noise_model import NoiseModel  # noqa: PLC0415 - brings numba

    history = History(NoiseModel())
    with opened(source, **reading) as scans:
        with progress(scans, length=None, to_stdout=False) as bar:
            history.add_all(bar, every)
        if not history.model.scans:
            raise lf.SourceError(
                f"{source}: expected a scan that tells a noise, got {history.scans} "
                f"scan{'s' * (history.scans != 1)} without 8 returns"
            )
    found = history.summary()
    _print(found)
    if json_file:
        with complete_file(json_file, source) as file:
            file.write(to_json(found))


@dataclass
class History:
    """A model, and what it and each scan by itself said of the noise."""

    model: "NoiseModel"
    scans: int = 0
    settled: "list[RangeNoise]" = field(default_factory=list)
    own: "list[RangeNoise]" = field(default_factory=list)
    means: list[float] = field(default_factory=list)

    def add_all(self, scans: Iterable[lf.LaserScan], every: int) -> None:
        """Take in every N-th of the scans."""
        from laserfeatures.noise_model import noise_of  # noqa: PLC0415 - brings numba

        for number, scan in enumerate(scans):
            if number % every:
                continue
            self.scans += 1
            before = self.model.scans
            told = self.model.feed(scan)
            if self.model.scans > before:
                self.settled.append(told)
                self.own.append(noise_of(scan))
                self.means.append(float(scan.ranges[scan.beams].mean()))

    def summary(self) -> dict[str, Any]:
        """Return the numbers [m, m/m], their errors, and how steady they are."""
        from laserfeatures.noise_model import SELDOM  # noqa: PLC0415 - brings numba

        mean = float(np.mean(self.means))
        now = self.model.noise
        return {
            "scans": self.scans,
            "telling": self.model.scans,
            **asdict(now),
            "uncertainty": self.model.uncertainty._asdict(),
            "mean_range": mean,
            "at_mean_range": now.at(mean),
            "factor": _factor(self.settled[SETTLED::SELDOM], mean),
            "factor_of_own": _factor(self.own, mean),
        }


def _factor(noises: "list[RangeNoise]", r: float) -> float | None:
    """Return the median factor from one noise to the next, at range `r`; None of fewer than 2."""
    if len(noises) < 2:
        return None
    steps = np.diff(np.log([each.at(r) for each in noises]))
    return float(np.exp(np.median(np.abs(steps))))


def _print(found: dict[str, Any]) -> None:
    from laserfeatures.noise_model import SELDOM  # noqa: PLC0415 - brings numba

    error = found["uncertainty"]
    factors = [
        "-" if found[name] is None else f"{found[name]:.3f}" for name in ("factor", "factor_of_own")
    ]
    rows = [
        ("scans", f"{found['scans']}, of which {found['telling']} tell a noise"),
        ("sigma", _with_error(1e3 * found["sigma"], 1e3 * error["sigma"], "mm")),
        ("relative", _with_error(1e2 * found["relative"], 1e2 * error["relative"], "%")),
        ("roughness", _with_error(1e3 * found["roughness"], 1e3 * error["roughness"], "mm")),
        ("correlation", f"{found['correlation']:.2f} of neighbours' errors"),
        ("together", f"{1e3 * found['at_mean_range']:.2f} mm at {found['mean_range']:.2f} m"),
        ("changes by", f"{factors[0]} in {SELDOM} scans, {factors[1]} from scan to scan alone"),
    ]
    for name, value in rows:
        click.echo(f"{name:<18} {value}")


def _with_error(value: float, error: float, unit: str) -> str:
    """Return a number with as many decimals as the first two digits of its error have."""
    if not isfinite(error):
        return f"{value:.2g} {unit}, its error unknown"
    decimals = max(0, 1 - floor(log10(error))) if error > 0 else 2
    return f"{value:.{decimals}f} ± {error:.{decimals}f} {unit}"
