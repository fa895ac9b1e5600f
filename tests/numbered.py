"""Scans that say which turn they are of: what the tests and benchmarks of faults are made of."""

import numpy as np

FIRST, STEP, NUMBERS = 1.0, 0.001, 2500  # [m], [m]


class NumberedFeed:
    """Every beam of turn k has the range 1 m + k mm (beginning again after 2500 turns)."""

    def __init__(self):
        self.turn = -1

    def __call__(self, angles):
        self.turn += 1
        return np.full(angles.size, FIRST + STEP * (self.turn % NUMBERS))


def numbers_of(scan):
    """Return the numbers (modulo 2500) of the turns that the valid beams of a scan are of."""
    return np.rint((scan.ranges[scan.valid] - FIRST) / STEP).astype(int)
