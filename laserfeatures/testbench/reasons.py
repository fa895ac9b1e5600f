"""Why the literal algorithm misses lines and finds corners that are none."""

import math
from collections.abc import Sequence
from typing import TYPE_CHECKING, Any

import numpy as np

from laserfeatures.arrays import BoolArray, IntArray
from laserfeatures.data import Features
from laserfeatures.evaluation import Truth, match_corners, match_lines
from laserfeatures.evaluation.true_lines import difference
from laserfeatures.testbench.measuring import Trial, extract, measure
from laserfeatures.testbench.paper import PaperRow

if TYPE_CHECKING:
    from laserfeatures.pipeline import Pipeline

MIN_ANGLE = math.radians(15)  # of a true corner
MIN_VOTES = 4  # the paper's MinTh
RELATIVE = 0.15  # of the largest vote, Eq. 2


def reasons_of(
    row: PaperRow, *, trials: Sequence[Trial], on_grid: Sequence[Trial]
) -> dict[str, Any]:
    """Return counts that tell where lines are lost and why corners are false.

    Parameters
    ----------
    row : PaperRow
        The parameters of the literal algorithm.
    trials : sequence of (LaserScan, Truth)
        The scans.
    on_grid : sequence of (LaserScan, Truth)
        Scans whose walls lie on the grid of theta.

    Returns
    -------
    dict
        "row", its name; "true_lines", how many there are, "weak" and "shadowed" ones; what the
        lines are before the filter, "found_..", and after it, "kept_.."; "false_corners", and what
        they are; "grid_tp_percent" and "grid_fp_percent" of the scans `on_grid`. `pages.REASONS`
        says what the names mean.
    """
    parts = [_count(row, row.extractor, trial, i) for i, trial in enumerate(trials)]
    sums = {key: sum(part[key] for part in parts) for key in parts[0]}
    on = measure(row.extractor, on_grid).score
    grid = {"grid_tp_percent": on.tp_percent, "grid_fp_percent": on.fp_percent}
    return {"row": row.name} | sums | grid


def _count(row: PaperRow, extractor: "Pipeline", trial: Trial, number: int) -> dict[str, int]:
    scan, truth = trial
    detected, features = extract(extractor, trial, number)
    votes = extractor.detector.accumulator(scan).votes  # type: ignore[attr-defined]
    threshold = max(MIN_VOTES, math.floor(RELATIVE * int(votes.max(initial=0)) + 0.5))
    beams = np.bincount(truth.line[truth.line >= 0], minlength=truth.theta.size)
    weak = beams < threshold
    counts = {
        "true_lines": truth.theta.size,
        "weak": int(weak.sum()),
        "shadowed": int((_shadowed(row, truth, beams) & ~weak).sum()),
    }
    for stage, segments in (("found", detected), ("kept", features.segments)):
        wall, copies = match_lines(segments, truth)
        own = int((wall >= 0).sum())
        counts |= {f"{stage}_true": own, f"{stage}_copies": copies}
        counts[f"{stage}_false"] = len(segments.lines) - own - copies
    return counts | _false_corners(features, truth)


def _shadowed(row: PaperRow, truth: Truth, beams: IntArray) -> BoolArray:
    """Tell of each true line whether it lies in the window of one with more beams, (L,)."""
    turn, shift = difference(truth.theta[:, None], truth.d[:, None], truth.theta, truth.d)
    turned = abs(turn) <= (row.v_theta // 2) * math.radians(row.dtheta_deg)
    shifted = abs(shift) <= (row.v_d // 2) * row.dd_cm / 100
    by = turned & shifted & (beams[:, None] < beams)
    return np.asarray(by.any(axis=1))


def _false_corners(features: Features, truth: Truth) -> dict[str, int]:
    corners = features.corners
    false = np.full(len(corners), fill_value=True)
    false[match_corners(corners.positions, truth.corners)[0]] = False
    shallow = corners.angles < MIN_ANGLE
    wall, _ = match_lines(features.segments, truth)
    stray = (wall[corners.lines] < 0).any(axis=1)
    return {
        "false_corners": int(false.sum()),
        "shallow": int((false & shallow).sum()),
        "stray": int((false & ~shallow & stray).sum()),
        "off": int((false & ~shallow & ~stray).sum()),
    }
