"""When the filter is not to be trusted any more."""

from collections import deque

from laserfeatures.slam.association import gate

WINDOW = 20  # scans
SURE = 1 - 1e-6  # that innovations so large are not chance
LOST = 3  # scans in a row at least in which nothing was recognised
ODD = 20.0  # minus the logarithm of the chance of that


class Watch:
    """Watches innovations and misses, scan by scan; says each trouble once, when it begins."""

    def __init__(self) -> None:
        self._recent: deque[tuple[int, float]] = deque(maxlen=WINDOW)
        self._unrecognised = 0
        self._oddity = 0.0
        self._lost = False
        self._wide = False

    def notice(self, matched: int, nis: float, oddity: float) -> str | None:
        """Return what is wrong from this scan on, if anything.

        Parameters
        ----------
        matched : int
            Measurements of known landmarks.
        nis : float
            Their normalised innovation squared.
        oddity : float
            Minus the logarithm of the chance that those landmarks are not recognised that ought to
            be and were not.
        """
        self._recent.append((matched, nis))
        degrees = 2 * sum(count for count, _ in self._recent)
        total = sum(squared for _, squared in self._recent)
        before, self._wide = self._wide, bool(degrees) and total > gate(degrees, SURE)
        if self._loses(matched, oddity):
            return (
                f"lost: for {self._unrecognised} scans none of the landmarks that ought to be seen "
                "was recognised; the robot may have been carried, or the map be wrong"
            )
        if self._wide and not before:
            return (
                f"inconsistent: over the last {len(self._recent)} scans, innovations were "
                f"{(total / degrees) ** 0.5:.1f} times what the covariances allow"
            )
        return None

    def _loses(self, matched: int, oddity: float) -> bool:
        """Return whether it is with this scan that the filter is lost."""
        if matched:
            self._unrecognised, self._oddity, self._lost = 0, 0.0, False
            return False
        self._unrecognised += 1
        self._oddity += oddity
        before = self._lost
        self._lost = self._unrecognised >= LOST and self._oddity > ODD
        return self._lost and not before
