"""``laserfeatures warm-up``: what the first use compiles, compiled ahead of it."""

import time
from collections.abc import Callable, Iterator
from functools import partial

import click
import numpy as np

import laserfeatures as lf
from laserfeatures.cli.extractor import DEFAULT, blamed, complete_names, make
from laserfeatures.cli.group import NAME
from laserfeatures.cli.parameters import PRESET, presets_of
from laserfeatures.registry import find_factory
from laserfeatures.simulation import Scanner, hallway

SCANS = 4


@click.command("warm-up")
@click.argument("extractors", nargs=-1, metavar="[EXTRACTOR]...", shell_complete=complete_names)
def warm_up(extractors: tuple[str, ...]) -> None:
    """Compile what EXTRACTORs need, so that their first scan is as fast as the others.

    Without a name, all of them and SLAM are compiled, which takes a few minutes; what is compiled
    already takes a moment. Compiled code is kept in the folder NUMBA_CACHE_DIR, else in the user's
    folder for caches; it is for one kind of processor and one version of this package.

    \b
    Examples:
      laserfeatures warm-up
      laserfeatures warm-up direct_hough split_and_merge
      NUMBA_CACHE_DIR=/opt/laserfeatures-cache laserfeatures warm-up
    In an image, make that variable one of the image's, and let all users read the folder; with
    NUMBA_CPU_NAME=generic it is for all processors, and the code a little slower.
    """  # noqa: D301 - click's mark for lines to keep is a backspace
    works: list[Callable[[], None]]
    works = [partial(_extract, name) for name in extractors or lf.list_extractors()]
    names = list(extractors or lf.list_extractors())
    if not extractors:
        works.append(_map)
        names.append("SLAM")
    for name, work in zip(names, works, strict=True):
        began = time.perf_counter()
        try:
            work()
        except lf.LaserFeaturesError as error:
            if extractors:
                raise
            click.echo(f"{NAME}: {name} is left out: {error}", err=True)  # a third party's
        else:
            click.echo(f"{name:<20} {time.perf_counter() - began:6.1f} s")


def _scans() -> Iterator[tuple[lf.LaserScan, lf.Pose2D]]:
    world, path = hallway()
    rng = np.random.default_rng(0)
    for pose in path[:SCANS]:
        yield Scanner().scan(world, pose, rng), pose


def _extract(name: str) -> None:
    """Run an extractor and its presets, told the noise and not."""
    from laserfeatures.noise_model import NoiseModel  # noqa: PLC0415 - brings numba

    model = NoiseModel()
    for preset in ("", *presets_of(find_factory(name))):
        pipeline = make(name, (f"{PRESET}={preset}",) if preset else ())
        for index, (scan, _) in enumerate(_scans()):
            with blamed(pipeline, index):
                pipeline(scan)
                pipeline(scan, noise=model.feed(scan))


def _map() -> None:
    """Run SLAM, at first with an odometry that stands still."""
    from laserfeatures.slam import EkfSlam  # noqa: PLC0415 - brings numba

    slam, extractor = EkfSlam(), lf.get_extractor(DEFAULT)
    for scan, pose in _scans():
        slam.step(pose, extractor(scan))
