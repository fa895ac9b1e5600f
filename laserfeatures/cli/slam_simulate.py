"""``laserfeatures slam simulate``: the paper's Figs. 8 and 9, and many such drives."""

from importlib.resources import files
from typing import TYPE_CHECKING

import click

import laserfeatures as lf
from laserfeatures.cli import extractor as one
from laserfeatures.cli import values
from laserfeatures.cli.slam_options import slam_options
from laserfeatures.testbench.workers import core_count

if TYPE_CHECKING:
    from laserfeatures.slam import Motion

FOLDER = "slam-simulation"


@click.command()
@click.argument("plan", type=click.Path(), required=False)
@click.option(
    "-e",
    "--extractor",
    "names",
    metavar="NAME",
    multiple=True,
    shell_complete=one.complete_names,
    help="One of those that 'laserfeatures extractors' lists; may be repeated. Else "
    f"{one.DEFAULT}, or with --seeds all of them.",
)
@click.option(
    "-p",
    "--param",
    "params",
    metavar="NAME=VALUE",
    multiple=True,
    shell_complete=one.complete_assignments,
    help="Set a parameter of every extractor named, in SI units or with one of "
    f"{', '.join(values.UNITS)}: theta_step=1deg, preset=paper. May be repeated.",
)
@slam_options
@click.option(
    "--seed",
    type=click.IntRange(min=0),
    metavar="N",
    help="Of noise, wheels and floor; with --seeds of the first drive. Else the plan's, or 0.",
)
@click.option(
    "--seeds", type=click.IntRange(min=1), metavar="N", help="Drive so often, with as many seeds."
)
@click.option(
    "--workers",
    type=click.IntRange(min=1),
    default=core_count,
    show_default="number of cores",
    metavar="N",
    help="Worker processes for the seeds. What is found does not depend on it; times do.",
)
@click.option(
    "--json", "json_file", type=click.Path(), metavar="FILE", help="Write the figures as JSON."
)
@click.option(
    "-o",
    "--output",
    type=click.Path(file_okay=False),
    metavar="FOLDER",
    help="Where fig8.png and fig9.png of the first drive go; made if it is missing. Else "
    f"{FOLDER}, or with --seeds nowhere.",
)
def simulate(
    plan: str | None,
    names: tuple[str, ...],
    params: tuple[str, ...],
    landmarks: str,
    association: str,
    motion: "Motion | None",
    roughness: float | None,
    seed: int | None,
    seeds: int | None,
    workers: int,
    json_file: str | None,
    output: str | None,
) -> None:
    """Let a simulated robot find its way by the features of its scans.

    PLAN is a TOML file as 'laserfeatures simulate' takes it; else an office with a loop of 68 m.
    The robot drives along it, its wheels slip, and EKF-SLAM corrects its odometry by landmarks.
    The errors are printed, and drawn as in the paper: fig8.png is the map, with the true path,
    those by odometry and by SLAM, and the landmarks; fig9.png is the position's error over time.
    Pictures of several extractors have their names, as fig8_ransac.png. How uncertain the odometry
    is follows from what is known of the robot, unless --motion says else.

    \b
    Examples:
      laserfeatures slam simulate
      laserfeatures slam simulate office.toml -e ransac --landmarks both -o pictures
      laserfeatures slam simulate --seeds 30 --json slam.json
    """  # noqa: D301 - click's mark for lines to keep is a backspace
    # Imported here: they bring numba.
    from laserfeatures.cli.slam_simulated import simulate_all  # noqa: PLC0415
    from laserfeatures.mapping.robot_motion import motion_of  # noqa: PLC0415
    from laserfeatures.simulation.robot import Robot  # noqa: PLC0415

    if params and seeds and not names:
        raise click.UsageError("-p sets parameters of the extractors that -e names: name them")
    if len(set(names)) < len(names):
        raise click.UsageError(f"-e names {max(names, key=names.count)!r} twice")
    wanted = names or (lf.list_extractors() if seeds else (one.DEFAULT,))
    simulate_all(
        str(files("laserfeatures.simulation") / "office.toml") if plan is None else plan,
        {name: one.make(name, params) for name in wanted},
        landmarks=landmarks,
        association=association,
        motion=motion or motion_of(Robot()),
        roughness=roughness or 0.0,
        seed=seed,
        seeds=seeds,
        workers=workers,
        json_file=json_file,
        folder=output or (None if seeds else FOLDER),
    )
