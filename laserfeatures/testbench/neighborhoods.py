"""Two scenes at three sizes of the peaks' neighbourhood: the paper's Figs. 6 and 7."""

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np

from laserfeatures.arrays import FloatArray
from laserfeatures.data import Features, Pose2D
from laserfeatures.evaluation import Truth, match_corners, truth_of
from laserfeatures.figures import removed_lines
from laserfeatures.simulation import Scanner, hallway
from laserfeatures.testbench.paper import PaperRow

# The paper says neither at which resolution nor how large the middle window is. Table I has
# the largest, 21 cells of theta by 11 of d, at no resolution.
WINDOWS = ((1, 1), (11, 5), (21, 11))  # cells along theta, along d
RESOLUTION = (1.0, 2.0)  # [deg], [cm]
SCENES = {"figure6": Pose2D(8.5, 1.6, 0.9), "figure7": Pose2D(4.0, 1.0, 0.0)}


@dataclass(frozen=True, eq=False, kw_only=True)
class Panel:
    """One scene at one size.

    Parameters
    ----------
    figure : str
        Which figure it belongs to.
    row : PaperRow
        The parameters.
    features : Features
        What was found.
    truth : Truth
        What is true.
    removed : (R, 2) array
        (theta, d) [rad, m] of the lines that the filter removed.
    """

    figure: str
    row: PaperRow
    features: Features
    truth: Truth
    removed: FloatArray

    @property
    def counts(self) -> dict[str, Any]:
        """What can be counted in it."""
        found = self.features.corners.positions
        matched, _ = match_corners(found, self.truth.corners)
        passed = len(self.features.lines)
        return {
            "figure": self.figure,
            "v_theta": self.row.v_theta,
            "v_d": self.row.v_d,
            "lines_true": self.truth.theta.size,
            "lines_detected": passed + len(self.removed),
            "lines_passed": passed,
            "features_true": len(self.truth.corners),
            "features_extracted": len(found),
            "features_matched": matched.size,
        }


def run(*, seed: int = 1) -> list[Panel]:
    """Return the panels of both figures, small windows first.

    Parameters
    ----------
    seed : int
        Seed of the scans' noise.

    Raises
    ------
    MissingDependencyError
        If SciPy is missing.
    """
    world, _ = hallway()
    panels = []
    for number, (figure, pose) in enumerate(SCENES.items()):
        rng = np.random.default_rng((seed, number))
        observation = Scanner.model("lms200").observe(world, pose, rng)
        for v_theta, v_d in WINDOWS:
            row = PaperRow(*RESOLUTION, v_theta, v_d)
            features = row.extractor(observation.scan)
            panels.append(
                Panel(
                    figure=figure,
                    row=row,
                    features=features,
                    truth=truth_of(observation),
                    removed=removed_lines(row.extractor, features),
                )
            )
    return panels


def of_figure(panels: Sequence[Panel], figure: str) -> list[Panel]:
    """Return the panels of one figure."""
    return [panel for panel in panels if panel.figure == figure]
