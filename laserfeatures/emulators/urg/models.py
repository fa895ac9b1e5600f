"""What tells one model from the other."""

from dataclasses import dataclass

from laserfeatures.drivers.urg.sensor import Geometry

RATES = frozenset({19_200, 57_600, 115_200, 250_000, 500_000, 750_000})  # [Bd]
MAKER = "Hokuyo Automatic Co.,Ltd."


@dataclass(frozen=True)
class Model:
    """A model.

    Parameters
    ----------
    product, firmware, serial : str
        As VV says.
    geometry : Geometry
        As PP says.
    largest_step : int
        The last step that it takes in a command; beyond `geometry.last` nothing is measurable.
    baud : int or None
        Rate of its line after power-on [Bd]; None: USB.
    old : bool
        Whether it speaks SCIP 1.1 after power-on.
    """

    product: str
    firmware: str
    serial: str
    geometry: Geometry
    largest_step: int
    baud: int | None
    old: bool


def _geometry(name: str) -> Geometry:
    return Geometry(
        model=name, shortest=20, longest=5600, steps=1024, first=44, last=725, front=384, speed=600
    )


MODELS = {
    "ug01": Model(
        product="SOKUIKI Sensor URG-04LX-UG01(Simple-URG)",
        firmware="3.4.03(17/Dec./2012)",
        serial="H1510998",
        geometry=_geometry(f"URG-04LX-UG01(Simple-URG)({MAKER})"),
        largest_step=768,
        baud=None,
        old=False,
    ),
    "classic": Model(
        product="SOKUIKI Sensor URG-04LX",
        firmware="3.1.04(02/Aug./2007)",
        serial="H0706400",
        geometry=_geometry(f"URG-04LX({MAKER})"),
        largest_step=768,
        baud=19_200,
        old=True,
    ),
}
"""The models by name; the classic one's serial line is played, not its USB."""
