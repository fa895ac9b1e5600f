"""Packages that only an extra brings, and that take long to import."""

import json
import re
import shlex
from contextlib import suppress
from importlib import import_module
from pathlib import Path
from typing import Any
from urllib.parse import unquote, urlsplit

from laserfeatures.errors import MissingDependencyError

_NAME = "laserfeatures"

# Which package of Debian and Ubuntu a library is in that wheels take for granted.
_PACKAGES = {
    "libGL.": "libgl1",
    "libEGL.": "libegl1",
    "libOSMesa.": "libosmesa6",
    "libgomp.": "libgomp1",
    "libusb-1.0.": "libusb-1.0-0",
    "libudev.": "libudev1",
    "libglib-2.0.": "libglib2.0-0",
    "libgthread-2.0.": "libglib2.0-0",
    "libSM.": "libsm6",
    "libICE.": "libice6",
    "libX11.": "libx11-6",
    "libXext.": "libxext6",
    "libXrender.": "libxrender1",
    "libtbb.": "libtbb12",
    "libstdc++.": "libstdc++6",
}


def optional(module: str, need: str, extra: str) -> Any:
    """Import a module of an optional package when it is needed.

    Parameters
    ----------
    module : str
        The module's name.
    need : str
        What needs the package, as the error is to begin: "scores need SciPy".
    extra : str
        The extra that brings it.

    Raises
    ------
    MissingDependencyError
        If it is not installed, or lacks something itself, such as a library of the system.
    """
    try:
        return import_module(module)
    except (ImportError, OSError) as error:  # OSError: a shared library that cannot be loaded
        library = system_library(error)
        if library:
            raise MissingDependencyError(f"{need}, and that {library}") from error
        missing = isinstance(error, ModuleNotFoundError) and module.startswith(error.name or "?")
        why = "" if missing else f" ({error})"
        raise MissingDependencyError(f"{need}{why}: {install_line(extra)}") from error


def system_library(error: BaseException) -> str | None:
    """Return which library of the system is missing by an error of an import, and how to get it."""
    found = re.search(r"(lib[^\s:/]+\.so[^\s:]*): cannot open shared object file", str(error))
    if found is None:
        return None
    name = found[1]
    package = next((each for start, each in _PACKAGES.items() if name.startswith(start)), None)
    how = f"apt-get install {package}" if package else f"apt-file search {name} names its package"
    return f"lacks {name} of the system: {how}"


def install_line(extra: str) -> str:
    """Return the command that adds an extra to this installation, wherever that came from."""
    from importlib.metadata import PackageNotFoundError, distribution  # noqa: PLC0415 - slow

    source = Path(__file__).parents[1]
    if (source / "pyproject.toml").is_file():  # it runs right out of a checkout
        return f"pip install -e {shlex.quote(f'{source}[{extra}]')}"
    name = f"{_NAME}[{extra}]"
    with suppress(PackageNotFoundError, ValueError):
        told = json.loads(distribution(_NAME).read_text("direct_url.json") or "null")
        url = told["url"] if told else ""
        folder = Path(unquote(urlsplit(url).path))
        if told and "dir_info" in told:
            if folder.is_dir():
                return f"pip install {shlex.quote(f'{folder}[{extra}]')}"
            return f"pip install '.[{extra}]' in the checkout that it was installed from"
        if told and "vcs_info" in told:
            url = f"{told['vcs_info']['vcs']}+{url}@{told['vcs_info']['commit_id']}"
        if url:
            return f"pip install {shlex.quote(f'{name} @ {url}')}"
    return f"pip install '{name}'"
