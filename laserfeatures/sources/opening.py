"""`open_source`: the one way from a file or port to its scans."""

import re
from collections.abc import Iterable, Mapping, Sequence
from os import PathLike, fspath
from pathlib import Path
from typing import Any

from laserfeatures.drivers import DRIVERS, is_address
from laserfeatures.errors import SourceError
from laserfeatures.scan import FULL_TURN
from laserfeatures.sources import example
from laserfeatures.sources.formats import FORMATS, find_format
from laserfeatures.sources.log import Log, OnError, Wanted
from laserfeatures.sources.log_source import LogSource
from laserfeatures.sources.port import PortSource, driver_of
from laserfeatures.sources.replay import SCHEME, ReplaySource
from laserfeatures.sources.source import Source
from laserfeatures.sources.table import ANGLE_UNITS, DELIMITERS, RANGE_UNITS, check_columns

URL = re.compile(r"[a-z][a-z0-9+]+:/")


def open_source(
    path: str | PathLike[str],
    *,
    format: str | None = None,  # noqa: A002 - the natural name for a user
    on_error: OnError = "raise",
    topic: str | None = None,
    range_max: float | None = None,
    field_of_view: float | tuple[float, float] | None = None,
    slice_band: tuple[float, float] | None = None,
    slice_origin: tuple[float, float] | None = None,
    poses: Wanted | None = None,
    columns: Sequence[str] | None = None,
    angle_unit: str | None = None,
    range_unit: str | None = None,
    delimiter: str | None = None,
) -> Source:
    r"""Open a log, table or bag of laser scans, a point cloud, a plan for a robot, or a port.

    Parameters
    ----------
    path : str or PathLike
        A file, gzip or not, or the folder of a ROS 2 bag; or the address of a rangefinder's port,
        ``protocol://port?name=value&..``, such as ``urg:///dev/ttyACM0?skip=1``,
        ``lms:///dev/ttyUSB0?baud=38400`` or ``urg:socket://192.168.0.10:10940``: the names are
        parameters of the protocol's driver, and ``scans=N`` or ``seconds=T``, after which a port's
        source ends; or ``replay:FILE?speed=1``, a recording of a port in its own time; or
        ``example:hallway``, ``example:office``, ``example:clutter``, which need no file.
    format : str, optional
        "carmen", "gfs", "breezyslam", "brenner", "urg_csv", "rplidar", "csv", "npz", "rosbag1",
        "rosbag2", "mcap", "point_cloud", "plan" or "recording"; told by the content if left out.
    on_error : {"raise", "skip"}
        What to do about a broken record: stop, or leave it out and count it in `Source.skipped`.
        A port's damaged frames are always left out and counted.
    topic : str, optional
        Which topic of a bag to read; needed if several hold laser scans.
    range_max : float, optional
        Range at and beyond which there is no return [m], instead of the log's or sensor's own.
    field_of_view : float or (float, float), optional
        Angle from the first to the last beam [rad], symmetric about the front, or the directions
        of both, for the logs that do not say (carmen, gfs).
    slice_band : (float, float), optional
        The heights ``low <= z < high`` [m] of a point cloud to scan; needed for one.
    slice_origin : (float, float), optional
        Where in a point cloud the scanner stands [m], looking along x; its own origin if left out.
    poses : {"odometry", "corrected"}, optional
        Which poses the scans must have: raw odometry, or those that a SLAM program has corrected
        (a simulated robot's: the true ones). Of a log that has both (carmen, plan) it chooses, any
        other is refused if its poses are of the other kind, or if it has none. An example has both.
    columns : sequence of str, optional
        Of a table without a header, what its columns are: "angle" (counter-clockwise) or
        "clockwise", and "range"; "scan", "stamp"; "intensity", "quality" and "-" are passed over.
    angle_unit : {"rad", "deg"}, optional
        Of a table's angles, where its header does not say.
    range_unit : {"m", "cm", "mm"}, optional
        Of a table's ranges, where its header does not say.
    delimiter : {",", ";", "tab", "space"}, optional
        What stands between a table's cells; told by its first line if left out.

    Returns
    -------
    Source
        An iterator of `LaserScan`, to be used in a ``with`` statement.

    Raises
    ------
    SourceError
        If the file is missing, empty, of no known format, holds no scan, or no
        `poses` of the kind asked for; and, here or from the
        iterator, if a record is broken.
    DriverError
        If a port cannot be opened or used; the message says why and what to do.
    MissingDependencyError
        If a bag is to be read and rosbags is not installed, a point cloud and Open3D is not, or a
        plan and mujoco is not.
    ValueError
        If an option makes no sense, or is none of this format's.

    Examples
    --------
    >>> import tempfile
    >>> from pathlib import Path
    >>> log = Path(tempfile.mkdtemp(), "two_beams.csv")
    >>> _ = log.write_text("stamp,-0.1,0.1\n5.0,2.0,\n")
    >>> with open_source(log) as scans:
    ...     for scan in scans:
    ...         print(scan.stamp, scan.valid.tolist())
    5.0 [True, False]
    """
    name = fspath(path)
    if on_error not in {"raise", "skip"}:
        raise ValueError(f"on_error must be 'raise' or 'skip', got {on_error!r}")
    if range_max is not None and not range_max > 0:
        raise ValueError(f"range_max must be > 0 m, got {range_max!r}")
    view = field_of_view
    width = view[1] - view[0] if isinstance(view, tuple) else view
    if width is not None and not 0 < width <= FULL_TURN:
        raise ValueError(f"field_of_view must be in (0, 2 pi] rad, got {view!r}")
    if slice_band is not None and not slice_band[0] < slice_band[1]:
        low, high = slice_band
        raise ValueError(f"slice_band must be low < high [m], got {low!r} and {high!r}")
    options: dict[str, Any] = {
        "topic": topic,
        "field_of_view": field_of_view,
        "slice_band": slice_band,
        "slice_origin": slice_origin,
        "columns": columns,
        "angle_unit": angle_unit,
        "range_unit": range_unit,
        "delimiter": delimiter,
    }
    _check_table(options)
    if poses not in {None, "odometry", "corrected"}:
        raise ValueError(f"poses must be 'odometry' or 'corrected', got {poses!r}")
    if name.startswith(example.SCHEME) and not Path(name).exists():
        _refuse(name, "an example", {"format": format, **options})
        return example.ExampleSource(name, range_max=range_max, poses=poses)
    if _is_live(name):
        if poses:
            raise SourceError(f"{name}: expected a log with {poses} poses, got a port: it has none")
        _refuse(name, "a port", {"format": format, **options})
        if name.startswith(SCHEME):
            return ReplaySource(name, on_error=on_error, range_max=range_max)
        return PortSource(*driver_of(name), name=name, range_max=range_max)
    log = Log(Path(name), on_error, range_max=range_max, wanted=poses, **options)
    found = find_format(log.path, format, columns=bool(columns))
    alien = {option: options[option] for option in options.keys() - set(FORMATS[found].options)}
    _refuse(name, f"the format {found!r}", alien)
    return LogSource(log, found)


def _check_table(options: dict[str, Any]) -> None:
    """Check the options of tables."""
    units: dict[str, Iterable[str]] = {
        "angle_unit": ANGLE_UNITS,
        "range_unit": RANGE_UNITS,
        "delimiter": DELIMITERS,
    }
    for option, known in units.items():
        if options[option] is not None and options[option] not in known:
            raise ValueError(f"{option} must be one of {', '.join(known)}, got {options[option]!r}")
    if options["columns"] is not None:
        if isinstance(options["columns"], str):
            raise ValueError(f"columns must be a sequence of names, got {options['columns']!r}")
        options["columns"] = tuple(options["columns"])
        check_columns(options["columns"])


def _is_live(name: str) -> bool:
    """Return whether `name` is the address of a port or replay, not a file.

    Raises
    ------
    SourceError
        If it is an address of another kind.
    """
    if Path(name).exists():
        return False
    if is_address(name) or name.startswith(SCHEME):
        return True
    if URL.match(name):
        schemes = ", ".join([*DRIVERS, SCHEME.rstrip(":"), example.SCHEME.rstrip(":")])
        raise SourceError(
            f"{name}: expected a file or folder, or an address that starts with one of {schemes}, "
            "as in urg:///dev/ttyACM0"
        )
    return False


def _refuse(name: str, what: str, options: Mapping[str, object]) -> None:
    for option, value in options.items():
        if value is not None:
            raise ValueError(f"{name}: {option} does not apply to {what}")
