import sys

import numpy as np
from cli_runs import fails, run

import laserfeatures as lf
from laserfeatures.cli.tour import tour
from laserfeatures.optional import install_line
from laserfeatures.simulation import hallway


def test_the_demo_prints_a_table_and_draws_a_picture(tmp_path):
    result = run("demo", "-o", tmp_path / "demo.png")
    assert result.exit_code == 0, result.stderr
    assert (tmp_path / "demo.png").read_bytes().startswith(b"\x89PNG")
    rows = result.stdout.splitlines()
    assert rows[0].split()[:3] == ["scan", "x", "[m]"]
    assert len([row for row in rows if row[:4].strip().isdigit()]) == len(hallway()[1])
    assert str(tmp_path / "demo.png") in result.stdout


def test_the_default_finds_corners_to_a_centimetre():
    visits = list(tour(lf.get_extractor("direct_hough"), *hallway()))
    errors = np.concatenate([visit.errors for visit in visits])
    assert errors.size > 50
    assert np.median(errors) < 0.01


def test_without_matplotlib_the_table_is_still_printed(tmp_path, monkeypatch):
    monkeypatch.setitem(sys.modules, "matplotlib.figure", None)  # makes its import fail
    result = run("demo", "-o", tmp_path / "demo.png")
    assert result.exit_code == 0
    assert install_line("plots") in result.stderr
    assert "all" in result.stdout
    assert not list(tmp_path.iterdir())


def test_an_ending_that_is_no_picture_is_told_first(tmp_path):
    assert "must end in one of" in fails("demo", "-o", tmp_path / "demo.xyz")
