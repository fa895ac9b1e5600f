"""A file that grows under its own name: what is written stays, whatever ends the program."""

import errno
import fcntl
import os
from pathlib import Path
from typing import Self


class GrowingFile:
    """A file for whole lines, which is there from the first one on.

    Parameters
    ----------
    path : str or Path
        Its name. A device or named pipe is written to as it is.
    replace : bool
        Whether an older file of that name may go; it goes when the first line is written.

    Raises
    ------
    OSError
        If it cannot be written to, is there already and must not be replaced, or is being written
        by another program.
    """

    def __init__(self, path: str | Path, *, replace: bool = False) -> None:
        self.path = Path(path)
        self.size = 0
        self._plain = self.path.is_file() or not self.path.exists()
        self._older = self.path.is_file()
        if self._older and not replace:
            raise FileExistsError(
                errno.EEXIST, "is there already: give another name, or --force", str(path)
            )
        flags = os.O_WRONLY | os.O_CREAT | os.O_APPEND
        self._descriptor = os.open(self.path, flags, 0o666)
        if self._plain:
            self._lock()

    def _lock(self) -> None:
        """Keep other programs from growing this file; the lock goes with the descriptor."""
        try:
            fcntl.flock(self._descriptor, fcntl.LOCK_EX | fcntl.LOCK_NB)
            ours = os.path.samestat(self.path.stat(), os.fstat(self._descriptor))
        except (BlockingIOError, FileNotFoundError):
            ours = False  # the other one may just have removed what it had made
        except OSError:  # a file system without locks
            ours = True
        if not ours:
            os.close(self._descriptor)
            raise FileExistsError(
                errno.EEXIST, "another program is writing it: give another name", str(self.path)
            )

    def write(self, data: bytes) -> None:
        """Write lines, all or as much as there is room for.

        Raises
        ------
        OSError
            If the disk is full.
        """
        try:
            if data and self._older and not self.size:
                os.ftruncate(self._descriptor, 0)
            while data:
                written = os.write(self._descriptor, data)
                self.size += written
                data = data[written:]
        except OSError as error:
            raise OSError(error.errno, error.strerror, str(self.path)) from error

    def sync(self) -> None:
        """See to it that a loss of power does not take what was written."""
        if self._plain:
            os.fsync(self._descriptor)

    def __enter__(self) -> Self:
        """Return itself; it is open already."""
        return self

    def __exit__(self, *_: object) -> None:
        """Close it; a new one into which nothing was written goes."""
        self.sync()
        os.close(self._descriptor)
        if self._plain and not self._older and not self.size:
            self.path.unlink(missing_ok=True)
