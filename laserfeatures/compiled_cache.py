"""Where compiled kernels are kept from run to run, and what becomes of them where that fails."""

import hashlib
import logging
import os
import pickle
import stat
import tempfile
from collections.abc import Callable
from contextlib import suppress
from pathlib import Path
from typing import Any, Self

from numba.core.caching import (
    CompileResultCacheImpl,
    FunctionCache,
    IndexDataCacheFile,
    InTreeCacheLocator,
    NullCache,
    UserWideCacheLocator,
)

log = logging.getLogger("laserfeatures.compiled")  # without a handler, warnings are on stderr

ONCE = "compiling (once; on a slow machine it takes minutes)"
DIGEST = 32  # bytes

_told: set[str] = set()


def _tell(level: int, text: str) -> None:
    """Log something, once in a process."""
    if text not in _told:
        _told.add(text)
        log.log(level, text)


def _warn(problem: object) -> None:
    """Say that compiled code does not last, once in a process and not for each kernel."""
    if not any("NUMBA_CACHE_DIR" in each for each in _told):
        _tell(
            logging.WARNING,
            f"{problem}: set NUMBA_CACHE_DIR to a folder for it that can be written to and lasts",
        )


class _Temporary(UserWideCacheLocator):
    """A folder of this user's among the temporary ones, where there is no other."""

    def __init__(self, py_func: Any, py_file: str) -> None:
        super().__init__(py_func, py_file)
        folder = Path(tempfile.gettempdir()) / f"laserfeatures-{os.getuid()}"
        folder.mkdir(mode=0o700, exist_ok=True)
        found = folder.lstat()
        if not stat.S_ISDIR(found.st_mode) or found.st_uid != os.getuid() or found.st_mode & 0o022:
            raise PermissionError(f"{folder}: someone else could put code into it")
        self._cache_path = str(folder / self.get_suitable_cache_subpath(py_file))

    @classmethod
    def from_function(cls, py_func: Any, py_file: str) -> Self | None:
        """Return one, or None where it cannot be."""
        with suppress(OSError):
            found: Self | None = super().from_function(py_func, py_file)
            return found
        return None


_USUAL = CompileResultCacheImpl._locator_classes  # noqa: SLF001 - numba offers no other way


class _Places(CompileResultCacheImpl):
    """NUMBA_CACHE_DIR, the user's folder for caches, a temporary one: the first that will do.

    The package's own folders are left out: what is in them stays there when it is uninstalled.
    """

    _locator_classes = [  # noqa: RUF012 - as numba has it
        *(each for each in _USUAL if each is not InTreeCacheLocator),
        _Temporary,
    ]


class _Files(IndexDataCacheFile):
    """The files of a kernel's cache; each one tells what it is of, and whether it is whole.

    numba trusts an index that is written first. Where the code then is not, as on a full disk, or
    is another process's, there would be other code under that name.
    """

    def save(self, key: Any, data: Any) -> None:
        """Save what is compiled."""
        super().save(key, (self._source_stamp, key, data))

    def load(self, key: Any) -> Any:
        """Load it; None if it is not there."""
        found = super().load(key)
        return found[2] if found and found[:2] == (self._source_stamp, key) else None

    def _load_data(self, name: str) -> Any:
        content = Path(self._data_path(name)).read_bytes()
        digest, data = content[:DIGEST], content[DIGEST:]
        if hashlib.sha256(data).digest() != digest:
            raise ValueError(f"{name} is damaged")
        return pickle.loads(data)  # noqa: S301 - our own

    def _save_data(self, name: str, data: Any) -> None:
        content = self._dump(data)
        with self._open_for_write(self._data_path(name)) as file:
            file.write(hashlib.sha256(content).digest() + content)


class Cache(FunctionCache):
    """A kernel's cache, fresh only while all is that the kernel compiles in.

    To numba it is fresh while the kernel's own file is. The rest is looked at when the kernel is
    first called: only then all of it is defined, and importing it takes no longer. What cannot be
    read is compiled anew; what cannot be written is compiled in the next run, too.

    Parameters
    ----------
    function : callable
        The kernel's function.
    contents : callable
        Returns a digest of all that the kernel compiles in.

    Raises
    ------
    RuntimeError
        If there is no folder for it.
    """

    _impl_class = _Places

    def __init__(self, function: Any, contents: Callable[[], str]) -> None:
        super().__init__(function)
        self._contents = contents
        self._stamp = self._impl.locator.get_source_stamp()
        self._cache_file = _Files(self._cache_path, self._impl.filename_base, self._stamp)

    def load_overload(self, sig: Any, target_context: Any) -> Any:
        """Load what is compiled. Where nothing is, numba compiles and saves it next."""
        self._cache_file._source_stamp = self._stamp, self._contents()  # noqa: SLF001
        try:
            found = super().load_overload(sig, target_context)
        except Exception:  # noqa: BLE001 - of whatever a damaged file is taken for
            found = None
            with suppress(OSError):
                self.flush()
        if found is None:
            _tell(logging.INFO, ONCE)
            if isinstance(self._impl.locator, _Temporary):
                _warn(f"compiled code is kept in {self._cache_path} until that is cleared")
        return found

    def save_overload(self, sig: Any, data: Any) -> None:
        """Save what is compiled."""
        try:
            super().save_overload(sig, data)
        except Exception as error:  # noqa: BLE001 - what is compiled works all the same
            _warn(f"compiled code cannot be kept in {self._cache_path} ({error})")


class NoCache(NullCache):
    """In place of a cache where there is no folder for it, or no file that the kernel is of."""

    def __init__(self, function: Any) -> None:
        self._of_a_file = Path(function.__code__.co_filename).is_file()

    def load_overload(self, sig: Any, target_context: Any) -> None:  # noqa: ARG002 - as numba calls it
        """Say that there is none."""
        _tell(logging.INFO, ONCE)
        if self._of_a_file:
            _warn("each run compiles anew, as there is no folder to keep compiled code in")
