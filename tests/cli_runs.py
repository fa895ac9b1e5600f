"""What the tests of the command share: simulated logs, and ways to run it."""

import os
import subprocess
import sys
from pathlib import Path

import numpy as np
from bounded import Child
from click.testing import CliRunner

from laserfeatures.cli import main
from laserfeatures.simulation import Scanner, hallway

ENTRY = "from laserfeatures.cli import main; main()"


def carmen_log(path, scans=5):
    """Write scans of the hallway as a CARMEN log, ten a second."""
    world, path_of_poses = hallway()
    rng = np.random.default_rng(1)
    lines = []
    for i in range(scans):
        pose = path_of_poses[i % len(path_of_poses)]
        ranges = Scanner().scan(world, pose, rng).ranges
        values = " ".join(f"{r:.3f}" for r in ranges)
        where = f"{pose.x} {pose.y} {pose.theta}"
        lines.append(f"FLASER {ranges.size} {values} {where} {where} {i / 10:.6f} host {i / 10}\n")
    Path(path).write_text("".join(lines), encoding="ascii")
    return str(path)


def run(*arguments):
    """Run the command in this process."""
    return CliRunner().invoke(main, [str(argument) for argument in arguments])


def fails(*arguments):
    """Run the command, check that it ends with one line and status 2, and return the line."""
    result = run(*arguments)
    assert result.exit_code == 2, result.output
    assert not result.stdout
    assert result.stderr.startswith("laserfeatures: error: ")
    assert result.stderr.count("\n") == 1
    assert "Traceback" not in result.stderr
    return result.stderr


def start(*arguments, code=ENTRY, env=None, **options):
    """Start the command as a process of its own."""
    options = {"stdout": subprocess.PIPE, "stderr": subprocess.PIPE} | options
    return Child(
        [sys.executable, "-c", code, *map(str, arguments)],
        env={**os.environ, **(env or {})},
        **options,
    )
