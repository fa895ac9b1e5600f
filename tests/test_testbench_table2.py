"""Table II on simulated logs, for the counts, and on a recording."""

from dataclasses import fields
from pathlib import Path

import numpy as np
import pytest
from recordings import DATA, needs_recordings
from test_testbench_real_map import drive

from laserfeatures.errors import SourceError
from laserfeatures.registry import list_extractors
from laserfeatures.testbench import table2
from laserfeatures.testbench.paper import TABLE2
from laserfeatures.testbench.real.map_picture import map_png
from laserfeatures.testbench.real.recordings import RECORDINGS, Recording

BLANK = "FLASER 181 " + " ".join(["81.9"] * 181) + " 0 0 0 0 0 0 {0} host {0}\n"


def write_log(path: Path, scans):
    """Write a CARMEN log with corrected poses."""
    lines = ["NEFF 0 1\n"]
    for number, scan in enumerate(scans):
        ranges = " ".join(f"{r:.3f}" for r in np.where(scan.valid, scan.ranges, 81.9))
        pose = f"{scan.pose.x:.4f} {scan.pose.y:.4f} {scan.pose.theta:.5f}"
        lines.append(f"FLASER {len(scan)} {ranges} {pose} {pose} {number}.0 host {number}.0\n")
    path.write_text("".join(lines))


@pytest.fixture(scope="module")
def folder(tmp_path_factory):
    data = tmp_path_factory.mktemp("data")
    write_log(data / "room.log", drive(24)[1])
    (data / "blank.log").write_text("".join(BLANK.format(k) for k in range(5)))
    return data


ROOM = (Recording("room", "room.log", "map"), Recording("blank", "blank.log", "none"))


@pytest.fixture(scope="module")
def result(folder):
    return table2.run(folder, recordings=ROOM)


def test_the_rows_are_the_papers_and_the_counts_add_up(result):
    assert [row["neighborhood"] for row in result.log_rows] == [
        [row.v_theta, row.v_d] for row in TABLE2
    ]
    assert [row["paper"]["tp_percent"] for row in result.log_rows] == [
        row.tp_percent for row in TABLE2
    ]
    for row in [*result.log_rows, *result.log_defaults]:
        assert row["scans"] == 24
        assert row["real_features"] == result.recordings[0]["true_corners"] > 24
        share = row["features_matched"] / row["real_features"]
        assert row["tp_percent"] == pytest.approx(100 * share)
        assert row["needlessly_blind"] <= min(row["blind_scans"], row["unseeing_scans"])
        assert row["features_judged"] <= row["features_extracted"]
    assert [row["scans"] for row in result.rows] == [0] * 6  # there is no arena


def test_the_defaults_find_the_corners_of_the_room(result):
    rows = {row["extractor"]: row for row in result.log_defaults}
    assert set(rows) == {*list_extractors(), "oracle"}
    for name in ("direct_hough", "ransac", "split_and_merge", "oracle"):
        assert rows[name]["tp_percent"] > 85
        assert rows[name]["fp_judged_percent"] < 15
        assert rows[name]["median_error"] < 0.03


def test_blind_scans_are_counted_with_and_without_truth(result):
    room, blank, every = result.blind
    assert (room["recording"], room["scans"], room["direct_hough"]) == ("room", 24, 0)
    assert set(blank.values()) == {"blank", 5}  # nothing to be found by anybody
    assert every["direct_hough"] == 5
    assert every["scans"] == 29


def test_two_workers_count_the_same(folder, result):
    again = table2.run(folder, recordings=ROOM, workers=2)
    for item in fields(result):
        if item.name != "maps":
            one, two = (_timeless(getattr(each, item.name)) for each in (result, again))
            assert one == two


def _timeless(rows):
    return [{k: repr(v) for k, v in row.items() if k != "time_ms"} for row in rows]


def test_the_map_is_drawn(result):
    png = map_png(result.maps["room"])
    assert png.startswith(b"\x89PNG")
    assert 5_000 < len(png) < 300_000


def test_a_missing_folder_is_named(tmp_path):
    with pytest.raises(SourceError, match="nowhere: expected the folder of the recordings"):
        table2.run(tmp_path / "nowhere")


def test_a_missing_recording_is_named(tmp_path):
    with pytest.raises(SourceError, match=r"room\.log"):
        table2.run(tmp_path, recordings=ROOM)


def test_a_damaged_recording_is_named_with_its_line(folder, tmp_path):
    text = (folder / "room.log").read_text()
    (tmp_path / "room.log").write_text(text[: len(text) // 2])
    with pytest.raises(SourceError, match=r"room\.log:14: expected a record"):
        table2.run(tmp_path, recordings=ROOM)


@needs_recordings
def test_a_recording_without_truth_has_blind_scans_only():
    frm = next(recording for recording in RECORDINGS if recording.name == "frm 1")
    result = table2.run(DATA, recordings=[frm])
    assert result.blind[0]["scans"] == 3
    assert result.details == []
