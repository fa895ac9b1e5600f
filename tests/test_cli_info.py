import math

import numpy as np
from cli_runs import carmen_log, run
from recordings import DATA, needs_recordings

from laserfeatures import LaserScan
from laserfeatures.cli.info import Summary


def told(*arguments):
    result = run("info", *arguments)
    assert result.exit_code == 0, result.stderr
    return dict(line.split("  ", 1) for line in result.stdout.splitlines())


def test_a_log_is_described(tmp_path):
    rows = {name: value.strip() for name, value in told(carmen_log(tmp_path / "a.log", 20)).items()}
    assert rows["format"] == "carmen"
    assert rows["scans"] == "20"
    assert rows["beams"] == "181"
    assert rows["field of view"] == "180.0 deg (-90.0 to 90.0), a beam every 1.00 deg"
    assert rows["time"] == "1.9 s, 10 scans/s (median)"
    assert rows["poses"] == "odometry"  # both poses of the log are the same


def summary(*scans):
    found = Summary()
    for scan in scans:
        found.add(scan)
    return dict(found.rows())


def scan(ranges, stamp=math.nan, **rest):
    return LaserScan.uniform(ranges, 0.0, 0.1, stamp=stamp, **rest)


def test_invalid_readings_and_ranges_are_counted():
    rows = summary(scan([1.0, math.inf, 3.0, 0.0]), scan([2.0, 2.0, math.nan, 5.0], range_max=4.0))
    assert rows["invalid readings"] == "50.0%"
    assert rows["ranges seen"] == "1.000 to 3.000 m"
    assert rows["range limits"] == "0 to inf m (and 1 other)"
    assert rows["time"] == "no time stamps"


def test_a_log_of_nothing_is_told_as_that():
    rows = summary()
    assert rows["scans"] == "0"
    assert rows["beams"] == rows["ranges seen"] == rows["invalid readings"] == "-"


def test_odd_scans_are_told_as_they_are():
    assert summary(scan([]))["field of view"] == "no beam"
    assert summary(scan([1.0]))["field of view"] == "one beam"
    rows = summary(*(scan([1.0, 1.0], stamp) for stamp in (1.0, 1.5, 1.2, 1.7, 2.2)))
    assert rows["time"] == "1.2 s, 2 scans/s (median), 1 step back in time"
    assert summary(*[scan([1.0], 3.0)] * 4)["time"] == "0.0 s, rate unknown"


@needs_recordings
def test_a_real_log_is_described():
    rows = told(DATA / "sick/csail.corrected.gfs.gz")
    assert rows["scans"].strip() == "406"
    assert rows["poses"].strip() == "odometry"
    assert np.isclose(float(rows["time"].split()[0]), 396, atol=1)
