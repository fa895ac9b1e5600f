"""Extractors that know the corners, and scans to run them on."""

import math

import numpy as np

from laserfeatures import Features, LineSegments, PointFeatures, Pose2D
from laserfeatures.simulation import Scanner, World

ROOM = np.array([(-4.0, -3.0), (4.0, -3.0), (4.0, 3.0), (-4.0, 3.0)])
WORLD = World.outline(ROOM)
WIDE = Scanner(beams=181, field_of_view=math.radians(250), range_max=20.0)


def tour(count, scanner=WIDE):
    """Return scans of the room from a path through it; each one's stamp is its number."""
    rng = np.random.default_rng(3)
    return [
        scanner.scan(WORLD, Pose2D(1.5 * math.cos(t), math.sin(2 * t), 3 * t), rng, stamp=float(i))
        for i, t in enumerate(np.linspace(0.0, 3.0, count))
    ]


def corners_at(positions, evidence=None, real=True):
    """Return corners that were found without lines."""
    positions = np.reshape(positions, (-1, 2))
    n = len(positions)
    return PointFeatures(
        positions=positions,
        covariance=np.tile(np.eye(2) * 1e-4, (n, 1, 1)),
        lines=np.full((n, 2), -1),
        angles=np.full(n, math.pi / 2),
        real=np.full(n, real),
        evidence=evidence,
    )


def seen(scan, corners=ROOM):
    """Return corners of the plan in the frame of a scan's sensor, and which it has in view."""
    c, s = math.cos(scan.pose.theta), math.sin(scan.pose.theta)
    positions = (corners - (scan.pose.x, scan.pose.y)) @ np.array([[c, -s], [s, c]])
    angles = np.arctan2(positions[:, 1], positions[:, 0])
    return positions, (angles >= scan.angles[0]) & (angles <= scan.angles[-1])


def oracle(*, keep=lambda _scan, _k: True, shift=(0.0, 0.0), evidence=lambda _chosen: None):
    """Return a detector of the room's corners in view: those to keep, shifted.

    `evidence` tells that of the chosen ones, which are given by their numbers.
    """

    def detect(scan):
        positions, in_view = seen(scan)
        chosen = [k for k in np.flatnonzero(in_view) if keep(scan, k)]
        return corners_at(positions[chosen] + shift, evidence(chosen))

    return detect


def extractor(detect):
    """Return an extractor of such a detector."""

    def extract(scan):
        return Features(scan=scan, segments=LineSegments.none(len(scan)), corners=detect(scan))

    return extract
