"""What ``laserfeatures slam run`` does: it reads, runs the filter, tells and saves."""

from collections.abc import Callable, Iterator, Mapping
from contextlib import ExitStack, contextmanager, suppress
from dataclasses import asdict, replace
from pathlib import Path, PurePath
from typing import IO, TYPE_CHECKING, Any, NamedTuple

import click
import numpy as np

import laserfeatures as lf
from laserfeatures import figures
from laserfeatures.cli import extractor as extractors
from laserfeatures.cli.noises import Noises
from laserfeatures.cli.output import complete_file, made_folder
from laserfeatures.cli.scans import opened, progress, select
from laserfeatures.cli.slam_table import print_summary
from laserfeatures.mapping.against import Against, against
from laserfeatures.mapping.checks import oddities, together
from laserfeatures.mapping.map_file import map_json
from laserfeatures.mapping.map_picture import map_figure
from laserfeatures.mapping.matching import Matched, matched
from laserfeatures.mapping.measures import errors
from laserfeatures.mapping.reference import Reference, read_reference
from laserfeatures.mapping.run import Recorder, Run
from laserfeatures.mapping.summary import summary
from laserfeatures.mapping.trajectory import Trajectory
from laserfeatures.mapping.tum import write_tum
from laserfeatures.optional import optional
from laserfeatures.slam import EkfSlam, Step
from laserfeatures.testbench.output import to_json

if TYPE_CHECKING:
    from laserfeatures.noise_model import RangeNoise
    from laserfeatures.pipeline import Pipeline

HINTS = {
    "none": "SLAM needs the robot's odometry",
    "corrected": "a SLAM program made them: run on the log that it was given, and give this one as "
    "--reference",
}
FILES = ("trajectory.txt", "odometry.txt", "map.json", "map.png")
WARM_UP = 5  # scans
TOLD = 10  # notices on the terminal

Save = Callable[[Run, Against | None, Mapping[str, Any]], None]


class Posed(NamedTuple):
    """A scan, its number in the log, where the sensor was by odometry, and the ranges' noise."""

    number: int
    scan: lf.LaserScan
    odometry: lf.Pose2D
    noise: "RangeNoise | None"


def run(
    source: str,
    pipeline: "Pipeline",
    slam: EkfSlam,
    *,
    noise: str,
    start: int,
    count: int | None,
    reference_file: str | None,
    folder: str | None,
    json_file: str | None,
    reading: Mapping[str, Any],
    facts: Mapping[str, Any],
) -> None:
    """Run the filter over a log; parameters as the command's options.

    `facts` are for the summary: "extractor" and "slam" are to be among them.

    Raises
    ------
    LaserFeaturesError, click.ClickException
        If something is wrong with the log, the reference, the extractor or the files to write.
    """
    _refuse_twice(folder, json_file, reference_file)
    if reference_file:  # said now, before the log is read
        optional("evo.core.metrics", "errors of trajectories need evo", "slam")
    with _saved(folder, json_file, source) as save:
        reference = read_reference(reference_file) if reference_file else None
        scans, format_, notices = _read(source, start, count, noise, **reading)
        pairs = _pairs(scans, reference) if reference else None
        found, said = _run(pipeline, slam, scans)
        notices += [*oddities(found.odometry, [each.number for each in scans]), *said]
        held = against(found, reference, pairs) if reference and pairs else None
        about = {"source": PurePath(source).name, "format": format_, **facts}
        about["reference"] = PurePath(reference_file).name if reference_file else None
        about["motion"] = asdict(slam.motion)
        document = summary(found, held, notices, **about)
        save(found, held, document)
        _tell(notices)
        print_summary(document)
    if folder:
        click.echo(f"\nThe trajectories, the map and its picture are in {folder}")


def _read(
    source: str, start: int, count: int | None, noise: str, **reading: Any
) -> tuple[list[Posed], str, list[str]]:
    """Return the scans that have odometry, the format, and what is odd about the others.

    Raises
    ------
    SourceError
        If there is none, or the log cannot be read.
    """
    noises = Noises(noise)
    with (
        _hinted(source, reading),
        opened(source, poses="odometry", **reading) as log,
        progress(
            select(noises.told(log), source, start, count), length=count, to_stdout=False
        ) as selected,
    ):
        every = [(number, scan, noises.now) for number, scan in selected]
        scans = [Posed(number, scan, scan.pose, now) for number, scan, now in every if scan.pose]
        if not scans:
            raise lf.SourceError(f"{source}: expected scans with odometry, got none with a pose")
        lost = len(every) - len(scans)
        notices = [f"{lost} of {len(every)} scans have no odometry: they are left out"]
        return scans, log.format, notices if lost else []


@contextmanager
def _hinted(source: str, reading: Mapping[str, Any]) -> Iterator[None]:
    """Say how to go on where a log can be read but has the wrong poses."""
    try:
        yield
    except lf.SourceError as error:
        hint = None
        if Path(source).exists():
            with suppress(lf.LaserFeaturesError), lf.open_source(source, **reading) as log:
                hint = HINTS.get(log.poses)
        if hint is None:
            raise
        raise lf.SourceError(f"{error}; {hint}") from error


def _pairs(scans: list[Posed], reference: Reference) -> Matched:
    """Return which scans have which poses of a reference.

    Raises
    ------
    SourceError
        If they do not fit, or leave nothing to measure: before SLAM has taken its time.
    """
    odometry = Trajectory.of([each.scan.stamp for each in scans], [each.odometry for each in scans])
    pairs = matched(odometry, reference)
    try:
        errors(*pairs.pairs(odometry, reference.trajectory))
    except ValueError as error:
        raise lf.SourceError(f"{reference.path}: as a reference, {error}") from error
    return pairs


def _run(pipeline: "Pipeline", slam: EkfSlam, scans: list[Posed]) -> tuple[Run, list[str]]:
    """Return what SLAM makes of the scans, and what it says of itself on the way."""
    known = {id(each.scan): each for each in scans}

    def extract(scan: lf.LaserScan) -> lf.Features:
        each = known[id(scan)]
        with extractors.blamed(pipeline, each.number):
            return pipeline(scan, noise=each.noise)

    start = scans[0].odometry
    warm, recorder = Recorder(extract, replace(slam)), Recorder(extract, slam)
    for each in scans[:WARM_UP]:  # what is compiled here is not in the times
        _stepped(warm, each, start)
    said = []
    with progress(scans, length=len(scans), to_stdout=False) as bar:
        for each in bar:
            step = _stepped(recorder, each, start)
            if step.notice:
                said.append((each.number, step.notice))
            if not np.isfinite(step.covariance).all():
                raise click.ClickException(
                    f"scan {each.number}: the filter's numbers are no longer finite; try larger "
                    "deviations of the odometry (--motion)"
                )
    return recorder.run(), together(said)


def _stepped(recorder: Recorder, each: Posed, start: lf.Pose2D) -> Step:
    try:
        return recorder.add(each.scan, each.odometry, start)
    except ValueError as error:
        raise lf.SourceError(f"scan {each.number}: {error}") from error


def _tell(notices: list[str]) -> None:
    for notice in notices[:TOLD]:
        click.echo(f"laserfeatures: {notice}", err=True)
    if len(notices) > TOLD:
        rest = len(notices) - TOLD
        click.echo(f"laserfeatures: and {rest} more such notices (--json FILE has all)", err=True)


def _refuse_twice(folder: str | None, json_file: str | None, reference_file: str | None) -> None:
    """Refuse to write a file twice, or over the reference."""
    paths = [str(Path(folder, name)) for name in FILES] if folder else []
    paths += [json_file] if json_file else []
    taken = {Path(reference_file).resolve()} if reference_file else set()
    for path in paths:
        if Path(path).resolve() in taken:
            raise click.UsageError(f"{path} would overwrite another file of this run: rename it")
        taken.add(Path(path).resolve())


@contextmanager
def _saved(folder: str | None, json_file: str | None, source: str) -> Iterator[Save]:
    """Yield what writes all files; none has its name before the block ends, and all went well."""
    with ExitStack() as stack:
        paths = [str(Path(folder, name)) for name in FILES] if folder else []
        if folder:
            figures.new_figure()  # says now if there is no matplotlib
            stack.enter_context(made_folder(folder))
        files = [
            stack.enter_context(complete_file(path, source, binary=path.endswith(".png")))
            for path in paths
        ]
        json_out = stack.enter_context(complete_file(json_file, source)) if json_file else None

        def save(run: Run, held: Against | None, document: Mapping[str, Any]) -> None:
            if folder:
                title = "{source}, {extractor}: {landmarks} landmarks".format(**document)
                _write(files, run, held, title)
            if json_out:
                json_out.write(to_json(document))
            for file in [*files, *([json_out] if json_out else [])]:
                file.flush()  # a full disk shows while nothing has its name yet

        yield save


def _write(files: list[IO[Any]], run: Run, held: Against | None, title: str) -> None:
    trajectory, odometry, landmarks, picture = files
    write_tum(trajectory, run.estimate)
    write_tum(odometry, run.odometry)
    landmarks.write(map_json(run.map))
    figures.save(map_figure(run, held.way if held else None, title), picture, "png")
