"""``laserfeatures slam run``: what it writes, prints and refuses."""

import dataclasses
import json
import math
import signal

import numpy as np
import pytest
from cli_runs import fails, run
from recordings import DATA, needs_recordings
from scenes import needs_compiler
from slam_logs import drifted, drive, write_log

import laserfeatures as lf
from laserfeatures import registry
from laserfeatures.data import Pose2D
from laserfeatures.mapping.map_file import read_map
from laserfeatures.slam import EkfSlam, Motion

FILES = ["map.json", "map.png", "odometry.txt", "trajectory.txt"]
MOTION = ("--motion", "turn_by_way=3deg")
ATE = "ate_rmse"

pytestmark = needs_compiler


@pytest.fixture(scope="module")
def truth():
    return drive()


@pytest.fixture(scope="module")
def log(truth, tmp_path_factory):
    """A log with true poses and odometry, as the simulated robot's logs have them."""
    return write_log(tmp_path_factory.mktemp("logs") / "hall.log", truth, drifted(truth))


@pytest.fixture(scope="module")
def made(log, tmp_path_factory):
    """Run it with a reference; return the folder, the JSON and the output."""
    folder = tmp_path_factory.mktemp("slam")
    result = run(
        "slam", "run", log, "--reference", log, "-o", folder / "new" / "folder",
        "--json", folder / "s.json", "--landmarks", "corners", *MOTION,
    )  # fmt: skip
    assert result.exit_code == 0, result.output
    assert [path.name for path in folder.iterdir() if path.is_file()] == ["s.json"]
    document = json.loads((folder / "s.json").read_text(), parse_constant=pytest.fail)
    return folder / "new" / "folder", document, result


def json_of(tmp_path, *arguments):
    result = run("slam", "run", *arguments, "--json", tmp_path / "s.json")
    assert result.exit_code == 0, result.output
    return json.loads((tmp_path / "s.json").read_text(), parse_constant=pytest.fail), result


def notices_of(tmp_path, log, *arguments):
    """Return the notices, which also stand on standard error, one a line."""
    document, result = json_of(tmp_path, log, *arguments)
    lines = [f"laserfeatures: {notice}" for notice in document["notices"]]
    assert result.stderr.splitlines() == lines
    return document["notices"]


def test_slam_is_nearer_to_the_truth_than_odometry(made):
    _, found, _ = made
    assert found[ATE] < 0.03
    assert found[f"odometry_{ATE}"] > 0.1
    assert found["matched_by"] == "stamp"
    assert found["matched_poses"] == found["scans"] == 43


def test_the_summary_has_what_was_asked_for(made, truth):
    _, found, _ = made
    assert found["extractor"] == "direct_hough"
    assert (found["source"], found["reference"]) == ("hall.log", "hall.log")
    assert (found["landmark_kinds"], found["association"]) == ("corners", "joint")
    assert found["seconds"] == pytest.approx(42 * 0.25)
    assert found["landmarks"] == found["corners"] > 8
    assert found["walls"] == 0
    assert found["motion"]["turn_by_way"] == pytest.approx(math.radians(3))
    assert 0 < found["median_step_ms"] <= found["worst_step_ms"]
    assert found["notices"] == []
    assert {"rpe_translation", "rpe_rotation", "odometry_rpe_rotation"} < set(found)
    for values in found["steps"].values():
        assert len(values) == len(truth)
    assert found["steps"]["landmarks"][-1] == found["landmarks"]


def test_the_trajectories_are_in_the_frame_of_the_odometry(made, truth):
    folder, _, _ = made
    assert sorted(path.name for path in folder.iterdir()) == FILES
    found = np.loadtxt(folder / "trajectory.txt")
    np.testing.assert_allclose(found[:, 0], 0.25 * np.arange(43), atol=1e-9)
    places = [(pose.x, pose.y) for pose in truth]
    np.testing.assert_allclose(found[0, 1:3], places[0], atol=1e-6)
    np.testing.assert_allclose(found[:, 1:3], places, atol=0.2)
    odometry = np.loadtxt(folder / "odometry.txt")
    moved = [(pose.x, pose.y) for pose in drifted(truth)]
    np.testing.assert_allclose(odometry[:, 1:3], moved, atol=1e-5)


def test_the_map_has_the_corners_of_the_hallway(made):
    folder, found, _ = made
    landmarks = read_map(folder / "map.json")
    assert len(landmarks) == found["landmarks"]
    places = np.array([landmark.values for landmark in landmarks])
    for corner in [(10, 0), (10, 6), (9, 7), (7.6, 6)]:
        assert np.linalg.norm(places - corner, axis=1).min() < 0.2, corner
    assert (folder / "map.png").read_bytes().startswith(b"\x89PNG")


def test_the_terminal_has_a_short_aligned_summary(made):
    folder, found, result = made
    lines = result.stdout.splitlines()
    assert lines[0] == "source     hall.log (carmen)"
    assert lines[1] == "scans      43 in 10.5 s"
    assert lines[3] == f"landmarks  {found['corners']}: {found['corners']} corners, 0 walls"
    (row,) = [line for line in lines if line.startswith("ATE, rms [m]")]
    assert [float(cell) for cell in row.split()[3:]] == pytest.approx(
        [found[ATE], found[f"odometry_{ATE}"]], abs=1e-3
    )
    assert "43 poses matched by stamp" in lines
    assert lines[-1].endswith(f"are in {folder}")
    assert not result.stderr


def test_without_a_reference_errors_are_null_and_nothing_else_is_written(log, tmp_path):
    found, result = json_of(tmp_path, log, "--count", 12, "--landmarks", "walls")
    assert found["scans"] == 12
    assert found["walls"] == found["landmarks"] > 0
    for name in (ATE, f"odometry_{ATE}", "rpe_translation", "matched_by", "reference"):
        assert found[name] is None
    assert "ATE" not in result.stdout
    assert [path.name for path in tmp_path.iterdir()] == ["s.json"]


def test_a_log_of_odometry_alone_will_do(truth, tmp_path):
    log = write_log(tmp_path / "raw.log", truth, drifted(truth), corrected=False)
    found, _ = json_of(tmp_path, log, "--count", 20, "-e", "split_and_merge")
    assert (found["scans"], found["extractor"]) == (20, "split_and_merge")


def test_what_has_no_odometry_is_refused(truth, tmp_path):
    table = tmp_path / "scans.csv"
    table.write_text("stamp,-0.1,0.1\n5.0,2.0,1.0\n")
    assert "got one with no poses; SLAM needs" in fails("slam", "run", table)
    corrected = write_log(tmp_path / "c.log", truth, truth)
    line = fails("slam", "run", corrected)
    assert "corrected poses only; a SLAM program made them" in line
    assert "--reference" in line
    assert "got a port" in fails("slam", "run", "urg:///dev/nothing")
    empty = tmp_path / "empty.log"
    empty.write_text("NEFF 0.5 0 host 0\n")
    assert str(empty) in fails("slam", "run", empty)


@pytest.mark.parametrize(
    ("value", "message"),
    [
        ("wya=1", "has no 'wya'; did you mean 'way'?"),
        ("way=-1", "way must be >= 0 and finite, got -1.0"),
        ("turn=2m", "turn is an angle [rad], got the length '2m'"),
        ("0.1", "must be as in way=0.1,turn=3deg, got '0.1'"),
    ],
)
def test_a_wrong_deviation_is_named(log, value, message):
    assert message in fails("slam", "run", log, "--motion", value)


def test_the_help_names_all_deviations():
    words = run("slam", "run", "--help").stdout.split()
    assert {field.name for field in dataclasses.fields(Motion)} < set(words)


def test_a_reference_that_does_not_fit_is_refused_and_nothing_is_written(log, truth, tmp_path):
    def refused(reference, *rest):
        line = fails(
            "slam", "run", log, "--reference", reference, "-o", tmp_path / "out", *rest,
            "--json", tmp_path / "s.json",
        )  # fmt: skip
        assert not (tmp_path / "out").exists()
        assert not (tmp_path / "s.json").exists()
        return line

    other = tmp_path / "other.txt"
    other.write_text("".join(f"{900 + i} {i} 0 0 0 0 0 1\n" for i in range(7)))
    assert "got one of 7 poses (900.000 to 906.000 s) for 43 scans" in refused(other)
    raw = write_log(tmp_path / "raw.log", truth, drifted(truth), corrected=False)
    assert "got one with raw odometry" in refused(raw)
    assert "nothing.txt" in refused(tmp_path / "nothing.txt")
    still = tmp_path / "still.txt"
    still.write_text("".join(f"{i / 4} 1 2 0 0 0 0 1\n" for i in range(43)))
    assert "as a reference, expected a reference that moves" in refused(still)
    assert "at least 3 matched poses, got 2" in refused(log, "--count", 2)


def test_oddities_of_a_log_are_named_with_the_scans_numbers(truth, tmp_path):
    odometry = drifted(truth)
    stamps = 0.25 * np.arange(len(truth))
    stamps[10:] -= 0.9
    stamps[30:] += 7
    first = odometry[36]
    odometry[36:] = [Pose2D(p.x - first.x, p.y - first.y, p.theta) for p in odometry[36:]]
    log = write_log(tmp_path / "odd.log", truth, odometry, stamps)
    back, gap, jump = notices_of(tmp_path, log, "--start", 5)
    assert back.startswith("stamps run backwards from scan 9 to 10, by 0.65 s;")
    assert gap.startswith("a gap of 7.25 s from scan 29 to 30, in which odometry moved 0.")
    assert jump.startswith("odometry jumps from scan 35 to 36: it moved 9.")


def test_one_scan_gives_a_notice_and_complete_files(log, tmp_path):
    (only,) = notices_of(tmp_path, log, "--count", 1, "-o", tmp_path / "out")
    assert "only one scan" in only
    assert sorted(path.name for path in (tmp_path / "out").iterdir()) == FILES
    landmarks = read_map(tmp_path / "out" / "map.json")
    assert {landmark.sightings for landmark in landmarks} == {1}  # of a pose that is certain


def test_what_the_filter_says_of_itself_is_told(log, tmp_path, monkeypatch):
    step = EkfSlam.step  # the real one, which has no reason to say anything here

    def worried(self, odometry, features, start=None):
        made = step(self, odometry, features, start)
        return dataclasses.replace(made, notice="lost") if features.scan.stamp >= 2.5 else made

    monkeypatch.setattr(EkfSlam, "step", worried)
    assert notices_of(tmp_path, log, "--start", 3, "--count", 9) == ["scans 10 to 11: lost"]


@pytest.fixture
def registered(monkeypatch):
    """Register extractors that do something at the scan with a certain stamp."""
    monkeypatch.setattr(registry, "_registered", {})

    def register(name, stamp, act):
        def factory():
            inner = lf.get_extractor("direct_hough").detector

            def detect(scan):
                if scan.stamp == stamp:
                    act()
                return inner(scan)

            return detect

        lf.register_extractor(name, factory)

    return register


def test_ctrl_c_leaves_no_file_and_older_ones_as_they_were(log, tmp_path, registered):
    registered("interrupted", 5.0, lambda: signal.raise_signal(signal.SIGINT))
    out = tmp_path / "out"
    out.mkdir()
    (out / "map.json").write_text("older")
    result = run("slam", "run", log, "-e", "interrupted", "-o", out, "--json", tmp_path / "s.json")
    assert result.exit_code == 130
    assert [path.name for path in out.iterdir()] == ["map.json"]
    assert (out / "map.json").read_text() == "older"
    assert not (tmp_path / "s.json").exists()


def test_no_file_is_written_twice_or_over_an_input(log, tmp_path):
    out = ("-o", tmp_path)
    line = fails("slam", "run", log, *out, "--reference", tmp_path / "trajectory.txt")
    assert "trajectory.txt would overwrite another file of this run" in line
    assert "map.json would" in fails("slam", "run", log, *out, "--json", tmp_path / "map.json")
    assert "overwrite the input" in fails("slam", "run", log, "--json", log)
    assert not list(tmp_path.iterdir())


def test_an_extractor_that_fails_is_named_with_the_scan(log, registered):
    registered("failing", 5.0, lambda: 1 / 0)
    line = fails("slam", "run", log, "-e", "failing", "--start", 3)
    assert "extractor 'failing' failed at scan 20: ZeroDivisionError" in line


@needs_recordings
def test_a_real_log_with_a_reference_of_another_sensor(tmp_path):
    arena = DATA / "urg/brenner_robot4"
    found, _ = json_of(tmp_path, arena, "--reference", arena, "--count", 60)
    assert found["matched_by"] == "stamp"
    assert 40 < found["matched_poses"] <= 60
    assert found["rpe_rotation"] is None  # the marker's heading is not known
    assert found[ATE] < 0.1


def test_a_run_that_fails_leaves_no_folder(truth, tmp_path):
    poses = [*drifted(truth)]
    poses[3] = Pose2D(1e308, 0.0, 0.0)
    log = write_log(tmp_path / "far.log", truth, poses)
    error = fails("slam", "run", log, "-o", tmp_path / "new" / "folder")
    assert "scan 3: odometry must be finite and within 1e+07 m, got x = 1e+308 m" in error
    assert sorted(path.name for path in tmp_path.iterdir()) == ["far.log"]
    (tmp_path / "old").mkdir()
    fails("slam", "run", log, "-o", tmp_path / "old")
    assert (tmp_path / "old").is_dir()
