"""Files that claim or unpack to more than they hold, and what is no file: refused in one line."""

import gzip
import io
import os
import struct
import subprocess
import sys
import zipfile

import numpy as np
import pytest

import laserfeatures as lf
from laserfeatures.sources.files import LONGEST_LINE, MOST_BEAMS


def array(shape, kind="<f8"):
    header = f"{{'descr': {kind!r}, 'fortran_order': False, 'shape': {shape}, }}"
    header = f"{header:<117}\n".encode()
    return b"\x93NUMPY\x01\x00" + struct.pack("<H", len(header)) + header


def archive(**members):
    content = io.BytesIO()
    with zipfile.ZipFile(content, "w") as file:
        for name, data in members.items():
            file.writestr(f"{name}.npy", data)
    return content.getvalue()


def refusal(path, content, **options):
    path.write_bytes(content)
    with pytest.raises(lf.SourceError) as error, lf.open_source(path, **options) as source:
        list(source)
    text = str(error.value)
    assert str(path) in text
    assert "\n" not in text
    return text


@pytest.mark.parametrize(
    ("shape", "kind"),
    [((10**12, 0), "<f8"), ((10**6, 10**6), "<f8"), ((0, 10**12), "<f8"), ((10**12, 1), "|V0")],
)
def test_arrays_that_claim_more_than_their_bytes_hold(tmp_path, shape, kind):
    content = archive(ranges=array(shape, kind), angles=array((shape[1],)))
    for data in (content, gzip.compress(content)):
        text = refusal(tmp_path / "a.npz", data)
        assert "ranges.npy" in text
        assert "numbers in 128 bytes" in text


def test_a_small_archive_of_no_beams_is_what_it_says(tmp_path):
    np.savez(tmp_path / "a.npz", ranges=np.zeros((3, 0)), angles=np.zeros(0))
    with lf.open_source(tmp_path / "a.npz") as source:
        assert [len(scan) for scan in source] == [0, 0, 0]


def test_archives_that_unpack_to_a_thousand_times_their_size(tmp_path):
    content = io.BytesIO()
    np.savez_compressed(content, ranges=np.zeros((9000, 1000)), angles=np.arange(1000) / 1000)
    assert "packed bytes of 72000128" in refusal(tmp_path / "a.npz", content.getvalue())
    content = gzip.compress(archive(ranges=bytes(1 << 27), angles=array((0,))))
    assert "packed bytes of more than" in refusal(tmp_path / "a.npz", content)


@pytest.mark.parametrize("packed", [False, True])
def test_a_line_without_an_end(tmp_path, packed):
    content = b"FLASER 2 1.0 2.0 0 0 0 0 0 0\nFLASER 2 " + b"1.0 " * (LONGEST_LINE // 3)
    content = gzip.compress(content) if packed else content
    text = refusal(tmp_path / "a.log", content)
    assert f"a.log:2: expected a line of at most {LONGEST_LINE} bytes" in text
    with lf.open_source(tmp_path / "a.log", on_error="skip") as source:
        assert len(list(source)) == source.skipped == 1


def test_gzip_data_of_a_thousand_times_their_size(tmp_path):
    content = gzip.compress(b"NOTE x\n" + (b"#" * 100_000 + b"\n") * 1000)
    assert "packed bytes of more than" in refusal(tmp_path / "a", content, format="carmen")


def test_a_table_without_an_end(tmp_path):
    row = "0.1,1\n"
    text = refusal(tmp_path / "a.csv", ("angle,range\n" + row * (MOST_BEAMS + 1)).encode())
    assert text.endswith(f"expected at most {MOST_BEAMS} beams a scan, got more")


@pytest.mark.parametrize(
    "text",
    [
        "[world]\n" + ".".join("a" * 5000) + " = 1\n",
        "[" + " . ".join("a" * 5000) + "]\n",
        "[[wall]]\nx = " + "[" * 900 + "]" * 900 + "\n",
        "[[wall]]\nx = " + "[" * 20_000 + "]" * 20_000 + "\n",
        "[[wall]]\nx = " + "{a = " * 300 + "1" + "}" * 300 + "\n",
    ],
)
def test_plans_with_values_within_values(tmp_path, text):
    assert "a.toml" in refusal(tmp_path / "a.toml", text.encode(), format="plan")


def test_a_plan_of_any_size_is_not_read(tmp_path):
    path = tmp_path / "a.toml"
    with path.open("wb") as file:
        file.write(b"[[wall]]\n")
        os.ftruncate(file.fileno(), 1 << 40)
    with pytest.raises(lf.SourceError, match="expected a plan of at most 4194304 bytes"):
        lf.open_source(path)


def test_a_packed_cloud_of_more_points_than_it_can_hold(tmp_path):
    pytest.importorskip("open3d", reason="the extra open3d is not installed")
    count = 300_000_000
    header = (
        f"# .PCD v0.7\nVERSION 0.7\nFIELDS x y z\nSIZE 4 4 4\nTYPE F F F\nCOUNT 1 1 1\n"
        f"WIDTH {count}\nHEIGHT 1\nPOINTS {count}\nDATA binary_compressed\n"
    )
    data = header.encode() + struct.pack("<II", 9, count * 12) + bytes(9)
    text = refusal(tmp_path / "a.pcd", data, slice_band=(0, 1))
    assert "expected 3600000000 bytes of points, got 9 packed ones" in text


@pytest.mark.parametrize("kind", [None, "carmen", "plan", "npz", "csv"])
def test_a_pipe_is_refused_at_once(tmp_path, kind):
    os.mkfifo(tmp_path / "pipe")
    for path in (tmp_path / "pipe", "/dev/zero"):
        with pytest.raises(lf.SourceError, match="got a pipe or device"):
            lf.open_source(path, format=kind)


def test_the_command_takes_little_memory_and_time(tmp_path):
    path = tmp_path / "a.log.gz"
    path.write_bytes(gzip.compress(b"FLASER 181 " + b"1 " * 100_000_000, 1))
    code = (
        "import re, sys; from laserfeatures.cli import main\n"
        "try: main(['info', sys.argv[1]])\n"
        "finally: print(re.search(r'VmHWM:\\s*(\\d+)', open('/proc/self/status').read())[1])"
    )
    run = subprocess.run(  # noqa: S603 - our own code
        [sys.executable, "-c", code, path], capture_output=True, text=True, timeout=60, check=False
    )
    assert run.returncode == 2
    assert len(run.stderr.splitlines()) == 1
    assert int(run.stdout) < 500_000  # kB
