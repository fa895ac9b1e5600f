"""The worlds that the package brings along."""

from laserfeatures.data import Pose2D
from laserfeatures.simulation.world import World


def hallway() -> tuple[World, list[Pose2D]]:
    """Return an L-shaped hallway with two door niches and a cupboard, and a path through it.

    The plan is in the manner of the paper's Fig. 5: a long part where parallel walls dominate and a
    part with oblique walls.
    """
    outline = [
        (0.0, 0.0), (5.0, 0.0), (5.0, -0.3), (6.0, -0.3), (6.0, 0.0), (10.0, 0.0),
        (10.0, 6.0), (9.0, 7.0), (8.2, 7.0), (7.6, 6.0), (7.6, 4.6), (7.9, 4.6), (7.9, 3.7),
        (7.6, 3.7), (7.6, 2.2), (0.0, 2.2),
    ]  # fmt: skip
    cupboard = [(2.6, 1.8), (3.6, 1.8), (3.6, 2.2), (2.6, 2.2)]
    path = [
        Pose2D(1.0, 1.0, 0.0), Pose2D(2.5, 0.9, 0.1), Pose2D(4.0, 1.0, 0.0), Pose2D(5.5, 1.1, 0.2),
        Pose2D(7.0, 1.2, 0.3), Pose2D(8.5, 1.6, 0.9), Pose2D(8.8, 2.8, 1.4), Pose2D(8.7, 4.2, 1.7),
    ]  # fmt: skip
    return World.outline(outline, cupboard), path
