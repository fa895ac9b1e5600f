"""The measured figures in docs/extractors.md, written between its marks.

A mark is a comment such as ``<!-- measured: ransac -->``; everything from it to the next
``<!-- /measured -->`` is replaced, by a table of all extractors if the name is ``all``.
"""

import math
import re

import accuracy
import numpy as np
import speed_all
from page import NONE, table

BEAMS = (181, 682)
MARKED = re.compile(r"(<!-- measured: (\w+) -->\n).*?(<!-- /measured -->)", re.DOTALL)

LINE = """Measured: {times} µs at 181 and 682 beams, {ratios} of `direct_hough`'s time; {false} µs
with 20 % false beams. {accuracy}"""
LINES = """Lines, without false beams and with 20 % of them and 15 mm noise: recall {recall},
precision {precision}, median angle error {angle}."""
POINTS = """It finds no lines. """
SIGHT = """Corners in sight: recall {recall}, precision {precision}, median error {error} mm."""


def section(options):
    """Write the figures into the page; return nothing for the report."""
    page = options.docs / "extractors.md"
    if page.exists():
        page.write_text(filled(page.read_text(), options))
    return []


def filled(text, options):
    """Return the page's text with the figures in it.

    Raises
    ------
    KeyError
        If a mark names no extractor.
    """
    figures = {"all": _table(options)} | {
        name: _sentence(name, options) for name in speed_all.all_extractors()
    }
    return MARKED.sub(lambda mark: f"{mark[1]}{figures[mark[2]]}\n{mark[3]}", text)


def _both(name, options):
    """Return an extractor's scores, of all and of what is in sight, without outliers and with."""
    scores = accuracy.measured(options)
    return scores[accuracy.CLEAN][name], scores[accuracy.ISOLATED][name]


def _times(name, options, false):
    seconds = speed_all.measured(options)
    return [seconds[beams, false][name] for beams in BEAMS]


def _table(options):
    rows = []
    for name in speed_all.all_extractors():
        both = _both(name, options)
        lines = [
            f"{s.line_recall:.3f} / {s.line_precision:.3f}" if s.lines_extracted else NONE
            for s, _ in both
        ]
        sight = [f"{_recall(s):.3f} / {_precision(s):.3f}" for _, s in both]
        times = [f"{1e6 * time:.0f}" for time, _ in _times(name, options, 0.0)]
        rows.append([name, *times, *lines, *sight])
    header = [
        "", "181 beams [µs]", "682 beams [µs]", "lines: recall / precision",
        "with 20 % false beams", "corners in sight: recall / precision", "with 20 % false beams",
    ]  # fmt: skip
    return table(header, rows)


def _sentence(name, options):
    clean = _times(name, options, 0.0)
    text = LINE.format(
        times=_and(f"{1e6 * time:.0f}" for time, _ in clean),
        ratios=_and(f"{ratio:.2f}" for _, ratio in clean),
        false=_and(f"{1e6 * time:.0f}" for time, _ in _times(name, options, 0.2)),
        accuracy=_accuracy(_both(name, options)),
    )
    return text.replace("\n", " ")


def _accuracy(both):
    lines = POINTS
    every, seen = zip(*both, strict=True)
    if every[0].lines_extracted:
        turns = [math.degrees(np.median(abs(score.angle_errors))) for score in every]
        lines = LINES.format(
            recall=_and(f"{score.line_recall:.3f}" for score in every),
            precision=_and(f"{score.line_precision:.3f}" for score in every),
            angle=_and(f"{turn:.2f}°" for turn in turns),
        ) + " "  # fmt: skip
    return lines + SIGHT.format(
        recall=_and(f"{_recall(score):.3f}" for score in seen),
        precision=_and(f"{_precision(score):.3f}" for score in seen),
        error=_and(f"{1e3 * score.median_error:.1f}" for score in seen),
    )


def _recall(score):
    return score.tp_percent / 100


def _precision(score):
    return 1 - score.fp_percent / 100


def _and(texts):
    return " and ".join(texts)
