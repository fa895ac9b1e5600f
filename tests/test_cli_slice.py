"""``--slice``: point clouds on the command line."""

import json

import clouds
import pytest
from cli_runs import carmen_log, fails, run, start
from clouds import o3d


@pytest.fixture(scope="module")
def room(tmp_path_factory):
    path = tmp_path_factory.mktemp("clouds") / "room.pcd"
    o3d.io.write_point_cloud(str(path), clouds.room(sigma=0.01))
    return path


def test_the_corners_of_a_room_from_end_to_end(room):
    with start("extract", room, "--slice", "0.3m..0.5m") as process:
        out, err = process.communicate(timeout=120)
    assert err.startswith(b"laserfeatures: wrote 1 scan with ")
    assert err.count(b"\n") == 1
    record = json.loads(out)
    positions = [(corner["x"], corner["y"]) for corner in record["corners"]]
    clouds.check_corners(positions, [corner["real"] for corner in record["corners"]])


@pytest.mark.parametrize("band", ["0.3..0.5", "30cm..500mm", " 0.3m .. 0.5m ", ".3m..+5e-1m"])
def test_the_band_in_other_words(room, band):
    said = run("extract", room, "--slice", band)
    assert said.output == run("extract", room, "--slice", "0.3m..0.5m").output
    assert said.exit_code == 0


def test_the_scanner_stands_where_it_is_told_to(room):
    said = run("extract", room, "--slice", "0.3m..0.5m", "--origin", "50cm,-0.25m")
    record = json.loads(said.stdout)
    positions = [(corner["x"] + 0.5, corner["y"] - 0.25) for corner in record["corners"]]
    clouds.check_corners(positions, [corner["real"] for corner in record["corners"]])


def test_a_scanner_on_a_wall_is_refused(tmp_path):
    box = o3d.geometry.TriangleMesh.create_box(4.0, 3.0, 2.0)  # one corner at the origin
    path = tmp_path / "box.pcd"
    o3d.io.write_point_cloud(str(path), box.sample_points_uniformly(100_000))
    said = fails("extract", path, "--slice", "0.3m..0.5m")
    assert "points of the band within 0.05 m of x, y = 0, 0 m" in said
    assert "--origin" in said
    assert run("extract", path, "--slice", "0.3m..0.5m", "--origin", "2,1.5").exit_code == 0
    log = carmen_log(tmp_path / "run.log")
    assert "slice_origin does not apply" in fails("info", log, "--origin", "1,1")
    assert "'--origin': must be two numbers as in 0.3m,0.5m" in fails("info", log, "--origin", "1")


def test_other_commands_slice_as_well(room, tmp_path):
    said = run("info", room, "--slice", "+0.1m..0.6m", "--range-max", "5m")
    assert said.exit_code == 0
    assert "point_cloud" in said.output
    assert "720" in said.output
    picture = tmp_path / "scan.png"
    done = run("plot", room, "--slice", "0.3..0.5", "--scan", 0, "-o", picture)
    assert done.exit_code == 0, done.output
    assert picture.stat().st_size > 10_000


@pytest.mark.parametrize(
    ("band", "reason"),
    [
        ("0.3m", "'--slice': must be two numbers as in 0.3m..0.5m, got '0.3m'"),
        ("", "'--slice': must be two numbers as in 0.3m..0.5m, got ''"),
        ("1..2..3", "'--slice': must be two numbers as in 0.3m..0.5m, got '1..2..3'"),
        ("0.3m..", "'--slice': must be a number [m], got ''"),
        ("low..high", "'--slice': must be a number [m], got 'low'"),
        ("0.3..20deg", "'--slice': is a length [m], got the angle '20deg'"),
        ("0.3..5in", "'--slice': has no unit 'in'"),
        ("0.5m..0.3m", "slice_band must be low < high [m], got 0.5 and 0.3"),
        ("3m..4m", "expected points with 3 <= z < 4 m, got none"),
    ],
)
def test_a_band_that_makes_no_sense(room, band, reason):
    assert reason in fails("extract", room, "--slice", band)


def test_the_band_is_asked_for_and_refused(room, tmp_path):
    said = fails("info", room)
    assert "room.pcd: expected a band of heights, got none: the cloud spans z = -0.0" in said
    assert said.endswith("(--slice LOW..HIGH)\n")
    log = carmen_log(tmp_path / "run.log")
    said = fails("info", log, "--slice", "0.3..0.5")
    assert "slice_band does not apply to the format 'carmen'" in said


def test_a_broken_cloud_is_one_line(tmp_path, capfd):
    path = tmp_path / "cut.ply"
    o3d.io.write_point_cloud(str(path), clouds.cloud_of([(1, 2, 3)] * 9))
    path.write_bytes(path.read_bytes()[:-5])
    assert "bytes of points, got" in fails("extract", path, "--slice", "0..4")
    assert capfd.readouterr() == ("", "")
