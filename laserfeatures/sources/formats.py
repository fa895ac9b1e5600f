"""The table of formats, and telling them apart by content."""

from collections.abc import Callable
from pathlib import Path
from typing import NamedTuple

from laserfeatures.errors import SourceError
from laserfeatures.point_clouds import is_point_cloud
from laserfeatures.registry import near_names
from laserfeatures.sources.bag_file import ZSTD_MAGIC
from laserfeatures.sources.breezy import is_breezy, read_breezy
from laserfeatures.sources.brenner import is_brenner, read_brenner, scan_files
from laserfeatures.sources.carmen import is_carmen, read_carmen
from laserfeatures.sources.files import check_regular, is_gzip, read_head
from laserfeatures.sources.gfs import is_gfs, read_gfs
from laserfeatures.sources.log import Log, Scans
from laserfeatures.sources.npz import read_npz
from laserfeatures.sources.point_cloud import read_cloud
from laserfeatures.sources.recording import is_recording, read_recording
from laserfeatures.sources.rosbag import MAGIC, read_bag
from laserfeatures.sources.rplidar import is_rplidar, read_rplidar
from laserfeatures.sources.simulated import is_plan, read_simulated
from laserfeatures.sources.table import WANTED, is_table, read_table
from laserfeatures.sources.urg_csv import is_urg_csv, read_urg_csv


class Format(NamedTuple):
    """How a format is told and read, which options it takes besides `on_error`, and more."""

    is_it: Callable[[bytes], bool]
    read: Callable[[Log], Scans]
    options: tuple[str, ...] = ("range_max",)
    gzip: bool = True
    open_limit: bool = False  # whether the range limit may be unknown, or wrong


def _starts(magic: bytes) -> Callable[[bytes], bool]:
    return lambda head: head.startswith(magic)


SICK = ("range_max", "field_of_view")
TABLE = ("range_max", "columns", "angle_unit", "range_unit", "delimiter")
BAG = ("range_max", "topic")
CLOUD = ("range_max", "slice_band", "slice_origin")
FORMATS = {  # in the order in which they are tried: the unmistakable ones first
    "rosbag1": Format(_starts(MAGIC[".bag"]), read_bag, BAG, gzip=False, open_limit=True),
    "rosbag2": Format(_starts(MAGIC[".db3"]), read_bag, BAG, gzip=False, open_limit=True),
    "mcap": Format(_starts(MAGIC[".mcap"]), read_bag, BAG, gzip=False, open_limit=True),
    "point_cloud": Format(is_point_cloud, read_cloud, CLOUD, gzip=False),
    "recording": Format(is_recording, read_recording),
    "npz": Format(_starts(b"PK"), read_npz, open_limit=True),
    "plan": Format(is_plan, read_simulated, gzip=False),
    "gfs": Format(is_gfs, read_gfs, SICK),
    "carmen": Format(is_carmen, read_carmen, SICK),
    "brenner": Format(is_brenner, read_brenner),
    "rplidar": Format(is_rplidar, read_rplidar, open_limit=True),
    "urg_csv": Format(is_urg_csv, read_urg_csv),
    "csv": Format(is_table, read_table, TABLE, open_limit=True),
    "breezyslam": Format(is_breezy, read_breezy),
}


def find_format(path: Path, name: str | None, *, columns: bool = False) -> str:
    """Return the name of the format of the file or folder at `path`, by its content.

    It is a table if its `columns` are named.

    Raises
    ------
    SourceError
        If it cannot be opened, is empty, or is none of the formats.
    ValueError
        If `name` is given and is no format's.
    """
    check_regular(path)
    if name is not None:
        if name not in FORMATS:
            raise ValueError(f"there is no format {name!r}; {near_names(name, FORMATS)}")
        return name
    if path.is_dir():
        return _folder_format(path)
    if columns:
        return "csv"
    head = read_head(path)
    if head.startswith(ZSTD_MAGIC):
        raise SourceError(
            f"{path}: expected a file that is not packed, got one packed with zstd; pass the "
            "folder of the bag that it is of, or unpack it first"
        )
    found = next((name for name, format_ in FORMATS.items() if format_.is_it(head)), None)
    if found is None:
        raise SourceError(
            f"{path}: expected one of the formats {', '.join(FORMATS)}, got a file that starts "
            f"with {head[:24]!r}; name its format with format= (--format), or write a table with "
            f"the header {WANTED}"
        )
    if not FORMATS[found].gzip and is_gzip(path):
        raise SourceError(
            f"{path}: expected a {found} file that is not packed, got gzip; gunzip it first"
        )
    return found


def _folder_format(path: Path) -> str:
    if (path / "metadata.yaml").is_file():
        return "rosbag2"
    if scan_files(path):
        return "brenner"
    raise SourceError(
        f"{path}: expected a ROS 2 bag (a folder with metadata.yaml) or a folder with a file of S "
        "records, got neither; pass the file itself"
    )
