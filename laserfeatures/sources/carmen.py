"""CARMEN logs (`.log`, `.clf`): the records FLASER and ROBOTLASER1 of the front laser.

::

    FLASER n r1..rn x y theta odom_x odom_y odom_theta [t host logger_t]
    ROBOTLASER1 type start fov res maxrange accuracy remission_mode n r1..rn m e1..em
                x y theta robot_x robot_y robot_theta (5 numbers) t host logger_t

Metres and radians. The pose is the first of the two, the laser's. It is "corrected" in a log with
records that only a SLAM program writes (NEFF, VERTEX2, EDGE2) or where it leaves the second one,
the robot's, else "odometry"; `carmen_poses` tells how raw odometry is got from a corrected log.
FLASER says nothing of directions: 180 and 181 beams are 1 degree apart, 360 and 361 half a degree,
from -90 degrees on; other counts are spread over 180 degrees, or over `field_of_view`. A stamp
written with too few digits to tell seconds apart (1.01893e+09), or 0 throughout, is nan.

Other records are passed over; a line whose first word is nearly that of a scan is broken.
"""

import difflib
import math
import re

from laserfeatures.arrays import FloatArray
from laserfeatures.data import Pose2D
from laserfeatures.sources.beams import even_angles, numbers, spread_angles
from laserfeatures.sources.carmen_poses import CarmenPoses
from laserfeatures.sources.log import Log, Scans
from laserfeatures.sources.readings import Reading, finish

SCANS = (b"FLASER", b"ROBOTLASER1")
SLAM = (b"NEFF", b"VERTEX2", b"EDGE2")
OTHER = re.compile(rb"#.*|[A-Za-z][\w-]*")
OTHER_LASERS = re.compile(rb"R?LASER\d?|(RAW|ROBOT)LASER\d")
STEPS = {180: 1.0, 181: 1.0, 360: 0.5, 361: 0.5}  # [degrees], of the SICK LMS


def is_carmen(head: bytes) -> bool:
    """Return whether a file that starts with `head` is a CARMEN log."""
    words = {line.split(None, 1)[0] for line in head.splitlines() if line.strip()}
    return bool(words & {*SCANS, *SLAM, b"PARAM", b"ODOM", b"SYNC"})


def read_carmen(log: Log) -> Scans:
    """Yield the scans of a CARMEN log."""
    log.poses = "odometry"
    poses = CarmenPoses(log)
    seen: set[bytes] = set()

    def parse(line: bytes) -> Reading | None:
        word = line[:64].split(None, 1)[:1]
        if word == [b"FLASER"]:
            return _flaser(line.split(), log.field_of_view)
        if word == [b"ROBOTLASER1"]:
            return _robotlaser(line.split(), log.field_of_view)
        if word == [b"PARAM"]:
            poses.param(line)
        elif word and word[0] not in seen:
            check_word(word[0], SCANS)
            seen.add(word[0])
            if word[0] in SLAM:
                poses.corrected()
        return None

    yield from finish(log, poses.chosen(log.records(parse)))


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


def flaser_angles(count: int, field_of_view: float | None) -> FloatArray:
    """Return the directions [rad] of the beams of a record that does not say them."""
    if field_of_view is None and count in STEPS:
        return even_angles(count, -math.pi / 2, math.radians(STEPS[count]))
    return spread_angles(count, field_of_view or math.pi)


def _flaser(tokens: list[bytes], field_of_view: float | None) -> Reading:
    ranges, rest = ranges_of(tokens, "FLASER", 1, (6, 9))
    pose = pose_of(rest[:3], "FLASER")
    odometry = pose_of(rest[3:6], "FLASER")
    # The logger's time is checked only: a record that lost or won a field shows there.
    stamps = [stamp_of(token) for token in (rest[6], rest[8])] if len(rest) == 9 else [math.nan]
    angles = flaser_angles(ranges.size, field_of_view)
    return Reading(angles, ranges, stamps[0], pose, odometry=odometry)


def _robotlaser(tokens: list[bytes], field_of_view: float | None) -> Reading:
    name = "ROBOTLASER1"
    count = count_of(tokens, name, 8)
    remissions = count_of(tokens, name, 9 + count)
    ranges, rest = ranges_of(tokens, name, 8, (15 + remissions,))
    start, fov, step, range_max = numbers(tokens[2:6], f"{name} with start, fov, res, maxrange")
    numbers(rest[1:-3], f"{name} with remissions and poses")
    rest = rest[1 + remissions :]
    pose, odometry = pose_of(rest[:3], name), pose_of(rest[3:6], name)
    stamps = [stamp_of(token) for token in (rest[11], rest[13])]
    if field_of_view is None:
        angles = _stated_angles(count, float(start), float(fov), float(step))
    else:
        angles = spread_angles(count, field_of_view)
    limit = float(range_max) if range_max > 0 else math.inf
    return Reading(angles, ranges, stamps[0], pose, limit, odometry)


def _stated_angles(count: int, start: float, fov: float, step: float) -> FloatArray:
    """Return the directions as ROBOTLASER1 states them; its numbers are rounded to 6 digits."""
    if not abs((count - 1) * step - fov) <= 2.5 * step:
        raise ValueError(
            f"expected ROBOTLASER1 with a field of view that fits {count} beams {step} rad apart, "
            f"got {fov} rad; field_of_view= replaces it"
        )
    return even_angles(count, _unrounded(start), _unrounded(step))


def _unrounded(angle: float) -> float:
    """Return the multiple of 1/8 degree that `angle` [rad] was rounded from, if it was."""
    eighths = math.degrees(angle) * 8
    exact = math.radians(round(eighths) / 8) if math.isfinite(eighths) else math.nan
    return exact if abs(angle - exact) < 1e-6 else angle
