"""The models that are played: identity, line and scan modes.

The rates are those that fit through each line: a measurement takes 5 bytes in a standard scan,
2.6 in an express one, 1.4 in an ultra capsule, 2.1 in a dense one.
"""

from dataclasses import dataclass

from laserfeatures.drivers.rplidar.packets import Answer


@dataclass(frozen=True)
class Mode:
    """A scan mode: name, form of the answer, time of a measurement [s], largest range [m]."""

    name: str
    answer: Answer
    period: float
    max_distance: float


@dataclass(frozen=True)
class Model:
    """A model.

    Parameters
    ----------
    code : int
        Model byte.
    hardware : int
        Its revision.
    baud : int
        Rate of its line [Bd].
    turn_rate : float
        How fast it turns [Hz].
    pwm : bool
        Whether the motor stands until a request sets its duty.
    modes : tuple of Mode
        By number; the first is the standard scan, the second the express one.
    typical : int
        The mode it suggests.
    """

    code: int
    hardware: int
    baud: int
    turn_rate: float
    pwm: bool
    modes: tuple[Mode, ...]
    typical: int


_A1 = (
    Mode("Standard", Answer.NODES, 508e-6, 12.0),
    Mode("Express", Answer.CAPSULES, 254e-6, 12.0),
    Mode("Boost", Answer.ULTRA_CAPSULES, 127e-6, 12.0),
)
MODELS = {
    "A1": Model(0x18, 7, 115_200, 7.0, False, _A1, 2),
    "A2": Model(0x28, 5, 115_200, 10.0, True, _A1, 2),
    "A3": Model(
        0x31,
        6,
        256_000,
        10.0,
        True,
        (
            Mode("Standard", Answer.NODES, 250e-6, 16.0),
            Mode("Express", Answer.CAPSULES, 125e-6, 16.0),
            Mode("Boost", Answer.ULTRA_CAPSULES, 62.5e-6, 25.0),
        ),
        2,
    ),
    "C1": Model(
        0x41,
        1,
        460_800,
        10.0,
        False,
        (
            Mode("Standard", Answer.NODES, 200e-6, 12.0),
            Mode("Express", Answer.CAPSULES, 200e-6, 12.0),
            Mode("DenseBoost", Answer.DENSE_CAPSULES, 200e-6, 12.0),
        ),
        2,
    ),
}
"""What can be emulated, by name: like A1M8, A2M8, A3M1 and C1M1."""
