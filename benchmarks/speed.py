"""The report's section on speed: direct_hough beside OpenCV, and how both grow."""

import math

import contest
import numpy as np
import truth as truths
from page import new_figure, percent, table, verdict
from rooms import random_room
from test_speed import TARGET

import laserfeatures as lf
from laserfeatures.simulation import Scanner

NOISES = 50  # scans from each pose of the known room: a repeated scan would train the processor
BEAM_COUNTS = (90, 181, 361, 721, 1081, 2000, 4000, 10000)
THETA_DEGREES = (4.0, 2.0, 1.0, 0.5, 0.25, 0.1)
ROOMS = 20
SEEDS = range(5000, 5000 + ROOMS)

METHOD = """Simulated scans with 5 mm noise, 1°, 2 cm. Ours is the whole call `extractor(scan)`,
from ranges to corners, on a scan made just before, of which nothing has been computed; scans
share their array of angles, as the readers give it. The peer is `cv2.HoughLinesPointSet` alone
(lines_max 8, threshold 4), on points that are Cartesian and float32 already. No scan is timed
twice in a row: {scans} different scans take turns, since a processor learns the branches of a
scan that it sees again and again ({repetition}). Both are timed in one process in turns of 10
calls, {repeats} calls of each; medians. The peer's accumulator reaches to the sensor's range (10,
10, 5.6, 30 m), or, as a user could not know before, to the farthest point of this very scan; the
target is held against the first.

A scan is all right where every wall of at least four beams is found once, within 0.3° and 1 cm
(or four standard deviations of what its points' noise leaves, if that is more), no line is found
besides, and every corner in sight within 5 cm."""

EMPTY = """Of ours, {time:.0f} µs are spent on a scan of 181 beams without a single return: the
calls, the objects, and the arrays of the results. That weighs most where there are few beams."""

ROOMS_METHOD = f"""{ROOMS} random rooms (seeds {SEEDS[0]} to {SEEDS[-1]}), ten scans each, timed
likewise: ratio of medians in each room."""


def section(options):
    """Return the section's paragraphs."""
    extractor = lf.get_extractor("direct_hough")
    repeats = options.repeats(1000)
    known, met = _known_room(extractor, repeats)
    return [
        "## Speed",
        METHOD.format(
            scans=4 * NOISES, repeats=repeats, repetition=_repetition(extractor, repeats)
        ),
        f"Target: at most {TARGET} of the peer's time: {met}.",
        known,
        EMPTY.format(time=_empty(extractor, repeats)),
        ROOMS_METHOD,
        _random_rooms(extractor, options.repeats(200)),
        *_growth(extractor, options),
    ]


def _repetition(extractor, repeats):
    """Say what a few scans, repeated, would take: a figure to distrust."""
    times = []
    for noises in (1, NOISES):
        cases = contest.room_cases(contest.SENSORS[181], noises=noises)
        for case in cases:
            extractor(case.scan)
        makers = contest.contenders(extractor, cases, [contest.sensor_range])
        times.append(1e6 * np.median(contest.interleaved(makers, repeats, block=repeats), axis=1))
    few, many = times
    return (
        f"181 beams, each contender's calls in one block: ours {few[0]:.0f} µs with 4 scans, "
        f"{many[0]:.0f} µs with {4 * NOISES}; the peer {few[1]:.0f} and {many[1]:.0f} µs"
    )


def _empty(extractor, repeats):
    """Return the time of a scan without a return [µs]."""
    scanner = contest.SENSORS[181]
    angles = scanner.angles
    angles.flags.writeable = False
    ranges = np.full(scanner.beams, np.inf)
    ranges.flags.writeable = False
    scan = lf.LaserScan(angles=angles, ranges=ranges, range_max=scanner.range_max)
    case = contest.Case(scan, None, None)
    makers = contest.contenders(extractor, [case], [])
    return 1e6 * float(np.median(contest.interleaved(makers, repeats)))


def _known_room(extractor, repeats):
    rows, ratios = [], []
    for beams, scanner in contest.SENSORS.items():
        cases = contest.room_cases(scanner, noises=NOISES)
        right = np.mean([not contest.faults(extractor(case.scan), case) for case in cases])
        reaches = [contest.sensor_range, contest.farthest]
        makers = contest.contenders(extractor, cases, reaches)
        seconds = contest.interleaved(makers, repeats)
        mine, peer, tight = np.median(seconds, axis=1)
        cold = np.median(contest.interleaved(makers[:2], repeats // 2, block=1), axis=1)
        low, high = np.percentile(seconds[0], (10, 90))
        ratios.append(mine / peer)
        rows.append([
            beams, percent(right), f"{_peer_walls(cases)}", f"{1e6 * mine:.0f}",
            f"{1e6 * low:.0f}..{1e6 * high:.0f}", f"{1e6 * peer:.0f}", f"**{mine / peer:.2f}**",
            f"{mine / tight:.2f}", f"{cold[0] / cold[1]:.2f}",
        ])  # fmt: skip
    header = [
        "beams", "scans all right", "walls found by the peer, repeats of one", "ours [µs]",
        "10..90 %", "peer [µs]", "ratio", "ratio, peer's reach the farthest point",
        "ratio, in turns call by call",
    ]  # fmt: skip
    met = f"{verdict(max(ratios) <= TARGET)} ({', '.join(f'{r:.2f}' for r in ratios)})"
    return table(header, rows), met


def _peer_walls(cases):
    walls = sum(case.truth.theta.size for case in cases)
    calls = [contest.peer_call(case.scan, case.scan.range_max) for case in cases]
    counts = [
        contest.walls_met(*contest.peer_lines(call()), case.truth)
        for call, case in zip(calls, cases, strict=True)
    ]
    found, again = np.sum(counts, axis=0)
    return f"{percent(found / walls)}, {percent(again / (contest.LINES_MAX * len(cases)))}"


def _random_rooms(extractor, repeats):
    rows = []
    for beams, scanner in contest.SENSORS.items():
        ratios, mine = [], []
        for seed in SEEDS:
            cases = _room(seed, scanner)
            makers = contest.contenders(extractor, cases, [contest.sensor_range])
            ours, peer = np.median(contest.interleaved(makers, repeats), axis=1)
            ratios.append(ours / peer)
            mine.append(1e6 * ours)
        rows.append([
            beams, f"{np.median(mine):.0f}", f"{min(mine):.0f}..{max(mine):.0f}",
            f"**{np.median(ratios):.2f}**", f"{min(ratios):.2f}..{max(ratios):.2f}",
            f"{sum(r <= TARGET for r in ratios)} of {ROOMS}",
        ])  # fmt: skip
    header = ["beams", "ours [µs], median", "all rooms", "ratio, median", "all rooms", "target met"]
    return table(header, rows)


def _room(seed, scanner):
    world, pose = random_room(seed)
    angles = scanner.angles
    angles.flags.writeable = False
    cases = []
    for noise in range(10):
        scan, truth = truths.sense(world, scanner, pose, np.random.default_rng((seed, noise)))
        scan = lf.LaserScan(angles=angles, ranges=scan.ranges, range_max=scan.range_max)
        cases.append(contest.Case(scan, truth, np.empty((0, 2))))
    return cases


def _growth(extractor, options):
    repeats = options.repeats(300)
    by_beams = []
    for beams in BEAM_COUNTS:
        scanner = Scanner(beams=beams, field_of_view=math.radians(270))
        by_beams.append(_pair(extractor, scanner, repeats, contest.THETA_STEP))
    by_theta = []
    for degrees in THETA_DEGREES:
        step = math.radians(degrees)
        fine = lf.get_extractor("direct_hough", theta_step=step)
        by_theta.append(_pair(fine, contest.SENSORS[361], repeats, step))
    rows = [[n, *_cells(pair)] for n, pair in zip(BEAM_COUNTS, by_beams, strict=True)]
    steps = [[f"{n}°", *_cells(pair)] for n, pair in zip(THETA_DEGREES, by_theta, strict=True)]
    inverse = [1 / n for n in THETA_DEGREES]
    return [
        f"### Growth\n\nThe known room, 270°, 10 m; medians of {repeats} calls of each.",
        table(["beams", "ours [µs]", "peer [µs]", "ratio"], rows),
        _exponents("beams", BEAM_COUNTS, by_beams),
        _plot(options, "speed_beams.png", BEAM_COUNTS, by_beams, "beams (1°, 2 cm)"),
        f"361 beams, 180°; medians of {repeats} calls of each.",
        table(["Δθ", "ours [µs]", "peer [µs]", "ratio"], steps),
        _exponents("1/Δθ", inverse, by_theta),
        _plot(options, "speed_theta.png", inverse, by_theta, "1/Δθ [1/deg] (361 beams, 2 cm)"),
    ]


def _pair(extractor, scanner, repeats, step):
    cases = contest.room_cases(scanner, noises=20)
    for case in cases[:4]:
        extractor(case.scan)
    makers = contest.contenders(extractor, cases, [contest.sensor_range], step)
    return np.median(contest.interleaved(makers, repeats), axis=1) * 1e6


def _cells(pair):
    return [f"{pair[0]:.0f}", f"{pair[1]:.0f}", f"{pair[0] / pair[1]:.2f}"]


def _exponents(name, x, pairs):
    ours, peer = (np.polyfit(np.log(x), np.log(times), 1)[0] for times in np.transpose(pairs))
    return (
        f"Over the whole table time grows as {name} to the power {ours:.2f} (ours) and {peer:.2f} "
        "(peer)."
    )


def _plot(options, name, x, pairs, label):
    figure = new_figure(5.5, 3.8)
    axes = figure.add_subplot()
    ours, peer = np.transpose(pairs)
    axes.loglog(x, ours, "o-", label="direct_hough, whole call")
    axes.loglog(x, peer, "s--", label="cv2.HoughLinesPointSet alone")
    axes.set(xlabel=label, ylabel="median time [µs]")
    axes.grid(visible=True, which="both", alpha=0.3)
    axes.legend()
    return options.save(figure, name, f"Median time over {label}, log-log")
