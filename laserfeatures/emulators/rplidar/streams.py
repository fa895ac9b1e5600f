"""The endless answers: frames of measurements, each when it is due."""

from collections.abc import Callable
from typing import NamedTuple

import numpy as np

from laserfeatures.drivers.rplidar.capsules import QUALITY, SAMPLES, THETA, head, pack_capsule
from laserfeatures.drivers.rplidar.nodes import DEGREE, FINE, TURN, Measurements, pack_nodes
from laserfeatures.drivers.rplidar.packets import Answer
from laserfeatures.drivers.rplidar.ultra import (
    DENSE_SAMPLES,
    ULTRA_SAMPLES,
    pack_dense,
    pack_ultra,
)
from laserfeatures.emulators.rplidar.sampling import Sampler, Samples

NODES = 8  # that are sent at once
JUMP = 40 * DEGREE


class Frame(NamedTuple):
    """What is sent, when it is ready [s], and the number of the turn."""

    data: bytes
    at: float
    turn: int


def node_frame(samples: Samples, _: bool) -> bytes:
    """Return nodes."""
    nodes = samples.part(slice(NODES))
    angles = (nodes.raw - nodes.theta) // FINE * FINE % TURN
    quality = np.where(nodes.distances > 0, QUALITY, 0)
    return pack_nodes(Measurements(angles, nodes.distances, quality), nodes.starts)


def capsule_frame(samples: Samples, first: bool) -> bytes:
    """Return a capsule."""
    own = samples.part(slice(SAMPLES))
    return pack_capsule(int(own.raw[0]), own.theta // THETA, own.distances, first=first)


def ultra_frame(samples: Samples, first: bool) -> bytes:
    """Return an ultra capsule."""
    distances = samples.distances
    return pack_ultra(
        int(samples.raw[0]), distances[:ULTRA_SAMPLES], distances[ULTRA_SAMPLES], first=first
    )


def dense_frame(samples: Samples, first: bool) -> bytes:
    """Return a dense capsule."""
    return pack_dense(int(samples.raw[0]), samples.distances[:DENSE_SAMPLES], first=first)


FORMS: dict[Answer, tuple[int, Callable[[Samples, bool], bytes]]] = {
    Answer.NODES: (NODES, node_frame),
    Answer.CAPSULES: (SAMPLES, capsule_frame),
    Answer.ULTRA_CAPSULES: (ULTRA_SAMPLES, ultra_frame),
    Answer.DENSE_CAPSULES: (DENSE_SAMPLES, dense_frame),
}


class Stream:
    """An endless answer.

    Parameters
    ----------
    answer : Answer
        Its form.
    sampler : Sampler
        What is measured.
    """

    def __init__(self, answer: Answer, sampler: Sampler) -> None:
        self.answer = answer
        self._sampler = sampler
        self._count, self._pack = FORMS[answer]
        self._first = True

    @property
    def due(self) -> float:
        """When the next frame is ready: with its last measurement [s]."""
        return float(self._sampler.ahead(self._count).times[-1])

    def next_frame(self) -> Frame:
        """Return the next frame."""
        samples = self._sampler.ahead(self._count + 1)
        data = self._pack(samples, self._first)
        self._sampler.take(self._count)
        self._first = False
        return Frame(data, float(samples.times[self._count - 1]), int(samples.turns[0]))


def with_bad_checksum(capsule: bytes) -> bytes:
    """Return a capsule whose checksum is wrong."""
    return bytes((capsule[0] ^ 1,)) + capsule[1:]


def with_jump(capsule: bytes) -> bytes:
    """Return a capsule with a wrong start angle and a right checksum."""
    start = (capsule[2] | (capsule[3] & 0x7F) << 8) * FINE
    return head(start + JUMP, capsule[4:])
