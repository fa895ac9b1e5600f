"""Work spread over processes: same results, in order, and nothing left behind."""

import math
import multiprocessing
import os
import signal
import subprocess
import sys
import time

import pytest
from bounded import Child

import laserfeatures as lf
from laserfeatures.testbench.workers import core_count, in_parallel

SLEEPERS = """
import time
from laserfeatures.testbench.workers import in_parallel, silent

def started(items, /, *, length, label):
    print("working", flush=True)
    return silent(items, length=length, label=label)

if __name__ == "__main__":
    in_parallel(time.sleep, [60, 60, 60], workers=2, progress=started)
"""


@pytest.mark.parametrize("workers", [1, 2, 5])
def test_results_are_in_the_items_order(workers):
    assert in_parallel(math.sqrt, [9, 4, 1], workers=workers) == [3, 2, 1]


def test_no_items_no_work():
    assert in_parallel(math.sqrt, [], workers=2) == []


def test_one_worker_is_this_process():
    assert in_parallel(getpid, [0, 0], workers=1) == [os.getpid()] * 2


def getpid(_item):
    return os.getpid()


def test_the_workers_are_of_this_processs_group():
    found = set(in_parallel(os.getpgid, [0, 0], workers=2))
    assert found == {os.getpgid(0)}  # of one group: a Ctrl-C reaches them all


def test_less_than_one_worker_is_refused():
    with pytest.raises(ValueError, match="workers must be >= 1, got 0"):
        in_parallel(math.sqrt, [1], workers=0)


def test_what_a_worker_raises_is_raised_here_and_the_others_end():
    before = time.monotonic()
    with pytest.raises(ValueError, match="negative"):
        in_parallel(time.sleep, [-1, 60, 60], workers=2)
    assert time.monotonic() - before < 30
    assert not multiprocessing.active_children()


def test_a_killed_worker_is_named():
    with pytest.raises(lf.LaserFeaturesError, match="one of 2 worker processes was killed"):
        in_parallel(os._exit, [3, 3], workers=2)


def test_progress_sees_each_item():
    seen = []

    class Bar:
        def __init__(self, items, /, *, length, label):
            self.items = items
            seen.append((length, label))

        def __enter__(self):
            return (seen.append("item") or item for item in self.items)

        def __exit__(self, *error):
            seen.append("end")

    in_parallel(math.sqrt, [1, 4], workers=1, progress=Bar, label="roots")
    assert seen == [(2, "roots"), "item", "item", "end"]


def test_ctrl_c_ends_the_workers_without_a_word_of_theirs(tmp_path):
    script = tmp_path / "sleepers.py"
    script.write_text(SLEEPERS)
    with Child(
        [sys.executable, script],
        stdout=subprocess.PIPE,
        stderr=subprocess.PIPE,
        start_new_session=True,  # so that the whole group can have the signal, as on a terminal
    ) as process:
        assert process.stdout.readline() == b"working\n"
        time.sleep(0.2)
        os.killpg(process.pid, signal.SIGINT)
        said = process.stderr.read()  # ends when no process is left that could write
        process.wait(timeout=30)
    assert said.count(b"Traceback") == 1  # this script's own: it does not catch Ctrl-C
    assert said.rstrip().endswith(b"KeyboardInterrupt")


def test_the_default_is_at_least_one_core():
    assert 1 <= core_count() <= os.cpu_count()
