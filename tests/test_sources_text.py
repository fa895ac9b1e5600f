"""Text with other marks, columns and units than our own; guesses that must not be believed."""

import logging
import math

import numpy as np
import pytest

import laserfeatures as lf

ANGLES = np.radians(np.arange(-90.0, 91.0))
RANGES = 2.0 + 0.5 * np.cos(3 * ANGLES)
MARK = b"\xef\xbb\xbf"


def read(path, content, **options):
    path.write_bytes(content.encode() if isinstance(content, str) else content)
    with lf.open_source(path, **options) as source:
        return source, list(source)


@pytest.fixture
def path(tmp_path):
    return tmp_path / "text"


def rows(*columns, between=","):
    table = zip(*(np.asarray(column).tolist() for column in columns), strict=True)
    return "".join(between.join(f"{cell:.6f}" for cell in row) + "\n" for row in table)


def check(scan, angles=ANGLES, ranges=RANGES):
    assert scan.angles == pytest.approx(angles, abs=1e-5)
    assert scan.ranges == pytest.approx(ranges, abs=1e-5)


def test_a_byte_order_mark_is_no_content(path):
    _, (scan,) = read(path, MARK + b"angle,range\r\n" + rows(ANGLES, RANGES).encode())
    check(scan)
    flaser = b"FLASER 2 1.0 2.0 0 0 0 0 0 0\n"
    assert len(read(path, MARK + flaser * 3)[1]) == 3
    assert len(read(path, MARK + b"#RPLIDAR\n" + b"1 1000 15\n2 1000 15\n")[1]) == 1
    assert len(read(path, MARK + b"LASER_READING 2 1.0 2.0 0 0 0 0\n")[1]) == 1
    with pytest.raises(lf.SourceError, match="expected text in UTF-8, got UTF-16"):
        read(path, "angle,range\n0,1\n".encode("utf-16"))


def test_a_table_with_a_header_is_no_rplidar_text(path):
    table = rows(np.degrees(ANGLES), 1000 * RANGES, np.full(ANGLES.size, 15.0))
    source, (scan,) = read(path, "angle_deg,range_mm,quality\n" + table)
    check(scan)
    assert source.format == "csv"
    assert read(path, table)[0].format == "rplidar"


@pytest.mark.parametrize(
    "header",
    ["angle;range", "angle_deg;range", "angle [deg];range [m]", "angle;range;intensity"],
)
def test_semicolons_and_decimal_commas(path, header):
    degrees = "deg" in header
    columns = [np.degrees(ANGLES) if degrees else ANGLES, RANGES]
    if "intensity" in header:
        columns.append(np.full(ANGLES.size, 47.0))
    text = rows(*columns, between=";").replace(".", ",")
    source, (scan,) = read(path, f"{header}\n{text}")
    check(scan)
    assert (source.format, source.notices) == ("csv", ())


def test_units_by_header_by_option_and_where_unambiguous(path):
    check(read(path, "angle_deg,range_mm\n" + rows(np.degrees(ANGLES), RANGES * 1000))[1][0])
    check(read(path, "angle (deg),range (cm)\n" + rows(np.degrees(ANGLES), RANGES * 100))[1][0])
    text = "angle,range\n" + rows(np.degrees(ANGLES), RANGES * 100)
    check(read(path, text, range_unit="cm")[1][0])
    check(read(path, text, angle_unit="deg", range_unit="cm")[1][0])
    text = "angle,range\n" + rows(ANGLES, RANGES)
    check(read(path, text)[1][0])


@pytest.mark.parametrize(
    ("scale", "first", "second"),
    [(100, "centimetres (2", "millimetres (0.2"), (1000, "millimetres (2", "centimetres (2")],
)
def test_centimetres_are_not_called_millimetres(path, scale, first, second):
    far = RANGES * (scale * 1.4)  # each of them is beyond 100
    with pytest.raises(lf.SourceError) as error:
        read(path, "angle,range\n" + rows(ANGLES, far))
    text = str(error.value)
    assert first in text
    assert second in text
    assert text.index(first) < text.index(second)
    assert "--range-unit" in text


def test_two_columns_without_a_header(path, caplog):
    for angles in (ANGLES, np.degrees(ANGLES), np.degrees(ANGLES) + 90):
        source, (scan,) = read(path, rows(angles, RANGES, between=" "))
        assert source.format == "csv"
        assert scan.ranges == pytest.approx(RANGES, abs=1e-5)
        assert np.ptp(scan.angles) == pytest.approx(math.pi, abs=1e-5)
        (notice,) = source.notices
        assert notice.startswith("no header: taken for angles in ")
    assert len(caplog.records) == 3
    assert {record.levelno for record in caplog.records} == {logging.WARNING}


def test_columns_that_are_named(path):
    quality = np.full(ANGLES.size, 15.0)
    text = rows(quality, -np.degrees(ANGLES), RANGES * 1000, between="\t")
    units = {"angle_unit": "deg", "range_unit": "mm"}
    check(read(path, text, columns=["quality", "clockwise", "range"], **units)[1][0])
    text = "".join(line.replace("15.000000", "yes", 1) for line in text.splitlines(keepends=True))
    check(read(path, text, columns=["-", "clockwise", "range"], **units)[1][0])
    _, scans = read(path, text + text + text, columns=["-", "clockwise", "range"], **units)
    assert [len(scan) for scan in scans] == [181, 181, 181]


def test_full_turns_of_named_columns_are_told_apart(path):
    degrees = (np.arange(1080) + 35.0) % 360
    text = rows(degrees, np.full(1080, 2.0))
    _, scans = read(path, text, columns=("angle", "range"), angle_unit="deg")
    assert [len(scan) for scan in scans] == [360, 360, 360]
    closed = rows(np.arange(-180.0, 181), np.full(361, 2.0))
    _, scans = read(path, closed, columns=("angle", "range"), angle_unit="deg")
    assert [len(scan) for scan in scans] == [361]


@pytest.mark.parametrize(
    ("options", "complaint"),
    [
        ({"columns": ["angle", "rnage"]}, "columns must be angle .* got angle,rnage"),
        ({"columns": ["angle"]}, "columns must be"),
        ({"columns": ["angle", "clockwise", "range"]}, "columns must be"),
        ({"columns": "angle,range"}, "must be a sequence of names"),
        ({"angle_unit": "grad"}, "angle_unit must be one of rad, deg, got 'grad'"),
        ({"range_unit": "ft"}, "range_unit must be one of m, cm, mm"),
        ({"delimiter": "|"}, "delimiter must be one of"),
        ({"range_unit": "m", "format": "npz"}, "range_unit does not apply to the format 'npz'"),
    ],
)
def test_options_that_make_no_sense(path, options, complaint):
    with pytest.raises(ValueError, match=complaint):
        read(path, "angle,range\n0,1\n", **options)


@pytest.mark.parametrize("order", [(1, 2, 0), (0, 1, 2)])
@pytest.mark.parametrize("between", [" ", "\t", ",", ";"])
def test_rplidar_text_with_the_quality_first_or_last(path, order, between):
    degrees = np.arange(480) * 0.75
    columns = [np.full(480, 15.0), degrees, 2000.0 + degrees]
    source, (scan,) = read(path, rows(*(columns[i] for i in order), between=between))
    assert source.format == "rplidar"
    assert len(source.notices) == 1
    at_90 = scan.ranges[np.argmin(np.abs(scan.angles + math.pi / 2))]
    assert at_90 == pytest.approx(2.09)


def test_rplidar_text_with_flags(path):
    lines = [f"{i % 480 == 0}\t15\t{i % 480 * 0.75}\t{2000 + i}\n" for i in range(960)]
    source, scans = read(path, "".join(lines))
    assert source.format == "rplidar"
    assert [len(scan) for scan in scans] == [480, 480]


def room_points(scale):
    directions = np.linspace(-math.pi, math.pi, 720, endpoint=False) + 1e-3
    r = np.minimum(3 / np.abs(np.cos(directions)), 2 / np.abs(np.sin(directions)))
    return scale * r * np.cos(directions), scale * r * np.sin(directions)


@pytest.mark.parametrize("scale", [1, 100, 1000])
@pytest.mark.parametrize("shift", [0, 5])
@pytest.mark.parametrize("between", [" ", ",", ";"])
def test_points_are_not_taken_for_angles(path, scale, shift, between):
    x, y = room_points(scale)
    x, y = x + shift * scale, y + shift * scale
    for columns in ((x, y, 0 * x), (x, y, 0.3 * scale + 0 * x), (x, y)):
        with pytest.raises(lf.SourceError, match="expected the header") as error:
            read(path, rows(*columns, between=between))
        assert ("PCD or PLY" in str(error.value)) == (len(columns) == 3)


@pytest.mark.parametrize("name", ["field.", "field.scan."])
def test_what_rostopic_echo_prints(path, name):
    fields = ["header.stamp", "angle_min", "angle_max", "angle_increment", "range_min", "range_max"]
    fields += ["ranges0", "ranges1", "ranges2", "intensities0"]
    header = ",".join(["%time", *(name + field for field in fields)])
    limits = "-0.5,0.5,0.5,0.1,8"
    text = f"{header}\n7,5500000000,{limits},1,2,inf,40\n8,6500000000,{limits},1,2,9,40\n"
    source, (first, second) = read(path, text)
    assert (source.format, source.notices, first.stamp) == ("csv", (), 5.5)
    assert (first.angles.tolist(), first.ranges.tolist()) == ([-0.5, 0, 0.5], [1, 2, math.inf])
    assert (second.range_min, second.range_max, second.valid.sum()) == (0.1, 8, 2)
    source, _ = read(path, text.replace(",0.5,0.5,", ",1.4,0.5,"))
    assert "angle_max is 80.21 deg" in source.notices[0]
