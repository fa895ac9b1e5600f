"""Draw docs/story_*.png: one scan after each step of `direct_hough`, for docs/direct-hough.md.

Run ``python benchmarks/story.py``; ``--docs`` says where the pictures go. The scan is of a
simulated office room with a column and some false beams, all from one seed. Each step calls the
kernels that the extractor calls, and what comes out is checked to be what the extractor returns.
"""

import argparse
import io
import math
from functools import cache
from pathlib import Path
from typing import Any, NamedTuple

import numpy as np
import scenes
from laserfeatures_plugins.direct_hough import search, voting
from matplotlib.collections import LineCollection
from matplotlib.patches import Rectangle
from page import new_figure
from PIL import Image

import laserfeatures as lf
from laserfeatures import figures
from laserfeatures.compiled import kernel
from laserfeatures.engine import (
    certainty,
    columns,
    explain,
    noise,
    partition,
    segments,
    sequence,
    steps,
    sums,
    walls,
)
from laserfeatures.engine.prices import PRICE, RETURN_PRICE
from laserfeatures.simulation import Scanner, World

ROOT = Path(__file__).parents[1]
SEED = 4824
SCANNER = Scanner(
    beams=541, field_of_view=math.radians(270), range_max=10.0, range_sigma=0.012, outliers=0.012
)
COLUMN = 0.12  # [m], radius
FIRST_ROW = math.radians(-45)  # of the votes as they are drawn
TURN = 0.07  # [rad], of the sensor from the walls' directions
ROOM_MARGIN = 0.4  # [m]
COLORS = 128  # of a picture

BLUE, LIGHT, RED, GREY = figures.BLUE, "#6aaee0", figures.RED, "0.6"
NEW, ROUND = "#e07b00", "#2b8a3e"
DOT: dict[str, Any] = {"marker": ".", "linestyle": "none", "markersize": 3}
CROSS: dict[str, Any] = {
    "marker": "x", "linestyle": "none", "markersize": 7, "markeredgewidth": 1.6, "color": RED,
}  # fmt: skip


class Story(NamedTuple):
    """What the steps made of a scan, one after another."""

    scan: lf.LaserScan
    extractor: lf.Pipeline
    ordered: sequence.Sequence  # step 1
    points: sequence.Sequence  # step 2
    noise: Any
    proposed: Any  # step 3, (COLUMNS, K)
    explained: Any  # step 4, labels
    settled: Any  # step 5, labels and walls
    parted: Any  # step 6, labels and walls
    weighed: Any  # step 7, walls before and after their covariances were inflated
    cut: lf.LineSegments  # step 8
    features: lf.Features  # steps 9 and 10


@cache
def compiled(function):
    """Return a helper as a kernel: Python must not call a helper itself."""
    return kernel(getattr(function, "py_func", function))


def scene(seed):
    """Return an office with a column near the sensor, and the sensor's pose."""
    world, pose = scenes.offices(seed)
    rng = np.random.default_rng((seed, 9))
    while True:
        bearing, away = pose.theta + rng.uniform(-1.8, 1.8), rng.uniform(1.0, 2.0)
        place = (pose.x + away * math.cos(bearing), pose.y + away * math.sin(bearing))
        if world.distances(place).min() > 0.45:
            turn = round(pose.theta / (math.pi / 2)) * math.pi / 2 + TURN
            poles = [*world.poles, [*place, COLUMN]]
            return World(boxes=world.boxes, poles=poles), lf.Pose2D(pose.x, pose.y, turn)


def tell():
    """Return what each step makes of the scan."""
    world, pose = scene(SEED)
    scan = SCANNER.observe(world, pose, np.random.default_rng(SEED)).scan
    extractor = lf.get_extractor("direct_hough")
    detector: Any = extractor.detector
    limits = partition.Limits(*detector._limits)  # noqa: SLF001 - as the detector passes them
    # 1 and 2
    seen = float(scan.range_min), float(scan.range_max)
    ordered = sequence.Sequence(
        *compiled(sequence.in_order)(scan.directions, scan.ranges, seen, scan.ring)
    )
    told = compiled(noise.estimate_noise)(ordered, sequence.Noise(-1.0, 0.0, 0.0, -1.0))
    compiled(sequence.weigh)(ordered, told)
    table = compiled(sequence.without_lone)(np.array(ordered))
    np.testing.assert_array_equal(table, detector.prepared(scan))
    points = sequence.Sequence(*table)
    # 3
    proposed = detector.propose(table)
    # 4
    total = compiled(sums.running_sums)(points)
    explained = np.empty(points.x.size, np.int64)
    lines = partition.Candidates(*proposed)
    none = np.empty((2, 0), np.int64)
    compiled(partition.partition)(points, total, lines, none, PRICE, limits, explained)
    # 5
    label, found = compiled(explain.settle)(points, total, proposed, none, PRICE, limits)
    round_ = compiled(columns.find_columns)(points, label, found, limits.max_pole_radius)
    found = compiled(steps.part_at_steps)(points, label, found, limits.min_points)
    again = compiled(explain.as_proposed)(found, limits.min_points, 0)
    label, found = compiled(explain.settle)(points, total, again, round_, RETURN_PRICE, limits)
    found = found.view(walls.WALL)  # numba forgets that fields are attributes
    settled = label.copy(), found.copy()
    # 6
    for _ in range(explain.PARTINGS):
        compiled(walls.part_at_corners)(points, label, found)
        compiled(walls.fit_walls)(points, label, found, True)
    parted = label.copy(), found.copy()
    # 7
    found = found[: compiled(walls.prune)(label, found, limits.min_points)]
    compiled(certainty.weigh_evidence)(points, label, found)
    before = found.copy()
    compiled(certainty.inflate_covariances)(points, found, limits.roughness_told)
    # 8
    cut = compiled(segments.cut_walls)(points, label, found, len(scan), limits)
    cut = segments.line_segments(cut)
    np.testing.assert_array_equal(cut.endpoints, extractor.detect(scan).endpoints)
    np.testing.assert_array_equal(cut.lines.evidence, extractor.detect(scan).lines.evidence)
    return Story(
        scan, extractor, ordered, points, told, proposed, explained, settled, parted,
        (before, found, label), cut, extractor(scan),
    )  # fmt: skip


def main():
    """Draw all pictures."""
    parser = argparse.ArgumentParser(description="Draw a scan after each step of direct_hough.")
    parser.add_argument("--docs", type=Path, default=ROOT / "docs")
    arguments = parser.parse_args()
    story = tell()
    for number, (title, draw) in enumerate(STEPS.items(), start=1):
        figure = new_figure(9.0, 6.0)
        figure.suptitle(f"{number}. {title}", fontsize="medium", x=0.01, ha="left")
        left, right = figure.subplots(1, 2)
        draw(story, left, right)
        figures.draw_legend(figure, columns=4)
        path = arguments.docs / f"story_{number:02d}.png"
        save(figure, path)
        print(f"wrote {path}, {path.stat().st_size / 1e3:.0f} kB")


def save(figure, path):
    """Save a picture of few colours, which takes half the room."""
    full = io.BytesIO()
    figure.savefig(full, dpi=100)
    few = Image.open(full).convert("RGB").quantize(COLORS, dither=Image.Dither.NONE)
    few.save(path, optimize=True)


# The pictures: on the left the scan, on the right what the step looks at


def order(story, left, right):
    """Draw step 1."""
    points = story.ordered
    number = np.arange(points.x.size)
    style = {"c": number, "cmap": "viridis", "s": 6}
    left.plot(points.x, points.y, color="0.85", linewidth=0.6, zorder=1)
    left.scatter(points.x, points.y, zorder=2, **style)
    frame(left, *whole(points))
    right.scatter(points.beam, np.hypot(points.x, points.y), **style)
    silent = np.setdiff1d(np.arange(len(story.scan)), points.beam)
    if silent.size:
        right.plot(silent, np.zeros(silent.size), **CROSS, label="no return")
    right.set(xlabel="beam", ylabel="range [m]", ylim=(-0.2, None))
    right.set_title("dark first, light last", fontsize="small", loc="right")


def tell_noise(story, left, right):
    """Draw step 2."""
    points = story.ordered
    lone = ~np.isin(points.beam, story.points.beam)
    left.plot(points.x, points.y, "k", **DOT, label="return")
    left.plot(points.x[lone], points.y[lone], **CROSS, label="alone, set aside")
    frame(left, *whole(points))
    variance, square, _, least, _ = compiled(noise.stretches)(points)
    right.semilogy(square, variance, "ko", markersize=4, fillstyle="none", label="8 returns")
    at = np.linspace(0, square.max() * 1.05, 50)
    sigma, relative = story.noise[:2]
    fit = sigma**2 + relative**2 * at
    told = f"fit: sigma {1e3 * sigma:.1f} mm, relative {1e3 * relative:.2f} mm/m"
    right.plot(at, fit, color=BLUE, label=told)
    width = math.exp(noise.WIDTH)
    right.fill_between(at, fit / width, fit * width, color=BLUE, alpha=0.15, label="still counts")
    right.set(xlabel="mean squared range [m²]", ylabel="variance about the line [m²]")
    right.set_ylim(max(least, variance.min() / 5), None)


def propose(story, left, right):
    """Draw step 3."""
    points, lines = story.points, story.proposed
    left.plot(points.x, points.y, "k", **DOT, label="return")
    for k, (c, s, d, first, last) in enumerate(lines.T):
        ends = [int(first), int(last) - 1]
        along = points.y[ends] * c - points.x[ends] * s
        x, y = c * d - s * along, s * d + c * along
        name = "line grown from a peak" if k == 0 else "_"
        left.plot(x, y, color=BLUE, linewidth=5, alpha=0.35, solid_capstyle="butt", label=name)
        tag(left, k, x.mean(), y.mean(), c * d, s * d)
    frame(left, *room(story))
    theta, d, votes = first_votes(story)
    shade = right.pcolormesh(np.degrees(theta), d, votes.T, cmap="Greys", rasterized=True)
    shade.set_clim(0, 5)
    bearing = np.arctan2(lines[1], lines[0])
    turned = (bearing - FIRST_ROW) % math.pi + FIRST_ROW
    side = np.cos(bearing - turned)
    right.plot(
        np.degrees(turned), side * lines[2], "o", color=BLUE, fillstyle="none", markersize=11,
        label="proposed line",
    )  # fmt: skip
    for k in range(turned.size):
        right.text(np.degrees(turned[k]) + 6, side[k] * lines[2, k], str(k), fontsize=8)
    far = 1.1 * lines[2].max()
    right.set(xlabel="θ [deg]", ylabel="d [m]", ylim=(-far, far))
    right.set_title("votes of the first round", fontsize="small", loc="right")


def explain_all(story, left, right):
    """Draw step 4."""
    points, label = story.points, story.explained
    known = story.proposed.shape[1]
    colors = pieces(left, right, points, label, known)
    frame(left, *room(story))
    for k in colors:
        mark(left, points, label == k, k)
    right.set(xlabel="number of the return", ylabel="range [m]", ylim=(-0.2, None))
    right.set_title("the sequence of pieces", fontsize="small", loc="right")


def settle(story, left, right):
    """Draw step 5."""
    points, (label, found) = story.points, story.settled
    pieces(left, None, points, label, found.size)
    for k in np.unique(label[label >= 0]):
        mark(left, points, label == k, k)
    frame(left, *room(story))
    k, parts = most_merged(story)
    wall = found[k]
    mine = label == k
    along, off = along_off(points, wall)
    right.plot(along[mine], 1e3 * off[mine], "k", **DOT)
    for rank, part_ in enumerate(parts):
        one = mine & (story.explained == part_)
        c, s, d = fitted(points, one)
        ends = np.array([along[one].min(), along[one].max()])
        x, y = wall.c * wall.d - wall.s * ends, wall.s * wall.d + wall.c * ends
        across = (d - c * x - s * y) / (c * wall.c + s * wall.s)
        name = "pieces of step 4, each fitted" if rank == 0 else "_"
        right.plot(ends, 1e3 * across, color=NEW, linewidth=2, label=name)
    right.axhline(0, linestyle="--", color=BLUE, label=f"line {k}, merged of them")
    right.set(xlabel=f"along line {k} [m]", ylabel="off the line [mm]")


def part(story, left, right):
    """Draw step 6."""
    points, (before, _), (label, found) = story.points, story.settled, story.parted
    changed = np.flatnonzero(before != label)
    pieces(left, None, points, label, found.size)
    x, y = points.x[changed], points.y[changed]
    left.plot(x, y, "o", color=NEW, fillstyle="none", markersize=9, label="changed its wall")
    frame(left, *room(story))
    pair, corner = most_parted(story)
    shown = np.array([corner - 0.16, corner + 0.16])
    box(left, shown)
    near = inside(points, shown)
    for k, color in zip(pair, (BLUE, LIGHT), strict=True):
        mine = near & (label == k)
        right.plot(points.x[mine], points.y[mine], "o", color=color, markersize=5)
        right.axline(*on_line(found[k]), color=color, linewidth=1)
    right.plot(
        points.x[changed], points.y[changed], "o", color=NEW, fillstyle="none", markersize=12,
        markeredgewidth=1.6,
    )  # fmt: skip
    right.axline((0, 0), corner, color=RED, linewidth=1, linestyle=":", label="beam to the corner")
    frame(right, *shown)


def weigh(story, left, right):
    """Draw step 7."""
    before, found, label = story.weighed
    points = story.points
    pieces(left, None, points, label, found.size)
    for k in range(found.size):
        mark(left, points, label == k, k)
    frame(left, *room(story))
    rank = np.argsort(found["evidence"])
    evidence = found["evidence"][rank]
    right.barh(range(found.size), evidence, color=LIGHT)
    right.set(
        xscale="log",
        xlim=(1, evidence.max() * 60),
        xlabel="evidence [nats], and the sigmas of θ and d",
    )
    right.set_yticks(range(found.size), [f"wall {k}" for k in rank])
    for row, k in enumerate(rank):
        turn, shift = math.degrees(math.sqrt(found["var_theta"][k])), math.sqrt(found["var_d"][k])
        text = f"{evidence[row]:.0f}: {turn:.2f}°, {1e3 * shift:.1f} mm"
        right.text(max(evidence[row], 1) * 1.15, row, text, va="center", fontsize=8)
    ratio = found["var_d"] / before["var_d"]
    text = f"covariances times {ratio.max():.2f} at the most, for roughness"
    right.set_title(text, fontsize="small", loc="right")


def cut(story, left, right):
    """Draw step 8."""
    points, label, found = story.points, story.weighed[2], story.weighed[1]
    left.plot(points.x, points.y, "k", **DOT, label="return")
    segments_of(left, story.cut.endpoints, BLUE, "segment")
    frame(left, *room(story))
    k = int(np.bincount(story.cut.line[story.cut.support >= 6]).argmax())
    wall = found.view(walls.WALL)[k]
    along, off = along_off(points, wall)
    right.plot(along[label == k], 1e3 * off[label == k], "k", **DOT)
    ends = np.sort(story.cut.endpoints[story.cut.line == k] @ (-wall.s, wall.c), axis=1)
    ends = ends[np.argsort(ends[:, 0])]
    for low, high in ends:
        right.plot([low, high], [0, 0], color=BLUE, linewidth=5, alpha=0.45)
    for low, high in zip(ends[:-1, 1], ends[1:, 0], strict=True):
        right.annotate("", (low, 0), (high, 0), arrowprops={"arrowstyle": "<->", "color": RED})
        right.text((low + high) / 2, 2, f"{high - low:.2f} m", ha="center", color=RED, fontsize=9)
    right.set(xlabel=f"along line {k} [m]", ylabel="off the line [mm]")


def clean(story, left, right):
    """Draw step 9."""
    kept = story.features.segments.endpoints
    gone = [e for e in story.cut.endpoints if not (kept == e).all(axis=(1, 2)).any()]
    shown = np.array([np.mean(gone[0], axis=0) - 0.4, np.mean(gone[0], axis=0) + 0.4])
    for axes, limits in ((left, room(story)), (right, shown)):
        axes.plot(story.points.x, story.points.y, "k", **DOT, label="return")
        segments_of(axes, kept, BLUE, "segment that stays")
        segments_of(axes, gone, NEW, "segment that goes")
        frame(axes, *limits)
    box(left, shown)


def cross(story, left, right):
    """Draw step 10."""
    features = story.features
    figures.draw_scan(left, features, removed=np.empty((0, 2)), limits=np.array(room(story)))
    left.set_title("")
    corners = features.corners
    real = np.flatnonzero(corners.real)
    apart = np.hypot(*(corners.positions[real, None] - corners.positions[None]).T)
    k = real[np.sort(apart, axis=0)[1].argmax()]  # the one that no other is near
    shown = corners.positions[k] + np.array([[-0.1, -0.1], [0.1, 0.1]])
    figures.draw_scan(right, features, removed=np.empty((0, 2)), limits=shown)
    sigma = 1e3 * np.sqrt(np.linalg.eigvalsh(corners.covariance[k]))
    text = f"sigma {sigma[1]:.1f} and {sigma[0]:.1f} mm, evidence {corners.evidence[k]:.1f} nats"
    right.set_title(text, fontsize="small", loc="right")
    box(left, shown)


STEPS = {
    "The returns in the order of their beams": order,
    "What short stretches show of the noise; returns that stand out alone set aside": tell_noise,
    "Lines proposed: peaks of the votes, grown along the scan": propose,
    "All returns explained at the least cost: walls, round objects, strays": explain_all,
    "Fitted, merged where one line costs less, and explained again with the merged lines": settle,
    "Where two walls meet, the bearing of the corner parts their returns": part,
    "The evidence of each wall, and its covariance": weigh,
    "Each line cut into segments where its returns leave a gap": cut,
    "Segments that are no reliable surface removed": clean,
    "The lines crossed: corners in sight filled, virtual ones hollow": cross,
}


# What the pictures share


def pieces(left, right, points, label, known):
    """Draw the returns in the colour of their piece; return the walls in scan order."""
    r = np.hypot(points.x, points.y)
    number = np.arange(label.size)
    ways = [(left, points.x, points.y)] + ([] if right is None else [(right, number, r)])
    present = list(dict.fromkeys(label[label >= 0].tolist()))
    for axes, x, y in ways:
        for rank, k in enumerate(present):
            mine = label == k
            color = NEW if k >= known else (BLUE, LIGHT)[rank % 2]
            name = ("wall, in turns dark and light", "_")[rank > 0]
            if k >= known:
                name = "wall that was not proposed" if k == max(present) else "_"
            axes.plot(x[mine], y[mine], color=color, label=name, **DOT)
        for kind, style, name in (
            (partition.ARC, {"marker": "o", "color": ROUND, "fillstyle": "none"}, "round"),
            (partition.STRAY, CROSS, "stray"),
        ):
            mine = label == kind
            if mine.any():
                axes.plot(x[mine], y[mine], **({"linestyle": "none", "markersize": 4} | style),
                          label=name)  # fmt: skip
    if right is not None:
        for i in np.flatnonzero(np.diff(label)) + 0.5:
            right.axvline(i, color="0.8", linewidth=0.6, zorder=0)
    return present


def mark(axes, points, mine, number):
    """Write the number of a wall beside it."""
    tag(axes, number, points.x[mine].mean(), points.y[mine].mean(), *fitted(points, mine)[:2])


def tag(axes, number, x, y, nx, ny):
    """Write a number beside a wall, on the side away from the sensor."""
    length = math.hypot(nx, ny)
    axes.text(
        x + 0.13 * nx / length, y + 0.13 * ny / length, str(number), fontsize=8, ha="center",
        va="center", color="0.25",
    )  # fmt: skip


def fitted(points, mine):
    """Return c, s and d of the best line through some returns."""
    x, y, w = points.x[mine], points.y[mine], points.weight[mine]
    terms = w.sum(), w @ x, w @ y, w @ x**2, w @ (x * y), w @ y**2
    return compiled(sums.line_of)(*map(float, terms))[:3]


def first_votes(story):
    """Return theta [rad], d [m] and votes of the first round, before any line is found."""
    cos, sin, step, votes, _ = story.extractor.detector._accumulator  # noqa: SLF001
    votes = np.zeros_like(votes)
    points = story.points
    tolerance = 0.25 * step + 2.0 * math.sqrt(points.variance.mean())
    compiled(voting.vote_pairs)(
        points.x, points.y, np.arange(points.x.size), cos, sin, step,
        story.extractor.detector.pair_distance, tolerance, search.PARTNERS - 1, votes, 0,
        np.empty(cos.size, np.int64),
    )  # fmt: skip
    half = voting.BINS // 2
    votes = np.roll(votes[:, : voting.BINS], half, axis=1)
    theta, d = np.arange(cos.size) * math.pi / cos.size, (np.arange(-half, half) + 0.5) * step
    late = theta >= FIRST_ROW + math.pi  # the same lines are those at theta - pi, -d
    votes[late] = votes[late, ::-1]
    order = np.argsort(theta - math.pi * late)
    return (theta - math.pi * late)[order], d, votes[order]


def along_off(points, wall):
    """Return where returns are along a wall's line, and how far off it [m]."""
    along = points.y * wall.c - points.x * wall.s
    return along, points.x * wall.c + points.y * wall.s - wall.d


def most_merged(story):
    """Return the wall of step 5 that most pieces of step 4 went into, and these."""
    label, found = story.settled
    parts = [
        [j for j in np.unique(story.explained[label == k]) if j >= 0
         and 2 * ((label == k) & (story.explained == j)).sum() > (story.explained == j).sum()]
        for k in range(found.size)
    ]  # fmt: skip
    k = max(range(found.size), key=lambda k: len(parts[k]))
    return k, parts[k]


def most_parted(story):
    """Return the two walls between which most returns changed in step 6, and their corner."""
    before, (after, found) = story.settled[0], story.parted
    changed = np.flatnonzero((before != after) & (before >= 0))
    pairs = np.sort(np.stack([before[changed], after[changed]], axis=1), axis=1)
    kinds, count = np.unique(pairs, axis=0, return_counts=True)
    one, other = kinds[count.argmax()]
    return (one, other), crossing(found[one], found[other])


def room(story):
    """Return the corners of what is shown of the scan: all but single returns."""
    label = story.explained
    mine = label != partition.STRAY
    places = np.stack([story.points.x, story.points.y], axis=1)[mine]
    return places.min(axis=0) - ROOM_MARGIN, places.max(axis=0) + ROOM_MARGIN


def on_line(wall):
    """Return two points on a wall's line."""
    foot = np.array([wall.c, wall.s]) * wall.d
    return foot, foot + np.array([-wall.s, wall.c])


def crossing(one, other):
    """Return where the lines of two walls cross."""
    return np.linalg.solve([[one.c, one.s], [other.c, other.s]], [one.d, other.d])


def segments_of(axes, endpoints, color, label):
    """Draw segments thick."""
    style = {"colors": color, "alpha": 0.45, "linewidths": 6, "label": label, "zorder": 1}
    axes.add_collection(LineCollection(list(endpoints), **style))
    ends = np.reshape(endpoints, (-1, 2))
    axes.plot(*ends.T, "|", color=color, markersize=7)


def inside(points, limits):
    """Tell which returns lie between two corners."""
    (left, low), (right, high) = limits
    return (points.x > left) & (points.x < right) & (points.y > low) & (points.y < high)


def whole(points):
    """Return the corners that hold all returns."""
    places = np.stack([points.x, points.y], axis=1)
    return places.min(axis=0) - 0.5, places.max(axis=0) + 0.5


def frame(axes, low, high):
    """Show a part of the scan, with the sensor."""
    figures.draw_sensor(axes, figures.ORIGIN, label="sensor")
    figures.in_metres(axes, np.asarray(low), np.asarray(high))


def box(axes, limits):
    """Mark what the other side shows."""
    low, high = np.asarray(limits)
    axes.add_patch(Rectangle(low, *(high - low), fill=False, edgecolor=GREY, linewidth=1))


if __name__ == "__main__":
    main()
