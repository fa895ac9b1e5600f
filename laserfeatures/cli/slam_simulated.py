"""What ``laserfeatures slam simulate`` does: it drives, tells and saves."""

import textwrap
from collections.abc import Callable, Iterator, Mapping, Sequence
from contextlib import ExitStack, contextmanager
from dataclasses import asdict
from functools import partial
from pathlib import Path
from typing import TYPE_CHECKING, Any

import click

from laserfeatures import figures as drawing
from laserfeatures.cli.output import complete_file, made_folder
from laserfeatures.cli.scans import progress
from laserfeatures.cli.slam_options import make_slam
from laserfeatures.cli.slam_simulate_table import LEGEND, table_of
from laserfeatures.cli.testbench_tables import print_page
from laserfeatures.comparison.document import Document
from laserfeatures.mapping.drive_score import NEES_BAND
from laserfeatures.mapping.drive_summary import figures, summary
from laserfeatures.mapping.landmark_score import SPURIOUS
from laserfeatures.mapping.monte_carlo import PICTURES, Outcome, Trial
from laserfeatures.optional import optional
from laserfeatures.simulation import read_plan
from laserfeatures.simulation.robot import Robot
from laserfeatures.slam import Motion
from laserfeatures.testbench.output import to_json
from laserfeatures.testbench.pages import Page
from laserfeatures.testbench.workers import in_parallel

if TYPE_CHECKING:
    from laserfeatures.pipeline import Pipeline

Save = Callable[[str, bytes], None]

WIDTH = 100  # columns


def simulate_all(
    plan: str,
    extractors: "Mapping[str, Pipeline]",
    *,
    landmarks: str,
    association: str,
    motion: Motion,
    roughness: float,
    seed: int | None,
    seeds: int | None,
    workers: int,
    json_file: str | None,
    folder: str | None,
) -> None:
    """Drive, print the table, and save what was asked for; parameters as the command's options."""
    numbers = _seeds(plan, seed, seeds)
    # What is not installed is said now, before minutes of work.
    optional("mujoco", "driving a robot needs mujoco", "sim")
    optional("evo.core.metrics", "errors of trajectories need evo", "slam")
    about = f"{Path(plan).name}, landmarks: {landmarks}, association: {association}"
    trial = Trial(
        plan=plan,
        extractors=extractors,
        slam=partial(make_slam, landmarks, association, motion, roughness),
        drawn=numbers[0] if folder else None,
        title=f"landmarks: {landmarks}, seed {numbers[0]}",
    )
    pictures = _picture_paths(folder, list(extractors)) if folder else {}
    paths = [*pictures.values(), *([json_file] if json_file else [])]
    with _saved(folder, paths, plan) as save:
        bar = partial(progress, to_stdout=False)
        outcomes = in_parallel(trial, numbers, workers=workers, progress=bar, label="drives")
        for (name, figure), path in pictures.items():
            save(path, outcomes[0].pictures[name][figure])
        if json_file:
            facts = {
                "plan": Path(plan).name,
                "landmarks": landmarks,
                "association": association,
                "roughness": roughness,
                "motion": asdict(motion),
            }
            save(json_file, to_json(facts | document_of(outcomes)).encode())
    _print(outcomes, f"{about}, {len(numbers)} drive{'s' * (len(numbers) > 1)}")
    if folder:
        click.echo(f"The pictures are in {folder}")


def summaries_of(outcomes: Sequence[Outcome]) -> dict[str, dict[str, Any]]:
    """Return the summary of each extractor's drives, by its name."""
    return {
        name: summary([outcome.scores[name] for outcome in outcomes]) for name in outcomes[0].scores
    }


def document_of(outcomes: Sequence[Outcome]) -> dict[str, Any]:
    """Return all figures, in metres but where their names say else, as they go into JSON."""
    return {
        "robot": asdict(Robot()),
        "nees_band": NEES_BAND,
        "spurious_from": SPURIOUS,
        "seeds": [outcome.seed for outcome in outcomes],
        "summary": [{"extractor": name} | row for name, row in summaries_of(outcomes).items()],
        "drives": [
            {"extractor": name, "seed": outcome.seed} | figures(score)
            for outcome in outcomes
            for name, score in outcome.scores.items()
        ],
    }


def _seeds(plan: str, seed: int | None, seeds: int | None) -> list[int]:
    if seeds is not None:
        first = seed or 0
        return list(range(first, first + seeds))
    drive = read_plan(plan).drive  # a plan without one is told of by who drives
    return [seed if seed is not None else drive.seed if drive else 0]


def _picture_paths(folder: str, extractors: Sequence[str]) -> dict[tuple[str, str], str]:
    """Return the file of each extractor's figures; one alone needs no name there."""
    several = len(extractors) > 1
    return {
        (name, figure): str(Path(folder, f"{figure}_{name}.png" if several else f"{figure}.png"))
        for name in extractors
        for figure in PICTURES
    }


@contextmanager
def _saved(folder: str | None, paths: Sequence[str], plan: str) -> Iterator[Save]:
    """Yield what writes to files; none of them has its name before all are written."""
    with ExitStack() as stack:
        if folder:
            drawing.new_figure()  # says now if there is no matplotlib
            stack.enter_context(made_folder(folder))
        files = {
            path: stack.enter_context(complete_file(path, plan, binary=True)) for path in paths
        }

        def save(path: str, content: bytes) -> None:
            files[path].write(content)
            files[path].flush()  # a full disk shows while nothing has its name yet

        yield save


def _print(outcomes: Sequence[Outcome], title: str) -> None:
    document = Document(title, [table_of(summaries_of(outcomes))])
    print_page(Page("simulate", document, {}))
    click.echo(textwrap.fill(LEGEND, WIDTH))
