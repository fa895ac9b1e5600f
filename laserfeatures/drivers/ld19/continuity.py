"""Telling frames that a CRC of eight bits lets through by chance."""

from laserfeatures.drivers.ld19.frames import CLOCK_MS, POINTS, TURN, Frame

GAP_MS = 100  # over more, speed and time say little of the angle
SLACK_MS = 2.0  # the clock counts whole milliseconds
SLACK_DEG = 1.0
SPEED_SLACK = 0.02  # share that the speed may change from frame to frame
WIDTH_SLACK = 0.25


class Continuity:
    """Lets those frames pass whose angles and time continue those of the frame before.

    One in 256 damaged frames has a CRC that fits. A frame that does not continue the last one is
    held back until the next shows which of both it continues: a device that was restarted, or whose
    frames were lost for long, loses none of its frames.
    """

    def __init__(self) -> None:
        self.reset()

    def reset(self) -> None:
        """Begin anew: the first frame is held back, too."""
        self._last: Frame | None = None
        self._held: tuple[Frame, float] | None = None

    @property
    def doubts(self) -> bool:
        """Whether the frame checked last contradicts those before it."""
        return self._held is not None and self._last is not None

    def check(self, frame: Frame, arrival: float) -> tuple[list[tuple[Frame, float]], int]:
        """Return the frames that are certain now, with their arrivals, and how many were false."""
        held, self._held = self._held, None
        if self._last is not None and _continues(self._last, frame):
            self._last = frame
            return [(frame, arrival)], int(held is not None)
        if held is not None and _continues(held[0], frame):
            self._last = frame
            return [held, (frame, arrival)], 0
        self._held = frame, arrival
        return [], int(held is not None)


def _continues(before: Frame, frame: Frame) -> bool:
    elapsed = (frame.time - before.time) % CLOCK_MS
    if elapsed > GAP_MS:
        return False
    widths = [(each.end - each.start) % TURN / 100 for each in (before, frame)]
    if abs(widths[1] - widths[0]) > WIDTH_SLACK * max(widths) + SLACK_DEG:
        return False
    expected = (before.speed + frame.speed) / 2 * elapsed / 1000
    turned = (frame.start - before.start) / 100
    if elapsed == 0:  # a clock that stands still, as of a simulator: the angles tell
        expected = widths[0] * POINTS / (POINTS - 1)
    off = abs((turned - expected + 180.0) % 360.0 - 180.0)
    return off <= SLACK_DEG + SPEED_SLACK * expected + SLACK_MS / 1000 * frame.speed
