"""The report's section on start times."""

import subprocess
import sys
import time
from pathlib import Path

import numpy as np
from page import table, verdict

IMPORT_TARGET = 0.150  # [s]
COMMAND_TARGET = 0.5  # [s]
COMMAND = str(Path(sys.executable).parent / "laserfeatures")

PROGRAMS = {
    "`python -c pass`": [sys.executable, "-c", "pass"],
    "`python -c 'import numpy'`": [sys.executable, "-c", "import numpy"],
    "`python -c 'import laserfeatures'`": [sys.executable, "-c", "import laserfeatures"],
    "`laserfeatures extractors`": [COMMAND, "extractors"],
}

METHOD = """Whole processes, from the start of the interpreter to its end, in turns, {repeats}
times each, from files that the system has read before."""

TEXT = f"""Target: `import laserfeatures` under {1e3 * IMPORT_TARGET:.0f} ms, numpy's own time
included (the process less the bare interpreter): {{imports}}. Target: `laserfeatures extractors`
under {1e3 * COMMAND_TARGET:.0f} ms, the whole process: {{command}}."""


def section(options):
    """Return the section's paragraphs."""
    repeats = options.repeats(30)
    seconds = np.array([[_run(program) for program in PROGRAMS.values()] for _ in range(repeats)])
    medians = np.median(seconds, axis=0)
    bare, _, package, command = medians
    rows = [
        [name, f"{1e3 * median:.0f}", f"{1e3 * (median - bare):.0f}", f"{1e3 * worst:.0f}"]
        for name, median, worst in zip(PROGRAMS, medians, seconds.max(axis=0), strict=True)
    ]
    header = ["process", "whole, median [ms]", "less the bare interpreter [ms]", "worst [ms]"]
    text = TEXT.format(
        imports=verdict(package - bare < IMPORT_TARGET), command=verdict(command < COMMAND_TARGET)
    )
    return ["## Start", METHOD.format(repeats=repeats), table(header, rows), text]


def _run(program):
    start = time.perf_counter()
    subprocess.run(program, check=True, capture_output=True)  # noqa: S603 - the programs above
    return time.perf_counter() - start
