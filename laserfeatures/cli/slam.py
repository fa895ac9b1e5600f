"""``laserfeatures slam``: EKF-SLAM in simulation and on logs."""

import click

from laserfeatures.cli.slam_run import run
from laserfeatures.cli.slam_simulate import simulate


@click.group()
def slam() -> None:
    """Find the sensor's way and a map by EKF-SLAM on corners and walls.

    \b
    Examples:
      laserfeatures slam simulate
      laserfeatures slam run example:office --reference example:office -o found/
    """  # noqa: D301 - click's mark for lines to keep is a backspace


slam.add_command(run)
slam.add_command(simulate)
