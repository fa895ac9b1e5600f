"""Measures the drivers and writes the figures into ``docs/drivers.md``.

``python benchmarks/driver_report.py [--quick]`` runs `driver_faults`, `driver_load` and
`driver_fuzz` (about a quarter of an hour; a tenth of each with --quick, which writes nothing) and
replaces what stands between the page's marks ``<!-- faults -->``, ``<!-- load -->``,
``<!-- fuzz -->`` and the next ``<!-- end -->``.
"""

import argparse
import re
import subprocess
import sys
from pathlib import Path

HERE = Path(__file__).parent
PAGE = HERE.parent / "docs/drivers.md"
SCRIPTS = {
    "faults": ["driver_faults.py", "--frames", "{frames}"],
    "load": ["driver_load.py", "--seconds", "{seconds}"],
    "fuzz": ["driver_fuzz.py", "--bytes", "{bytes}"],
}
FULL = {"frames": 10_000, "seconds": 60, "bytes": 10_000_000}
QUICK = {"frames": 1000, "seconds": 6, "bytes": 1_000_000}


def output_of(name, sizes):
    """Return what a script prints."""
    script, *options = (part.format(**sizes) for part in SCRIPTS[name])
    done = subprocess.run(  # noqa: S603 - our own script
        [sys.executable, HERE / script, *options], capture_output=True, text=True, check=False
    )
    if done.returncode:
        raise SystemExit(f"{script} failed:\n{done.stderr}")
    return done.stdout.strip()


def main():
    """Write the page, or print what would stand in it."""
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--quick", action="store_true")
    options = parser.parse_args()
    for name in SCRIPTS:
        text = output_of(name, QUICK if options.quick else FULL)
        print(f"## {name}\n\n{text}\n", flush=True)
        if not options.quick:
            marked = re.compile(rf"(<!-- {name} -->\n).*?(<!-- end -->)", re.DOTALL)
            page, found = marked.subn(lambda m, t=text: f"{m[1]}{t}\n{m[2]}", PAGE.read_text())
            assert found == 1, f"{PAGE} must have one mark {name}"
            PAGE.write_text(page)


if __name__ == "__main__":
    main()
