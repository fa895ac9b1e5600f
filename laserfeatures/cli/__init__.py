"""The ``laserfeatures`` command."""

import click

import laserfeatures as lf
from laserfeatures.cli.compare import compare
from laserfeatures.cli.demo import demo
from laserfeatures.cli.emulate import emulate
from laserfeatures.cli.extract import extract
from laserfeatures.cli.extractors import extractors
from laserfeatures.cli.group import NAME, CommandGroup
from laserfeatures.cli.info import info
from laserfeatures.cli.live import live
from laserfeatures.cli.noise import noise
from laserfeatures.cli.plot import plot
from laserfeatures.cli.record import record
from laserfeatures.cli.simulate import simulate
from laserfeatures.cli.slam import slam
from laserfeatures.cli.testbench import testbench
from laserfeatures.cli.warm import warm_up

__all__ = ["main"]


@click.group(NAME, cls=CommandGroup, context_settings={"help_option_names": ["-h", "--help"]})
@click.version_option(lf.__version__, prog_name=NAME)
def main() -> None:
    """Line segments and corners out of 2D laser scans.

    \b
    Start here:
      laserfeatures demo                                   try it without any data
      laserfeatures info example:office                    what a log holds
      laserfeatures plot example:office --scan 0 -o s.png  see what is found
      laserfeatures extract example:office -o out.jsonl    get it, scan by scan
      laserfeatures compare example:office -o report.html  see which extractor suits it
      laserfeatures simulate office.toml -o run.log        let a robot record a log
      laserfeatures testbench all                          run the paper's tables again
      laserfeatures slam run example:office -o found/      a map, and the way through it
      laserfeatures noise example:office                   how noisy the ranges of a log are
    In place of example:office goes your log; there are example:hallway and example:clutter, too.

    \b
    With a rangefinder, at /dev/ttyACM0 for example:
      laserfeatures live urg:///dev/ttyACM0                corners as it turns
      laserfeatures record urg:///dev/ttyACM0 -o u.rec     a log of it, byte for byte
      laserfeatures emulate urg --pty-link /tmp/urg        one to try, without hardware
    Wherever a log is read, such an address will do: urg:, lms:, rplidar:, ld19:.

    \b
    Completion of commands, options, extractors and parameters: a line for the shell's start file.
      bash  eval "$(_LASERFEATURES_COMPLETE=bash_source laserfeatures)"
      zsh   eval "$(_LASERFEATURES_COMPLETE=zsh_source laserfeatures)"
      fish  _LASERFEATURES_COMPLETE=fish_source laserfeatures | source
    """  # noqa: D301 - click's mark for lines to keep is a backspace


COMMANDS = (
    *(compare, demo, emulate, extract, extractors, info),
    *(live, noise, plot, record, simulate, slam, testbench, warm_up),
)

for command in COMMANDS:
    main.add_command(command)
