"""Pictures of SLAM on a simulated drive, in the manner of the paper's Figs. 8 and 9."""

import math
from typing import TYPE_CHECKING

import numpy as np

from laserfeatures import figures
from laserfeatures.arrays import FloatArray
from laserfeatures.mapping.drive_score import position_errors
from laserfeatures.mapping.map_picture import draw_landmarks
from laserfeatures.mapping.run import Run
from laserfeatures.mapping.simulated_drive import SimulatedDrive
from laserfeatures.simulation import World

if TYPE_CHECKING:
    from matplotlib.axes import Axes
    from matplotlib.figure import Figure

DEVIATIONS = 3.0
WALLS = "0.78"
MARGIN = 0.8  # around the world and both paths [m]


def drive_figure(run: Run, drive: SimulatedDrive, title: str = "") -> "Figure":
    """Return the world, all paths and the landmarks: the paper's Fig. 8.

    The true path is dashed black, odometry's black, the filter's blue; corners are red, with
    ellipses of three standard deviations, and so are walls.

    Raises
    ------
    MissingDependencyError
        If matplotlib is not installed.
    """
    paths = [each.poses[:, :2] for each in (drive.truth, run.odometry, run.estimate)]
    low, high = _limits(drive.world, paths)
    width, height = 9.0 * (high - low) / (high - low).max()
    figure = figures.new_figure(max(width, 5.0) + 0.6, max(height, 3.0) + 1.2)
    axes = figure.add_subplot()
    _draw_world(axes, drive.world)
    truth, odometry, estimate = (path.T for path in paths)
    axes.plot(*odometry, "-k", linewidth=1.0, label="odometry", zorder=3)
    axes.plot(*estimate, "-", color=figures.BLUE, linewidth=1.8, label="EKF-SLAM", zorder=4)
    axes.plot(*truth, "--k", linewidth=1.0, label="true path", zorder=5)
    draw_landmarks(axes, run.map)
    figures.in_metres(axes, low, high)
    axes.set_title(title, fontsize="medium")
    figures.draw_legend(figure, columns=5)
    return figure


def error_figure(run: Run, drive: SimulatedDrive, title: str = "") -> "Figure":
    """Return the error of the position over time: the paper's Fig. 9.

    Above, odometry and SLAM in metres; below, SLAM alone, with three standard deviations as the
    filter takes them to be: where it is right, the error stays below.

    Raises
    ------
    MissingDependencyError
        If matplotlib is not installed.
    """
    figure = figures.new_figure(8.0, 5.6)
    above, below = figure.subplots(2, 1, sharex=True)
    stamps = drive.truth.stamps - drive.truth.stamps[0]
    errors = position_errors(run.estimate, drive.truth)
    bound = DEVIATIONS * _deviations(run.covariances)
    above.plot(stamps, position_errors(run.odometry, drive.truth), "-k", label="odometry")
    above.plot(stamps, errors, color=figures.BLUE, label="EKF-SLAM")
    above.set(ylabel="position error [m]", ylim=(0, None))
    below.plot(stamps, 1e3 * errors, color=figures.BLUE, label="_")
    below.fill_between(stamps, 1e3 * bound, color=figures.RED, alpha=0.15, linewidth=0)
    below.plot(
        stamps,
        1e3 * bound,
        color=figures.RED,
        linewidth=0.8,
        label="three deviations of the EKF's position",
    )
    below.set(xlabel="time [s]", ylabel="position error [mm]", ylim=(0, None))
    below.set_xlim(0, max(float(stamps[-1]), 1e-3))
    for axes in (above, below):
        axes.tick_params(direction="in", top=True, right=True)
        axes.grid(color="0.9")
    figure.suptitle(title, fontsize="medium")
    figures.draw_legend(figure, columns=3)
    return figure


def _deviations(covariances: FloatArray) -> FloatArray:
    """Return the deviation of each position [m] along the direction in which it is largest."""
    largest = np.linalg.eigvalsh(covariances[:, :2, :2])[:, -1]
    deviations: FloatArray = np.sqrt(np.maximum(largest, 0.0))
    return deviations


def _limits(world: World, paths: list[FloatArray]) -> tuple[FloatArray, FloatArray]:
    points = np.concatenate([world.sides.reshape(-1, 2), *paths])
    return points.min(axis=0) - MARGIN, points.max(axis=0) + MARGIN


def _draw_world(axes: "Axes", world: World) -> None:
    axes.plot(
        *world.sides.transpose(2, 1, 0), color=WALLS, linewidth=4, solid_capstyle="round", zorder=1
    )
    angles = np.linspace(0, math.tau, 60)
    for x, y, radius in world.poles:
        axes.fill(x + radius * np.cos(angles), y + radius * np.sin(angles), color=WALLS, zorder=1)
