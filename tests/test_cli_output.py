import stat
from pathlib import Path

import click
import pytest

from laserfeatures.cli.output import complete_file


def fail_after_writing(file, error):
    file.write("half")
    file.flush()
    raise error


def names(folder):
    return sorted(path.name for path in folder.iterdir())


def test_a_file_appears_when_all_went_well(tmp_path):
    with complete_file(str(tmp_path / "out")) as file:
        file.write("grüße")
        assert "out" not in names(tmp_path)
    assert (tmp_path / "out").read_text(encoding="utf-8") == "grüße"
    assert names(tmp_path) == ["out"]


@pytest.mark.parametrize("error", [RuntimeError, KeyboardInterrupt, SystemExit])
def test_a_failure_leaves_what_was_there(tmp_path, error):
    target = tmp_path / "out"
    target.write_text("older")
    with pytest.raises(error), complete_file(str(target)) as file:
        fail_after_writing(file, error)
    assert target.read_text() == "older"
    assert names(tmp_path) == ["out"]


def test_permissions_are_those_of_any_new_file(tmp_path):
    (tmp_path / "plain").touch()
    with complete_file(str(tmp_path / "out"), binary=True) as file:
        file.write(b"x")
    modes = {stat.S_IMODE(path.stat().st_mode) for path in tmp_path.iterdir()}
    assert len(modes) == 1


def test_a_link_stays_a_link(tmp_path):
    (tmp_path / "link").symlink_to(tmp_path / "target")
    with complete_file(str(tmp_path / "link")) as file:
        file.write("x")
    assert (tmp_path / "link").is_symlink()
    assert (tmp_path / "target").read_text() == "x"


def test_a_device_is_written_to_and_not_replaced():
    with complete_file("/dev/null") as file:
        file.write("x")
    assert Path("/dev/null").is_char_device()


def test_the_input_is_not_overwritten(tmp_path):
    source = tmp_path / "log"
    source.write_text("precious")
    with pytest.raises(click.UsageError, match="overwrite the input"):
        complete_file(str(tmp_path / "." / "log"), str(source)).__enter__()
    assert source.read_text() == "precious"


def test_a_folder_is_no_file(tmp_path):
    with pytest.raises(click.UsageError, match="is a folder"):
        complete_file(str(tmp_path)).__enter__()


def test_a_folder_that_takes_no_files_is_told_at_once():
    with pytest.raises(click.UsageError, match="-o /proc/out cannot be written"):
        complete_file("/proc/out").__enter__()


def test_the_folder_must_be_there(tmp_path):
    with pytest.raises(click.UsageError, match="make it first"):
        complete_file(str(tmp_path / "missing" / "out")).__enter__()
