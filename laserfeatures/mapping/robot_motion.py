"""How uncertain the odometry of the simulated robot is, from what its odometry does not know.

The robot's wheels, track and floor are drawn from known distributions (`Robot`), so that nothing
has to be tuned. What is drawn once for a drive makes errors that grow with the way itself, not with
its root as the filter's noise does. The noise is made as large as they are after the way on which
the filter goes by the same corners: that is when odometry alone has carried it.
"""

import math

from laserfeatures.simulation.robot import Robot
from laserfeatures.simulation.robot.body import PATCH
from laserfeatures.slam import Motion

CORRELATED = 2.0  # [m]; in the office loop, a corner in view stays so for 1.8 m in the median
CORRELATED_TURN = math.pi / 2  # [rad], from one corridor into the next


def motion_of(robot: Robot) -> Motion:
    """Return the noise of a robot's wheel odometry, with r, b and u for its errors.

    Let wheels L and R differ from what they are taken for by shares of deviation r
    (`radius_error`), the track T by a share of deviation b (`track_error`), and the rolling radius
    of each wheel on each 5 cm of floor by one of deviation u (`unevenness`). Then

    - along: r^2/2 of the mean radius; u^2 for the bumps, as they lengthen the way by about their
      deviation (0.5 % in drives, where the mean of their radii would give nothing);
    - turn by way: 2 r^2/T^2 of the difference of the radii, and 2 u^2 PATCH/T^2 for the bumps;
    - turn: b^2 of the track, r^2/2 of the mean radius; the wheels roll T/2 a radian, over bumps;
    - across: what the turn by way moves a sensor that sits ahead of the axle.

    Slip comes to a tenth of that in this robot's drives, and is left out.

    References
    ----------
    Borenstein and Feng, Measurement and Correction of Systematic Odometry Errors in Mobile Robots,
    IEEE Transactions on Robotics and Automation 12(6), 1996: which errors there are.
    """
    radius, track, bumps = robot.radius_error**2, robot.track_error**2, robot.unevenness**2
    patches = 2 * bumps * PATCH / robot.track**2  # turn of two wheels, after 1 m
    turn_by_way = math.sqrt(2 * radius / robot.track**2 * CORRELATED + patches)
    turn = math.sqrt((track + radius / 2) * CORRELATED_TURN + patches * robot.track / 2)
    return Motion(
        way=math.sqrt((radius / 2 + bumps) * CORRELATED),
        side=abs(robot.laser.x) * turn_by_way,
        turn_by_way=turn_by_way,
        turn=turn,
    )
