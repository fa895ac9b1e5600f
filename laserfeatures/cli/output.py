"""Output that is complete or absent."""

import os
from collections.abc import Iterator
from contextlib import contextmanager, suppress
from pathlib import Path
from typing import IO, Any

import click


@contextmanager
def complete_file(
    path: str, source: str | None = None, *, binary: bool = False
) -> Iterator[IO[Any]]:
    """Open a file to write that appears under its name only when all went well.

    It is written beside its place and renamed at the end. Whatever ends the block early (an error,
    Ctrl-C, SIGTERM) removes it and leaves an older file of that name as it was. A device or named
    pipe is written to directly.

    Parameters
    ----------
    path : str
        Name of the file.
    source : str, optional
        The input, which must not be overwritten.
    binary : bool
        Whether bytes will be written instead of text.

    Raises
    ------
    click.UsageError
        If the path is a folder, or its folder is missing or cannot be written to, or it is the
        input itself.
    OSError
        If writing fails later.
    """
    target = Path(path).resolve()  # a link stays a link: what it points to is replaced
    if target.is_dir():
        raise click.UsageError(f"-o {path} is a folder: give the name of a file in it")
    if not target.parent.is_dir():
        raise click.UsageError(f"-o {path}: there is no folder {target.parent}; make it first")
    if source is not None and target in _files_of(source):
        raise click.UsageError(f"-o {path} would overwrite the input: give another name")
    mode, encoding = ("wb", None) if binary else ("w", "utf-8")
    if target.exists() and not target.is_file():
        with target.open(mode, encoding=encoding) as device:
            yield device
        return
    aside = target.with_name(f".{target.name}.{os.getpid()}.part")
    try:
        file = aside.open(mode, encoding=encoding)
    except OSError as error:
        raise click.UsageError(f"-o {path} cannot be written: {error.strerror}") from error
    try:
        with file:
            yield file
        aside.replace(target)
    finally:
        aside.unlink(missing_ok=True)


@contextmanager
def made_folder(folder: str) -> Iterator[None]:
    """Make a folder, and those that it is in; whatever ends the block early takes empty ones away.

    Raises
    ------
    click.UsageError
        If it cannot be made.
    """
    path = Path(folder).absolute()
    new = [each for each in (path, *path.parents) if not each.exists()]
    try:
        path.mkdir(parents=True, exist_ok=True)
    except OSError as error:
        raise click.UsageError(f"-o {folder} cannot be made: {error.strerror}") from error
    try:
        yield
    except BaseException:
        for each in new:
            with suppress(OSError):  # something is in it
                each.rmdir()
        raise


def _files_of(source: str) -> set[Path]:
    """Return the file that a source reads, be it a log or the recording of a replay."""
    recording = source.removeprefix("replay:").partition("?")[0]
    return {Path(name).resolve() for name in (source, recording) if Path(name).exists()}
