"""How many corners of a scan of a real log are found again in the next scan.

Pairs are successive scans whose (corrected) poses are nearer than 0.5 m and 20 degrees (``--near``,
``--turn``: logs that were thinned out need 1 m and 35 degrees). A corner of
scan A counts if it lies within 8 m of the sensor and within 80 degrees of its x axis, in A's frame
and, put there by the poses, in B's. It is found again if a corner of B is within 0.2 m. "Again" is
the share of them over all pairs; "chance" the same share where the corners of a scan half the log
away take the place of B's. What is reported is again with chance taken off:
(again - chance) / (1 - chance); more corners a scan raise both. Blind scans have fewer than two
corners.

Covariances: the pair's relative pose is refined by matching the raw points of both scans (points
to lines, robust), then corners that are each other's nearest within 0.2 m are held against their
joint 95 % ellipse. The same pose tells lines that are lost: of A's lines of which at least
80 % of the points have a return of B within 5 cm, those that no line of B is within 5 degrees and
5 cm of.

``python benchmarks/repeatability.py --extractors direct_hough,ransac [--logs flirt_mit-cscail]
[--every k] [--near 1] [--turn 35] [--range-sigma 0.01] [--model] [--curves] [--sigmas]``
"""

import argparse
import math
import sys
import time
from dataclasses import dataclass, field
from functools import cached_property
from pathlib import Path

import numpy as np
from page import NONE, table
from scan_matching import Matcher

import laserfeatures as lf
from laserfeatures.data import Pose2D
from laserfeatures.intersections import Intersections
from laserfeatures.noise_model import NoiseModel
from laserfeatures.poses import relative

DATA = Path(__file__).parents[1] / "../shared/data/sick"
SIGMAS = (0.05, 0.1, 0.15, 0.2, 0.25, 0.3, 0.5)  # [m], limits of `--sigmas`
LOGS = ("flirt_mit-cscail", "fr079_first_half")
NEAR, TURN = 0.5, 20.0  # [m], [deg], of the two poses of a pair
REACH, SIDE = 8.0, math.radians(80)  # of a corner from the sensor, and from its x axis
GATE = 0.2  # [m], of a corner from the same one in the other scan
ELLIPSE = 5.99  # squared Mahalanobis distance within which 95 % lie
BLIND = 2  # corners
KEPT = (0.25, 0.35, 0.5, 0.75, 0.9)  # shares of the corners that the curves select
SAME_TURN, SAME_SHIFT = math.radians(5), 0.05  # of a line from the same one in the other scan
THERE, PRESENT = 0.05, 0.8  # [m], of a point from B's; share of a line's points that are still so


@dataclass(frozen=True)
class Pair:
    """Two successive scans, one half the log away, and B's frame as A's points see it."""

    a: int
    b: int
    far: int
    to_b: Pose2D  # takes points of A's frame to B's


@dataclass
class Log:
    """A log's scans, and its pairs with their matched poses."""

    name: str
    scans: list
    every: int = 1
    near: float = NEAR
    turn: float = TURN

    @cached_property
    def pairs(self):
        """Every k-th pair of successive scans that are near to one another."""
        found = []
        for a in range(0, len(self.scans) - 1, self.every):
            before, after = self.scans[a].pose, self.scans[a + 1].pose
            to_b = relative(after, before)
            if math.hypot(to_b.x, to_b.y) < self.near and abs(to_b.theta) < math.radians(self.turn):
                far = (a + 1 + len(self.scans) // 2) % len(self.scans)
                found.append(Pair(a, a + 1, far, to_b))
        return found

    @cached_property
    def matched(self):
        """What the scans' points say of each pair's pose, and which of A's beams B still sees.

        A list of (pose, beams), None where the points do not say.
        """
        matchers = {}
        return [_matched(self.scans, pair, matchers) for pair in self.pairs]


def _matched(scans, pair, matchers):
    for k in (pair.a, pair.b):
        if k not in matchers:
            matchers[k] = Matcher(scans[k].points)
    points = scans[pair.a].points
    pose = matchers[pair.b].pose(points, pair.to_b)
    if pose is None:
        return None
    there = np.zeros(len(scans[pair.a]), bool)
    there[scans[pair.a].beams] = matchers[pair.b].distances(pose.transform(points)) < THERE
    return pose, there


@dataclass
class Counts:
    """Corners that count, found again, and found again by chance; by kind: all, real, virtual."""

    seen: np.ndarray = field(default_factory=lambda: np.zeros(3))
    again: np.ndarray = field(default_factory=lambda: np.zeros(3))
    chance: np.ndarray = field(default_factory=lambda: np.zeros(3))

    @property
    def score(self):
        """Again with chance taken off, of all, real and virtual corners."""
        with np.errstate(invalid="ignore", divide="ignore"):
            again, chance = self.again / self.seen, self.chance / self.seen
            return (again - chance) / (1 - chance)


def again(features, pairs, kept=None):
    """Return the counts of corners found again over pairs.

    Parameters
    ----------
    features : list of Features
        What was found in each scan.
    pairs : list of Pair
        The pairs.
    kept : list of bool arrays or None
        Which corners of each scan are selected; None: all.
    """
    positions = [each.corners.positions for each in features]
    real = [each.corners.real for each in features]
    if kept is not None:
        positions = [p[k] for p, k in zip(positions, kept, strict=True)]
        real = [r[k] for r, k in zip(real, kept, strict=True)]
    counts = Counts()
    for pair in pairs:
        moved = pair.to_b.transform(positions[pair.a])
        mine = _counts(positions[pair.a]) & _counts(moved)
        moved, kind = moved[mine], real[pair.a][mine]
        kinds = np.stack([np.ones_like(kind), kind, ~kind])
        counts.seen += kinds.sum(axis=1)
        counts.again += (kinds & _near(moved, positions[pair.b])).sum(axis=1)
        counts.chance += (kinds & _near(moved, positions[pair.far])).sum(axis=1)
    return counts


def _counts(points):
    """Tell which points are near enough to the sensor and its x axis."""
    x, y = points.T
    return (np.hypot(x, y) < REACH) & (abs(np.arctan2(y, x)) < SIDE)


def _near(points, others):
    """Tell which points have one of the others within the gate."""
    return (_gaps(points, others) < GATE).any(axis=1)


def _gaps(points, others):
    step = points[:, None] - others[None]
    return np.hypot(step[..., 0], step[..., 1])


def inside(features, log):
    """Return how many corners found again lie in their joint 95 % ellipse, and how many there are.

    A pair whose pose the points do not say is left out.
    """
    within, count = 0, 0
    for pair, matched in zip(log.pairs, log.matched, strict=True):
        if matched is None:
            continue
        error, covariance = _errors(features[pair.a].corners, features[pair.b].corners, matched[0])
        square = np.einsum("ni,nij,nj->n", error, np.linalg.pinv(covariance), error)
        within += int((square < ELLIPSE).sum())
        count += len(error)
    return within, count


def _errors(a, b, pose):
    """Return how far corners of A are from the same ones of B (M, 2) and its covariance."""
    moved = pose.transform(a.positions)
    mine = _counts(a.positions) & _counts(moved)
    moved, covariance = moved[mine], a.covariance[mine]
    if not len(moved) or not len(b):
        return np.empty((0, 2)), np.empty((0, 2, 2))
    gaps = _gaps(moved, b.positions)
    to, back = gaps.argmin(axis=1), gaps.argmin(axis=0)
    rows = np.flatnonzero((back[to] == np.arange(len(to))) & (gaps.min(axis=1) < GATE))
    c, s = math.cos(pose.theta), math.sin(pose.theta)
    turn = np.array([[c, -s], [s, c]])
    joint = turn @ covariance[rows] @ turn.T + b.covariance[to[rows]]
    known = np.isfinite(joint).all(axis=(1, 2))
    return (moved[rows] - b.positions[to[rows]])[known], joint[known]


def lost(features, log):
    """Return how many lines are lost though their points are still there, and how many are."""
    gone, count = 0, 0
    for pair, matched in zip(log.pairs, log.matched, strict=True):
        if matched is None:
            continue
        pose, there = matched
        segments, lines = features[pair.a].segments, features[pair.b].lines
        for number in range(len(segments.lines)):
            members = segments.points[segments.line == number].any(axis=0)
            if not members.any() or there[members].mean() < PRESENT:
                continue
            ends = pose.transform(segments.endpoints[segments.line == number].reshape(-1, 2))
            count += 1
            gone += not _same_line(ends, lines)
    return gone, count


def _same_line(ends, lines):
    """Tell whether a line of B is the one through these points."""
    step = ends[-1] - ends[0]
    normal = math.atan2(step[0], -step[1])
    turned = abs(np.sin(lines.theta - normal)) < math.sin(SAME_TURN)
    off = ends.mean(axis=0) @ np.stack([np.cos(lines.theta), np.sin(lines.theta)]) - lines.d
    return bool((turned & (abs(off) < SAME_SHIFT)).any())


def curves(features, pairs):
    """Return rows (what selects, share kept, score, corners a scan), selecting the best corners."""
    rows = []
    for name, merit in (("evidence", _evidence), ("sigma", _precision)):
        merits = [merit(each.corners) for each in features]
        if any(each is None for each in merits):
            continue
        every = np.concatenate(merits)
        if not every.size or every.min() == every.max():
            continue  # nothing to select by
        for share in KEPT:
            limit = np.quantile(every, 1 - share)
            kept = [each >= limit for each in merits]
            score = again(features, pairs, kept).score[0]
            rows.append((name, share, limit, score, sum(k.sum() for k in kept) / len(features)))
    return rows


def by_sigma(features, pairs):
    """Return rows (max_sigma [m], corners a scan, score)."""
    rows = []
    for limit in SIGMAS:
        kept = [-_precision(each.corners) <= limit for each in features]
        many = sum(each.sum() for each in kept) / len(features)
        rows.append((limit, many, again(features, pairs, kept).score[0]))
    return rows


def _evidence(corners):
    return getattr(corners, "evidence", None)


def _precision(corners):
    """Return minus the largest standard deviation of each corner [m]; -inf where unknown."""
    covariance = np.nan_to_num(corners.covariance, nan=1e6, posinf=1e6)
    return -np.sqrt(np.linalg.eigvalsh(covariance)[:, -1]) if len(corners) else np.empty(0)


def extracted(name, scans, options):
    """Return the features of each scan.

    The hook for what learns from the scans before, such as a model of the noise: with ``--model``
    the extractor comes from `modelled`.
    """
    told = {} if options.range_sigma is None else {"range_sigma": options.range_sigma}
    if options.sigmas:
        told["intersections"] = Intersections(max_sigma=SIGMAS[-1])
    extractor = modelled(name, told) if options.model else lf.get_extractor(name, **told)
    return [extractor(scan) for scan in scans]


def modelled(name, told):
    """Return an extractor that carries a model of the noise from scan to scan."""
    extractor, model = lf.get_extractor(name, **told), NoiseModel()
    return lambda scan: extractor(scan, noise=model.feed(scan))


def row_of(log, name, features):
    """Return a row of figures of an extractor on a log."""
    corners = [len(each.corners) for each in features]
    counts = again(features, log.pairs)
    share = counts.score
    within, refound = inside(features, log)
    gone, present = lost(features, log)
    return [
        f"{log.name}: {name}", len(log.pairs), f"{share[0]:.3f} @ {np.mean(corners):.1f}",
        f"{counts.again[0] / counts.seen[0]:.3f}", f"{counts.chance[0] / counts.seen[0]:.3f}",
        *(f"{share[k]:.3f} ({counts.seen[k] / len(log.pairs):.1f})" for k in (1, 2)),
        sum(n < BLIND for n in corners),
        f"{within / refound:.3f} ({refound})" if refound else NONE,
        f"{gone / present:.3f} ({present})" if present else NONE,
    ]  # fmt: skip


HEADER = ["log: extractor", "pairs", "score @ corners a scan", "again", "chance",
          "real (a pair)", "virtual", "blind", "inside (found again)", "lost lines"]  # fmt: skip


def main():
    """Print the table, and the curves."""
    options = _options()
    rows, chosen, limits = [], [], []
    for each in options.logs.split(","):
        with lf.open_source(DATA / f"{each}.log.gz") as source:
            log = Log(each, list(source), options.every, options.near, options.turn)
        for name in options.extractors.split(","):
            start = time.perf_counter()
            features = extracted(name, log.scans, options)
            rows.append(row_of(log, name, features))
            if options.curves:
                chosen += [
                    [f"{each}: {name}", what, f"{limit:.4g}", f"{score:.3f} @ {many:.1f}"]
                    for what, _, limit, score, many in curves(features, log.pairs)
                ]
            if options.sigmas:
                limits += [
                    [f"{each}: {name}", f"{limit}", f"{score:.3f} @ {many:.1f}"]
                    for limit, many, score in by_sigma(features, log.pairs)
                ]
            print(f"{each}, {name}: {time.perf_counter() - start:.0f} s", file=sys.stderr)
    print(table(HEADER, rows))
    if chosen:
        print("\n" + table(["log: extractor", "selected by", "at least", "score"], chosen))
    if limits:
        head = ["log: extractor", "max_sigma [m]", "score @ corners a scan"]
        print("\n" + table(head, limits))


def _options():
    parser = argparse.ArgumentParser(description="Corners found again in the next scan.")
    parser.add_argument("--extractors", default="direct_hough", help="names, with commas")
    parser.add_argument("--logs", default=",".join(LOGS), help="names, with commas")
    parser.add_argument("--every", type=int, default=1, help="take every k-th pair")
    parser.add_argument("--near", type=float, default=NEAR, help="poses of a pair, at most [m]")
    parser.add_argument("--turn", type=float, default=TURN, help="and turned by so much [deg]")
    parser.add_argument("--range-sigma", type=float, help="tell the extractors the noise [m]")
    parser.add_argument("--model", action="store_true", help="carry a model of the noise along")
    parser.add_argument("--curves", action="store_true", help="select by evidence and by sigma")
    parser.add_argument("--sigmas", action="store_true", help="the trade-off of max_sigma")
    return parser.parse_args()


if __name__ == "__main__":
    main()
