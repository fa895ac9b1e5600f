import gc
import gzip
import math
import warnings
from pathlib import Path

import numpy as np
import pytest

import laserfeatures as lf


@pytest.mark.parametrize(
    ("content", "complaint"),
    [
        (b"", "the file is empty"),
        (gzip.compress(b"", mtime=0), "hold no content"),
        (gzip.compress(b"FLASER" * 99, mtime=0)[:10], "hold no content, or are damaged"),
        (bytes(range(256)), "expected one of the formats"),
        (b"hello\n", "expected one of the formats rosbag1, .* carmen.*'angle,range'"),
        (b"\x1f\x8b" + bytes(50), "damaged at the start"),
        (b"PARAM robot_width 3\n", "expected laser scans, got none"),
        (b"PK\x03\x04 broken", "expected a .npz archive"),
        (gzip.compress(b"#ROSBAG V2.0\n", mtime=0), "gunzip it first"),
        (b"angle,range\n", "expected laser scans, got none"),
    ],
)
def test_what_is_no_log(tmp_path, content, complaint):
    path = tmp_path / "log"
    path.write_bytes(content)
    with pytest.raises(lf.SourceError, match=complaint) as error:
        lf.open_source(path)
    assert str(error.value).startswith(f"{path}: ")
    assert "\n" not in str(error.value)


def test_missing_files_and_empty_folders(tmp_path):
    for name in ("nothing", "nothing.bag"):
        with pytest.raises(lf.SourceError, match="No such file or directory"):
            lf.open_source(tmp_path / name)
    with pytest.raises(lf.SourceError, match="No such file or directory"):
        lf.open_source(tmp_path / "nothing", format="carmen")
    (tmp_path / "junk.gz").write_bytes(b"\x1f\x8b")
    with pytest.raises(lf.SourceError, match=r"a folder with metadata.yaml"):
        lf.open_source(tmp_path)


@pytest.mark.parametrize(
    ("options", "complaint"),
    [
        ({"format": "carmn"}, "no format 'carmn'; did you mean 'carmen'"),
        ({"on_error": "ignore"}, "on_error must be 'raise' or 'skip', got 'ignore'"),
        ({"range_max": 0}, "range_max must be > 0 m, got 0"),
        ({"range_max": math.nan}, "range_max must be > 0 m"),
        ({"field_of_view": 7}, "field_of_view must be in"),
        ({"field_of_view": 1}, "field_of_view does not apply to the format 'csv'"),
        ({"topic": "/scan"}, "topic does not apply to the format 'csv'"),
    ],
)
def test_options_that_make_no_sense(tmp_path, options, complaint):
    path = tmp_path / "log"
    path.write_text("angle,range\n0,1\n")
    with pytest.raises(ValueError, match=complaint):
        lf.open_source(path, **options)


def test_the_format_can_be_named(tmp_path):
    path = tmp_path / "log"
    path.write_text("NOTE nothing that tells the format\n" * 3000 + "FLASER 1 2.5 0 0 0 0 0 0\n")
    with pytest.raises(lf.SourceError, match="name its format with format="):
        lf.open_source(path)
    with lf.open_source(path, format="carmen") as source:
        assert [scan.ranges.tolist() for scan in source] == [[2.5]]


@pytest.mark.parametrize("form", ["carmen", "npz"])
def test_millimetres_are_told(tmp_path, form):
    ranges = np.random.default_rng(0).integers(200, 5000, 181)
    path = tmp_path / "log"
    if form == "npz":
        np.savez(tmp_path / "log.npz", ranges=ranges, angles=np.arange(181) / 100)
        path = tmp_path / "log.npz"
    else:
        path.write_text(f"FLASER 181 {' '.join(map(str, ranges))} 0 0 0 0 0 0\n")
    with pytest.raises(lf.SourceError, match=r"expected ranges in metres, .* divide them by 1000"):
        lf.open_source(path)
    with lf.open_source(path, range_max=10_000) as source:
        assert next(source).valid.all()


def test_long_ranges_and_silent_scans_are_not_taken_for_millimetres(tmp_path):
    path = tmp_path / "log"
    silent = "FLASER 181 " + "81.91 " * 181 + "0 0 0 0 0 0\n"
    path.write_text(silent)
    with lf.open_source(path) as source:
        assert not next(source).valid.any()
    path.write_text(silent.replace("81.91", "1000"))
    with lf.open_source(path) as source:
        assert len(list(source)) == 1


def test_nothing_but_broken_records(tmp_path):
    path = tmp_path / "log"
    path.write_text("FLASER 3\nFLASER x\n")
    with pytest.raises(lf.SourceError, match=r"2 records are broken, the first: .*log:1: "):
        lf.open_source(path, on_error="skip")


def open_files():
    return len(list(Path("/proc/self/fd").iterdir()))


def test_closing(tmp_path):
    path = tmp_path / "log"
    path.write_text("FLASER 1 2.5 0 0 0 0 0 0\n" * 5000)
    gc.collect()  # what earlier tests left
    before = open_files()
    with warnings.catch_warnings():
        warnings.simplefilter("error", ResourceWarning)
        with lf.open_source(path) as source:
            assert open_files() == before + 1
            next(source)
        gc.collect()
    assert open_files() == before
    assert list(source) == []


def test_scans_are_read_once_in_order(tmp_path):
    path = tmp_path / "log"
    path.write_text("".join(f"FLASER 1 {i} 0 0 0 0 0 0\n" for i in range(1, 30)))
    with lf.open_source(str(path)) as source:
        assert [scan.ranges[0] for scan in source] == list(range(1, 30))
        assert list(source) == []
