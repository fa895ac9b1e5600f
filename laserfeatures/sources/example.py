"""Examples: ``example:hallway`` and others, scans of worlds that the package brings along."""

from dataclasses import replace

from laserfeatures.data import LaserScan
from laserfeatures.errors import SourceError
from laserfeatures.simulation.examples import example
from laserfeatures.sources.log import Poses, Wanted
from laserfeatures.sources.source import Source

SCHEME = "example:"


class ExampleSource(Source):
    """An example that is being read.

    Parameters
    ----------
    name : str
        ``example:`` and its name.
    range_max : float or None
        Overrides the sensor's limit [m].
    poses : {"odometry", "corrected"} or None
        By wheel odometry, as if left out, or the true ones.

    Raises
    ------
    SourceError
        If there is no such example.
    """

    path = None
    format = "example"

    def __init__(
        self, name: str, *, range_max: float | None = None, poses: Wanted | None = None
    ) -> None:
        self.name = name
        self._range_max = range_max
        self._poses: Poses = poses or "odometry"
        try:
            self._shots = example(name.removeprefix(SCHEME))
        except ValueError as error:
            raise SourceError(f"{name}: {error}") from error

    @property
    def poses(self) -> Poses:
        """What the scans' poses are."""
        return self._poses

    @property
    def skipped(self) -> int:
        """Number of broken records: there are none."""
        return 0

    @property
    def first_error(self) -> None:
        """What was wrong: nothing."""

    def __next__(self) -> LaserScan:
        """Return the next scan."""
        shot = next(self._shots)
        scan = shot.observation.scan
        pose = shot.odometry if self._poses == "odometry" else shot.observation.pose
        limit = scan.range_max if self._range_max is None else self._range_max
        return replace(scan, pose=pose, range_max=limit)

    def close(self) -> None:
        """There are no more scans then."""
        self._shots = iter(())
