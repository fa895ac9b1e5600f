"""The README and the pages of docs do what they say."""

import importlib
import json
import os
import re
import subprocess
import sys
import tomllib
from pathlib import Path

import pytest

import laserfeatures as lf

ROOT = Path(__file__).parents[1]
README = (ROOT / "README.md").read_text()
RUN_AS_WRITTEN = ["README.md", *(f"docs/{n}.md" for n in ("drivers", "noise", "robot", "slam"))]
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


@pytest.mark.parametrize("page", RUN_AS_WRITTEN)
def test_every_line_of_a_page_runs_as_written(page, tmp_path):
    text = (ROOT / page).read_text()
    lines = [line for block in blocks(text, "sh") for line in block.splitlines()]
    commands = [line for line in lines if "pip install" not in line]
    assert commands
    for number, code in enumerate(blocks(text, "python")):
        (tmp_path / f"block_{number}.py").write_text(code)
        commands.append(f'"{sys.executable}" block_{number}.py')
    (tmp_path / "docs").symlink_to(ROOT / "docs")
    (tmp_path / "bin").mkdir()
    program = tmp_path / "bin" / "laserfeatures"
    program.write_text(f'#!/bin/sh\nexec "{sys.executable}" -m laserfeatures "$@"\n')
    program.chmod(0o755)
    script = ["set -e", "trap 'kill $! 2>/dev/null || :' EXIT", *commands]
    with (tmp_path / "said").open("w+") as said:  # no pipe, which an emulator would keep open
        done = subprocess.run(  # noqa: S603 - our own page
            ["/bin/sh", "-c", "\n".join(script)],
            stdin=subprocess.DEVNULL,
            stdout=said,
            stderr=subprocess.STDOUT,
            check=False,
            cwd=tmp_path,
            env={
                **os.environ,
                "PATH": f"{program.parent}{os.pathsep}{os.environ['PATH']}",
                "PYTHONPATH": os.pathsep.join([str(ROOT), str(ROOT / "plugins"), *sys.path]),
            },
            timeout=600,
        )
        said.seek(0)
        output = said.read()
    assert done.returncode == 0, output
    assert "error:" not in output
    for name in re.findall(r" -o ([\w.]+)", "\n".join(commands)):
        assert (tmp_path / name).exists(), name


@pytest.mark.parametrize("page", [*ROOT.glob("*.md"), *ROOT.glob("docs/*.md")], ids=str)
def test_links_lead_to_files(page):
    for link in re.findall(r"\]\((?!https?:)([^)#]+)\)", page.read_text()):
        assert (page.parent / link).exists(), f"{page.name} links to {link}"


def test_every_extra_that_the_readme_names_exists():
    project = tomllib.loads((ROOT / "pyproject.toml").read_text())["project"]
    named = re.search(r"Extras: (.*?)all of them", README, re.DOTALL).group(1)
    assert set(re.findall(r"`(\w+)`", named)) == set(project["optional-dependencies"])


@pytest.fixture(scope="module")
def plugin(tmp_path_factory):
    """Return a folder with what the plugin page writes, and an environment as if installed."""
    folder = tmp_path_factory.mktemp("plugin")
    detector, trial = blocks(PLUGIN_PAGE, "python")
    (folder / "one_wall.py").write_text(detector)
    (folder / "trial.py").write_text(trial)
    (project,) = blocks(PLUGIN_PAGE, "toml")
    entries = tomllib.loads(project)["project"]["entry-points"]
    site = folder / "site" / "one_wall-1.0.dist-info"  # what pip makes of the page's project
    site.mkdir(parents=True)
    (site / "METADATA").write_text("Metadata-Version: 2.1\nName: one-wall\nVersion: 1.0\n")
    ((group, names),) = entries.items()
    lines = [f"[{group}]", *(f"{name} = {value}" for name, value in names.items())]
    (site / "entry_points.txt").write_text("\n".join(lines))
    return folder, str(site.parent)


def in_plugin(plugin, *command, installed=True):
    folder, site = plugin
    where = [str(folder), *([site] if installed else []), *sys.path]
    done = subprocess.run(  # noqa: S603 - our own page
        command,
        capture_output=True,
        text=True,
        check=False,
        cwd=folder,
        env={**os.environ, "PYTHONPATH": os.pathsep.join(where)},
        timeout=300,
    )
    assert done.returncode == 0, done.stderr
    return done.stdout


def test_the_plugin_page_runs_as_written_and_finds_the_wall_it_shows(plugin):
    printed = in_plugin(plugin, sys.executable, "trial.py", installed=False)
    assert [printed] == blocks(PLUGIN_PAGE, "text")


def test_the_plugin_pages_commands_find_the_wall_too(plugin):
    (script,) = blocks(PLUGIN_PAGE, "sh")
    command = f'laserfeatures() {{ "{sys.executable}" -m laserfeatures "$@"; }}; set -e\n'
    printed = in_plugin(plugin, "sh", "-c", command + script)
    (found,) = [json.loads(line) for line in printed.splitlines() if line.startswith("{")]
    (segment,) = found["segments"]
    ends = [segment[name] for name in ("x1", "y1", "x2", "y2")]
    assert ends == pytest.approx([2.0, -0.405, 2.0, 0.405], abs=0.002)
    assert "range_sigma = 0.01 m" in printed
    assert "Standard deviation of a range" in printed
    assert re.search(r"one_wall +\d+ +\d+ +0\.00 +0\.00", printed)


def test_the_plugin_pages_detector_takes_a_scan_without_returns(plugin, monkeypatch):
    monkeypatch.syspath_prepend(plugin[0])
    one_wall = importlib.import_module("one_wall")
    monkeypatch.delitem(sys.modules, "one_wall")
    extractor = lf.Pipeline(name="one_wall", detector=one_wall.OneWall())
    assert len(extractor(lf.LaserScan.uniform([0.0, 0.0], -0.1, 0.1)).lines) == 0
