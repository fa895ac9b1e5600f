"""``laserfeatures testbench``: the paper's tables and figures, run again."""

from collections.abc import Callable, Iterator, Sequence
from contextlib import ExitStack, contextmanager
from dataclasses import asdict, fields
from functools import partial
from pathlib import Path
from typing import IO, Any, TypeVar

import click

from laserfeatures import figures as drawing
from laserfeatures.cli.output import complete_file, made_folder
from laserfeatures.cli.scans import progress
from laserfeatures.cli.testbench_tables import print_page
from laserfeatures.testbench import neighborhoods, noise, pages, table1
from laserfeatures.testbench.output import to_json
from laserfeatures.testbench.pages import Page
from laserfeatures.testbench.workers import core_count

Command = TypeVar("Command", bound=Callable[..., None])

Part = tuple[list[Page], Any]  # and what of it goes into the JSON
Save = Callable[[Sequence[Page], Any], None]

BAR = partial(progress, to_stdout=False)

_OPTIONS = {
    "output": click.option(
        "-o",
        "--output",
        type=click.Path(file_okay=False),
        default="docs/testbench",
        show_default=True,
        metavar="FOLDER",
        help="Where Markdown, CSV and PNG go; made if it is missing.",
    ),
    "json": click.option(
        "--json", "json_file", type=click.Path(), metavar="FILE", help="Write the figures as JSON."
    ),
    "seed": click.option(
        "--seed", type=click.IntRange(min=0), metavar="N", help="Seed of the simulated scans."
    ),
    "scans": click.option(
        "--scans", type=click.IntRange(min=1), metavar="N", help="Number of simulated scans."
    ),
    "workers": click.option(
        "--workers",
        type=click.IntRange(min=1),
        default=core_count,
        show_default="number of cores",
        metavar="N",
        help="Worker processes. What is counted does not depend on it.",
    ),
    "data": click.option(
        "--data",
        type=click.Path(file_okay=False),
        default="../shared/data",
        show_default=True,
        metavar="FOLDER",
        help="The recordings of real scans.",
    ),
}


def _options(*names: str) -> Callable[[Command], Command]:
    def give(command: Command) -> Command:
        for name in reversed(names):
            command = _OPTIONS[name](command)
        return command

    return give


@click.group()
def testbench() -> None:
    """Run the paper's tables and figures again, and score every extractor.

    Simulated scans with known truth go through the paper's literal algorithm with the parameters of
    its tables, through every extractor with its defaults, and through an oracle that knows which
    beam measures which wall. Pages, plain figures and pictures go to a folder, all of them or none.

    \b
    Examples:
      laserfeatures testbench table1 --json table1.json
      laserfeatures testbench all --workers 2
    """  # noqa: D301 - click's mark for lines to keep is a backspace


@testbench.command("table1")
@_options("output", "json", "seed", "scans", "workers")
def table1_command(
    output: str, json_file: str | None, seed: int | None, scans: int | None, workers: int
) -> None:
    """Run Table I again: 250 simulated scans, all 18 rows.

    Then the same scans with the defaults of every extractor, and the oracle. The times are taken
    at the end, in one process, while no worker runs. In the JSON theta_step is in degrees,
    distance_step in centimetres, and neighborhood cells along theta and along d, as in the paper.
    """
    with _saved(output, json_file) as save:
        save(*_table1(seed, scans, workers))


@testbench.command("table2")
@_options("output", "json", "data", "workers")
def table2_command(output: str, json_file: str | None, data: str, workers: int) -> None:
    """Run Table II again, on real scans with known corners.

    All six rows, then the defaults of every extractor and the oracle, on the scans of an arena with
    known corners and of logs with corrected poses; blind scans of all recordings.
    """
    with _saved(output, json_file) as save:
        drawing.new_figure()  # says now if there is no matplotlib
        save(*_table2(data, workers))


@testbench.command("noise")
@_options("output", "json", "seed", "scans", "workers")
def noise_command(
    output: str, json_file: str | None, seed: int | None, scans: int | None, workers: int
) -> None:
    """Score every extractor over noise, beams and outliers.

    Standard deviations of a range from 0 to 50 mm, 91 to 1081 beams in 180 degrees, and 0 to 20 %
    of beams that show anything; --scans is the number for each setting, else 100.
    """
    with _saved(output, json_file) as save:
        drawing.new_figure()  # says now if there is no matplotlib
        save(*_noise(seed, scans, workers))


@testbench.command("figures")
@_options("output", "json", "seed")
def figures_command(output: str, json_file: str | None, seed: int | None) -> None:
    """Draw the figures 6 and 7 again: one scan each at three sizes of the neighbourhood."""
    with _saved(output, json_file) as save:
        save(*_figures(seed))


@testbench.command("all")
@_options("output", "json", "seed", "scans", "data", "workers")
def all_command(
    output: str,
    json_file: str | None,
    seed: int | None,
    scans: int | None,
    data: str,
    workers: int,
) -> None:
    """Run all of them; the JSON has a part for each.

    Where the folder of recordings is missing, Table II is left out.
    """
    with _saved(output, json_file) as save:
        drawing.new_figure()  # says now if there is no matplotlib
        parts = {
            "table1": _table1(seed, scans, workers),
            "figures": _figures(seed),
            "noise": _noise(seed, scans, workers),
        }
        if Path(data).is_dir():
            parts["table2"] = _table2(data, workers)
        else:
            click.echo(f"laserfeatures: there is no folder {data}: no Table II (--data)", err=True)
        made = [page for pages_of_part, _ in parts.values() for page in pages_of_part]
        save(made, {name: value for name, (_, value) in parts.items()})


def _table1(seed: int | None, scans: int | None, workers: int) -> Part:
    result = table1.run(**_given(seed=seed, scans=scans), workers=workers, progress=BAR)
    keys = ("real_lines", "real_features", "rows", "defaults")
    return [pages.table1_page(result)], {key: getattr(result, key) for key in keys}


def _table2(data: str, workers: int) -> Part:
    # Imported here: they bring all the readers.
    from laserfeatures.testbench import table2  # noqa: PLC0415
    from laserfeatures.testbench.table2_page import table2_page  # noqa: PLC0415

    result = table2.run(Path(data), workers=workers, progress=BAR)
    kept = {item.name: getattr(result, item.name) for item in fields(result) if item.name != "maps"}
    return [table2_page(result)], kept


def _noise(seed: int | None, scans: int | None, workers: int) -> Part:
    result = noise.run(**_given(seed=seed, scans=scans), workers=workers, progress=BAR)
    return [pages.noise_page(result)], asdict(result)


def _figures(seed: int | None) -> Part:
    panels = neighborhoods.run(**_given(seed=seed))
    return [pages.figures_page(panels)], {"panels": [panel.counts for panel in panels]}


def _given(**options: int | None) -> dict[str, Any]:
    """Return the options that were given: the others have defaults where they are used."""
    return {name: value for name, value in options.items() if value is not None}


@contextmanager
def _saved(folder: str, json_file: str | None) -> Iterator[Save]:
    """Yield what saves pages and figures; nothing has its name before all is written."""
    with made_folder(folder), ExitStack() as files:
        json_out = files.enter_context(complete_file(json_file)) if json_file else None

        def save(made: Sequence[Page], value: Any) -> None:
            contents = {name: data for page in made for name, data in page.files.items()}
            for name, data in contents.items():
                path = str(Path(folder, name))
                _write(files.enter_context(complete_file(path, binary=True)), data)
            if json_out:
                _write(json_out, to_json(value))
            for page in made:
                print_page(page)

        yield save
    click.echo(f"The pages, figures and pictures are in {folder}")


def _write(file: IO[Any], content: str | bytes) -> None:
    file.write(content)
    file.flush()  # a full disk shows while nothing has its name yet
