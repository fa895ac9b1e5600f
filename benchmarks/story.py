"""Draw docs/story_*.png: one scan after each step of `direct_hough`, for docs/direct-hough.md.

Run ``python benchmarks/story.py``; ``--docs`` says where the pictures go. The scan is of a simulated
office room with a column and some false beams, all from one seed. Each step calls the kernels that
the extractor calls, and what comes out at the end is checked to be what the extractor returns.
"""

import argparse
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

import laserfeatures as lf
from laserfeatures import figures
from laserfeatures.compiled import kernel
from laserfeatures.engine import explain, noise, partition, segments, sequence, sums, walls
from laserfeatures.engine.prices import PRICE, RETURN_PRICE
from laserfeatures.simulation import Scanner, World

ROOT = Path(__file__).parents[1]
SEED = 410
SCANNER = Scanner(
    beams=541, field_of_view=math.radians(270), range_max=10.0, range_sigma=0.012, outliers=0.012
)
COLUMN = 0.12  # [m], radius
ROOM = np.array([[-1.75, -2.05], [2.15, 3.35]])  # [m], shown of the scan
RIGHT_WALL = np.array([[0.84, -1.75], [1.16, 1.6]])  # [m], in step 5
LEAF = np.array([[-0.9, 0.45], [-0.3, 1.05]])  # [m], in step 9

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
            return World(boxes=world.boxes, poles=[*world.poles, [*place, COLUMN]]), pose


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
    told = compiled(noise.estimate_noise)(ordered)
    compiled(sequence.weigh)(ordered, sequence.Noise(told[0], told[1], 0.0))
    table = compiled(sequence.without_lone)(np.array(ordered))
    np.testing.assert_array_equal(table, detector.prepared(scan))
    points = sequence.Sequence(*table)
    # 3
    proposed = detector.propose(table)
    # 4
    total = compiled(sums.running_sums)(points)
    explained = np.empty(points.x.size, np.int64)
    lines = partition.Candidates(*proposed)
    compiled(partition.partition)(points, total, lines, PRICE, limits, explained)
    # 5
    first = compiled(explain.settle)(points, total, proposed, PRICE, limits)
    again = compiled(explain.as_proposed)(first[1], limits.min_points, 0)
    label, found = compiled(explain.settle)(points, total, again, RETURN_PRICE, limits)
    found = found.view(walls.WALL)  # numba forgets that fields are attributes
    settled = label.copy(), found.copy()
    # 6
    for _ in range(explain.PARTINGS):
        compiled(walls.part_at_corners)(points, label, found)
        compiled(walls.fit_walls)(points, label, found, True)
    parted = label.copy(), found.copy()
    # 7
    found = found[: compiled(walls.prune)(label, found, limits.min_points)]
    compiled(walls.weigh_evidence)(points, label, found)
    before = found.copy()
    compiled(walls.inflate_covariances)(points, found)
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
    for number, draw in enumerate(STEPS, start=1):
        figure = new_figure(9.0, 6.0)
        figure.suptitle(f"{number}. {draw.__doc__}", fontsize="medium", x=0.01, ha="left")
        left, right = figure.subplots(1, 2, width_ratios=[4.3, 4.7])
        draw(story, left, right)
        figures.draw_legend(figure, columns=4)
        path = arguments.docs / f"story_{number:02d}.png"
        figure.savefig(path, dpi=100, pil_kwargs={"optimize": True})
        print(f"wrote {path}, {path.stat().st_size / 1e3:.0f} kB")


# The pictures: on the left the scan, on the right what the step looks at


def order(story, left, right):
    """The returns in the order of their beams."""
    points = story.ordered
    number = np.arange(points.x.size)
    style = {"c": number, "cmap": "viridis", "s": 6}
    left.plot(points.x, points.y, color="0.85", linewidth=0.6, zorder=1)
    shade = left.scatter(points.x, points.y, zorder=2, **style)
    left.figure.colorbar(shade, ax=left, label="number of the return", location="bottom", aspect=40)
    frame(left, *whole(points))
    right.scatter(points.beam, np.hypot(points.x, points.y), **style)
    silent = np.setdiff1d(np.arange(len(story.scan)), points.beam)
    right.plot(silent, np.zeros(silent.size), **CROSS, label="no return", clip_on=False)
    right.set(xlabel="beam", ylabel="range [m]", ylim=(0, None))


def tell_noise(story, left, right):
    """What short stretches show of the noise; returns that stand out alone are set aside."""
    points = story.ordered
    lone = ~np.isin(points.beam, story.points.beam)
    left.plot(points.x, points.y, "k", **DOT, label="return")
    left.plot(points.x[lone], points.y[lone], **CROSS, label="alone, set aside")
    frame(left, *whole(points))
    variance, square, least, _ = compiled(noise.stretches)(points)
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
    """Lines proposed: peaks of the votes, grown along the scan."""
    points, lines = story.points, story.proposed
    left.plot(points.x, points.y, "k", **DOT, label="return")
    for k, (c, s, d, first, last) in enumerate(lines.T):
        ends = [int(first), int(last) - 1]
        along = points.y[ends] * c - points.x[ends] * s
        x, y = c * d - s * along, s * d + c * along
        name = "line grown from a peak" if k == 0 else "_"
        left.plot(x, y, color=BLUE, linewidth=5, alpha=0.35, solid_capstyle="butt", label=name)
        tag(left, k, x.mean(), y.mean(), c * d, s * d)
    frame(left, *ROOM)
    theta, d, votes = first_votes(story)
    shade = right.pcolormesh(np.degrees(theta), d, np.sqrt(votes.T), cmap="Greys", rasterized=True)
    shade.set_clim(0, math.sqrt(votes.max()))
    turned = np.arctan2(lines[1], lines[0]) % math.pi
    side = np.where(np.arctan2(lines[1], lines[0]) < 0, -1, 1)
    right.plot(
        np.degrees(turned), side * lines[2], "o", color=BLUE, fillstyle="none", markersize=11,
        label="proposed line",
    )  # fmt: skip
    right.set(xlabel="θ [deg]", ylabel="d [m]", xlim=(0, 180), ylim=(-2.2, 3.4))
    right.set_title("first round of votes", fontsize="small", loc="right")


def explain_all(story, left, right):
    """All returns explained at the least cost: walls, round objects, strays."""
    points, label = story.points, story.explained
    known = story.proposed.shape[1]
    colors = pieces(left, right, points, label, known)
    frame(left, *ROOM)
    for k in colors:
        mine = label == k
        name = "no line was proposed" if k >= known else ""
        mark(left, points, mine, k, name)
    right.set(xlabel="number of the return", ylabel="range [m]", ylim=(0, None))
    right.set_title("the sequence of pieces", fontsize="small", loc="right")


def settle(story, left, right):
    """Fitted, merged where one line costs less, and explained again with the merged lines."""
    points, (label, found) = story.points, story.settled
    pieces(left, None, points, label, found.size)
    for k in np.unique(label[label >= 0]):
        mark(left, points, label == k, k, "")
    frame(left, *ROOM)
    box(left, RIGHT_WALL)
    x, y = points.x, points.y
    near = inside(points, RIGHT_WALL)
    right.plot(x[near], y[near], "k", **DOT, label="return")
    first = True
    for k in np.unique(story.explained[near]):
        mine = near & (story.explained == k)
        if k < 0 or mine.sum() < 20:
            continue
        c, s, d = fitted(points, story.explained == k)
        ends = np.array([y[mine].min(), y[mine].max()])
        right.plot(
            (d - s * ends) / c, ends, color=NEW, linewidth=2,
            label="pieces of step 4, each fitted" if first else "_",
        )  # fmt: skip
        first = False
    k = np.bincount(label[near & (label >= 0)]).argmax()
    ends = RIGHT_WALL[:, 1]
    wall = found[k]
    right.plot((wall.d - wall.s * ends) / wall.c, ends, "--", color=BLUE, label="merged")
    right.set(xlim=RIGHT_WALL[:, 0], ylim=RIGHT_WALL[:, 1], xlabel="x [m], stretched")
    right.set_ylabel("y [m]")


def part(story, left, right):
    """Where two walls meet, the bearing of the corner parts their returns."""
    points, (before, _), (label, found) = story.points, story.settled, story.parted
    changed = np.flatnonzero(before != label)
    pieces(left, None, points, label, found.size)
    x, y = points.x[changed], points.y[changed]
    left.plot(x, y, "o", color=NEW, fillstyle="none", markersize=9, label="changed its wall")
    frame(left, *ROOM)
    i = changed[0]
    one, other = found[label[i]], found[before[i] if before[i] >= 0 else label[i + 1]]
    corner = crossing(one, other)
    shown = np.array([corner - 0.16, corner + 0.16])
    box(left, shown)
    near = inside(points, shown)
    for k, color in ((label[i], BLUE), (before[i], LIGHT)):
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
    """The evidence of each wall, and its covariance."""
    before, found, label = story.weighed
    points = story.points
    pieces(left, None, points, label, found.size)
    for k in range(found.size):
        mark(left, points, label == k, k, "")
    frame(left, *ROOM)
    rank = np.argsort(found["evidence"])
    evidence = found["evidence"][rank]
    right.barh(range(found.size), evidence, color=LIGHT)
    right.set(xscale="log", xlim=(1, evidence.max() * 60), xlabel="evidence [nats]")
    right.set_yticks(range(found.size), [f"wall {k}" for k in rank])
    for row, k in enumerate(rank):
        turn, shift = math.degrees(math.sqrt(found["var_theta"][k])), math.sqrt(found["var_d"][k])
        text = f"{evidence[row]:.0f}: σθ {turn:.2f}°, σd {1e3 * shift:.1f} mm"
        right.text(max(evidence[row], 1) * 1.15, row, text, va="center", fontsize=8)
    ratio = found["var_d"] / before["var_d"]
    text = f"covariances inflated by up to {100 * (ratio.max() - 1):.0f} %"
    right.set_title(text, fontsize="small", loc="right")


def cut(story, left, right):
    """Each line cut into segments where its returns leave a gap."""
    points, label, found = story.points, story.weighed[2], story.weighed[1]
    left.plot(points.x, points.y, "k", **DOT, label="return")
    segments_of(left, story.cut.endpoints, BLUE, "segment")
    frame(left, *ROOM)
    k = int(np.bincount(story.cut.line).argmax())
    c, s = found["c"][k], found["s"][k]
    mine = label == k
    along, off = points.y * c - points.x * s, points.x * c + points.y * s - found["d"][k]
    right.plot(along[mine], 1e3 * off[mine], "k", **DOT)
    ends = np.sort(story.cut.endpoints[story.cut.line == k] @ (-s, c), axis=1)
    ends = ends[np.argsort(ends[:, 0])]
    for low, high in ends:
        right.plot([low, high], [0, 0], color=BLUE, linewidth=5, alpha=0.45)
    for low, high in zip(ends[:-1, 1], ends[1:, 0], strict=True):
        right.annotate("", (low, 0), (high, 0), arrowprops={"arrowstyle": "<->", "color": RED})
        right.text((low + high) / 2, 2, f"{high - low:.2f} m", ha="center", color=RED, fontsize=9)
    right.set(xlabel=f"along line {k} [m]", ylabel="off the line [mm]")


def clean(story, left, right):
    """What is no reliable surface is removed."""
    kept = story.features.segments.endpoints
    gone = [e for e in story.cut.endpoints if not (kept == e).all(axis=(1, 2)).any()]
    shown = np.array([np.mean(gone[0], axis=0) - 0.5, np.mean(gone[0], axis=0) + 0.5])
    for axes, limits in ((left, ROOM), (right, shown)):
        axes.plot(story.points.x, story.points.y, "k", **DOT, label="return")
        segments_of(axes, kept, BLUE, "segment that stays")
        segments_of(axes, gone, NEW, "segment that goes")
        frame(axes, *limits)
    box(left, shown)


def cross(story, left, right):
    """The lines crossed: corners in sight filled, virtual ones hollow."""
    features = story.features
    figures.draw_scan(left, features, removed=np.empty((0, 2)), limits=ROOM)
    left.set_title("")
    corners = features.corners
    real = np.flatnonzero(corners.real)
    k = real[corners.evidence[real].argmax()]
    shown = corners.positions[k] + np.array([[-0.1, -0.1], [0.1, 0.1]])
    figures.draw_scan(right, features, removed=np.empty((0, 2)), limits=shown)
    sigma = 1e3 * np.sqrt(np.linalg.eigvalsh(corners.covariance[k]))
    text = f"σ {sigma[1]:.1f} and {sigma[0]:.1f} mm, evidence {corners.evidence[k]:.1f} nats"
    right.set_title(text, fontsize="small", loc="right")
    box(left, shown)


STEPS = (order, tell_noise, propose, explain_all, settle, part, weigh, cut, clean, cross)


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


def mark(axes, points, mine, number, note):
    """Write the number of a wall beside it."""
    del note
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
    return np.arange(cos.size) * math.pi / cos.size, (np.arange(-half, half) + 0.5) * step, votes


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
