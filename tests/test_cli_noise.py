import json

import numpy as np
import pytest
from cli_runs import carmen_log, fails, run

import laserfeatures as lf
from laserfeatures.noise_model import NoiseModel, noise_of


@pytest.fixture(scope="module")
def log(tmp_path_factory):
    return carmen_log(tmp_path_factory.mktemp("log") / "a.log", 40)


def scans_of(log):
    with lf.open_source(log) as source:
        return list(source)


def features(*arguments):
    result = run("extract", *arguments)
    assert result.exit_code == 0, result.stderr
    return [json.loads(line) for line in result.stdout.splitlines()]


def test_the_noise_of_a_log_is_printed(log):
    result = run("noise", log)
    assert result.exit_code == 0, result.stderr
    rows = dict(line.split(maxsplit=1) for line in result.stdout.splitlines())
    assert rows["scans"] == "40, of which 40 tell a noise"
    assert rows["sigma"].endswith(" mm")
    assert "±" in rows["sigma"]
    assert rows["relative"].endswith(" %")
    assert rows["roughness"].endswith(" mm")
    assert rows["changes"].startswith("by")


def test_the_numbers_are_those_of_the_model(log, tmp_path):
    result = run("noise", log, "--every", 3, "--json", tmp_path / "n.json")
    assert result.exit_code == 0, result.stderr
    found = json.loads((tmp_path / "n.json").read_text())
    model = NoiseModel()
    for scan in scans_of(log)[::3]:
        model.feed(scan)
    assert found["scans"] == found["telling"] == model.scans == 14
    assert found["sigma"] == model.noise.sigma
    assert found["relative"] == model.noise.relative
    assert found["roughness"] == model.noise.roughness
    assert found["uncertainty"]["sigma"] == model.uncertainty.sigma
    assert found["factor"] is None
    assert 1.0 < found["factor_of_own"] < 1.5


def test_a_log_without_returns_tells_no_noise(tmp_path):
    log = tmp_path / "blind.log"
    log.write_text("FLASER 3 0.0 0.0 0.0 0 0 0 0 0 0 1.0 host 1.0\n")
    assert "got 1 scan without 8 returns" in fails("noise", log)


def test_an_extractor_is_told_the_noise_of_the_log(log):
    model, extractor = NoiseModel(), lf.get_extractor("direct_hough")
    records = features(log)
    alone = features(log, "--noise", "scan")
    assert records != alone
    for scan, record, own in zip(scans_of(log), records, alone, strict=True):
        told = extractor(scan, noise=model.feed(scan))
        assert np.array_equal([c["cov"] for c in record["corners"]], told.corners.covariance)
        assert np.array_equal(
            [c["cov"] for c in own["corners"]], extractor(scan).corners.covariance
        )


def test_what_is_found_in_a_scan_does_not_depend_on_the_first_one_wanted(log):
    assert features(log, "--start", 25, "--count", 5) == features(log)[25:30]


def test_a_given_range_sigma_counts_more(log):
    given = ("-p", "range_sigma=1cm")
    assert features(log, *given) == features(log, "--noise", "scan", *given)


def test_an_unknown_choice_is_refused(log):
    assert "'log', 'scan'" in fails("extract", log, "--noise", "none")


@pytest.mark.parametrize("choice", ["log", "scan"])
def test_compare_takes_the_choice(log, choice, tmp_path):
    report = tmp_path / "r.md"
    wanted = ("--extractors", "direct_hough,kanade_tomasi", "--count", 4)
    result = run("compare", log, *wanted, "--noise", choice, "-o", report)
    assert result.exit_code == 0, result.stderr
    what = {"log": "told from the log up to each scan", "scan": "told from each scan alone"}
    assert what[choice] in report.read_text()


def test_slam_and_plot_take_it(log, tmp_path):
    summaries = []
    for choice in ("log", "scan"):
        file = tmp_path / f"{choice}.json"
        result = run("slam", "run", log, "--noise", choice, "--json", file)
        assert result.exit_code == 0, result.stderr
        summaries.append(json.loads(file.read_text()))
    assert [each["noise"] for each in summaries] == ["log", "scan"]
    picture = tmp_path / "p.png"
    result = run("plot", log, "--scan", 3, "--noise", "scan", "-o", picture)
    assert result.exit_code == 0, result.stderr
    assert picture.stat().st_size


def test_each_scan_alone_tells_what_a_detector_takes(log):
    scan = scans_of(log)[0]
    noise = noise_of(scan)
    given = lf.get_extractor(
        "direct_hough", range_sigma=noise.sigma, range_sigma_relative=noise.relative
    )
    alone = lf.get_extractor("direct_hough")(scan)
    assert np.array_equal(given(scan).corners.covariance, alone.corners.covariance)
