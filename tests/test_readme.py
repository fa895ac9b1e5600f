"""The README and the pages of docs do what they say."""

import re
import shlex
import sys
import tomllib
from pathlib import Path
from types import ModuleType

import pytest
from click.testing import CliRunner

import laserfeatures as lf
from laserfeatures.cli import main

ROOT = Path(__file__).parents[1]
README = (ROOT / "README.md").read_text()
PLUGIN_PAGE = (ROOT / "docs/writing-a-plugin.md").read_text()


def blocks(page, language):
    return re.findall(rf"```{language}\n(.*?)```", page, re.DOTALL)


def test_the_readmes_python_prints_corners(capsys):
    (code,) = blocks(README, "python")
    exec(compile(code, "README.md", "exec"), {})  # noqa: S102 - our own page
    printed = capsys.readouterr().out
    assert re.search(r"^real corner at \d+\.\d\d m, -?\d+\.\d\d m$", printed, re.MULTILINE)


def test_the_readmes_table_names_every_extractor():
    named = set(re.findall(r"^\| `(\w+)`", README, re.MULTILINE))
    assert named == set(lf.list_extractors())


@pytest.mark.parametrize(
    "line", [line for block in blocks(README, "sh") for line in block.splitlines()]
)
def test_the_readmes_commands_parse(line):
    if not line.startswith("laserfeatures "):
        assert "pip install" in line
        return
    command, *arguments = shlex.split(line)[1:]
    context = main.make_context("laserfeatures", [command])
    subcommand = main.get_command(context, command)
    assert subcommand is not None
    subcommand.make_context(command, arguments)


@pytest.mark.parametrize("page", [*ROOT.glob("*.md"), *ROOT.glob("docs/*.md")], ids=str)
def test_links_lead_to_files(page):
    for link in re.findall(r"\]\((?!https?:)([^)#]+)\)", page.read_text()):
        assert (page.parent / link).exists(), f"{page.name} links to {link}"


def test_every_extra_that_the_readme_names_exists():
    project = tomllib.loads((ROOT / "pyproject.toml").read_text())["project"]
    named = re.search(r"Extras: (.*?)all of them", README, re.DOTALL).group(1)
    assert set(re.findall(r"`(\w+)`", named)) == set(project["optional-dependencies"])


def test_the_plugin_page_takes_a_reader_there(monkeypatch):
    detector, trial = blocks(PLUGIN_PAGE, "python")
    monkeypatch.setattr("laserfeatures.registry._registered", {})
    names = {"__name__": "one_wall"}
    monkeypatch.setitem(sys.modules, "one_wall", ModuleType("one_wall"))  # dataclasses look there
    exec(compile(detector, "one_wall.py", "exec"), names)  # noqa: S102 - our own page
    exec(compile(trial, "trial.py", "exec"), names)  # noqa: S102 - our own page
    assert len(names["features"].lines) == 1
    nothing = names["extractor"](lf.LaserScan.uniform([0.0, 0.0], -0.1, 0.1))
    assert len(nothing.lines) == 0
    listed = CliRunner().invoke(main, ["extractors", "one_wall"])
    assert "range_sigma = 0.01 m" in listed.output
    assert "Standard deviation of a range" in listed.output
