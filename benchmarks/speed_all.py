"""The report's section on the speed of all extractors, beside each other and beside the peers."""

import math
from functools import cache
from itertools import chain

import contest
import numpy as np
import peers
from page import new_figure, table, verdict

import laserfeatures as lf
from laserfeatures.simulation import Scanner

NOISES = 25  # scans from each pose of the known room
FALSE = (0.0, 0.2)  # share of beams that show nothing true
BEAM_COUNTS = (90, 181, 361, 721, 1081, 2000, 4000)
BARE = "cv2.HoughLines, the image and arguments of raster_hough"
MARKERS = "osD^vP*X"

# Name, of whose time, at most this share of it, with which shares of false beams.
TARGETS = [
    ("region_growing", "direct_hough", 0.5, FALSE[:1]),
    ("split_and_merge", "direct_hough", 0.5, FALSE[:1]),
    ("ransac", "direct_hough", 10.0, FALSE),
    ("raster_hough", BARE, 1.3, FALSE[:1]),
]
TARGET_BEAMS = (181, 682)

METHOD = f"""Every extractor with its defaults, whole calls from ranges to corners as above, and
these peers, called as a user would (`benchmarks/peers.py`): OpenCV's transform of the points as
above; `cv2.HoughLines` on the very image that `raster_hough` draws (2 cm a pixel, 1°), once with
its arguments (all lines of six pixels and more) and once, as `cv2.HoughLinesP` and scikit-image's
`hough_line` with `hough_line_peaks`, for walls of half a metre; and `skimage.measure.ransac` with
`LineModelND`, one wall after the other, as many as there are, inliers within
{1e3 * peers.INLIER:.0f} mm (three standard deviations), {peers.TRIALS} trials. Drawing the image is
not timed, nor is making points. What each finds is checked by `benchmarks/test_speed.py`.

The known room, {4 * NOISES} scans in turns, all contenders in turns of 10 calls in one process;
medians of {{repeats}} calls of each, of scikit-image's {{few}}. In brackets: divided by
direct_hough's in the same run. With 20 % of the beams replaced by false ones (no two
neighbours, from 0.3 m to the sensor's range):"""

GROWTH = """Over beams: the known room, 270°, 10 m, no false beams; medians of {repeats} calls."""


def all_extractors():
    """Return every extractor with its defaults, and the paper's preset, by name."""
    found = {name: lf.get_extractor(name) for name in lf.list_extractors()}
    return found | {"preset paper": lf.get_extractor("direct_hough", preset="paper")}


def section(options):
    """Return the section's paragraphs."""
    seconds = measured(options)
    return [
        "## All extractors: speed",
        METHOD.format(repeats=_repeats(options), few=_few(options)),
        *(_table(seconds, false) for false in FALSE),
        "Targets, at 181 and 682 beams:",
        _targets(seconds),
        *_growth(options),
    ]


@cache
def measured(options):
    """Return the medians of all contenders, by (beams, share of false beams) and name.

    Each is its seconds and the ratio to direct_hough in the same run: what takes milliseconds is in
    a run of its own.
    """
    return {
        (beams, false): {
            name: (time, time / medians["direct_hough"])
            for medians in (_slow(options, cases), _fast(options, cases))
            for name, time in medians.items()
        }
        for beams, scanner in contest.SENSORS.items()
        for false in FALSE
        for cases in [contest.room_cases(scanner, noises=NOISES, outliers=false)]
    }


def turns(makers, repeats):
    """Return the median seconds of makers, by name, taken in turns; all are warmed up before."""
    contest.interleaved(makers.values(), min(repeats, 4))
    seconds = contest.interleaved(makers.values(), repeats)
    return dict(zip(makers, np.median(seconds, axis=1), strict=True))


def makers_of(cases, extractors, rivals):
    """Return what `turns` takes: extractors, and functions of `peers`, by name."""
    return {name: contest.whole_call(each, cases) for name, each in extractors.items()} | {
        name: contest.in_turn([peer(case)[0] for case in cases]) for name, peer in rivals.items()
    }


def _repeats(options):
    return options.repeats(200)


def _few(options):
    return options.repeats(10)


def _slow(options, cases):
    """Time what takes milliseconds; direct_hough besides, for the ratios."""
    ours = {"direct_hough": lf.get_extractor("direct_hough")}
    return turns(makers_of(cases, ours, peers.SLOW), _few(options))


def _fast(options, cases):
    return turns(makers_of(cases, all_extractors(), peers.FAST), _repeats(options))


def _table(seconds, false):
    names = list(all_extractors()) + list(chain(peers.FAST, peers.SLOW))
    rows = [
        [name, *(_cell(*seconds[beams, false][name]) for beams in contest.SENSORS)]
        for name in names
    ]
    what = f"µs, {100 * false:.0f} % false beams" if false else "µs, no false beams"
    return table([what, *(f"{beams} beams" for beams in contest.SENSORS)], rows)


def _cell(time, ratio):
    return f"{1e6 * time:.0f} ({ratio:.2g})" if ratio < 10 else f"{1e6 * time:.0f} ({ratio:.0f})"


def _targets(seconds):
    rows = []
    for name, other, limit, shares in TARGETS:
        for false in shares:
            ratios = [
                seconds[beams, false][name][0] / seconds[beams, false][other][0]
                for beams in TARGET_BEAMS
            ]
            what = f", {100 * false:.0f} % false beams" if false else ""
            rows.append([
                f"{name} at most {limit:g} of {other}{what}",
                *(f"{ratio:.2f}" for ratio in ratios), verdict(max(ratios) <= limit),
            ])  # fmt: skip
    return table(["target", *(f"{beams} beams" for beams in TARGET_BEAMS), ""], rows)


def _growth(options):
    repeats = options.repeats(100)
    times = {}
    for beams in BEAM_COUNTS:
        scanner = Scanner(beams=beams, field_of_view=math.radians(270))
        cases = contest.room_cases(scanner, noises=NOISES)
        for name, time in turns(makers_of(cases, all_extractors(), {}), repeats).items():
            times.setdefault(name, []).append(1e6 * time)
    rows = [
        [name, *(f"{time:.0f}" for time in own), f"{_exponent(own):.2f}"]
        for name, own in times.items()
    ]
    return [
        GROWTH.format(repeats=repeats),
        table(["µs at beams", *BEAM_COUNTS, "grows to the power"], rows),
        _plot(options, times),
    ]


def _exponent(times):
    return np.polyfit(np.log(BEAM_COUNTS), np.log(times), 1)[0]


def _plot(options, times):
    figure = new_figure(6.5, 4.2)
    axes = figure.add_subplot()
    for marker, (name, own) in zip(MARKERS, times.items(), strict=False):
        axes.loglog(BEAM_COUNTS, own, f"{marker}-", label=name)
    axes.set_xticks(BEAM_COUNTS, BEAM_COUNTS)
    axes.minorticks_off()
    axes.set(xlabel="beams (270°)", ylabel="median time [µs], whole call")
    axes.grid(visible=True, alpha=0.3)
    figure.legend(loc="outside right upper", fontsize="small")
    return options.save(figure, "speed_all.png", "Median time of all extractors over beams")
