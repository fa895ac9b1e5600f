"""``laserfeatures slam run``: EKF-SLAM on a log."""

from typing import TYPE_CHECKING, Any

import click

from laserfeatures.cli import extractor as extractors
from laserfeatures.cli.noises import noise_option
from laserfeatures.cli.scans import source_options
from laserfeatures.cli.slam_options import make_slam, slam_options

if TYPE_CHECKING:
    from laserfeatures.slam import Motion


@click.command()
@source_options
@extractors.extractor_options
@noise_option
@slam_options
@click.option(
    "--start", type=click.IntRange(min=0), default=0, metavar="N", help="First scan, from 0."
)
@click.option("--count", type=click.IntRange(min=1), metavar="N", help="How many scans; else all.")
@click.option(
    "--reference",
    "reference_file",
    type=click.Path(),
    metavar="FILE",
    help="Poses to hold it against: a log with corrected poses, or a TUM file.",
)
@click.option(
    "-o",
    "--output",
    type=click.Path(file_okay=False),
    metavar="FOLDER",
    help="Where trajectory.txt, odometry.txt, map.json and map.png go; made if it is missing.",
)
@click.option("--json", "json_file", type=click.Path(), metavar="FILE", help="Write the summary.")
def run(
    source: str,
    extractor: str,
    params: tuple[str, ...],
    noise: str,
    landmarks: str,
    association: str,
    motion: "Motion | None",
    roughness: float | None,
    start: int,
    count: int | None,
    reference_file: str | None,
    output: str | None,
    json_file: str | None,
    **reading: Any,
) -> None:
    """Map the world of SOURCE and follow the sensor through it, by odometry and features.

    SOURCE is a log whose poses are raw odometry. The frame is that of the odometry, with which the
    first pose agrees. The folder gets the poses by SLAM and by odometry as TUM trajectories, the
    map as JSON, and as a picture over all scans; all of them or none. With a reference come the
    errors that evo finds.

    \b
    Examples:
      laserfeatures slam run example:office --reference example:office -o found/
      laserfeatures slam run raw.gfs.gz --reference corrected.log.gz --json summary.json
      laserfeatures slam run office.toml -e split_and_merge --landmarks walls
      laserfeatures slam run run.log.gz --motion way=0.1,turn=3deg -o found/
    """  # noqa: D301 - click's mark for lines to keep is a backspace
    from laserfeatures.cli import slam_log  # noqa: PLC0415 - brings numba, and all the readers

    slam_log.run(
        source,
        extractors.make(extractor, params),
        make_slam(landmarks, association, motion, roughness),
        noise=noise,
        start=start,
        count=count,
        reference_file=reference_file,
        folder=output,
        json_file=json_file,
        reading=reading,
        facts={
            "extractor": extractor,
            "extractor_parameters": list(params),
            "landmark_kinds": landmarks,
            "association": association,
            "noise": noise,
        },
    )
