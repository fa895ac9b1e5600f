"""What the sections of the report share: options, tables, pictures."""

from dataclasses import dataclass
from pathlib import Path

from matplotlib.figure import Figure

NONE = "\N{EN DASH}"  # what does not apply


@dataclass(frozen=True)
class Options:
    """Where the recordings are, where the report goes, and whether to cut it short."""

    data: Path
    docs: Path
    quick: bool

    def repeats(self, full: int) -> int:
        """Return how often to repeat what a full run repeats `full` times."""
        return max(full // 10, 3) if self.quick else full

    def save(self, figure: Figure, name: str, shows: str) -> str:
        """Save a picture; return the text that shows it, with what it shows in words."""
        figure.savefig(self.docs / name, dpi=110)
        return f"![{shows}]({name})"


def new_figure(width, height):
    """Return an empty figure of that size [inch]."""
    return Figure(figsize=(width, height), layout="constrained")


def table(header, rows):
    """Return a table; the first column is text, the others are numbers to the right."""
    cells = [header, ["---", *["---:"] * (len(header) - 1)], *rows]
    return "\n".join("| " + " | ".join(str(cell) for cell in row) + " |" for row in cells)


def percent(share):
    """Return a share as a percentage."""
    return f"{100 * share:.1f} %"


def verdict(met):
    """Return whether a target is met, as text."""
    return "met" if met else "**missed**"
