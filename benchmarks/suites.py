"""Lines and corners of held-out simulated scans against the truth, in suites of scenes.

A section of the report; alone, ``python benchmarks/suites.py --quick --tune --extractors
direct_hough,ransac`` prints one table of all suites. `observations` gives the scans and truths of
a suite, `measure` the figures of some extractors on it.
"""

import argparse
import math
import sys
import tempfile
import time
from collections.abc import Callable
from dataclasses import dataclass, replace
from functools import cached_property
from pathlib import Path

import numpy as np
import scenes
from page import NONE, percent, table, verdict

import laserfeatures as lf
from laserfeatures.evaluation import Score, oracle, score, truth_of
from laserfeatures.evaluation.matching import match_lines
from laserfeatures.simulation import Scanner
from laserfeatures.sources.carmen_writer import write_carmen

# Seeds of scenes and noise that no parameter was tuned on. Those from 60,000 on were looked at when
# the engine was made: they are held out no more.
HELD_OUT = range(60_400, 60_800)
TUNING = range(70_000, 70_400)  # seeds on which parameters may be tuned
ORACLE = "oracle"
FEW_BEAMS = (5, 12)  # of the walls whose recall is aimed at
FEW_TARGETS = 0.93, 0.96  # of direct_hough, of the best
BEAMS = {
    "4": (4, 4), "5": (5, 5), "6": (6, 6), "7-8": (7, 8), "9-12": (9, 12), "5-12": FEW_BEAMS,
    ">12": (13, math.inf),
}  # fmt: skip


@dataclass(frozen=True)
class Suite:
    """Scenes, a scanner, how rough the walls are, and what is aimed at.

    `scene` makes a world and a pose from a seed. The walls' roughness is `rough` [m]; it is white
    where `rough_length` [m] is 0. The targets are shares of the oracle's F1: of `direct_hough`, of
    the best extractor, and what the best public peer reached on scenes like these (None: unknown).
    """

    name: str
    scanner: Scanner
    scene: Callable
    direct_hough: float
    best: float
    peer: float | None = None
    rough: float = 0.0
    rough_length: float = 0.0


LMS = Scanner.model("lms200")
FAR = Scanner.model("lms200", beams=361, range_max=20.0, range_sigma=0.010)
SPOILED = Scanner.model(
    "lms200", beams=361, range_max=20.0, range_sigma=0.010, relative_sigma=0.001,
    outliers=0.02, dropouts=0.03,
)  # fmt: skip
CIRCLE = {"beams": 720, "field_of_view": 2 * math.pi * 719 / 720}  # no beam twice
FAR_CIRCLE = Scanner(**CIRCLE, range_max=20.0, range_sigma=0.010)
HOKUYO = Scanner(
    beams=541, field_of_view=math.radians(270), range_max=20.0, range_sigma=0.008,
    relative_sigma=0.002,
)  # fmt: skip
CHEAP = Scanner(**CIRCLE, range_max=12.0, range_sigma=0.004, relative_sigma=0.008, outliers=0.01)
ROUGH = 0.004  # [m], of the offices' walls
SUITES = [
    Suite("rooms, 181 beams, 5 mm, 10 m", LMS, scenes.rooms(), 0.99, 0.995, 0.87),
    Suite("rooms, 361 beams, 10 mm, 20 m", FAR, scenes.rooms(), 0.975, 0.985, 0.87),
    Suite(
        "clutter: 361 beams, 10 mm + 0.1 %, 6 poles, 2 % outliers, 3 % drop-outs",
        SPOILED, scenes.rooms(poles=6), 0.94, 0.95, 0.71,
    ),
    Suite("partitions: 361 beams, 10 mm, 20 m", FAR, scenes.partitions, 0.975, 0.985),
    Suite("partitions, full circle: 720 beams, 10 mm, 20 m", FAR_CIRCLE, scenes.partitions,
          0.975, 0.985),
    Suite("offices: 541 beams, 270°, 8 mm + 0.2 %, walls 4 mm rough", HOKUYO, scenes.offices,
          0.96, 0.97, rough=ROUGH),
    Suite(
        "offices by a cheap lidar: 720 beams, full circle, 12 m, 4 mm + 0.8 %, 1 % outliers, "
        "walls 4 mm rough",
        CHEAP, scenes.offices, 0.92, 0.94, rough=ROUGH,
    ),
]  # fmt: skip

METHOD = f"""{len(HELD_OUT)} random scenes a suite, one scan each, on whose seeds ({HELD_OUT[0]} to
{HELD_OUT[-1]}) nothing was tuned: rooms are `laserfeatures.simulation.random_room`; partitions
(large rooms with thin free-standing or attached walls) and offices (door jambs, radiators, table
legs, cupboards) are of `benchmarks/scenes.py`. The scans are
written to a CARMEN log and read back, so that the noise is not told; every extractor runs with its
defaults. Corners are paired one to one with the true ones within 0.2 m
([evaluation.md](evaluation.md)). "Share" is the F1 as a share of that of the oracle, the
least-squares lines through exactly the beams of each wall; it can exceed 1, since the oracle
withholds nothing. "Given" is `direct_hough` told the range noise (what of it does not grow with
range); "few beams" is the recall of walls of {FEW_BEAMS[0]} to {FEW_BEAMS[1]} beams; the last
columns are the shares of corners and lines inside their own 95 % ellipse. ± is the standard error
of the share over the scans, by the jackknife in 20 blocks. Roughness moves each return along the
wall's normal, every beam by itself."""


@dataclass(frozen=True)
class Measured:
    """What an extractor did on a suite: the score of each scan, and the oracle's.

    `walls` (W, 2) holds each true wall's beams and whether it was found.
    """

    scores: list
    best: list
    walls: np.ndarray

    @cached_property
    def total(self):
        """The scores of all scans, added up."""
        return Score.total(self.scores)

    @cached_property
    def share(self):
        """F1 as a share of the oracle's, and its standard error."""
        return share(self.scores, self.best)

    def recall(self, beams):
        """Return the share found of the walls that this many beams hit, a key of `BEAMS`."""
        low, high = BEAMS[beams]
        count, found = self.walls.T
        mine = (count >= low) & (count <= high)
        return found[mine].mean() if mine.any() else math.nan

    @property
    def consistency(self):
        """Share of the corners, and of the lines, inside their own 95 % ellipse."""
        return self.total.corner_consistency, self.total.line_consistency

    @property
    def precision(self):
        """Share of the corners found that are true."""
        return 1 - self.total.fp_percent / 100

    @property
    def corner_recall(self):
        """Share of the true corners that were found."""
        return self.total.tp_percent / 100


def section(options):
    """Return the section's paragraphs."""
    seeds = HELD_OUT[: options.repeats(len(HELD_OUT))]
    parts = ["## Corners on held-out scans", METHOD]
    for suite in SUITES:
        found = measure(suite, seeds, _methods(suite))
        parts += [f"### {suite.name[0].upper()}{suite.name[1:]}", _table(found)]
        parts.append(_targets(suite, found))
    return parts


def observed(suite, seed):
    """Return the observation of one scene."""
    world, pose = suite.scene(seed)
    seen = suite.scanner.observe(world, pose, np.random.default_rng((seed, 1)))
    if not suite.rough:
        return seen
    rng = np.random.default_rng((seed, 2))
    return scenes.roughened(seen, suite.rough, rng, length=suite.rough_length)


def observations(suite, seeds):
    """Yield a scan, as a log gives it back, and what is true of it, for each seed."""
    seen = [observed(suite, seed) for seed in seeds]
    scans = as_logged([each.scan for each in seen])
    for scan, each in zip(scans, seen, strict=True):
        yield scan, truth_of(each)


def measure(suite, seeds, methods):
    """Return what each extractor, and the oracle, did on a suite, by name.

    `methods` are extractors by name, or names of `lf.list_extractors()`.
    """
    if not isinstance(methods, dict):
        methods = {name: lf.get_extractor(name) for name in methods}
    pairs = list(observations(suite, seeds))
    features = {name: [extractor(scan) for scan, _ in pairs] for name, extractor in methods.items()}
    features[ORACLE] = [oracle(scan, truth) for scan, truth in pairs]
    truths = [truth for _, truth in pairs]
    scores = {
        name: [score(each, truth) for each, truth in zip(found, truths, strict=True)]
        for name, found in features.items()
    }
    return {
        name: Measured(scores[name], scores[ORACLE], _walls(found, truths))
        for name, found in features.items()
    }


def _walls(features, truths):
    """Return each true wall's beams and whether it was found, (W, 2)."""
    parts = [np.empty((0, 2))]
    for each, truth in zip(features, truths, strict=True):
        beams = np.bincount(truth.line[truth.line >= 0], minlength=truth.theta.size)
        wall = match_lines(each.segments, truth)[0]
        found = np.isin(np.arange(beams.size), wall)
        parts.append(np.stack([beams, found], axis=1))
    return np.concatenate(parts)


def _methods(suite):
    """Return all extractors, and direct_hough told the noise."""
    from speed_all import all_extractors  # noqa: PLC0415 - it brings the peers

    given = lf.get_extractor("direct_hough", **told(suite))
    return {**all_extractors(), "direct_hough, given": given}


def told(suite):
    """Return what of the noise an extractor can be told."""
    return {
        "range_sigma": suite.scanner.range_sigma,
        "range_sigma_relative": suite.scanner.relative_sigma,
        "roughness": suite.rough,
    }


def as_logged(scans):
    """Return scans as a CARMEN log gives them back."""
    with tempfile.TemporaryDirectory() as folder:
        log = Path(folder) / "scans.log"
        with log.open("w") as file:
            write_carmen(file, scans)
        with lf.open_source(log) as source:
            return list(source)


def share(found, best):
    """Return F1 as a share of the oracle's, and its standard error."""
    blocks = min(20, len(found))
    left = [
        Score.total(found[k] for k in range(len(found)) if k % blocks != block).f1
        / Score.total(best[k] for k in range(len(best)) if k % blocks != block).f1
        for block in range(blocks)
    ]
    spread = np.sqrt((blocks - 1) * np.var(left))
    return Score.total(found).f1 / Score.total(best).f1, spread


def _table(found):
    rows = []
    for name, each in found.items():
        total = each.total
        ratio, spread = each.share
        known = name != ORACLE
        rows.append([
            name, f"{ratio:.3f} ± {spread:.3f}", f"{total.tp_percent:.1f}",
            f"{total.fp_percent:.1f}", f"{1e3 * total.median_error:.1f}",
            f"{1e3 * total.rms_error:.1f}", _share(total.line_recall), _share(each.recall("5-12")),
            _share(total.line_precision),
            _share(total.corner_consistency) if known else NONE,
            _share(total.line_consistency) if known else NONE,
        ])  # fmt: skip
    header = ["corners", "share", "TP [%]", "FP [%]", "error, median [mm]", "rms [mm]",
              "lines: recall", "few beams", "precision", "corners inside",
              "lines inside"]  # fmt: skip
    return table(header, rows)


def _share(value):
    return NONE if np.isnan(value) else percent(value)


def _targets(suite, found):
    known = [name for name in found if name in lf.list_extractors()]
    shares = {name: found[name].share[0] for name in known}
    recalls = {name: found[name].recall("5-12") for name in known}
    best = max(shares, key=shares.get)
    most = max(recalls, key=recalls.get)
    few, of = "recall of walls of few beams", "share of the oracle's F1"
    aims = [
        (f"direct_hough: {of}", suite.direct_hough, shares["direct_hough"]),
        (f"the best, {best}: {of}", suite.best, shares[best]),
        (f"direct_hough: {few}", FEW_TARGETS[0], recalls["direct_hough"]),
        (f"the best, {most}: {few}", FEW_TARGETS[1], recalls[most]),
    ]
    rows = [[what, f"{aim:g}", f"{got:.3f}", verdict(got >= aim)] for what, aim, got in aims]
    if suite.peer is not None:
        rows.append([
            f"best public peer, as measured on scenes like these: {of}", NONE,
            f"{suite.peer:g}", NONE,
        ])  # fmt: skip
    return table(["", "target", "measured", ""], rows)


def rows_of(suite, found):
    """Return a row of figures for each extractor on a suite."""
    return [
        [
            f"{suite.name.split(' walls')[0][:44]}: {name}",
            "{:.3f} ± {:.3f}".format(*each.share), f"{each.precision:.3f}",
            f"{each.corner_recall:.3f}",
            *(f"{each.recall(beams):.3f}" for beams in BEAMS),
            f"{each.total.line_precision:.3f}",
            *(f"{inside:.3f}" if name != ORACLE else NONE for inside in each.consistency),
        ]
        for name, each in found.items()
    ]  # fmt: skip


HEADER = ["suite: extractor", "share", "corners: P", "R", *(f"walls {name}" for name in BEAMS),
          "lines: P", "corners inside", "lines inside"]  # fmt: skip


def main():
    """Print one table of all suites."""
    parser = argparse.ArgumentParser(description="Measure extractors on all suites.")
    parser.add_argument("--quick", action="store_true", help="a tenth of the scans")
    parser.add_argument("--scans", type=int, help="how many scans of each suite")
    parser.add_argument("--skip", type=int, default=0, help="how many seeds to leave out first")
    parser.add_argument("--tune", action="store_true", help="the tuning seeds, not the held-out")
    parser.add_argument("--extractors", default="direct_hough", help="names, with commas, or all")
    parser.add_argument("--suites", default="", help="only those whose name contains this")
    parser.add_argument("--told", action="store_true", help="tell the extractors the noise")
    parser.add_argument("--smooth", action="store_true", help="roughness smooth along the wall")
    options = parser.parse_args()
    names = lf.list_extractors() if options.extractors == "all" else options.extractors.split(",")
    seeds = (TUNING if options.tune else HELD_OUT)[options.skip :]
    seeds = seeds[: options.scans or len(seeds) // (10 if options.quick else 1)]
    rows = []
    for suite in SUITES:
        if options.suites not in suite.name:
            continue
        start = time.perf_counter()
        noise = told(suite) if options.told else {}
        methods = {name: lf.get_extractor(name, **noise) for name in names}
        smoothed = smooth(suite) if options.smooth else suite
        rows += rows_of(suite, measure(smoothed, seeds, methods))
        print(f"{suite.name}: {time.perf_counter() - start:.0f} s", file=sys.stderr)
    print(table(HEADER, rows))


def smooth(suite):
    """Return a suite whose walls' roughness is smooth along the wall."""
    return replace(suite, rough_length=scenes.CORRELATION)


if __name__ == "__main__":
    main()
