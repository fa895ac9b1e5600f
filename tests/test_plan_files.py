import math
import re
from pathlib import Path

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from laserfeatures.errors import SourceError
from laserfeatures.simulation import Plan, Scanner, read_plan
from laserfeatures.simulation.plan_reader import parse_plan
from laserfeatures.simulation.toml_lines import TomlLines

GOOD = """\
# An office
[[outline]]
points = [
  [0, 0],  # the door, on the left
  [6, 0],
  [6, 4],
  [0, 4],
]
reflectivity = 0.8

[[wall]]
from = [1.0, 1.0]
to = [2.0, 1.0]

[[wall]]
from = [4, 3]
to = [5, 3]
reflectivity = 0.05

[[outline]]
closed = false
points = [[0.5, 3.5], [1.0, 3.5], [1.0, 3.8]]

[[box]]
center = [3.0, 2.0]
size = [1.0, 0.5]
heading_deg = 30

[[pole]]
center = [5.0, 1.0]
radius = 0.1
reflectivity = 0.3

[drive]
waypoints = [[0.5, 0.5], [5.5, 0.4],
             [5.4, 3.4]]
scanner = "urg04lx_ug01"
seed = 7
speed = 0.3
scan_rate = 10

[scanner]
outliers = 0.02
beams = 501
"""
NAME = Path("plan.toml")
LINES = GOOD.splitlines()


def parse(text):
    return parse_plan(text, NAME)


def test_a_plan_holds_what_its_file_says():
    plan = parse(GOOD)
    ends = [[(1, 1), (2, 1)], [(4, 3), (5, 3)]]
    ends += [[(0, 0), (6, 0)], [(6, 0), (6, 4)], [(6, 4), (0, 4)], [(0, 4), (0, 0)]]
    ends += [[(0.5, 3.5), (1, 3.5)], [(1, 3.5), (1, 3.8)]]
    np.testing.assert_array_equal(plan.world.walls, ends)
    np.testing.assert_array_equal(plan.world.boxes, [(3, 2, 1, 0.5, math.radians(30))])
    np.testing.assert_array_equal(plan.world.poles, [(5, 1, 0.1)])
    np.testing.assert_array_equal(
        plan.world.reflectivity, [0.9, 0.05, 0.8, 0.8, 0.8, 0.8, 0.9, 0.9, 0.9, 0.3]
    )
    assert plan.drive.waypoints.tolist() == [[0.5, 0.5], [5.5, 0.4], [5.4, 3.4]]
    assert (plan.drive.seed, plan.drive.speed, plan.drive.scan_rate) == (7, 0.3, 10.0)
    assert plan.drive.scanner == Scanner.model("urg04lx_ug01", outliers=0.02, beams=501)
    assert plan.path == NAME


def test_a_drive_needs_only_way_points():
    drive = parse("[[wall]]\nfrom=[0,1]\nto=[1,1]\n[drive]\nwaypoints=[[0,0],[1,0]]").drive
    assert (drive.scanner, drive.seed, drive.speed, drive.scan_rate) == (Scanner(), 0, 0.4, 5.0)
    assert parse("[[pole]]\ncenter=[0,1]\nradius=1\n").drive is None


@pytest.mark.parametrize(
    ("good", "bad", "line", "message"),
    [
        ("[6, 4]", "[6, 0]", 3, r"a wall must have a length > 0, got \[6\.0, 0\.0\] as both"),
        ("to = [2.0, 1.0]", "to = [1, 1]", 13, "a wall must have a length > 0"),
        ("to = [2.0, 1.0]\n", "", 11, "a wall needs 'to'"),
        ("from = [4, 3]", "form = [4, 3]", 16, "a wall has no 'form'; did you mean 'from'"),
        ("from = [4, 3]", "from = [4, nan]", 16, r"from must be two finite numbers .*\[4, nan\]"),
        ("from = [4, 3]", "from = [4]", 16, r"from must be two finite numbers"),
        ("from = [4, 3]", "from = [4, 1e300]", 16, r"numbers \[x, y\] up to 1000000"),
        ("from = [4, 3]", "from = [4, true]", 16, r"from must be two finite numbers"),
        ("from = [4, 3]", "from = '4, 3'", 16, "from must be two finite numbers"),
        ("[6, 4]", "[6, 'x']", 3, r"points must be .* number 3 is none"),
        ("= 0.05", "= 0", 18, r"reflectivity must be a number in \(0, 1\], got 0"),
        ("= 0.05", "= 1.5", 18, r"reflectivity must be a number in \(0, 1\], got 1\.5"),
        ("closed = false", "closed = 0", 21, "closed must be true or false, got 0"),
        ("[[box]]", "[[bos]]", 24, "a plan has no 'bos'; did you mean 'box'"),
        ("[[box]]", "[box]", 24, r"expected tables \[\[box\]\], got \{"),
        ("[1.0, 0.5]", "[1.0, 0]", 26, r"size must be two numbers > 0, \[length, width\], got"),
        ("[1.0, 0.5]", "1.0", 26, r"size must be two numbers > 0, \[length, width\], got 1\.0"),
        ("= 30", "= inf", 27, "heading_deg must be a finite number up to 1000000, got inf"),
        ("= 30", "= 30\nheading_rad = 1", 28, "give heading_deg or heading_rad, not both"),
        ("radius = 0.1", "radius = -0.1", 31, r"radius must be a number > 0, got -0\.1"),
        ("radius = 0.1", "radius = 1e-300", 31, "radius must be a number > 0, got 1e-300"),
        ("radius = 0.1", "radius 0.1", 31, r"expected TOML, got a mistake: .*line 31"),
        ("radius = 0.1", "radius = 0.1\nradius = 0.1", 32, "expected TOML, got a mistake"),
        ("[drive]", "[[drive]]", 34, r"expected one table \[drive\], got \["),
        ("[5.4, 3.4]]", "[5.5, 0.4]]", 35, "way-points 2 and 3 must differ"),
        ("[5.4, 3.4]]", "]", 35, None),
        ("points = [[0.5, 3.5], [1.0, 3.5], [1.0, 3.8]]", "points = 'all'", 22, "got 'all'"),
        ("[[0.5, 0.5], [5.5, 0.4],\n             [5.4, 3.4]]", "[[1, 2]]", 35, "at least 2 points"),
        (
            "[0.5, 0.5]",
            "[3, 2.1]",
            35,
            "way-point 1 must be free, .* inside the box of line 24",
        ),
        ("[5.5, 0.4]", "[5.01, 1]", 35, "way-point 2 must be free, .* the pole of line 29"),
        ("[0.5, 0.5]", "[4.5, 3.0005]", 35, "way-point 1 must be free, .* the wall of line 15"),
        ("[0.5, 0.5]", "[3, 0]", 35, "way-point 1 must be free, .* the outline of line 2"),
        ("urg04lx_ug01", "urg04", 37, "there is no scanner 'urg04'; there are: lms200"),
        ('"urg04lx_ug01"', "4", 37, "scanner must be a text, got 4"),
        ("seed = 7", "seed = 7.5", 38, r"seed must be a whole number >= 0, got 7\.5"),
        ("seed = 7", "seed = -7", 38, "seed must be a whole number >= 0, got -7"),
        ("speed = 0.3", "speed = 0", 39, "speed must be a number > 0, got 0"),
        ("scan_rate", "scan_rat", 40, "a drive has no 'scan_rat'; did you mean 'scan_rate'"),
        ("outliers = 0.02", "outliers = 2", 43, r"outliers must be in \[0, 1\], got 2"),
        ("outliers = 0.02", "outlier = 0.02", 43, "a scanner has no 'outlier'; did you mean 'out"),
        ("beams = 501", "beams = 1", 44, "beams must be >= 2, got 1"),
        ("beams = 501", "beams = 50.5", 44, r"beams must be a whole number >= 0, got 50\.5"),
        ("beams = 501", "range_max = 0.1", 43, r"outliers need a range of view beyond 0\.3 m"),
    ],
)
def test_a_mistake_is_named_with_its_line(good, bad, line, message):
    assert GOOD.count(good) == 1 or good in {"[6, 4]", "scan_rate", "[0.5, 0.5]"}
    text = GOOD.replace(good, bad)
    if message is None:
        assert len(parse(text).drive.waypoints) == 2
        return
    with pytest.raises(SourceError, match=message) as error:
        parse(text)
    assert str(error.value).startswith(f"plan.toml:{line}: ")
    assert "\n" not in str(error.value)
    assert len(str(error.value)) < 250


def test_an_empty_plan_and_a_scanner_without_a_drive_are_refused():
    with pytest.raises(SourceError, match=r"^plan\.toml:1: a plan needs a \[\[wall\]\]"):
        parse("# nothing\n")
    with pytest.raises(SourceError, match=r"^plan\.toml:4: a \[scanner\] needs a \[drive\]"):
        parse("[[wall]]\nfrom = [0, 0]\nto = [1, 0]\n[scanner]\noutliers = 0.1\n")


@pytest.mark.parametrize(
    ("text", "line"),
    [
        ("wall = [\n  {from = [0, 0], to = [1, 0]},\n  {from = [0, 0], to = [0, 0]},\n]", 1),
        ('note = """\n[[wall]]\n"""\n', 1),
        ('[[pole]]\nradius = 1 # a, b,\ncenter = [  # "c,"\n\n 1, # d,\n 2]\n\nname = "e"', 8),
        ("[[wall]]\nfrom = [0, 0]\nto = [1, 0]\n[[wall.door]]\nat = 1\n", 4),
        ("[[wall]]\nfrom = [0, 0]\nto = [1, 0]\n\n[wall.door]\nat = 1\n", 5),
        ("drive.speed = 1\ndrive.sped = 2\n[[pole]]\nradius=1\ncenter=[0,0]", 2),
        ("# [[wall]]\n[[wall]]\nfrom = [0, 0]\nto = [1, 0]\n \n[[ wall ]] # 2\nfrom = [0, 0]\n", 6),
        ("\r\n[[wall]]\r\nfrom = [0, 0]\r\nto = [0, 0]\r\n", 4),
        ("a = " + "[" * 3000, 1),
        ("[[pole]]\nradius = " + "9" * 5000, 2),
        ("[[pole]]\nradius = " + "9" * 400, 2),
        ("[[pole]]\nradius = 2020-01-01", 2),
    ],
)
def test_lines_are_found_however_the_file_is_written(text, line):
    with pytest.raises(SourceError, match=rf"^plan\.toml:{line}: "):
        parse(text)


def test_no_depth_of_nesting_is_too_much():
    for depth in range(1, 1000, 3):
        with pytest.raises(SourceError, match=r"^plan\.toml:\d: "):
            parse("[[pole]]\nradius = " + "[" * depth + "]" * depth)


def test_commas_and_quotes_in_comments_and_texts_end_no_value_and_begin_none():
    lines = TomlLines(
        "[[pole]]\n"
        "a = [ # one,\n 1, # 'two\n 2 ] # three,\n"
        'b = [\n "x,#"]\n'
        'c = """\n[[pole]]\n\n1,\n"""\n'
        "d = 4\n\n[[pole]]\na = 1"
    )
    found = [lines.of("pole", 0, key) for key in ("a", "b", "c", "d")]
    assert found == [2, 5, 7, 12]
    assert (lines.of("pole", 1), lines.of("pole", 1, "a"), lines.of("pole", 1, "e")) == (14, 15, 14)
    assert lines.of("nothing") == 1


def test_a_file_that_cannot_be_read_is_named(tmp_path):
    with pytest.raises(SourceError, match=r"nothing\.toml: cannot be read: No such file"):
        read_plan(tmp_path / "nothing.toml")
    with pytest.raises(SourceError, match=r"cannot be read: Is a directory"):
        read_plan(tmp_path)
    path = tmp_path / "plan.toml"
    path.write_bytes(b"# fine\n[[wall]]\nfrom = [\xff]\n")
    with pytest.raises(SourceError, match=r"plan\.toml:3: expected UTF-8"):
        read_plan(path)


JUNK = st.sampled_from(
    ["[", "]", "[[", "]]", "=", '"', "'''", "#", ",", "nan", "1e999", "-1", "true", "[[wall]]",
     "[drive]", "x = 1", "from = 3", "[[wall]]\nfrom = 1", "\x00", "\r", "{", "}", "\\", "é", "0"]
)  # fmt: skip
DAMAGE = st.lists(
    st.tuples(
        st.integers(0, len(LINES) - 1),
        st.sampled_from(["drop", "double", "cut", "replace", "insert"]),
        st.one_of(JUNK, st.text(max_size=5)),
        st.integers(0, 30),
    ),
    min_size=1,
    max_size=3,
)


def damaged(damage):
    lines = list(LINES)
    for number, kind, junk, at in damage:
        line = lines[number]
        lines[number] = {
            "drop": "",
            "double": line + "\n" + line,
            "cut": line[:at],
            "replace": line[:at] + junk + line[at + 1 :],
            "insert": line[:at] + junk + line[at:],
        }[kind]
    return "\n".join(lines)


@given(DAMAGE)
def test_a_damaged_plan_is_refused_with_a_line_or_is_a_plan(damage):
    text = damaged(damage)
    try:
        plan = parse(text)
    except SourceError as error:
        line = re.match(r"plan\.toml:(\d+): .", str(error))
        assert line
        assert 1 <= int(line[1]) <= text.count("\n") + 1
    else:
        assert isinstance(plan, Plan)
