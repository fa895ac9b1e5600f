"""Work spread over processes."""

import multiprocessing
import os
import signal
from collections.abc import Callable, Iterable, Iterator, Sequence
from concurrent.futures import Future, ProcessPoolExecutor
from concurrent.futures.process import BrokenProcessPool
from contextlib import AbstractContextManager, contextmanager, nullcontext
from typing import Any, Protocol, TypeVar

from laserfeatures.errors import LaserFeaturesError

Item = TypeVar("Item")
Result = TypeVar("Result")


class Progress(Protocol):
    """What shows how far a long work is, such as a bar on a terminal."""

    def __call__(
        self, items: Iterable[Any], /, *, length: int, label: str
    ) -> AbstractContextManager[Iterable[Any]]:
        """Return a context whose value yields `items`, `length` of them, and tells when it does."""
        ...


def silent(
    items: Iterable[Any], /, *, length: int, label: str
) -> AbstractContextManager[Iterable[Any]]:
    """Show nothing."""
    del length, label
    return nullcontext(items)


def core_count() -> int:
    """Return the number of cores that this process may use."""
    return len(os.sched_getaffinity(0)) if hasattr(os, "sched_getaffinity") else os.cpu_count() or 1


def in_parallel(
    function: Callable[[Item], Result],
    items: Sequence[Item],
    *,
    workers: int,
    progress: Progress = silent,
    label: str = "scans",
) -> list[Result]:
    """Return `function` of each item, in their order, whatever the number of workers.

    Whatever ends this early, Ctrl-C too, ends the workers at once.

    Parameters
    ----------
    function : callable
        What to do with an item: of the top level of a module, or a `functools.partial` of such.
    items : sequence
        What to do it with. It is pickled, as the result is.
    workers : int
        Number of processes; with 1 all is done in this one.
    progress : Progress
        Shows how many items are done.
    label : str
        What the items are.

    Raises
    ------
    ValueError
        If `workers` is less than 1.
    LaserFeaturesError
        If a worker is killed.
    """
    if workers < 1:
        raise ValueError(f"workers must be >= 1, got {workers}")
    workers = min(workers, len(items))
    if workers <= 1:
        with progress(map(function, items), length=len(items), label=label) as done:
            return list(done)
    with _workers(workers) as pool:
        with _interrupts_held_back():  # the workers inherit that: Ctrl-C is for this process
            futures = [pool.submit(function, item) for item in items]
        try:
            with progress(_results(futures), length=len(items), label=label) as done:
                return list(done)
        except BrokenProcessPool as error:
            raise LaserFeaturesError(
                f"one of {workers} worker processes was killed, perhaps for want of memory; "
                "take fewer workers"
            ) from error


def _results(futures: Sequence[Future[Result]]) -> Iterator[Result]:
    for future in futures:
        yield future.result()


@contextmanager
def _workers(count: int) -> Iterator[ProcessPoolExecutor]:
    """Start workers as new interpreters: a fork would copy the locks of numba's threads."""
    others = set(multiprocessing.active_children())
    pool = ProcessPoolExecutor(count, mp_context=multiprocessing.get_context("spawn"))
    try:
        yield pool
    except BaseException:
        for process in set(multiprocessing.active_children()) - others:
            process.terminate()
        pool.shutdown(cancel_futures=True)
        raise
    pool.shutdown()


@contextmanager
def _interrupts_held_back() -> Iterator[None]:
    before = signal.pthread_sigmask(signal.SIG_BLOCK, {signal.SIGINT})
    try:
        yield
    finally:
        signal.pthread_sigmask(signal.SIG_SETMASK, before)
