"""Odometry of two driven wheels: from what their encoders have counted to poses."""

import bisect
import math
from dataclasses import dataclass, field

from laserfeatures.poses import compose
from laserfeatures.scan import Pose2D

FASTEST = 3.0  # [m/s]; no wheel of a robot in a house is faster
SLACK = 0.5  # [m] beyond that, for stamps that are not quite the encoders'
CAUSE = "the counter was reset or has wrapped, or the record is damaged"


def arc(left: float, right: float, track: float) -> Pose2D:
    """Return the step of a robot whose wheels have rolled evenly, which makes its way an arc.

    Parameters
    ----------
    left, right : float
        How far each wheel has rolled [m].
    track : float
        Distance between the wheels [m].

    Returns
    -------
    Pose2D
        In the frame of the axle's middle before the step.

    References
    ----------
    Borenstein and Feng, Measurement and Correction of Systematic Odometry Errors in Mobile Robots,
    IEEE Transactions on Robotics and Automation 12(6), 1996.
    """
    turn = (right - left) / track
    way = (left + right) / 2
    chord = way * math.sin(turn / 2) / (turn / 2) if turn else way
    return Pose2D(chord * math.cos(turn / 2), chord * math.sin(turn / 2), turn)


@dataclass(frozen=True, kw_only=True)
class Wheels:
    """What must be known of a robot to make poses of its ticks.

    Parameters
    ----------
    tick : float
        How far a wheel rolls in one tick [m].
    track : float
        Distance between the wheels [m].
    ahead : float
        How far the sensor is ahead of the axle [m].
    latency : float
        How much later than the encoders' counts a scan of the same moment is stamped [s].
    """

    tick: float
    track: float
    ahead: float
    latency: float = 0.0


@dataclass
class WheelOdometry:
    """The way of a sensor by the ticks of two wheels, as they come.

    Parameters
    ----------
    wheels : Wheels
        The robot's.
    start : Pose2D
        Where the sensor is at the first count.
    keep : float
        How long a count is remembered [s]: poses are known as far back.
    """

    wheels: Wheels
    start: Pose2D = field(default_factory=lambda: Pose2D(0.0, 0.0, 0.0))
    keep: float = math.inf
    _times: list[float] = field(default_factory=list, init=False)
    _axles: list[Pose2D] = field(default_factory=list, init=False)
    _rolled: list[tuple[float, float]] = field(default_factory=list, init=False)  # [m], since then
    _ticks: tuple[float, float] = field(default=(0.0, 0.0), init=False)

    def add(self, time: float, left: float, right: float) -> None:
        """Take in what the encoders have counted at a time [s].

        A time before the last one starts the clock anew; the way goes on from where it was, and if
        the counts jump there too, they start anew as well.

        Raises
        ------
        ValueError
            If a count is not finite, or farther from the last one than a wheel can have rolled.
            Of such a jump the way is not known: it goes on from the new counts.
        """
        if not (math.isfinite(left) and math.isfinite(right) and math.isfinite(time)):
            raise ValueError(f"expected finite ticks and time, got {left}, {right} at {time} s")
        before, self._ticks = self._ticks, (left, right)
        if not self._times:
            self._times.append(time)
            self._axles.append(compose(self.start, Pose2D(-self.wheels.ahead, 0.0, 0.0)))
            return
        seconds = time - self._times[-1]
        most = SLACK + FASTEST * max(seconds, 0.0)
        jump = _jump(before, self._ticks, most / self.wheels.tick)
        rolled = (left - before[0]) * self.wheels.tick, (right - before[1]) * self.wheels.tick
        if jump:
            rolled = 0.0, 0.0
        axle = compose(self._axles[-1], arc(*rolled, self.wheels.track))
        if seconds < 0:
            self._times, self._axles, self._rolled = [time], [axle], []
        else:
            self._times.append(time)
            self._axles.append(axle)
            self._rolled.append(rolled)
            if jump:
                raise ValueError(f"{jump} within {seconds:.3g} s: {CAUSE}")
            while self._rolled and self._times[1] <= time - self.keep:
                for history in (self._times, self._axles, self._rolled):
                    del history[0]

    def at(self, time: float) -> Pose2D:
        """Return the pose of the sensor in a scan with this stamp [s].

        Between two counts the wheels turn evenly; before the first and after the last they stand.

        Raises
        ------
        ValueError
            If nothing was counted yet.
        """
        if not self._times:
            raise ValueError("expected ticks before the first pose, got none")
        time -= self.wheels.latency
        i = max(bisect.bisect_right(self._times, time) - 1, 0)
        axle = self._axles[i]
        if i < len(self._rolled) and time > self._times[i]:
            share = (time - self._times[i]) / (self._times[i + 1] - self._times[i])
            left, right = self._rolled[i]
            axle = compose(axle, arc(share * left, share * right, self.wheels.track))
        return compose(axle, Pose2D(self.wheels.ahead, 0.0, 0.0))

    @property
    def end(self) -> float:
        """Time of the last count [s]; -inf before the first."""
        return self._times[-1] if self._times else -math.inf


def _jump(before: tuple[float, float], after: tuple[float, float], most: float) -> str | None:
    """Return what is wrong with two counts that are more than `most` apart."""
    for side, then, now in zip(("left", "right"), before, after, strict=True):
        if abs(now - then) > most:
            return (
                f"expected at most {most:.0f} more or fewer ticks of the {side} wheel, "
                f"got {now - then:.0f} (from {then:.0f} to {now:.0f})"
            )
    return None
