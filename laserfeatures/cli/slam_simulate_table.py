"""The scores of simulated drives as a table."""

from collections.abc import Mapping
from typing import Any

from laserfeatures.comparison.document import Table
from laserfeatures.testbench.output import cell

COLUMNS = {
    "odometry_final_error": ("odom. end [m]", 1),
    "final_error": ("end [m]", 1),
    "worst_final_error": ("worst end [m]", 1),
    "ratio": ("ratio", 1),
    "worst_ratio": ("worst ratio", 1),
    "odometry_ate_rmse": ("odom. ATE [m]", 1),
    "ate_rmse": ("ATE [m]", 1),
    "rpe_rmse": ("RPE [mm]", 1000),
    "nees_inside": ("NEES in band [%]", 100),
    "nees_mean": ("mean NEES", 1),
    "nis_per_degree": ("mean NIS", 1),
    "landmarks": ("land- marks", 1),
    "virtual": ("vir- tual [%]", 100),
    "landmark_error": ("off by [mm]", 1000),
    "spurious": ("spu- rious [%]", 100),
    "doubled": ("dou- bled [%]", 100),
    "step_ms": ("time [ms]", 1),
}
LEGEND = """End: distance of the last pose from the true one, by odometry and by SLAM, median of all
drives and worst; ratio: that by SLAM over that by odometry. ATE, RPE (over 1 m): rms errors,
medians of all drives, without alignment, as start and frame are given. NEES: of the pose, share of
scans inside the 95 % band of its 3 degrees of freedom, and mean (3 is right); NIS: over its degrees
of freedom (1 is right). Virtual: landmarks where surfaces would meet if they were longer. Off by:
median distance of the landmarks from the nearest true corner or wall. Spurious: farther than 0.3 m
from any; doubled: second one of the same. Time: median of a scan, features and filter together,
while all workers ran."""


def table_of(summaries: Mapping[str, Mapping[str, Any]]) -> Table:
    """Return a table with a row for each extractor; `summaries` are as `summary` returns them."""
    return Table(
        ["extractor", *(head for head, _ in COLUMNS.values())],
        [[name, *_cells(found)] for name, found in summaries.items()],
    )


def _cells(found: Mapping[str, Any]) -> list[str]:
    return [
        cell(float(found[key]) * scale, "percent" if scale != 1 else "")
        for key, (_, scale) in COLUMNS.items()
    ]
