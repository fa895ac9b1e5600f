"""The real recordings, which lie beside the project and not in it."""

import gzip
from pathlib import Path
from typing import NamedTuple

import pytest

DATA = Path(__file__).parents[2] / "shared/data"
needs_recordings = pytest.mark.skipif(
    not DATA.is_dir(), reason="the recordings (../shared/data) are not here"
)


class Recording(NamedTuple):
    """What ../shared/data/README.md and a look at the file say of a recording."""

    path: str
    format: str
    scans: int
    beams: int
    field_of_view: float  # [degrees], first to last beam
    poses: str = "none"
    first_stamp: float | None = None  # [s]; None: the log has no stamps that tell time
    last_stamp: float | None = None
    no_returns: int = 0  # counted in the file's text: values at or above the log's code
    largest: float = 0.0  # [m], the largest true return in the file's text


RECORDINGS = [
    Recording(
        "sick/aces-corrected.log.gz",
        *("carmen", 440, 180, 179, "corrected", 21.0199, 1339.08, 620, 49.91),
    ),
    Recording(
        "sick/belgioioso-corrected.log.gz",
        *("carmen", 395, 361, 180, "corrected", None, None, 699, 79.34),
    ),
    Recording(
        "sick/csail-corrected.log.gz",
        *("carmen", 406, 361, 180, "corrected", None, None, 3907, 35.12),
    ),
    Recording(
        "sick/freiburg-101-corrected.log.gz",
        *("carmen", 292, 360, 179.5, "corrected", 158.415, 1077.35, 12555, 73.98),
    ),
    Recording(
        "sick/orebro-corrected.log.gz",
        *("carmen", 237, 181, 180, "corrected", None, None, 968, 32.63),
    ),
    Recording(
        "sick/seattle-corrected.log.gz",
        *("carmen", 241, 361, 180, "corrected", 1244.18, 2409.51, 707, 40.66),
    ),
    Recording(
        "sick/flirt_mit-cscail.log.gz",
        *("carmen", 1051, 361, 180, "corrected"),
        *(1134864629.895182, 1134865040.234209, 10649, 42.25),
    ),
    Recording(
        "sick/csail.corrected.gfs.gz",
        *("gfs", 406, 361, 180, "odometry"),
        *(1134864642.914187, 1134865038.743188, 3907, 35.12),
    ),
    Recording(
        "urg/breezy_exp1.dat.gz",
        *("breezyslam", 756, 682, 239.414, "odometry", 212.387282, 287.007421, 284922, 5.562),
    ),
    Recording(
        "urg/brenner_robot4", *("brenner", 278, 660, 231.68, "odometry", 0.315, 55.707, 41, 2.483)
    ),
    Recording("urg/frm_g5_Scan1.csv.gz", "urg_csv", 3, 682, 239.414),
    Recording("urg/frm_g5_Scan2.csv.gz", "urg_csv", 3, 682, 239.414),
    Recording("urg/frm_g5_Scan3.csv.gz", "urg_csv", 3, 682, 239.414),
    Recording("rplidar/tdt4856_points_8k_1.txt", "rplidar", 1, 567, 359.67),
    Recording("rplidar/tdt4856_points_dekk_8k_1.txt", "rplidar", 1, 847, 359.65),
    Recording(
        "rosbag/cartographer_data_hokuyo.bag",
        *("rosbag1", 427, 721, 180, "none", 1590384022.532645, 1590384033.191523),
    ),
    *(
        Recording(path, form, 1265, 512, 179.65, "none", 1403201183.698857, 1403201309.687908)
        for path, form in [
            ("rosbag/legtracker_demo_stationary_simple_environment.bag", "rosbag1"),
            ("ros2_converted/urg04lx_ros2_sqlite3", "rosbag2"),
            ("ros2_converted/urg04lx_ros2_sqlite3/urg04lx_ros2_sqlite3.db3", "rosbag2"),
            ("ros2_converted/urg04lx_ros2_mcap", "rosbag2"),
            ("ros2_converted/urg04lx_ros2_mcap/urg04lx_ros2_mcap.mcap", "mcap"),
        ]
    ),
]


def unpacked(path: str) -> bytes:
    """Return the content of a recording, unpacked."""
    raw = (DATA / path).read_bytes()
    return gzip.decompress(raw) if path.endswith(".gz") else raw


def lines_of(path: str, word: bytes, count: int) -> list[bytes]:
    """Return the first `count` lines of a recording that start with `word`."""
    lines = unpacked(path).splitlines(keepends=True)
    return [line for line in lines if line.startswith(word)][:count]
