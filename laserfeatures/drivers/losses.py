"""What was lost between a device and its user, counted by kind."""

from dataclasses import asdict, dataclass


@dataclass
class Losses:
    """Counters of a driver.

    Parameters
    ----------
    frames : int
        Whole frames taken, for comparison.
    damaged : int
        Frames thrown away: a wrong checksum, a length or field that cannot be.
    garbage : int
        Bytes that belong to no frame.
    missed : int
        Scans that the device made and that never came whole, by its clock or counters.
    overruns : int
        Scans dropped because the user had not taken the ones before.
    silences : int
        Times that the device said nothing for longer than it may.
    restarts : int
        Times that the sweep had to be started again.
    reconnects : int
        Times that the port was opened again.
    refusals : int
        Faults and refusals that the device reported.
    problem : str or None
        The last problem, in words.
    """

    frames: int = 0
    damaged: int = 0
    garbage: int = 0
    missed: int = 0
    overruns: int = 0
    silences: int = 0
    restarts: int = 0
    reconnects: int = 0
    refusals: int = 0
    problem: str | None = None

    @property
    def scans(self) -> int:
        """Number of scans that did not reach the user, as far as is known."""
        return self.missed + self.overruns

    def counts(self) -> dict[str, int]:
        """Return the counters by name, without `frames`."""
        return {
            name: value for name, value in asdict(self).items() if name not in {"frames", "problem"}
        }

    def __str__(self) -> str:
        """Return what is not 0, in a line."""
        counts = [f"{value} {name}" for name, value in self.counts().items() if value]
        return ", ".join(counts) or "none"
