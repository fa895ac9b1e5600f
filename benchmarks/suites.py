"""The report's section on the corners' accuracy: three suites of scans, read from CARMEN logs."""

import tempfile
from dataclasses import dataclass
from pathlib import Path

import numpy as np
from page import NONE, percent, table, verdict
from speed_all import all_extractors

import laserfeatures as lf
from laserfeatures.evaluation import Score, oracle, score, truth_of
from laserfeatures.simulation import Scanner, random_room
from laserfeatures.sources.carmen_writer import write_carmen

HELD_OUT = range(60_000, 60_400)  # seeds of rooms and noise; no parameter was tuned on them
ORACLE = "oracle"


@dataclass(frozen=True)
class Suite:
    """A scanner, how many poles stand in the rooms, and what is aimed at.

    The targets are shares of the oracle's F1: of `direct_hough`, of the best extractor, and what
    the best public peer reached on scenes like these.
    """

    name: str
    scanner: Scanner
    poles: int
    direct_hough: float
    best: float
    peer: float


LMS = Scanner.model("lms200")
FAR = Scanner.model("lms200", beams=361, range_max=20.0, range_sigma=0.010)
SPOILED = Scanner.model(
    "lms200", beams=361, range_max=20.0, range_sigma=0.010, relative_sigma=0.001,
    outliers=0.02, dropouts=0.03,
)  # fmt: skip
SUITES = [
    Suite("rooms, 181 beams, 5 mm, 10 m", LMS, 0, 0.98, 0.985, 0.87),
    Suite("rooms, 361 beams, 10 mm, 20 m", FAR, 0, 0.965, 0.975, 0.87),
    Suite(
        "clutter: 361 beams, 10 mm + 0.1 %, 6 poles, 2 % outliers, 3 % drop-outs",
        SPOILED, 6, 0.88, 0.90, 0.71,
    ),
]  # fmt: skip

METHOD = f"""{len(HELD_OUT)} random rooms a suite (`laserfeatures.simulation.random_room`, the split
of seeds {HELD_OUT[0]} to {HELD_OUT[-1]}, on which nothing was tuned), one scan each. The scans are
written to a CARMEN log and read back, so that the noise is not told; every extractor runs with its
defaults. Corners are paired one to one with the true ones within 0.2 m
([evaluation.md](evaluation.md)). "Share" is the F1 as a share of that of the oracle, the
least-squares lines through exactly the beams of each wall; it can exceed 1, since the oracle
withholds nothing. "Given" is `direct_hough` told the range noise (what of it does not grow with
range); the last columns are the shares of corners and lines inside their own 95 % ellipse. ± is the
standard error of the share over the scans, by the jackknife in 20 blocks."""


def section(options):
    """Return the section's paragraphs."""
    seeds = HELD_OUT[: options.repeats(len(HELD_OUT))]
    parts = ["## Corners on held-out scans", METHOD]
    for suite in SUITES:
        scores = measure(suite, seeds)
        parts += [f"### {suite.name[0].upper()}{suite.name[1:]}", _table(scores)]
        parts.append(_targets(suite, scores))
    return parts


def measure(suite, seeds):
    """Return the scores of each scan of a suite, by the extractor's name."""
    seen = []
    for seed in seeds:
        world, pose = random_room(seed, poles=suite.poles)
        seen.append(suite.scanner.observe(world, pose, np.random.default_rng((seed, 1))))
    truths = [truth_of(each) for each in seen]
    scans = as_logged([each.scan for each in seen])
    given = lf.get_extractor("direct_hough", range_sigma=suite.scanner.range_sigma)
    methods = {**all_extractors(), "direct_hough, given": given}
    scores = {
        name: [score(extractor(scan), truth) for scan, truth in zip(scans, truths, strict=True)]
        for name, extractor in methods.items()
    }
    best = [score(oracle(scan, truth), truth) for scan, truth in zip(scans, truths, strict=True)]
    return {**scores, ORACLE: best}


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


def _table(scores):
    rows = []
    for name, each in scores.items():
        total = Score.total(each)
        ratio, spread = share(each, scores[ORACLE])
        known = name != ORACLE
        rows.append([
            name, f"{ratio:.3f} ± {spread:.3f}", f"{total.tp_percent:.1f}",
            f"{total.fp_percent:.1f}", f"{1e3 * total.median_error:.1f}",
            f"{1e3 * total.rms_error:.1f}", _share(total.line_recall), _share(total.line_precision),
            _share(total.corner_consistency) if known else NONE,
            _share(total.line_consistency) if known else NONE,
        ])  # fmt: skip
    header = ["corners", "share", "TP [%]", "FP [%]", "error, median [mm]", "rms [mm]",
              "lines: recall", "precision", "corners inside", "lines inside"]  # fmt: skip
    return table(header, rows)


def _share(value):
    return NONE if np.isnan(value) else percent(value)


def _targets(suite, scores):
    own = share(scores["direct_hough"], scores[ORACLE])[0]
    shares = {
        name: share(each, scores[ORACLE])[0]
        for name, each in scores.items()
        if name in lf.list_extractors()
    }
    best = max(shares, key=shares.get)
    rows = [
        ["direct_hough", f"{suite.direct_hough:g}", f"{own:.3f}",
         verdict(own >= suite.direct_hough)],
        [f"the best: {best}", f"{suite.best:g}", f"{shares[best]:.3f}",
         verdict(shares[best] >= suite.best)],
        ["best public peer, as measured on scenes like these", NONE, f"{suite.peer:g}", NONE],
    ]  # fmt: skip
    return table(["share of the oracle's F1", "target", "measured", ""], rows)
