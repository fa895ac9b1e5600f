"""Packages that only an extra brings, and that take long to import."""

from importlib import import_module
from typing import Any

from laserfeatures.errors import MissingDependencyError


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
        missing = isinstance(error, ModuleNotFoundError) and module.startswith(error.name or "?")
        why = "" if missing else f" ({error})"
        raise MissingDependencyError(
            f"{need}{why}: pip install 'laserfeatures[{extra}]'"
        ) from error
