"""``laserfeatures slam simulate``."""

import json
import sys
from importlib.resources import files

import numpy as np
import pytest
from click.testing import CliRunner
from robots import PLAN_FILE
from scenes import needs_compiler

import laserfeatures as lf
from laserfeatures.cli.group import NAME, CommandGroup
from laserfeatures.cli.slam_simulate import simulate
from laserfeatures.cli.slam_simulate_table import COLUMNS, table_of
from laserfeatures.cli.testbench_tables import print_page
from laserfeatures.comparison.document import Document
from laserfeatures.mapping.robot_motion import motion_of
from laserfeatures.optional import install_line
from laserfeatures.simulation import read_plan
from laserfeatures.simulation.robot import Robot
from laserfeatures.testbench.pages import Page

pytestmark = needs_compiler

PNG = b"\x89PNG"
SCORED = {
    "final_error", "odometry_final_error", "ate_rmse", "rpe_rmse", "nees_inside", "nees_mean",
    "nis_per_degree", "landmarks", "landmark_error", "spurious", "doubled", "virtual", "step_ms",
}  # fmt: skip


def run(*arguments):
    group = CommandGroup(NAME, commands=[simulate])
    return CliRunner().invoke(group, ["simulate", *map(str, arguments)])


def fails(*arguments):
    result = run(*arguments)
    assert result.exit_code == 2, result.output
    assert not result.stdout
    assert result.stderr.startswith("laserfeatures: error: ")
    assert result.stderr.count("\n") == 1
    return result.stderr


@pytest.fixture(scope="module")
def plan(tmp_path_factory):
    path = tmp_path_factory.mktemp("plan") / "room.toml"
    path.write_text(PLAN_FILE)
    return path


@pytest.fixture(scope="module")
def once(plan, tmp_path_factory):
    """Return the folder, JSON and output of the plain command."""
    folder = tmp_path_factory.mktemp("simulate")
    result = run(plan, "-o", folder / "new" / "folder", "--json", folder / "s.json")
    assert result.exit_code == 0, result.output
    found = json.loads((folder / "s.json").read_text(), parse_constant=pytest.fail)
    return folder / "new" / "folder", found, result.stdout


def test_it_draws_both_figures(once):
    folder, _, output = once
    assert sorted(path.name for path in folder.iterdir()) == ["fig8.png", "fig9.png"]
    for path in folder.iterdir():
        assert path.read_bytes().startswith(PNG)
    assert str(folder) in output


def test_its_json_has_what_it_was_made_with_and_what_came_of_it(once):
    _, found, output = once
    assert (found["plan"], found["landmarks"], found["seeds"]) == ("room.toml", "both", [3])
    assert found["motion"]["way"] == pytest.approx(motion_of(Robot()).way)
    (row,) = found["summary"]
    (drive,) = found["drives"]
    assert (row["extractor"], drive["extractor"], drive["seed"]) == ("direct_hough",) * 2 + (3,)
    assert set(drive) > SCORED
    assert set(row) > SCORED
    assert all(
        np.isfinite(value)
        for value in (*row.values(), *drive.values())
        if value != row["extractor"]
    )
    assert row["final_error"] == drive["final_error"] < 0.1
    assert "direct_hough" in output


@pytest.mark.parametrize("names", [["direct_hough"], lf.list_extractors(), ["x" * 70, "ransac"]])
def test_the_table_has_all_columns_within_100(names, once, capsys):
    rows = {name: dict.fromkeys(COLUMNS, 123.456) for name in names}
    print_page(Page("simulate", Document("A drive", [table_of(rows)]), {}))
    lines = capsys.readouterr().out.splitlines()
    assert max(map(len, lines)) <= 100
    for name in names:
        cells = [cell for line in lines if line.startswith(name) for cell in line.split()[1:]]
        assert len(cells) == len(COLUMNS)
    assert max(map(len, once[2].splitlines())) <= 100


def test_many_seeds_give_a_row_for_each_extractor_and_the_first_is_as_alone(plan, once, tmp_path):
    result = run(
        plan, "--seeds", 2, "--seed", 3, "-e", "direct_hough", "-e", "split_and_merge",
        "--json", tmp_path / "s.json", "--workers", 1,
    )  # fmt: skip
    assert result.exit_code == 0, result.output
    found = json.loads((tmp_path / "s.json").read_text())
    assert found["seeds"] == [3, 4]
    assert [row["extractor"] for row in found["summary"]] == ["direct_hough", "split_and_merge"]
    assert [row["drives"] for row in found["summary"]] == [2, 2]
    assert len(found["drives"]) == 4
    (alone,) = once[1]["drives"]
    first = found["drives"][0]
    assert {**first, "step_ms": 0} == {**alone, "step_ms": 0}
    assert found["drives"][2]["odometry_final_error"] != first["odometry_final_error"]
    assert sorted(path.name for path in tmp_path.iterdir()) == ["s.json"]  # no picture unasked


def test_landmarks_motion_and_parameters_reach_the_filter(plan, once, tmp_path):
    result = run(
        plan, "--landmarks", "walls", "--motion", "way=0.1", "-p", "theta_step=1deg",
        "-o", tmp_path, "--json", tmp_path / "s.json",
    )  # fmt: skip
    assert result.exit_code == 0, result.output
    found = json.loads((tmp_path / "s.json").read_text())
    assert found["motion"]["way"] == 0.1
    assert found["drives"][0]["virtual"] == 0
    assert found["drives"][0]["landmarks"] != once[1]["drives"][0]["landmarks"]


def test_pictures_of_several_extractors_have_their_names(plan, tmp_path):
    result = run(plan, "-e", "direct_hough", "-e", "split_and_merge", "-o", tmp_path)
    assert result.exit_code == 0, result.output
    assert {path.name for path in tmp_path.iterdir()} == {
        f"{figure}_{name}.png"
        for figure in ("fig8", "fig9")
        for name in ("direct_hough", "split_and_merge")
    }


def test_the_packages_own_plan_is_a_loop_of_60_metres():
    drive = read_plan(files("laserfeatures.simulation") / "office.toml").drive
    assert np.linalg.norm(np.diff(drive.waypoints, axis=0), axis=1).sum() > 60
    assert drive.waypoints[0].tolist() == drive.waypoints[-1].tolist()


WORLD = "[[outline]]\npoints = [[0, 0], [5, 0], [5, 4], [0, 4]]\n"


@pytest.mark.parametrize(
    ("text", "expected"),
    [
        (None, "cannot be read"),
        (WORLD, "expected a plan with a drive"),
        (f"{WORLD}[drive]\nwaypoints = [[1, 1]]\n", "waypoints"),
        (f"{WORLD}[drive]\nwaypoints = [[1, 1], [9, 1]]\n", "stuck"),
    ],
)
def test_a_plan_that_cannot_be_driven_is_named_and_leaves_nothing(tmp_path, text, expected):
    path = tmp_path / "plan.toml"
    if text is not None:
        path.write_text(text)
    line = fails(path, "-o", tmp_path / "out", "--json", tmp_path / "s.json")
    assert "plan.toml" in line
    assert expected in line
    assert not (tmp_path / "s.json").exists()
    assert not any((tmp_path / "out").glob("*"))


@pytest.mark.parametrize(
    ("arguments", "expected"),
    [
        (["-e", "direct_houg"], "direct_hough"),
        (["-e", "ransac", "-e", "ransac"], "-e names 'ransac' twice"),
        (["--seeds", 2, "-p", "theta_step=1deg"], "-p sets parameters of the extractors"),
        (["-p", "theta_stepp=1deg"], "theta_step"),
        (["--seeds", 0], "--seeds"),
        (["--landmarks", "poles"], "poles"),
    ],
)
def test_a_wrong_option_is_one_line(plan, arguments, expected):
    assert expected in fails(plan, *arguments)


def test_a_folder_that_cannot_be_made_and_the_plan_as_output_are_refused(plan, tmp_path):
    (tmp_path / "file").write_text("")
    assert "cannot be made" in fails(plan, "-o", tmp_path / "file" / "folder")
    assert "would overwrite the input" in fails(plan, "-o", tmp_path, "--json", plan)
    assert plan.read_text() == PLAN_FILE


def test_without_mujoco_it_says_what_to_install(plan, tmp_path, monkeypatch):
    monkeypatch.setitem(sys.modules, "mujoco", None)
    assert install_line("sim") in fails(plan, "-o", tmp_path)


def test_an_extractor_that_breaks_is_named(plan, tmp_path, monkeypatch):
    def broken(*_):
        raise ZeroDivisionError("oh")

    monkeypatch.setattr(type(lf.get_extractor("ransac").detector), "__call__", broken)
    line = fails(plan, "-e", "ransac", "-o", tmp_path)
    assert "ransac failed at scan 0: ZeroDivisionError: oh" in line
    assert not list(tmp_path.iterdir())
