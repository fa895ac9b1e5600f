"""The paper's own figures, and its literal algorithm with the parameters of each."""

import math
from dataclasses import dataclass
from typing import TYPE_CHECKING

from laserfeatures.registry import get_extractor

if TYPE_CHECKING:
    from laserfeatures.pipeline import Pipeline

REAL_LINES = 1700  # in the 250 scans of Table I
REAL_FEATURES = 2950
SCANS = 250


@dataclass(frozen=True)
class PaperRow:
    """The parameters of a row of the paper's tables; names and units are those of the CSV files.

    Parameters
    ----------
    dtheta_deg, dd_cm : float
        Size of an accumulator's cell [deg], [cm].
    v_theta, v_d : int
        Cells that a peak suppresses around itself, along theta and along d.
    """

    dtheta_deg: float
    dd_cm: float
    v_theta: int
    v_d: int

    @property
    def extractor(self) -> "Pipeline":
        """The literal algorithm with these parameters."""
        return paper_extractor(
            math.radians(self.dtheta_deg), self.dd_cm / 100, self.v_theta, self.v_d
        )

    @property
    def name(self) -> str:
        """Resolution and window in a few signs."""
        return f"{self.dtheta_deg:g}°, {self.dd_cm:g} cm, {self.v_theta} x {self.v_d}"


@dataclass(frozen=True)
class Table1Row(PaperRow):
    """A row of Table I: what the paper reports of 250 simulated scans."""

    time_ms: float
    lines_detected: int
    lines_filtered: int
    features_matched: int
    features_extracted: int
    tp_percent: float
    fp_percent: float


@dataclass(frozen=True)
class Table2Row(PaperRow):
    """A row of Table II: what the paper reports of its real scans."""

    blind_scans: int
    real_features: int
    matches: int
    extracted: int
    tp_percent: float
    fp_percent: float


# The resolution of the first three is cut off in our copy; their times fit 1 deg, 2 cm.
TABLE1 = (
    Table1Row(1, 2, 1, 1, 151, 2000, 1090, 496, 1000, 16.8, 50.4),
    Table1Row(1, 2, 11, 21, 144, 1871, 969, 915, 1019, 31.0, 10.2),
    Table1Row(1, 2, 33, 67, 140, 1721, 1109, 1147, 1376, 38.9, 16.6),
    Table1Row(2, 2, 1, 1, 80, 2000, 979, 954, 1116, 32.3, 14.5),
    Table1Row(2, 2, 11, 21, 80, 1844, 1209, 1426, 1481, 48.3, 3.7),
    Table1Row(2, 2, 33, 67, 78, 1668, 1237, 1491, 1565, 50.5, 4.7),
    Table1Row(3, 2, 1, 1, 74, 1995, 1103, 1134, 1381, 38.4, 17.9),
    Table1Row(3, 2, 5, 7, 72, 1753, 1207, 1498, 1511, 50.8, 0.9),
    Table1Row(3, 2, 15, 21, 70, 1582, 1237, 1566, 1577, 53.1, 0.7),
    Table1Row(5, 2, 1, 1, 67, 1850, 1298, 1402, 1760, 47.5, 20.3),
    Table1Row(5, 2, 3, 7, 65, 1573, 1232, 1577, 1577, 53.5, 0.0),
    Table1Row(5, 2, 11, 21, 64, 1464, 1244, 1601, 1601, 54.3, 0.0),
    Table1Row(5, 5, 1, 1, 64, 1907, 1102, 1328, 1328, 45.0, 0.0),
    Table1Row(5, 5, 3, 5, 63, 1905, 1220, 1480, 1485, 50.2, 0.3),
    Table1Row(5, 5, 11, 11, 62, 1797, 1338, 1646, 1763, 55.8, 6.6),
    Table1Row(5, 10, 1, 1, 62, 2000, 845, 838, 841, 28.4, 0.4),
    Table1Row(5, 10, 3, 3, 62, 2000, 948, 904, 955, 30.6, 5.3),
    Table1Row(5, 10, 11, 7, 62, 1980, 1190, 1128, 1542, 38.2, 26.9),
)
TABLE2 = (
    Table2Row(0.5, 1, 61, 101, 11, 163, 135, 157, 82.8, 14.0),
    Table2Row(0.5, 1, 61, 51, 11, 163, 135, 168, 82.8, 19.6),
    Table2Row(2, 5, 31, 51, 10, 163, 126, 152, 77.3, 17.1),
    Table2Row(3, 2, 15, 21, 10, 163, 122, 172, 74.8, 29.1),
    Table2Row(5, 2, 3, 7, 15, 163, 91, 126, 55.8, 27.8),
    Table2Row(5, 2, 11, 21, 11, 163, 121, 170, 74.2, 28.8),
)


def paper_extractor(theta_step: float, distance_step: float, v_theta: int, v_d: int) -> "Pipeline":
    """Return the paper's literal algorithm; all else is as its section III.C has it.

    Parameters
    ----------
    theta_step, distance_step : float
        Size of an accumulator's cell [rad], [m].
    v_theta, v_d : int
        Cells that a peak suppresses around itself, along theta and along d.

    Raises
    ------
    ValueError
        If a parameter is out of its range.
    """
    return get_extractor(
        "direct_hough",
        preset="paper",
        theta_step=theta_step,
        distance_step=distance_step,
        neighborhood=(v_d, v_theta),
    )
