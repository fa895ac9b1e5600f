import re
import sys

import pytest
from cli_runs import carmen_log, fails, run

import laserfeatures as lf
from laserfeatures import registry
from laserfeatures.optional import install_line


@pytest.fixture
def log(tmp_path):
    return carmen_log(tmp_path / "hallway.log")


@pytest.mark.parametrize(
    ("name", "magic"), [("a.png", b"\x89PNG"), ("a.PDF", b"%PDF"), ("a.svg", b"<?xml")]
)
def test_the_ending_chooses_the_format(log, tmp_path, name, magic):
    result = run("plot", log, "--scan", 2, "-o", tmp_path / name)
    assert result.exit_code == 0, result.stderr
    assert not result.stdout
    assert re.fullmatch(
        r"laserfeatures: wrote scan 2 with \d+ lines, \d+ segments and \d+ corners \(\d+ real\) to "
        + re.escape(f"{tmp_path / name}\n"),
        result.stderr,
    )
    assert (tmp_path / name).read_bytes().startswith(magic)


@pytest.mark.parametrize("preset", [[], ["-p", "preset=paper"]])
def test_the_accumulator_widens_the_picture(log, tmp_path, preset):
    for name, flag in (("a.png", []), ("b.png", ["--accumulator"])):
        result = run("plot", log, "--scan", 2, "-o", tmp_path / name, *flag, *preset)
        assert result.exit_code == 0, result.stderr
    widths = [
        int.from_bytes((tmp_path / name).read_bytes()[16:20], "big") for name in ("a.png", "b.png")
    ]
    assert widths[1] > 1.5 * widths[0]


def test_a_detector_without_accumulator_is_named(log, tmp_path, monkeypatch):
    detector = lf.get_extractor("direct_hough").detector.__call__  # and no more than that
    monkeypatch.setitem(registry._registered, "plain", lambda: detector)
    arguments = ["plot", log, "--scan", 0, "-e", "plain", "-o", tmp_path / "a.png"]
    assert "extractor 'plain' has no accumulator" in fails(*arguments, "--accumulator")
    assert not (tmp_path / "a.png").exists()
    assert run(*arguments).exit_code == 0


def test_an_unknown_ending_names_the_known_ones(log, tmp_path):
    line = fails("plot", log, "--scan", 0, "-o", tmp_path / "a.xyz")
    assert ".png" in line
    assert ".pdf" in line


def test_a_scan_past_the_end_says_how_many_there_are(log, tmp_path):
    line = fails("plot", log, "--scan", 9, "-o", tmp_path / "a.png")
    assert "there is no scan 9: the log has 5, 0 to 4" in line
    assert not (tmp_path / "a.png").exists()


def test_without_matplotlib_the_extra_is_named(log, tmp_path, monkeypatch):
    monkeypatch.setitem(sys.modules, "matplotlib.figure", None)
    line = fails("plot", log, "--scan", 0, "-o", tmp_path / "a.png")
    assert install_line("plots") in line


def test_what_is_drawn_can_be_chosen(tmp_path):
    def said(*options):
        result = run("plot", "example:clutter", "--scan", 20, "-o", tmp_path / "a.png", *options)
        assert result.exit_code == 0, result.stderr
        return [
            int(number) for number in re.findall(r"(\d+) (?:lines|corners|real)", result.stderr)
        ]

    lines, corners, real = said()
    assert said("--real-only") == [lines, real, real]
    assert said("--max-sigma", "1cm")[1] < corners
    assert said("--min-evidence", 20)[0] < lines
