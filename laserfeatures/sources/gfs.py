"""GFS logs of GMapping: `LASER_READING n r1..rn x y theta t`, metres and radians.

The pose is raw odometry, the stamp complete. Directions are those of FLASER (see `carmen`).
"""

from laserfeatures.sources.carmen import check_word, flaser_angles, pose_of, ranges_of, stamp_of
from laserfeatures.sources.log import Log, Scans
from laserfeatures.sources.readings import Reading, finish

SCAN = b"LASER_READING"


def is_gfs(head: bytes) -> bool:
    """Return whether a file that starts with `head` is a GFS log."""
    words = {line.split(None, 1)[0] for line in head.splitlines() if line.strip()}
    return bool(words & {SCAN, b"ODO_UPDATE", b"SM_UPDATE"})


def read_gfs(log: Log) -> Scans:
    """Yield the scans of a GFS log."""
    log.poses = "odometry"
    seen: set[bytes] = set()

    def parse(line: bytes) -> Reading | None:
        word = line[:64].split(None, 1)[:1]
        if word == [SCAN]:
            return _reading(line.split(), log.field_of_view)
        if word and word[0] not in seen:
            check_word(word[0], (SCAN,))
            seen.add(word[0])
        return None

    yield from finish(log, log.records(parse))


def _reading(tokens: list[bytes], field_of_view: float | None) -> Reading:
    name = SCAN.decode()
    ranges, rest = ranges_of(tokens, name, 1, (4,))
    angles = flaser_angles(ranges.size, field_of_view)
    return Reading(angles, ranges, stamp_of(rest[3]), pose_of(rest[:3], name))
