import gzip
import io
import math

import numpy as np
import pytest
from evo.tools import file_interface

import laserfeatures as lf
from laserfeatures.mapping.trajectory import Trajectory
from laserfeatures.mapping.tum import is_tum, read_tum, write_tum

STAMPS = [1134864642.914187, 1134864643.1, 1134864644.25]
POSES = [(576.48068, -0.103068, -1.487635), (1e-9, 2.5, math.pi), (-3.0, 0.1, 0.0)]


def text_of(trajectory):
    file = io.StringIO()
    write_tum(file, trajectory)
    return file.getvalue()


def read_text(folder, text):
    path = folder / "way.txt"
    path.write_text(text)
    return read_tum(path)


def test_what_is_written_is_read_back(tmp_path):
    trajectory = Trajectory(stamps=STAMPS, poses=POSES)
    back = read_text(tmp_path, text_of(trajectory))
    assert back.stamps.tolist() == STAMPS
    assert back.poses[:, :2].tolist() == trajectory.poses[:, :2].tolist()
    np.testing.assert_allclose(back.poses[:, 2], trajectory.poses[:, 2], rtol=0, atol=1e-12)


def test_evo_reads_it_and_it_reads_evos(tmp_path):
    path = tmp_path / "way.txt"
    path.write_text(text_of(Trajectory(stamps=STAMPS, poses=POSES)))
    theirs = file_interface.read_tum_trajectory_file(path)
    assert theirs.timestamps.tolist() == STAMPS
    np.testing.assert_array_equal(theirs.positions_xyz[:, :2], np.array(POSES)[:, :2])
    np.testing.assert_allclose(
        theirs.poses_se3[0][:2, 0], [math.cos(POSES[0][2]), math.sin(POSES[0][2])]
    )
    file_interface.write_tum_trajectory_file(tmp_path / "theirs.txt", theirs)
    back = read_tum(tmp_path / "theirs.txt")
    np.testing.assert_allclose(back.poses, POSES, rtol=0, atol=1e-9)


def test_poses_without_stamps_are_numbered_and_without_headings_stay_so(tmp_path):
    nowhere = Trajectory(stamps=[math.nan, 2.0], poses=[(1, 2, math.nan), (3, 4, 0.5)])
    back = read_text(tmp_path, text_of(nowhere))
    assert back.stamps.tolist() == [0, 1]
    assert np.isnan(back.poses[:, 2]).tolist() == [True, False]


def test_packed_with_comments_and_empty_lines(tmp_path):
    path = tmp_path / "way.tum"
    path.write_bytes(gzip.compress(b"# stamp x y ..\n\n5 1 2 0.3 0 0 0 1\n"))
    assert read_tum(path).poses.tolist() == [[1, 2, 0]]


def test_a_quaternion_and_its_negative_are_one_heading(tmp_path):
    half = math.sqrt(0.5)
    back = read_text(tmp_path, f"1 0 0 0 0 0 {half} -{half}\n2 0 0 0 0 0 -{half} {half}\n")
    assert back.poses[:, 2] == pytest.approx([-math.pi / 2] * 2)


@pytest.mark.parametrize(
    ("line", "complaint"),
    [
        ("1 2 3 4", "expected stamp x y z qx qy qz qw, got 4 fields"),
        ("1 2 3 4 0 0 0 x", "could not convert string to float: b'x'"),
        ("1 2 nan 4 0 0 0 1", "expected finite numbers"),
        ("1 2 3 4 0 0 1 1", "a quaternion qx qy qz qw of length 1, got one of 1.41"),
        ("1 2 3 4 0.7071 0 0 0.7071", "a pose in the plane, .* got qx = 0.707"),
    ],
)
def test_a_broken_line_is_named(tmp_path, line, complaint):
    with pytest.raises(lf.SourceError, match=f"way.txt:3: .*{complaint}"):
        read_text(tmp_path, f"# a\n1 2 3 0 0 0 0 1\n{line}\n1 2 3 0 0 0 0 1\n")


def test_a_cut_an_empty_and_a_missing_file_are_named(tmp_path):
    path = tmp_path / "way.gz"
    lines = "".join(f"{i} {i}.25 0 0 0 0 0 1\n" for i in range(9000))
    path.write_bytes(gzip.compress(lines.encode())[:-3000])
    with pytest.raises(lf.SourceError, match=r"way.gz:\d+: the file is cut or damaged"):
        read_tum(path)
    with pytest.raises(lf.SourceError, match=r"way.txt: expected poses in TUM format, got none"):
        read_text(tmp_path, "# nothing\n")
    with pytest.raises(lf.SourceError, match=r"none.txt: cannot be opened"):
        read_tum(tmp_path / "none.txt")


def test_a_trajectory_is_told_from_other_text():
    assert is_tum(b"# way\n\n1 2 3 0 0 0 0 1\n")
    for other in (b"", b"P 1 2 3\n", b"1 2 3\n", b"S 1 3 1 1 1 1 1\n", b"# 1 2 3 4 5 6 7 8\n"):
        assert not is_tum(other)
