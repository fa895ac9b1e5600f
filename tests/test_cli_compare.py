import re
import signal
import sys

import pytest
from cli_runs import ENTRY, carmen_log, fails, run, start
from recordings import DATA, needs_recordings
from scenes import needs_compiler

import laserfeatures as lf
from laserfeatures import registry
from laserfeatures.cli import extractor_list
from laserfeatures.comparison import Failure
from laserfeatures.optional import install_line

PNG = b"\x89PNG\r\n\x1a\n"
BOTH = ("--extractors", "direct_hough,direct_hough:theta_step=2deg")
SLOW = """
import sys, time
import laserfeatures as lf

def detector(scan):
    print("working", file=sys.stderr, flush=True)
    time.sleep(60)

lf.register_extractor("slow", lambda: detector)
""" + ENTRY  # fmt: skip


@pytest.fixture
def log(tmp_path):
    return carmen_log(tmp_path / "hallway.log")


@pytest.fixture
def register(monkeypatch):
    def add(name, factory):
        monkeypatch.setitem(registry._registered, name, factory)

    return add


def names(folder):
    return sorted(path.name for path in folder.iterdir())


def rows(stdout):
    """Return the cells of each numbered row by the extractor's name, agreement apart."""
    first, _, second = stdout.partition("\n\n")
    return [
        {line.split()[1]: line.split()[2:] for line in part.splitlines() if re.match(r"\d ", line)}
        for part in (first, second)
    ]


def raising(error, *, at=0.0):
    detector = lf.get_extractor("direct_hough").detector

    def fragile(scan):
        if scan.stamp >= at - 0.01:
            raise error
        return detector(scan)

    return lambda: fragile


def test_a_table_and_nothing_else(log, tmp_path):
    result = run("compare", log, *BOTH)
    assert result.exit_code == 0, result.stderr
    assert not result.stderr
    measured, agreement = rows(result.stdout)
    extractor = lf.get_extractor("direct_hough")
    with lf.open_source(log) as scans:
        found = [extractor(scan) for scan in scans]
    median, p99, lines, corners, real, blind, again, judged, in_sight = measured["direct_hough"]
    assert 1 < float(median) <= float(p99)
    assert lines == f"{sum(len(f.lines) for f in found) / 5:.2f}"
    assert corners == f"{sum(len(f.corners) for f in found) / 5:.2f}"
    assert real == f"{sum(f.corners.real.sum() for f in found) / 5:.2f}"
    assert blind == "0"
    assert 0 < float(again) < 1
    assert 0 < float(in_sight) < 1
    assert 0 < int(judged) <= sum(len(f.corners) for f in found)
    assert [list(map(float, row)) for row in agreement.values()] == [
        [pytest.approx(0.8, abs=0.2)]
    ] * 2
    assert names(tmp_path) == ["hallway.log"]


def test_the_table_fits_and_is_aligned(log, register):
    register("region_growing_or_so", lambda: lf.get_extractor("direct_hough").detector)
    register("wordy", raising(ValueError("word " * 40)))
    wanted = [
        "direct_hough", "direct_hough:preset=paper", "region_growing_or_so", "wordy",
        "direct_hough:theta_step=2deg:distance_step=4cm:segment_filter.max_error=3cm",
        "direct_hough:min_points=6",
    ]  # fmt: skip
    lines = run("compare", log, "--extractors", ",".join(wanted)).stdout.splitlines()
    assert max(map(len, lines)) <= 100
    head = lines[0]
    figures = [line for line in lines[1:] if re.search(r"\d\.\d\d +\d+ +\d\.\d\d$", line)]
    assert len(figures) == 5
    assert {len(line) for line in figures} == {len(head)}
    assert "word word" in lines[5]
    assert lines[4].startswith("4 wordy ")


def test_the_default_is_every_extractor():
    assert tuple(extractor_list.make_all(None)) == lf.list_extractors()


def test_a_comma_inside_a_value_is_no_end():
    made = extractor_list.make_all(
        "direct_hough:preset=paper:neighborhood=11,21 , direct_hough:min_points=5"
    )
    assert list(made) == [
        "direct_hough:preset=paper:neighborhood=11,21",
        "direct_hough:min_points=5",
    ]
    paper, ours = made.values()
    assert paper.detector.neighborhood == (11, 21)
    assert ours.detector.min_points == 5


@pytest.mark.parametrize(
    ("wanted", "says"),
    [
        ("direct_hough,direct_huogh", "no extractor is named 'direct_huogh'; did you mean"),
        ("direct_hough:theta_stop=1deg", "no parameter 'theta_stop'; did you mean 'theta_step'"),
        ("direct_hough:theta_step", "takes name=value, got 'theta_step'"),
        ("direct_hough:theta_step=-1deg", "theta_step must"),
        ("direct_hough:preset=papre", "no preset 'papre'; did you mean 'paper'"),
        ("direct_hough,direct_hough", "names 'direct_hough' twice"),
        ("", "no extractor is named ''"),
        ("direct_hough,", "no extractor is named"),
    ],
)
def test_what_is_mistyped_stops_before_anything_is_read(tmp_path, wanted, says):
    assert says in fails("compare", tmp_path / "no.log", "--extractors", wanted)


def test_one_that_raises_has_that_in_its_row_and_the_others_finish(log, register, tmp_path):
    register("fragile", raising(ZeroDivisionError("oh\nno"), at=0.2))
    wanted = ("--extractors", "fragile,direct_hough")
    result = run("compare", log, *wanted, "-o", tmp_path / "report.md")
    assert result.exit_code == 0, result.stderr
    assert "1 fragile       failed at scan 2: ZeroDivisionError: oh no\n" in result.stdout
    assert len(rows(result.stdout)[0]["direct_hough"]) == 9
    assert "failed at scan 2: ZeroDivisionError: oh no |" in (tmp_path / "report.md").read_text()
    assert "failed at scan 4" in run("compare", log, *wanted, "--start", 4).stdout


def test_one_that_cannot_be_made_has_that_in_its_row(log, register):
    def shy():
        raise RuntimeError("no licence")

    def needy(*, size):
        return size

    register("shy", shy)
    register("needy", needy)
    result = run("compare", log, "--extractors", "shy,needy,direct_hough")
    assert result.exit_code == 0, result.stderr
    assert "extractor 'shy' cannot be made: RuntimeError: no licence" in result.stdout
    assert "2 needy" in result.stdout
    assert "'size'" in result.stdout


def test_if_none_finishes_that_is_an_error(log, register, tmp_path):
    register("one", raising(ZeroDivisionError("oh\nno"), at=0.1))
    register("two", raising(ValueError("never")))
    assert "error: one failed at scan 1: ZeroDivisionError: oh no\n" in fails(
        "compare", log, "--extractors", "one"
    )
    line = fails("compare", log, "--extractors", "two,one", "-o", tmp_path / "report.html")
    assert "none of 2 extractors finished; the first, two, failed at scan 0: ValueError" in line
    assert names(tmp_path) == ["hallway.log"]


def test_start_and_count_choose_scans(log):
    first = run("compare", log, *BOTH, "--start", 1, "--count", 2).stdout
    assert "hallway.log: 2 scans" in first
    extractor = lf.get_extractor("direct_hough")
    with lf.open_source(log) as scans:
        found = [len(extractor(scan).lines) for scan in scans]
    assert rows(first)[0]["direct_hough"][2] == f"{sum(found[1:3]) / 2:.2f}"
    assert "there is no scan 5: the log has 5, 0 to 4" in fails("compare", log, "--start", 5)


def test_markdown_lies_beside_its_pictures(log, tmp_path):
    result = run("compare", log, *BOTH, "-o", tmp_path / "my report.md", "--scan", 3)
    assert result.exit_code == 0, result.stderr
    assert rows(result.stdout)[0]
    page = (tmp_path / "my report.md").read_text(encoding="utf-8")
    linked = re.findall(r"!\[[^\]]+\]\(<([^>]+)>\)", page)
    assert len(linked) == 4
    assert names(tmp_path) == sorted(["hallway.log", "my report.md", *linked])
    assert all((tmp_path / name).read_bytes().startswith(PNG) for name in linked)
    assert "Scan 3 in the sensor's frame" in page
    assert "| format | carmen |" in page
    assert "| poses | raw odometry" in page


def test_a_page_is_one_file(log, tmp_path):
    result = run("compare", log, *BOTH, "-o", tmp_path / "report.HTML")
    assert result.exit_code == 0, result.stderr
    assert names(tmp_path) == ["hallway.log", "report.HTML"]
    assert (tmp_path / "report.HTML").read_text(encoding="utf-8").count("data:image/png") == 4


@pytest.mark.parametrize("blocked", ["report-speed.png", "report-scan-2-direct_hough.png"])
def test_a_report_is_whole_or_absent(log, register, tmp_path, blocked):
    register("other", lambda: lf.get_extractor("direct_hough").detector)
    (tmp_path / blocked).mkdir()
    wanted = ("--extractors", "other,direct_hough")
    result = run("compare", log, *wanted, "-o", tmp_path / "report.md")
    assert result.exit_code == 2
    assert f"{blocked} is a folder" in result.stderr
    assert names(tmp_path) == sorted(["hallway.log", blocked])


@pytest.mark.parametrize("name", ["report.md", "report.html"])
def test_a_signal_leaves_nothing(log, tmp_path, name):
    arguments = ("compare", log, "--extractors", "slow", "-o", tmp_path / name)
    with start(*arguments, code=SLOW) as process:
        assert process.stderr.readline() == b"working\n"
        process.send_signal(signal.SIGINT)
        said = process.stderr.read()
        assert process.wait(timeout=60) == 130
    assert b"interrupted" in said
    assert b"Traceback" not in said
    assert names(tmp_path) == ["hallway.log"]


@pytest.mark.parametrize(
    ("arguments", "says"),
    [
        (("-o", "report.pdf"), "must end in .md or .html; got 'report.pdf'"),
        (("-o", "missing/report.md"), "make it first"),
        (("--scan", "2"), "needs -o"),
        (("-o", "report.md", "--scan", "5"), "--scan 5 is none of the scans read, 0 to 4"),
    ],
)
def test_a_report_that_cannot_be_is_refused_at_once(log, tmp_path, monkeypatch, arguments, says):
    monkeypatch.chdir(tmp_path)
    assert says in fails("compare", log, *BOTH, *arguments)
    assert names(tmp_path) == ["hallway.log"]


def test_without_matplotlib_there_is_a_table_but_no_report(log, tmp_path, monkeypatch):
    monkeypatch.setitem(sys.modules, "matplotlib.figure", None)
    assert run("compare", log, *BOTH).exit_code == 0
    line = fails("compare", log, *BOTH, "-o", tmp_path / "report.md")
    assert install_line("plots") in line
    assert names(tmp_path) == ["hallway.log"]


def test_without_poses_the_table_says_so(tmp_path):
    log = tmp_path / "log.csv"
    log.write_text("stamp,-0.1,0.0,0.1\n1,2.01,2.0,2.01\n2,2.01,2.0,2.01\n")
    result = run("compare", log, *BOTH)
    assert result.exit_code == 0, result.stderr
    assert "no two scans in a row have poses" in " ".join(result.stdout.split())
    assert rows(result.stdout)[0]["direct_hough"][-3:] == ["-"] * 3


def test_the_shell_completes_the_last_name():
    offers = extractor_list.complete(None, None, "other,direct")
    assert [offer.value for offer in offers] == ["other,direct_hough"]


def test_failures_to_be_made_keep_the_reason(register):
    def shy():
        raise RuntimeError("no licence")

    register("shy", shy)
    (failure,) = extractor_list.make_all("shy").values()
    assert isinstance(failure, Failure)
    assert failure.scan is None


@needs_compiler
@needs_recordings
@pytest.mark.parametrize("ending", ["md", "html"])
def test_a_recording_from_end_to_end(tmp_path, ending):
    log = DATA / "sick/aces-corrected.log.gz"
    wanted = ("--extractors", "direct_hough,direct_hough:preset=paper")
    result = run("compare", log, *wanted, "--count", 20, "-o", tmp_path / f"aces.{ending}")
    assert result.exit_code == 0, result.stderr
    measured, agreement = rows(result.stdout)
    assert float(measured["direct_hough"][2]) > 3
    assert int(measured["direct_hough"][7]) > 50
    assert 0 < float(measured["direct_hough"][6]) < 1
    assert set(agreement) == {"direct_hough", "direct_hough:preset=paper"}
    page = (tmp_path / f"aces.{ending}").read_text(encoding="utf-8")
    assert "corrected by a SLAM program" in page
    assert "detector=PaperHough(" in page
    assert len(names(tmp_path)) == (5 if ending == "md" else 1)
