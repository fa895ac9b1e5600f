"""Third-party clients of the emulators, each in a Python environment of its own.

A test calls ``client_python(tmp_path_factory, "rplidar==0.9.2")`` and hands the interpreter to
`run_client` with a script of ``tests/clients``, which prints one line of JSON.
"""

import json
import os
import subprocess
import sys
import venv
from pathlib import Path
from typing import Any

import pytest

SCRIPTS = Path(__file__).parent / "clients"
ALWAYS_THERE = "pip"  # a package that every registry has
INSTALLING = 300.0  # [s]

_made: dict[str, Path] = {}


def client_python(factory: pytest.TempPathFactory, requirement: str) -> Path:
    """Return a Python that has `requirement` (``name==version``), made once a session.

    Skips the test if no registry can be reached; a package that a registry does not give, or that
    cannot be installed, is a failure.
    """
    if requirement not in _made:
        folder = factory.mktemp("client")
        venv.create(folder, symlinks=True)
        python = folder / "bin" / "python"
        tried = _pip("--python", str(python), "install", "--no-input", requirement)
        if tried.returncode:
            asked = _pip("download", "--no-deps", "--no-cache-dir", "-d", str(folder), ALWAYS_THERE)
            if asked.returncode:
                pytest.skip(f"no package registry can be reached to install {requirement}")
            pytest.fail(f"{requirement} cannot be installed: {tried.stderr[-2000:]}")
        _made[requirement] = python
    return _made[requirement]


def run_client(python: Path, script: str, *arguments: str, timeout: float = 60.0) -> Any:
    """Run a script of ``tests/clients`` and return what it printed: one line of JSON."""
    command = [str(python), str(SCRIPTS / script), *arguments]
    # Its own packages only: the paths of this process would shadow them.
    environment = {k: v for k, v in os.environ.items() if not k.startswith("PYTHON")}
    try:
        done = subprocess.run(  # noqa: S603 - our own script
            command, capture_output=True, text=True, timeout=timeout, env=environment, check=False
        )
    except subprocess.TimeoutExpired as late:
        pytest.fail(f"{script} is not through after {timeout:g} s: {_tail(late.stderr)}")
    if done.returncode:
        pytest.fail(f"{script} ended with {done.returncode}: {_tail(done.stderr)}")
    return json.loads(done.stdout.splitlines()[-1])


def _pip(*arguments: str) -> subprocess.CompletedProcess[str]:
    command = [sys.executable, "-m", "pip", "--disable-pip-version-check", "--quiet", *arguments]
    return subprocess.run(  # noqa: S603 - our own command
        command, capture_output=True, text=True, timeout=INSTALLING, check=False
    )


def _tail(output: str | bytes | None) -> str:
    text = output.decode(errors="replace") if isinstance(output, bytes) else output or ""
    return text[-2000:]
