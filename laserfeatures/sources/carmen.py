"""CARMEN logs (`.log`, `.clf`): the records FLASER and ROBOTLASER1 of the front laser.

::

    FLASER n r1..rn x y theta odom_x odom_y odom_theta [t host logger_t]
    ROBOTLASER1 type start fov res maxrange accuracy remission_mode n r1..rn m e1..em
                x y theta robot_x robot_y robot_theta (5 numbers) t host logger_t
    RAWLASER1   type start fov res maxrange accuracy remission_mode n r1..rn m e1..em
                t host logger_t

Metres and radians. The pose is the first of the two, the laser's. It is "corrected" in a log with
records that only a SLAM program writes (NEFF, VERTEX2, EDGE2) or where it leaves the second one,
the robot's, else "odometry"; `carmen_poses` tells how raw odometry is got from a corrected log.
FLASER says nothing of directions: 180 and 181 beams are 1 degree apart, 360 and 361 half a degree,
from -90 degrees on; other counts are spread over 180 degrees, or over `field_of_view`. A stamp
written with too few digits to tell seconds apart (1.01893e+09), or 0 throughout, is nan.

Where a log has none of the front laser's records with poses, the first of ROBOTLASER2, RLASER (as
FLASER) and RAWLASER1 to RAWLASER4 (no poses) that it has is read. Other records are passed over and
counted; a line whose first word is nearly that of a scan is broken.
"""

import difflib
import io
import math
import re
from contextlib import suppress
from itertools import islice

from laserfeatures.arrays import FloatArray
from laserfeatures.data import Pose2D
from laserfeatures.sources.beams import even_angles, numbers, spread_angles
from laserfeatures.sources.carmen_poses import CarmenPoses
from laserfeatures.sources.files import DAMAGE, LONGEST_LINE, MARK, open_stream
from laserfeatures.sources.log import Log, Scans
from laserfeatures.sources.readings import Reading, finish

KINDS = (  # what may be read, the best first
    (b"FLASER", b"ROBOTLASER1"),
    (b"ROBOTLASER2",),
    (b"RLASER",),
    *((b"RAWLASER%d" % number,) for number in range(1, 5)),
)
LOOK_AHEAD = 1000  # lines, in which a kind of record shows
SLAM = (b"NEFF", b"VERTEX2", b"EDGE2")
OTHER = re.compile(rb"#.*|[A-Za-z][\w-]*")
OTHER_LASERS = re.compile(rb"R?LASER\d?|(RAW|ROBOT)LASER\d")
SICK = (180, 181, 361)  # beams of the SICK LMS, whose field of view is known
FEWEST = 30  # beams of a rangefinder
STEPS = {180: 1.0, 181: 1.0, 360: 0.5, 361: 0.5}  # [degrees], of the SICK LMS


def is_carmen(head: bytes) -> bool:
    """Return whether a file that starts with `head` is a CARMEN log."""
    words = {line.split(None, 1)[0] for line in head.splitlines() if line.strip()}
    scans = {name for kind in KINDS for name in kind}
    return bool(words & {*scans, *SLAM, b"PARAM", b"ODOM", b"SYNC"})


def read_carmen(log: Log) -> Scans:
    """Yield the scans of a CARMEN log."""
    scans = _kind(log)
    raw = scans[0].startswith(b"RAW")
    log.poses = "none" if raw else "odometry"
    poses = CarmenPoses(log)
    seen: set[bytes] = set()

    def parse(line: bytes) -> Reading | None:
        word = b"".join(line[:64].split(None, 1)[:1])
        if word in scans:
            return _reading(log, word.decode(), line.split())
        if word == b"PARAM":
            poses.param(line)
        elif word and word not in seen:
            check_word(word, scans)
            seen.add(word)
            if word in SLAM and not raw:
                poses.corrected()
        if word and not word.startswith(b"#"):
            log.passed_over[word.decode("ascii", "backslashreplace")] += 1
        return None

    readings = log.records(parse)
    yield from finish(log, readings if raw else poses.chosen(readings))


def _kind(log: Log) -> tuple[bytes, ...]:
    """Return the names of the records to read: the best of those near the log's beginning."""
    words = set()
    with open_stream(log.path) as stream, suppress(*DAMAGE):
        start = io.BytesIO(stream.read(LONGEST_LINE))
        for line in islice(start, LOOK_AHEAD):
            words.add(b"".join(line.removeprefix(MARK)[:64].split(None, 1)[:1]))
    return next((kind for kind in KINDS if words & {*kind}), KINDS[0])


def _reading(log: Log, name: str, tokens: list[bytes]) -> Reading:
    if name in {"FLASER", "RLASER"}:
        return _flaser(log, name, tokens)
    return _stated(log, name, tokens)


def check_word(word: bytes, scans: tuple[bytes, ...]) -> None:
    """Let the first word of a line that is no scan pass, unless it may be a damaged scan's.

    Raises
    ------
    ValueError
        If it is no word, or nearly one of `scans`.
    """
    if OTHER_LASERS.fullmatch(word):
        return
    text = word.decode("ascii", "backslashreplace").upper()
    names = [name.decode() for name in scans]
    cut = any(name.startswith(text) for name in names)
    if not OTHER.fullmatch(word) or cut or difflib.get_close_matches(text, names, cutoff=0.75):
        raise ValueError(f"expected a record such as {' or '.join(names)}, got {text!r}")


def ranges_of(
    tokens: list[bytes], name: str, at: int, after: tuple[int, ...]
) -> tuple[FloatArray, list[bytes]]:
    """Return the ranges and what follows them, given that their number is the token `at`.

    Raises
    ------
    ValueError
        If what follows does not have one of the lengths `after`, or a range is not a number.
    """
    count = count_of(tokens, name, at)
    values = tokens[at + 1 :]
    if len(values) - count not in after:
        wanted = " or ".join(str(count + n) for n in after)
        raise ValueError(
            f"{name} of {count} ranges: expected {wanted} fields after their number, "
            f"got {len(values)}"
        )
    return numbers(values[:count], f"{name} with ranges in m"), values[count:]


def count_of(tokens: list[bytes], name: str, at: int) -> int:
    """Return the number of values that the token `at` gives.

    Raises
    ------
    ValueError
        If it is missing, or no number that is at least 0.
    """
    token = b"".join(tokens[at : at + 1])
    if not token.isdigit():
        text = token.decode("ascii", "backslashreplace") or "nothing"
        raise ValueError(f"{name}: expected how many values follow as field {at}, got {text}")
    return int(token)


def pose_of(tokens: list[bytes], name: str) -> Pose2D:
    """Return the pose that three tokens give.

    Raises
    ------
    ValueError
        If they are not three finite numbers.
    """
    pose = numbers(tokens, f"{name} with a pose x, y, theta").tolist()
    if not all(map(math.isfinite, pose)):
        raise ValueError(f"expected {name} with a finite pose x, y, theta, got {pose}")
    return Pose2D(*pose)


def stamp_of(token: bytes) -> float:
    """Return the time that a token gives [s]; nan if its last digit is worth more than a second.

    Raises
    ------
    ValueError
        If it is not a number.
    """
    stamp = float(numbers([token], "a time in s")[0])
    mantissa, _, exponent = token.lower().partition(b"e")
    if exponent and int(exponent) > len(mantissa.partition(b".")[2]):
        return math.nan
    return stamp if math.isfinite(stamp) else math.nan


def flaser_angles(count: int) -> FloatArray:
    """Return the directions [rad] of the beams of a record that does not say them."""
    if count in STEPS:
        return even_angles(count, -math.pi / 2, math.radians(STEPS[count]))
    return spread_angles(count, math.pi)


def angles_of(log: Log, name: str, count: int) -> FloatArray:
    """Return the same, or those that are asked for; it is told where they are a guess."""
    if log.field_of_view is not None:
        return spread_angles(count, log.field_of_view)
    if count >= FEWEST and count not in SICK:
        log.notice(
            "field of view",
            f"a {name} of {count} beams does not say its field of view: 180 deg are assumed; give "
            "field_of_view= (--field-of-view 270deg, or both ends as -135deg..135deg)",
        )
    return flaser_angles(count)


def _flaser(log: Log, name: str, tokens: list[bytes]) -> Reading:
    ranges, rest = ranges_of(tokens, name, 1, (6, 9))
    pose = pose_of(rest[:3], name)
    odometry = pose_of(rest[3:6], name)
    # The logger's time is checked only: a record that lost or won a field shows there.
    stamps = [stamp_of(token) for token in (rest[6], rest[8])] if len(rest) == 9 else [math.nan]
    angles = angles_of(log, name, ranges.size)
    return Reading(angles, ranges, stamps[0], pose, odometry=odometry)


def _stated(log: Log, name: str, tokens: list[bytes]) -> Reading:
    """Return a reading of a record that states the directions: ROBOTLASER1, RAWLASER1, .."""
    raw = name.startswith("RAW")
    count = count_of(tokens, name, 8)
    remissions = count_of(tokens, name, 9 + count)
    ranges, rest = ranges_of(tokens, name, 8, (1 + remissions + (3 if raw else 14),))
    start, fov, step, range_max = numbers(tokens[2:6], f"{name} with start, fov, res, maxrange")
    numbers(rest[1:-3], f"{name} with remissions and poses")
    rest = rest[1 + remissions :]
    pose, odometry = (None, None) if raw else (pose_of(rest[:3], name), pose_of(rest[3:6], name))
    stamps = [stamp_of(token) for token in (rest[-3], rest[-1])]
    if log.field_of_view is None:
        angles = _stated_angles(name, count, float(start), float(fov), float(step))
    else:
        angles = spread_angles(count, log.field_of_view)
    limit = float(range_max) if range_max > 0 else math.inf
    return Reading(angles, ranges, stamps[0], pose, limit, odometry)


def _stated_angles(name: str, count: int, start: float, fov: float, step: float) -> FloatArray:
    """Return the directions as ROBOTLASER1 states them; its numbers are rounded to 6 digits."""
    if not abs((count - 1) * step - fov) <= 2.5 * step:
        raise ValueError(
            f"expected {name} with a field of view that fits {count} beams {step} rad apart, "
            f"got {fov} rad; field_of_view= replaces it"
        )
    return even_angles(count, _unrounded(start), _unrounded(step))


def _unrounded(angle: float) -> float:
    """Return the multiple of 1/8 degree that `angle` [rad] was rounded from, if it was."""
    eighths = math.degrees(angle) * 8
    exact = math.radians(round(eighths) / 8) if math.isfinite(eighths) else math.nan
    return exact if abs(angle - exact) < 1e-6 else angle
