"""Every bad input is one line that says what to do, status 2, and no file."""

import gzip

import pytest
from cli_runs import carmen_log, fails, run


@pytest.fixture
def log(tmp_path):
    return carmen_log(tmp_path / "hallway.log")


@pytest.mark.parametrize(
    ("arguments", "reason"),
    [
        (["-e", "direct_huogh"], "did you mean 'direct_hough'?"),
        (["-p", "theta_stp=1deg"], "did you mean 'theta_step'?"),
        (["-p", "theta_step=2cm"], "theta_step is an angle [rad], got the length '2cm'"),
        (["-p", "theta_step=-1deg"], "theta_step must be"),
        (["-p", "segment_filter.max_error=-1cm"], "max_error must be"),
        (["-p", "preset=papre"], "did you mean 'paper'?"),
        (["-p", "theta_step"], "--param takes name=value"),
        (["--format", "nonsense"], "nonsense"),
        (["--range-max", "-1m"], "range_max"),
        (["--range-max", "1deg"], "is a length [m], got the angle '1deg'"),
        (["--on-error", "ignore"], "'ignore' is not one of 'raise', 'skip'"),
        (["--start", "-1"], "-1 is not in the range x>=0"),
        (["--count", "0"], "0 is not in the range x>=1"),
        (["--nonsense"], "--nonsense"),
        (["more", "arguments"], "unexpected extra arguments"),
    ],
)
def test_a_wrong_argument(log, tmp_path, arguments, reason):
    assert reason in fails("extract", log, "-o", tmp_path / "out.csv", *arguments)
    assert [path.name for path in tmp_path.iterdir()] == ["hallway.log"]


@pytest.mark.parametrize("command", [["extract"], ["info"], ["plot", "--scan", "0"]])
@pytest.mark.parametrize(
    "content",
    [b"", b"\x00\xff\x93junk" * 100, b"no scan\n", gzip.compress(b"FLASER 3 1 1", mtime=0)[:-9]],
)
def test_an_input_that_is_no_log(tmp_path, command, content):
    (tmp_path / "bad").write_bytes(content)
    output = [] if command == ["info"] else ["-o", tmp_path / "out.png"]
    assert "bad" in fails(*command, tmp_path / "bad", *output)
    assert [path.name for path in tmp_path.iterdir()] == ["bad"]


def test_a_missing_file(tmp_path):
    assert "gone.log" in fails("extract", tmp_path / "gone.log")


def test_a_missing_folder_is_told_before_the_work(log, tmp_path):
    assert "make it first" in fails("extract", log, "-o", tmp_path / "no" / "out.csv")


def test_usage_errors_point_to_the_help():
    assert fails("nonsense").endswith("(see 'laserfeatures --help')\n")
    assert fails("extract").endswith("(see 'laserfeatures extract --help')\n")


def test_no_command_shows_the_help():
    result = run()
    assert result.exit_code == 2
    assert result.stderr.startswith("Usage: laserfeatures [OPTIONS] COMMAND")
    assert "\n    laserfeatures demo " in result.stderr


def test_a_skip_that_leaves_nothing_is_an_error(tmp_path):
    path = tmp_path / "all.log"
    path.write_text("FLASER 3 1 x 1 0 0 0 0 0 0 1 h 1\n" * 5)
    assert "all.log" in fails("extract", path, "--on-error", "skip")
