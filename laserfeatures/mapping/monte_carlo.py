"""The same drive for every extractor, and as many drives as there are seeds."""

import io
from collections.abc import Callable, Mapping
from dataclasses import dataclass

from laserfeatures import figures
from laserfeatures.data import Features, LaserScan
from laserfeatures.mapping.drive_pictures import drive_figure, error_figure
from laserfeatures.mapping.drive_score import DriveScore, score_drive
from laserfeatures.mapping.run import Run
from laserfeatures.mapping.simulated_drive import Blamed, SimulatedDrive
from laserfeatures.slam import EkfSlam
from laserfeatures.sources.simulated import readings_of

PICTURES = {"fig8": drive_figure, "fig9": error_figure}


@dataclass(frozen=True, eq=False, kw_only=True)
class Outcome:
    """What came of a drive.

    Parameters
    ----------
    seed : int
        Its seed.
    scores : dict of str to DriveScore
        By the extractors' names.
    pictures : dict of str to dict of str to bytes
        By the extractors' names, PNGs by the names of the paper's figures; empty if none are drawn.
    """

    seed: int
    scores: dict[str, DriveScore]
    pictures: dict[str, dict[str, bytes]]


@dataclass(frozen=True, eq=False, kw_only=True)
class Trial:
    """SLAM with some extractors on the drive of a plan; called with the drive's seed.

    Drives of several seeds are independent, and may be spread over processes.

    Parameters
    ----------
    plan : str
        The plan's file.
    extractors : mapping of str to callable
        By name.
    slam : callable
        Makes a new filter.
    drawn : int, optional
        The seed of the drive to draw.
    title : str
        What the pictures are called, after the extractor.
    """

    plan: str
    extractors: Mapping[str, Callable[[LaserScan], Features]]
    slam: Callable[[], EkfSlam]
    drawn: int | None = None
    title: str = ""

    def __call__(self, seed: int) -> Outcome:
        """Drive, and run every extractor on it.

        Raises
        ------
        SourceError
            If the plan cannot be read or driven.
        PluginError
            If an extractor fails.
        MissingDependencyError
            If mujoco or evo is not installed, or matplotlib to draw with.
        """
        drive = SimulatedDrive.of(list(readings_of(self.plan, seed=seed)))
        scores, pictures = {}, {}
        for name, extractor in self.extractors.items():
            Blamed(extractor)(drive.readings[0].scan)  # a step's time is not the compiler's
            run = drive.run(extractor, self.slam())
            scores[name] = score_drive(run, drive)
            if seed == self.drawn:
                pictures[name] = _drawn(run, drive, f"{name}, {self.title}")
        return Outcome(seed=seed, scores=scores, pictures=pictures)


def _drawn(run: Run, drive: SimulatedDrive, title: str) -> dict[str, bytes]:
    pngs = {}
    for name, draw in PICTURES.items():
        file = io.BytesIO()
        figures.save(draw(run, drive, title), file, "png")
        pngs[name] = file.getvalue()
    return pngs
