"""The options that set up the filter."""

from collections.abc import Callable
from typing import TYPE_CHECKING, TypeVar

import click

from laserfeatures.cli import values
from laserfeatures.cli.parameters import parameters_of
from laserfeatures.registry import near_names

if TYPE_CHECKING:
    from laserfeatures.slam import EkfSlam, Motion

Command = TypeVar("Command", bound=Callable[..., None])

LANDMARKS = {"corners": (True, False), "walls": (False, True), "both": (True, True)}


class MotionType(click.ParamType["Motion"]):
    """An option's type: deviations of the odometry, as in ``way=0.1,turn=3deg``."""

    name = "deviations"

    def convert(
        self, value: object, param: click.Parameter | None, ctx: click.Context | None
    ) -> "Motion":
        """Return the motion's noise; deviations not named keep their defaults."""
        from laserfeatures.slam import Motion  # noqa: PLC0415 - brings numba

        known = parameters_of(Motion)
        given: dict[str, float] = {}
        for part in str(value).split(","):
            name, equals, text = (piece.strip() for piece in part.partition("="))
            if not (name and equals and text):
                self.fail(f"must be as in way=0.1,turn=3deg, got {value!r}", param, ctx)
            if name not in known:
                self.fail(f"has no {name!r}; {near_names(name, list(known))}", param, ctx)
            try:
                given[name] = float(str(values.parse(text, float, known[name].unit)))
            except ValueError as error:
                self.fail(f"{name} {error}", param, ctx)
        try:
            return Motion(**given)
        except ValueError as error:
            self.fail(str(error), param, ctx)


_OPTIONS = (
    click.option(
        "--landmarks",
        type=click.Choice(list(LANDMARKS)),
        default="both",
        show_default=True,
        help="What becomes a landmark.",
    ),
    click.option(
        "--association",
        type=click.Choice(["joint", "nearest"]),
        default="joint",
        show_default=True,
        help="By joint compatibility, or each feature for itself.",
    ),
    click.option(
        "--motion",
        type=MotionType(),
        metavar="NAME=VALUE,..",
        help="Deviations of the odometry: way and side along and across, and turn_by_way of the "
        "angle, after 1 m; turn of the angle, after 1 rad.",
    ),
    click.option(
        "--roughness",
        type=values.Quantity("m"),
        metavar="LENGTH",
        help="How far walls and corners are off lines and points. Else 3cm; in simulation 0.",
    ),
)


def slam_options(command: Command) -> Command:
    """Give a command the options --landmarks, --association, --motion and --roughness."""
    for option in reversed(_OPTIONS):
        command = option(command)
    return command


def make_slam(
    landmarks: str, association: str, motion: "Motion | None", roughness: float | None
) -> "EkfSlam":
    """Return a filter as those options say."""
    from laserfeatures.slam import EkfSlam, Motion  # noqa: PLC0415 - brings numba

    corners, walls = LANDMARKS[landmarks]
    return EkfSlam(
        motion=motion or Motion(),
        corners=corners,
        walls=walls,
        association="joint" if association == "joint" else "nearest",
        roughness=EkfSlam.roughness if roughness is None else roughness,
    )
