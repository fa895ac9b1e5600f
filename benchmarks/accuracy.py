"""The report's section on accuracy: lines and corners of simulated rooms against the truth."""

import math
from dataclasses import dataclass, replace
from functools import cache

import numpy as np
import truth as truths
from page import NONE, percent, table, verdict
from rooms import random_room
from speed_all import all_extractors

import laserfeatures as lf
from laserfeatures.evaluation import Score, Truth, oracle, score
from laserfeatures.evaluation.matching import GATE
from laserfeatures.simulation import Scanner

SEEDS = range(10_000, 10_400)
GIVEN = "direct_hough, range_sigma given"
DEFAULT = "direct_hough"
ORACLE = "oracle"


@dataclass(frozen=True)
class Scene:
    """A sensor, the size of the rooms and the share of false beams, isolated or anywhere."""

    name: str
    scanner: Scanner
    scale: float = 1.0
    outliers: float = 0.0
    isolated: bool = False


SICK = Scanner(beams=181, field_of_view=math.pi, range_max=10.0, range_sigma=0.005)
NOISY = Scanner(beams=181, field_of_view=math.pi, range_max=10.0, range_sigma=0.015)
FAR = Scanner(beams=361, field_of_view=math.pi, range_max=20.0, range_sigma=0.010)
CLEAN = Scene("181 beams, 10 m, 5 mm", SICK)
ISOLATED = Scene(
    "181 beams, 10 m, 15 mm, 20 % isolated false beams", NOISY, outliers=0.2, isolated=True
)
SCENES = [
    CLEAN,
    Scene("361 beams, 20 m, 10 mm, rooms twice as large", FAR, scale=2.0),
    Scene("181 beams, 10 m, 5 mm, 20 % false beams", SICK, outliers=0.2),
    ISOLATED,
]

METHOD = f"""{len(SEEDS)} random rooms (`benchmarks/rooms.py`, seeds {SEEDS[0]} to {SEEDS[-1]}; no
parameter was tuned on them): rectangles of 3 to 9 m with niches, pillars, corridors, a cut corner
and up to three boxes turned anyhow. True lines are the walls that at least four beams hit,
collinear ones merged; true corners are where two cross at 15° or more within 20 m of the sensor,
however far from the points. The oracle knows which beams hit which wall and fits each by least
squares (total, unweighted); its corners are all crossings of its lines. A false beam returns from
anywhere between 0.3 m and the sensor's range; isolated ones have no false neighbour.

A line found is a wall's where at least half of its points are beams of that wall, one line a
wall; a second line on the same wall is a duplicate (share of the lines found). A corner found is a
true one where both are paired within {GATE} m (least total distance). F1 counts both found and
missed. `preset="paper"` is raw bins: theta and d are centres of the accumulator's cells.

An extractor that finds points without lines cannot find where the prolongations of two walls
cross, which most of the true corners are. Therefore the columns "in sight": the corners that are
called real, against the places where the scan goes from one wall over to the next, paired likewise.
They are few ({{sights:.1f}} a scan in the first scene, of {{crossings:.1f}} corners in all)."""

RIGHT, ANGLE = 0.98, 0.06  # least recall and precision, greatest median error [°], without outliers
FOUND, TRUE = 0.92, 0.85  # least recall and precision with them

TARGETS = """Targets for lines, in the first scene without any duplicate. They were set for plain
rooms, where the tests check them; the rooms here have niches and boxes of which a wall may show no
more than four beams:"""

CONSISTENCY = """Covariances: share of the corners (of pairs of lines that are walls', however far
off; of points without lines, those paired with a true corner) and of the lines that lie within
their own 95 % ellipse, scenes numbered as above. `range_sigma` is estimated from each scan but
where it says given."""


@cache
def measured(options):
    """Return the scores of all extractors and of the oracle, by scene and name."""
    seeds = SEEDS[: options.repeats(len(SEEDS))]
    scores = {}
    for scene in SCENES:
        given = lf.get_extractor("direct_hough", range_sigma=scene.scanner.range_sigma)
        scores[scene] = _scores(scene, seeds, {**all_extractors(), GIVEN: given})
    return scores


def section(options):
    """Return the section's paragraphs."""
    scores = measured(options)
    every = scores[CLEAN][ORACLE][0]
    sights = scores[CLEAN][DEFAULT][1]
    scans = options.repeats(len(SEEDS))
    method = METHOD.format(
        sights=sights.features_true / scans, crossings=every.features_true / scans
    )
    return [
        "## Accuracy in simulated rooms", method,
        *(part for scene in SCENES for part in (f"### {scene.name}", *_tables(scores[scene]))),
        TARGETS, _targets(scores), CONSISTENCY, _consistency(scores),
    ]  # fmt: skip


def _scores(scene, seeds, extractors):
    found = {name: [] for name in [*extractors, ORACLE]}
    for seed in seeds:
        world, pose = random_room(seed, scale=scene.scale)
        rng = np.random.default_rng((seed, 1))
        scan, truth = truths.sense(
            world, scene.scanner, pose, rng, outliers=scene.outliers, isolated=scene.isolated
        )
        sights = truths.junctions(world, scene.scanner, pose)
        sights = Truth.of_corners(scan, sights, np.ones(len(sights), bool))
        for name, extractor in extractors.items():
            features = extractor(scan)
            found[name].append((score(features, truth), score(_real(features), sights)))
        found[ORACLE].append((score(oracle(scan, truth), truth), Score()))
    return {
        name: [Score.total(part) for part in zip(*parts, strict=True)]
        for name, parts in found.items()
    }


def _real(features):
    """Return the same without the virtual corners."""
    return replace(features, corners=features.corners.select(features.corners.real))


def _tables(scores):
    corners = [[name, *_corner_cells(*score)] for name, score in scores.items()]
    lines = [[name, *_line_cells(every)] for name, (every, _) in scores.items()]
    return [
        table(["corners", "F1", "precision", "recall", "error, median [mm]", "rms [mm]",
               "in sight: precision", "recall", "error, median [mm]"], corners),
        table(["lines", "precision", "recall", "duplicates", "angle error, median [°]",
               "distance, median [mm]", "angle, 90 % [°]", "distance, 90 % [mm]"], lines),
    ]  # fmt: skip


def _corner_cells(every, seen):
    cells = [f"{every.f1:.3f}", *_precision_and_recall(every),
             f"{1e3 * every.median_error:.1f}", f"{1e3 * every.rms_error:.1f}"]  # fmt: skip
    if not seen.features_extracted:
        return [*cells, *3 * [NONE]]
    return [*cells, *_precision_and_recall(seen), f"{1e3 * seen.median_error:.1f}"]


def _precision_and_recall(score):
    return f"{1 - score.fp_percent / 100:.3f}", f"{score.tp_percent / 100:.3f}"


def _line_cells(score):
    if not score.lines_extracted:
        return 7 * [NONE]
    turns, shifts = np.degrees(abs(score.angle_errors)), 1e3 * abs(score.distance_errors)
    return [
        f"{score.line_precision:.3f}", f"{score.line_recall:.3f}",
        f"{score.duplicates / score.lines_extracted:.3f}",
        f"{np.median(turns):.3f}", f"{np.median(shifts):.1f}",
        f"{np.percentile(turns, 90):.2f}", f"{np.percentile(shifts, 90):.1f}",
    ]  # fmt: skip


def _targets(scores):
    rows = []
    for name in ("ransac", "region_growing", "split_and_merge"):
        every = scores[CLEAN][name][0]
        angle = math.degrees(np.median(abs(every.angle_errors)))
        right = min(every.line_recall, every.line_precision) >= RIGHT
        met = right and angle <= ANGLE and not every.duplicates
        rows.append([
            f"{name}, scene 1: recall and precision at least {RIGHT:g}, angle at most {ANGLE:g}°",
            f"{every.line_recall:.3f}", f"{every.line_precision:.3f}", f"{angle:.3f}°",
            every.duplicates,
            verdict(met),
        ])  # fmt: skip
    for name in ("ransac", "direct_hough"):
        every = scores[ISOLATED][name][0]
        rows.append([
            f"{name}, scene {len(SCENES)}: recall at least {FOUND:g}, precision at least {TRUE:g}",
            f"{every.line_recall:.3f}", f"{every.line_precision:.3f}", NONE, NONE,
            verdict(every.line_recall >= FOUND and every.line_precision >= TRUE),
        ])  # fmt: skip
    return table(["target", "recall", "precision", "angle", "duplicates", ""], rows)


def _consistency(scores):
    names = [name for name in scores[CLEAN] if name not in {ORACLE, "preset paper"}]
    rows = [
        [name, *(_inside(getattr(scores[scene][name][0], kind)) for scene in SCENES
                 for kind in ("corner_consistency", "line_consistency"))]
        for name in names
    ]  # fmt: skip
    header = [
        f"scene {k}: {kind}" for k in range(1, len(SCENES) + 1) for kind in ("corners", "lines")
    ]
    return table(["inside", *header], rows)


def _inside(share):
    return NONE if math.isnan(share) else percent(share)
