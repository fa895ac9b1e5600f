"""Finding nodes of five bytes in a stream that may be damaged.

A node has three check bits and no checksum. As long as they are right, nodes follow each other. At
a wrong one the stream goes on with the next node if only this one is damaged; if bytes are lost or
added it is searched byte by byte for nodes that agree with each other, also in their angles.
"""

from itertools import pairwise

from laserfeatures.drivers.losses import Losses
from laserfeatures.drivers.rplidar.nodes import NODE, in_sync

AGREE = 8  # nodes in a row that make a new beginning
AHEAD = AGREE * NODE
SUSPECT = 2  # nodes before a loss of synchronism that may hold bytes of others
LARGEST_STEP = 10 * 64  # from node to node [1/64 degree]
WHOLE = 360 * 64

# For bytes.translate: whether a byte's two flags differ; its lowest bit, which starts a turn in a
# node's first byte and is 1 in its second.
_FLAGS = bytes((byte ^ byte >> 1) & 1 for byte in range(256))
_CHECK = bytes(byte & 1 for byte in range(256))


class NodeFraming:
    """Cuts the bytes of a standard scan into whole nodes.

    Parameters
    ----------
    losses : Losses
        Where damage is counted: nodes thrown away as damaged, other bytes as garbage.
    """

    def __init__(self, losses: Losses) -> None:
        self._losses = losses
        self._buffer = b""
        self._locked = True

    @property
    def pending(self) -> int:
        """How many bytes wait for more."""
        return len(self._buffer)

    def feed(self, data: bytes) -> list[tuple[bytes, int]]:
        """Take bytes; return runs of whole nodes, and how many bytes came after each run."""
        buffer, at = self._buffer + data, 0
        runs: list[tuple[bytes, int]] = []
        while True:
            if not self._locked:
                found = search(buffer, at)
                self._losses.garbage += found[0] - at
                at, self._locked = found
                if not self._locked:
                    break
            end, wrong = run(buffer, at)
            good = end
            unknown = wrong and len(buffer) < end + NODE + AHEAD  # the next nodes will tell
            lost = wrong and not unknown and not agree(buffer, end + NODE)
            if unknown or lost:
                good = max(at, end - SUSPECT * NODE)
            self._locked = not lost
            if good > at:
                runs.append((buffer[at:good], len(buffer) - good))
            at = good
            if not wrong or unknown:
                break
            self._losses.damaged += 1
            if lost:
                at += 1  # this was no beginning
                self._losses.garbage += 1
            else:
                at = end + NODE
        self._buffer = buffer[at:]
        return runs


def run(buffer: bytes, at: int) -> tuple[int, bool]:
    """Return where the nodes from `at` on end, and whether that is because one is wrong.

    A node counts when the check bits of the next one are there and right, too: a lost byte shows
    only there.
    """
    flags = buffer[at::NODE].translate(_FLAGS)
    checks = buffer[at + 1 :: NODE].translate(_CHECK)
    heads = len(checks)
    bad = min(_or(flags.find(0, 0, heads), heads), _or(checks.find(0), heads))
    if bad < heads:
        return at + bad * NODE, True
    return at + max(heads - 1, 0) * NODE, False


def agree(buffer: bytes, at: int) -> bool:
    """Return whether `AGREE` nodes stand at `at`, whole, in order of their angles."""
    nodes = buffer[at : at + AHEAD]
    if len(nodes) < AHEAD or not in_sync(nodes):
        return False
    if 0 in nodes[::NODE].translate(_FLAGS) or 0 in nodes[1::NODE].translate(_CHECK):
        return False
    angles = [angle_at(nodes, i) for i in range(AGREE)]
    return max(angles) <= WHOLE and all(near(a, b) for a, b in pairwise(angles))


def search(buffer: bytes, at: int) -> tuple[int, bool]:
    """Return the first place from `at` on where nodes agree, or where they may once more come."""
    last = len(buffer) - AHEAD
    for i in range(at, last + 1):
        if in_sync(buffer[i : i + 2]) and agree(buffer, i):
            return i, True
    return max(at, last + 1), False


def starts_turn(nodes: bytes, at: int = 0) -> int:
    """Return the index of the first node from node `at` on that starts a turn, -1 if none does."""
    return nodes[::NODE].translate(_CHECK).find(1, at)


def angle_at(nodes: bytes, index: int) -> int:
    """Return the angle of a node [1/64 degree]."""
    return nodes[NODE * index + 1] >> 1 | nodes[NODE * index + 2] << 7


def near(angle: int, other: int, within: int = LARGEST_STEP) -> bool:
    """Return whether two angles [1/64 degree] are near each other."""
    return abs((angle - other + WHOLE // 2) % WHOLE - WHOLE // 2) <= within


def _or(found: int, otherwise: int) -> int:
    return otherwise if found < 0 else found
