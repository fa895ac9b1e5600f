"""What reaches the terminal is short and printable, and says which file."""

import errno
import os

import numpy as np
import pytest
from click.testing import CliRunner

import laserfeatures as lf
from laserfeatures.cli import main
from laserfeatures.cli.output import complete_file
from laserfeatures.errors import shown


def run(*arguments):
    return CliRunner().invoke(main, [str(argument) for argument in arguments])


@pytest.mark.parametrize(
    ("text", "line"),
    [
        ("two\nlines\t here", "two lines here"),
        ("a\x1b[31mred\x07", "a\\x1b[31mred\\x07"),
        ("b\u202ec\u200b", "b\\u202ec\\u200b"),
        ("Grüße.csv", "Grüße.csv"),
        (b"\xff.csv".decode("utf-8", "surrogateescape"), "\\udcff.csv"),
    ],
)
def test_one_printable_line(text, line):
    assert shown(text) == line


@pytest.mark.parametrize("size", [299, 300, 301, 1200, 1201, 10**7])
def test_of_bounded_length(size):
    line = shown("a" * (size - 1) + "b")
    assert len(line) <= 300
    assert line[-1] == "b"
    assert (len(line) == size) == (size <= 300)


def test_control_characters_of_names_do_not_reach_the_terminal(tmp_path):
    path = tmp_path / "evil\x1b]0;title\x07.log"
    text = run("info", path).stderr
    path.write_text("FLASER 2 1 2 0 0 0 0 0 0\nEV\x1b[2JIL 1\n")
    text += run("info", path, "--format", "carmen").output
    path.write_text("FLASER 2 1 2 0 0 0 0 0 0\nO\x1b 1\n" * 3)
    text += run("info", path, "--format", "carmen", "--on-error", "skip").output
    assert "\\x1b" in text
    assert "\x1b" not in text
    assert "\x07" not in text


def test_a_message_is_never_long(tmp_path):
    path = tmp_path / "a.npz"
    np.savez(path, ranges=np.ones((3, 400)), angles=np.arange(400) / 400)
    content = bytearray(path.read_bytes())
    at = content.index(b"ranges.npy") - 4  # how long the name is
    content[at : at + 2] = b"\xff\x0f"
    path.write_bytes(content)
    done = run("info", path)
    assert done.exit_code == 2
    assert 50 < len(done.stderr) < 1000
    names = "/".join(["x" * 200] * 15)
    done = run("info", names)
    assert done.exit_code == 2
    assert len(done.stderr) < 1000
    assert "No such file" in done.stderr


def test_a_full_disk_is_named():
    with (
        pytest.raises(OSError, match="/dev/full") as error,
        complete_file("/dev/full") as file,
    ):
        file.write("x" * 100_000)
    assert error.value.errno == errno.ENOSPC


def test_a_full_disk_is_named_and_nothing_is_left(tmp_path):
    def fails():
        raise OSError(errno.ENOSPC, os.strerror(errno.ENOSPC))

    with pytest.raises(OSError, match=r"out\.jsonl"), complete_file(str(tmp_path / "out.jsonl")):
        fails()
    assert list(tmp_path.iterdir()) == []
    with (
        pytest.raises(lf.SourceError, match="a reader's own"),
        complete_file(str(tmp_path / "b")),
    ):
        raise lf.SourceError("a reader's own")
