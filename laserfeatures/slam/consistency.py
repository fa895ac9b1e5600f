"""When the filter is not to be trusted any more."""

from collections import deque

from laserfeatures.slam.association import gate

WINDOW = 20  # scans
SURE = 1 - 1e-6  # that innovations so large are not chance
LOST = 3  # scans at least that are odd
ODD = 20.0  # minus the logarithm of the chance of what they do not show
DOUBTFUL = 5.0  # from where on nothing new is believed
MOST = 2 * ODD  # so that the filter can find itself again
EACH_MATCH, EACH_SCAN = 3.0, 5.0  # what speaks against it


class Watch:
    """Watches innovations and misses, scan by scan; says each trouble once, when it begins."""

    def __init__(self) -> None:
        self._recent: deque[tuple[int, float]] = deque(maxlen=WINDOW)
        self._odd_scans = 0
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
                f"lost: for {self._odd_scans} scans hardly any landmark that ought to be seen was "
                "recognised; the robot may have been carried, or the map be wrong"
            )
        if self._wide and not before:
            return (
                f"inconsistent: over the last {len(self._recent)} scans, innovations were "
                f"{(total / degrees) ** 0.5:.1f} times what the covariances allow"
            )
        return None

    @property
    def doubts(self) -> bool:
        """Whether the latest scans are so odd that what is new in them is not to be believed."""
        return self._oddity > DOUBTFUL and not self._lost

    def _loses(self, matched: int, oddity: float) -> bool:
        """Return whether it is with this scan that the filter is lost.

        What speaks for it is summed up, and starts anew where matches have outweighed it.
        """
        self._oddity = min(self._oddity + oddity - EACH_MATCH * matched - EACH_SCAN, MOST)
        if self._oddity <= 0:
            self._odd_scans, self._oddity, self._lost = 0, 0.0, False
            return False
        self._odd_scans += 1
        before = self._lost
        self._lost = before or (self._odd_scans >= LOST and self._oddity > ODD)
        return self._lost and not before
