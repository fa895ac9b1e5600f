"""GFS logs of GMapping: `LASER_READING n r1..rn x y theta t`, metres and radians.

The pose is raw odometry, the stamp complete. Directions are those of FLASER (see `carmen`).
"""

from laserfeatures.sources.carmen import angles_of, check_word, pose_of, ranges_of, stamp_of
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
            return _reading(log, line.split())
        if word and word[0] not in seen:
            check_word(word[0], (SCAN,))
            seen.add(word[0])
        if word and not word[0].startswith(b"#"):
            log.passed_over[word[0].decode("ascii", "backslashreplace")] += 1
        return None

    yield from finish(log, log.records(parse))


def _reading(log: Log, tokens: list[bytes]) -> Reading:
    name = SCAN.decode()
    ranges, rest = ranges_of(tokens, name, 1, (4,))
    angles = angles_of(log, name, ranges.size)
    return Reading(angles, ranges, stamp_of(rest[3]), pose_of(rest[:3], name))
