"""Figs. 6 and 7: three sizes of the neighbourhood, in the paper's colours."""

import numpy as np
import pytest
from matplotlib.colors import to_hex

from laserfeatures import figures
from laserfeatures.testbench import neighborhoods, pictures
from laserfeatures.testbench.pages import figures_page


@pytest.fixture(scope="module")
def panels():
    return neighborhoods.run(seed=1)


def test_each_figure_has_one_scan_at_three_sizes(panels):
    for name in ("figure6", "figure7"):
        own = neighborhoods.of_figure(panels, name)
        assert [(p.row.v_d, p.row.v_theta) for p in own] == [(1, 1), (5, 11), (11, 21)]
        assert len({p.features.scan.ranges.tobytes() for p in own}) == 1
    scans = {p.features.scan.ranges.tobytes() for p in panels}
    assert len(scans) == 2


def test_larger_neighborhoods_leave_fewer_copies(panels):
    for name in ("figure6", "figure7"):
        removed = [len(p.removed) for p in neighborhoods.of_figure(panels, name)]
        assert removed == sorted(removed, reverse=True)
        assert removed[0] > removed[-1]


def test_counts_are_those_of_the_panel(panels):
    counts = panels[0].counts
    assert counts["lines_detected"] == 8
    assert counts["lines_passed"] == len(panels[0].features.lines)
    assert counts["features_true"] == len(panels[0].truth.corners)
    assert counts["features_matched"] <= counts["features_extracted"]


def test_the_colours_are_the_papers(panels):
    panel = panels[-1]
    axes = figures.new_figure().add_subplot()
    pictures.draw_panel(axes, panel)
    drawn = {line.get_label(): line for line in axes.lines}
    points = drawn["raw measurements"]
    assert to_hex(points.get_color()) == "#000000"
    assert np.allclose(points.get_xydata(), panel.features.scan.points)
    circles = drawn["true features"]
    assert circles.get_marker() == "o"
    red, green, blue = bytes.fromhex(to_hex(circles.get_color())[1:])
    assert red == green == blue
    assert np.allclose(circles.get_xydata(), panel.truth.corners)
    squares = drawn["features detected"]
    assert squares.get_marker() == "s"
    red, green, blue = bytes.fromhex(to_hex(squares.get_color())[1:])
    assert blue > 2 * red
    assert np.allclose(squares.get_xydata(), panel.features.corners.positions)
    assert to_hex(drawn["laser"].get_color()) == figures.RED
    assert len([line for line in axes.lines if line.get_color() == figures.BLUE]) == len(
        panel.features.lines
    )


def test_the_page_has_two_pictures_wide_enough(panels):
    files = figures_page(panels).files
    assert set(files) == {"figure6.png", "figure7.png", "figures.csv", "figures.md"}
    for name in ("figure6.png", "figure7.png"):
        assert int.from_bytes(files[name][16:20]) >= 1200
        assert f"](<{name}>)" in files["figures.md"].decode()
