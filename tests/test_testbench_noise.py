"""Extractors over noise, beams and outliers."""

import csv
import io
import math

import pytest
from scenes import needs_compiler

import laserfeatures as lf
from laserfeatures.testbench import noise
from laserfeatures.testbench.pages import noise_page

pytestmark = needs_compiler


@pytest.fixture(scope="module")
def result():
    return noise.run(seed=4, scans=4, workers=1)


def test_every_setting_has_every_extractor_the_paper_and_the_oracle(result):
    wanted = {*lf.list_extractors(), "paper", "oracle"}
    for axis in noise.AXES:
        for value in axis.values:
            at = [r for r in result.rows if (r["axis"], r["value"]) == (axis.name, value)]
            assert {row["extractor"] for row in at} == wanted
            assert len(at) == len(wanted)


def test_axes_span_what_is_asked():
    sigma, beams, outliers = noise.AXES
    assert (sigma.values[0], sigma.values[-1]) == (0, 50)
    assert sigma.scanner(50).range_sigma == pytest.approx(0.05)
    assert (beams.values[0], beams.values[-1]) == (91, 1081)
    assert beams.scanner(361).beams == 361
    assert (outliers.values[0], outliers.values[-1]) == (0, 20)
    assert outliers.scanner(20).outliers == pytest.approx(0.2)
    assert outliers.scanner(20).range_sigma == 0.005


def of(result, axis, value, extractor):
    (row,) = [
        r for r in result.rows
        if (r["axis"], r["value"], r["extractor"]) == (axis, value, extractor)
    ]  # fmt: skip
    return row


def test_without_noise_the_oracle_finds_all_and_with_more_less(result):
    without, little, much = (of(result, "sigma_mm", value, "oracle") for value in (0, 5, 50))
    assert without["tp_percent"] == 100
    assert without["median_error"] == pytest.approx(0, abs=1e-9)
    assert 0 < little["median_error"] < much["median_error"]
    assert little["oracle_share"] == 1


def test_outliers_hurt_the_literal_algorithm_more_than_ours(result):
    ours, paper = (
        of(result, "outliers_percent", 20, name)["fp_percent"] for name in ("direct_hough", "paper")
    )
    assert ours < paper


def test_results_do_not_depend_on_the_workers(monkeypatch):
    monkeypatch.setattr(noise, "AXES", noise.AXES[:1])
    one, two = (str(noise.run(seed=4, scans=2, workers=workers).rows) for workers in (1, 2))
    assert one == two


def test_the_page_has_tables_figures_and_curves(result):
    files = noise_page(result).files
    assert set(files) == {"noise.md", "noise.csv", "noise.png"}
    assert list(files)[-1] == "noise.md"  # it is the last to take its name
    rows = list(csv.DictReader(io.StringIO(files["noise.csv"].decode())))
    assert len(rows) == len(result.rows)
    assert files["noise.png"].startswith(b"\x89PNG")
    width = int.from_bytes(files["noise.png"][16:20])
    assert width >= 1200
    text = files["noise.md"].decode()
    row = of(result, "beams", 181, "direct_hough")
    error = 1e3 * row["median_error"]
    assert f"| {row['tp_percent']:.1f} / {row['fp_percent']:.1f} / {error:.1f} |" in text
    assert not math.isnan(error)
