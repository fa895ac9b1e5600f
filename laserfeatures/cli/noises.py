"""The option --noise: whether the noise of the ranges settles over a log, or is each scan's own."""

from collections.abc import Callable, Iterable, Iterator
from typing import TYPE_CHECKING, TypeVar

import click

import laserfeatures as lf

if TYPE_CHECKING:
    from laserfeatures.noise_model import RangeNoise

Command = TypeVar("Command", bound=Callable[..., None])

LOG, SCAN = "log", "scan"

noise_option = click.option(
    "--noise",
    type=click.Choice([LOG, SCAN]),
    default=LOG,
    show_default=True,
    help="What tells the noise of a scan's ranges: the log, from its first scan up to this one, or "
    "the scan alone. Not where a range_sigma is given.",
)


class Noises:
    """The noise of each scan of a source, as --noise says.

    The model is fed with every scan from the first on, whichever are wanted: so what is found in a
    scan does not depend on --start and --count.
    """

    def __init__(self, choice: str) -> None:
        from laserfeatures.noise_model import NoiseModel  # noqa: PLC0415 - brings numba

        self._model = NoiseModel() if choice == LOG else None
        self.now: RangeNoise | None = None  # of the scan that `told` yielded last

    def told(self, scans: Iterable[lf.LaserScan]) -> Iterator[lf.LaserScan]:
        """Yield the scans; meanwhile `now` is the noise of each, None if it is to tell its own."""
        for scan in scans:
            if self._model:
                self.now = self._model.feed(scan)
            yield scan
