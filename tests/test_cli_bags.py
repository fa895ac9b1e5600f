import json

import pytest
from cli_runs import fails, run

pytest.importorskip("rosbags", reason="rosbags (extra ros) is not installed")

from test_sources_bags import NOETIC, message, write1


@pytest.fixture
def bag(tmp_path):
    return write1(tmp_path / "two.bag", {"/front": [message(NOETIC)], "/rear": [message(NOETIC)]})


def test_several_laser_topics_are_named(bag):
    line = fails("extract", bag)
    assert "/front" in line
    assert "/rear" in line
    assert "--topic" in line


def test_a_topic_can_be_chosen(bag):
    result = run("extract", bag, "--topic", "/rear")
    assert result.exit_code == 0, result.stderr
    assert json.loads(result.stdout)["stamp"] == 7.5


def test_a_bag_without_laser_scans_is_told(tmp_path):
    line = fails("info", write1(tmp_path / "none.bag", {"/chatter": []}))
    assert "none.bag" in line
    assert "LaserScan" in line
