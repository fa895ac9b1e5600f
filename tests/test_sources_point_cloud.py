import gzip
import math
import re
import subprocess
import sys

import clouds
import numpy as np
import pytest
from clouds import BAND, cloud_of, o3d

import laserfeatures as lf
from laserfeatures.optional import install_line
from laserfeatures.point_clouds import read_point_cloud

FORMS = {
    "ascii.pcd": {"write_ascii": True},
    "binary.pcd": {},
    "compressed.pcd": {"compressed": True},
    "ascii.ply": {"write_ascii": True},
    "binary.ply": {},
}
SOME = cloud_of(np.random.default_rng(0).uniform(1, 2, (30, 3)))
SOME.paint_uniform_color((0.2, 0.4, 0.6))

PCD = """# .PCD v0.7 - Point Cloud Data file format
VERSION 0.7
FIELDS x y z
SIZE 4 4 4
TYPE F F F
COUNT 1 1 1
WIDTH 2
HEIGHT 1
VIEWPOINT 0 0 0 1 0 0 0
POINTS 2
DATA ascii
1 2 0.4
3 4 0.5
"""
PLY = """ply
format ascii 1.0
comment two points
element vertex 2
property float x
property float y
property float z
end_header
1 2 0.4
3 4 0.5
"""


def write(path, cloud, form):
    assert o3d.io.write_point_cloud(str(path), cloud, **FORMS[form])
    return path


@pytest.mark.parametrize("sigma", [0.0, 0.01])
@pytest.mark.parametrize("form", FORMS)
def test_a_rooms_corners_are_found_in_its_file(tmp_path, form, sigma):
    seed = list(FORMS).index(form)
    path = write(tmp_path / form, clouds.room(sigma=sigma, seed=seed), form)
    with lf.open_source(path, slice_band=BAND) as source:
        assert (source.format, source.poses) == ("point_cloud", "none")
        (scan,) = source
    assert scan.pose is None
    assert math.isnan(scan.stamp)
    corners = lf.get_extractor("direct_hough")(scan).corners
    clouds.check_corners(corners.positions, corners.real)


@pytest.mark.parametrize("form", FORMS)
def test_a_cloud_is_told_by_content_and_read_whole(tmp_path, capfd, form):
    path = write(tmp_path / form, SOME, form).rename(tmp_path / "cloud")
    cloud = read_point_cloud(path)
    np.testing.assert_allclose(cloud.points, SOME.points, rtol=0, atol=1e-5)
    np.testing.assert_allclose(cloud.colors, SOME.colors, rtol=0, atol=1 / 255)
    with lf.open_source(path, slice_band=(0, 3)) as source:
        assert source.format == "point_cloud"
    assert capfd.readouterr() == ("", "")


def test_more_than_the_plainest_files(tmp_path):
    path = tmp_path / "cloud"
    coloured = PLY.replace("float z\n", "float z\nproperty uchar red\n").replace("0.", "0 0.")
    before = PLY.replace("element", "element camera 1\nproperty list uchar int id\nelement", 1)
    for text in (
        PCD.replace("\n", "\r\n"),
        PLY.replace("\n", "\r\n"),
        PCD[PCD.index("VERSION") :],
        PCD.replace("COUNT 1 1 1\n", ""),
        PCD.replace("POINTS 2\n", ""),
        PCD.replace("1 2 0.4\n", "\n1 2 0.4\n\n"),
        PCD.replace("x y z", "x y n z", 1)
        .replace("4 4 4", "4 4 4 4", 1)
        .replace("F F F", "F F F F", 1)
        .replace("1 1 1", "1 1 2 1", 1)
        .replace(" 0.", " 7 8 0."),
        coloured.replace("0 0.4", "0.4 9").replace("0 0.5", "0.5 9"),
        before.replace("header\n", "header\n2 5 6\n"),
        PLY.replace("end_", "element face 1\nproperty list uchar int i\nend_") + "3 0 1 1\n",
    ):
        path.write_bytes(text.encode())
        points = np.asarray(read_point_cloud(path).points)
        np.testing.assert_allclose(points, [[1, 2, 0.4], [3, 4, 0.5]], rtol=1e-6)


def test_of_a_mesh_the_vertices_are_read(tmp_path):
    mesh = clouds.box((1, 1, 1), (2, 0, 0))
    o3d.io.write_triangle_mesh(str(tmp_path / "mesh.ply"), mesh)
    cloud = read_point_cloud(tmp_path / "mesh.ply")
    np.testing.assert_array_equal(cloud.points, mesh.vertices)


@pytest.mark.parametrize("kind", ["f4", "f8", "i1", "i2", "i4", "i8", "u1", "u2", "u4", "u8"])
def test_numbers_of_every_type_of_binary_pcd(tmp_path, kind):
    sizes, types = " ".join([kind[1]] * 3), " ".join([kind[0].upper()] * 3)
    header = PCD[: PCD.index("ascii")].replace("4 4 4", sizes).replace("F F F", types) + "binary\n"
    points = np.array([[1, 2, 3], [4, 5, 6]], dtype=f"<{kind}")
    (tmp_path / "a.pcd").write_bytes(header.encode() + points.tobytes())
    np.testing.assert_array_equal(read_point_cloud(tmp_path / "a.pcd").points, points)


def test_padding_as_the_point_cloud_library_writes_it(tmp_path):
    header = (
        PCD[: PCD.index("ascii")]
        .replace("x y z", "x y z _ i _")
        .replace("4 4 4", "4 4 4 1 4 1")
        .replace("F F F", "F F F U F U")
        .replace("1 1 1", "1 1 1 4 1 12")
    )
    row = [("xyz", "<f4", 3), ("pad", "u1", 4), ("i", "<f4"), ("rest", "u1", 12)]
    points = np.zeros(2, row)
    points["xyz"] = [[1, 2, 3], [4, 5, 6]]
    path = tmp_path / "a.pcd"
    path.write_bytes(f"{header}binary\n".encode() + points.tobytes())
    np.testing.assert_array_equal(read_point_cloud(path).points, points["xyz"])
    path.write_text(header.replace("4 4 4 1", "8 8 8 1") + "binary\n")
    with pytest.raises(
        lf.SourceError, match=r"of at most 4 bytes where fields share .* got .*F8 F8"
    ):
        read_point_cloud(path)


def test_points_that_are_none_are_left_out(tmp_path):
    path = tmp_path / "a.pcd"
    path.write_text(PCD.replace("1 2 0.4", "nan 2 0.4"))
    with lf.open_source(path, slice_band=(0.3, 0.6)) as source:
        np.testing.assert_allclose(next(source).points, [[3, 4]], rtol=1e-6)
    with pytest.raises(lf.SourceError, match=r"the 1 points of the cloud span z = 0\.500 \.\."):
        lf.open_source(path, slice_band=BAND)


def test_the_range_can_be_limited(tmp_path):
    (tmp_path / "a.ply").write_text(PLY)
    with lf.open_source(tmp_path / "a.ply", slice_band=(0, 1), range_max=3.0) as source:
        scan = next(source)
    np.testing.assert_allclose(scan.points, [[1, 2]], rtol=1e-6)
    assert scan.range_max == 3.0


BROKEN = [
    (
        PCD.replace("x y z", "x y").replace("4 4 4", "4 4").replace("1 1 1", "1 1"),
        "x, y and z.*x y$",
    ),
    (PCD.replace("FIELDS x", "FIELDS a"), "with x, y and z, got the fields a y z"),
    (PCD.replace("POINTS 2", "POINTS 0"), "expected points, got an empty cloud"),
    (PCD.replace("POINTS 2", "POINTS many"), "expected POINTS with 1 whole numbers, got many"),
    (PCD.replace("POINTS 2\nDATA", "POINTS 3\nDATA"), "expected 3 lines of points, got 2; .* cut"),
    (PCD[: PCD.index("1 2")], "expected 2 lines of points, got 0; the file is cut"),
    (PCD[: PCD.index("COUNT")], "expected a header that ends with DATA, got none"),
    (PCD.replace("SIZE 4 ", "SIZE "), "expected SIZE with 3 whole numbers, got 4 4"),
    (PCD.replace("SIZE 4 4 4\n", ""), "expected SIZE with 3 whole numbers, got nothing"),
    (PCD.replace("ascii", "packed"), "DATA to be one of ascii, binary, .* got 'packed'"),
    (PCD.replace("ascii", "binary"), "expected 24 bytes of points, got 16; the file is cut"),
    (PCD.replace("ascii", "binary_compressed"), "expected 24 bytes of points, got"),
    (PCD.replace("2 0.4", "abc 0.4"), "a line of numbers for each point: .*'abc'.* row 0"),
    (PCD.replace("2 0.4", "2"), "a line of numbers for each point"),
    (PCD.replace("TYPE F F F", "TYPE F F Q"), "cannot be read: .*Unsupported data type Q"),
    (PCD.replace("SIZE 4 4 4", "SIZE 8 4 4"), "cannot be read: .*Read PCD failed"),
    (
        PCD.replace("1 2", "nan 2").replace("3 4", "3 inf"),
        "finite x, y and z, got none among 2 poi",
    ),
    ("ply\n", "expected a header that ends with end_header, got none"),
    (PLY.replace("float z", "float h"), "with x, y and z, got the fields x y h"),
    (PLY.replace("vertex 2", "vertex 0"), "expected points, got an empty cloud"),
    (PLY.replace("vertex 2", "vertex -2"), "element vertex with 1 whole numbers, got -2"),
    (PLY.replace("vertex 2", "face 2"), "a format and the element vertex, got none"),
    (PLY.replace("format ascii 1.0\n", ""), "a format and the element vertex, got none"),
    (PLY.replace("float x", "number x"), "header of a PLY file, got 'property number x'"),
    (PLY[:-8], "expected 2 lines of points, got 1; the file is cut"),
    (PLY.replace("3 4", "3 x"), "a line of numbers for each point: .*'x'.* row 1"),
    (PLY.replace("ascii", "binary_little_endian"), "expected 24 bytes of points, got 16"),
]


@pytest.mark.parametrize(("text", "complaint"), BROKEN)
def test_a_broken_file_is_told_before_open3d_reads_it(tmp_path, capfd, text, complaint):
    path = tmp_path / "cloud"
    path.write_text(text)
    with pytest.raises(lf.SourceError, match=complaint) as error:
        lf.open_source(path, slice_band=BAND)
    assert str(error.value).startswith(f"{path}: ")
    assert "\n" not in str(error.value)
    assert capfd.readouterr() == ("", "")


@pytest.mark.parametrize("form", FORMS)
def test_no_cut_file_gives_other_points(tmp_path, capfd, form):
    content = write(tmp_path / form, SOME, form).read_bytes()
    path = tmp_path / "cut"
    refused = 0
    for length in range(0, len(content), 7):
        path.write_bytes(content[:length])
        try:
            cloud = read_point_cloud(path)
        except lf.SourceError:
            refused += 1
        else:
            np.testing.assert_allclose(cloud.points, SOME.points, rtol=0, atol=1e-3)
    assert refused > len(content) / 7 - 10
    assert capfd.readouterr() == ("", "")


def test_what_is_no_cloud(tmp_path):
    for path, complaint in [
        (tmp_path / "gone.pcd", "cannot be opened: No such file"),
        (tmp_path, "cannot be opened: Is a directory"),
    ]:
        with pytest.raises(lf.SourceError, match=complaint):
            read_point_cloud(path)
        with pytest.raises(lf.SourceError, match=str(path)):
            lf.open_source(path, slice_band=BAND)
    path = tmp_path / "log.pcd"
    path.write_text("angle,range\n0,1\n")
    with pytest.raises(lf.SourceError, match=r"expected a PCD or PLY file, got .* b'angle,ra'"):
        lf.open_source(path, format="point_cloud", slice_band=BAND)
    path.write_bytes(gzip.compress(PCD.encode()))
    with pytest.raises(lf.SourceError, match="point_cloud file that is not packed, got gzip; gunz"):
        lf.open_source(path, slice_band=BAND)


def test_the_band_is_needed_and_must_hold_points(tmp_path):
    path = tmp_path / "cloud"
    path.write_text(PCD)
    span = r"spans? z = 0\.400 \.\. 0\.500 m; choose .* slice_band=\S* ?\S* ?\(--slice"
    with pytest.raises(lf.SourceError, match=f"{path}: expected a band of heights, .*{span}"):
        lf.open_source(path)
    with pytest.raises(lf.SourceError, match=rf"{path}: .* with 1 <= z < 2 m, got none: .*{span}"):
        lf.open_source(path, slice_band=(1.0, 2.0))
    for band in [(0.5, 0.3), (0.3, 0.3), (0.3, math.nan)]:
        with pytest.raises(ValueError, match=r"slice_band must be low < high \[m\], got 0"):
            lf.open_source(path, slice_band=band)
    for option in ({"topic": "/scan"}, {"field_of_view": 1.0}):
        with pytest.raises(ValueError, match="does not apply to the format 'point_cloud'"):
            lf.open_source(path, slice_band=BAND, **option)
    path.write_text("angle,range\n0,1\n")
    with pytest.raises(ValueError, match="slice_band does not apply to the format 'csv'"):
        lf.open_source(path, slice_band=BAND)


def test_without_open3d_the_extra_is_named(tmp_path, monkeypatch):
    monkeypatch.setitem(sys.modules, "open3d", None)
    (tmp_path / "cloud").write_text(PCD)
    with pytest.raises(lf.MissingDependencyError, match=re.escape(install_line("open3d"))):
        lf.open_source(tmp_path / "cloud", slice_band=BAND)


def test_open3d_is_imported_only_for_clouds(tmp_path):
    (tmp_path / "log").write_text("angle,range\n0,1\n")
    code = (
        "import sys, laserfeatures as lf, laserfeatures.point_clouds\n"
        f"assert len(list(lf.open_source({str(tmp_path / 'log')!r}))) == 1\n"
        "print('open3d' in sys.modules)"
    )
    command = [sys.executable, "-c", code]
    done = subprocess.run(command, capture_output=True, text=True, check=True)  # noqa: S603 - our own code
    assert done.stdout == "False\n"


@pytest.mark.parametrize("kind", ["F4", "F8"])
def test_a_cloud_that_is_far_from_the_scanner_is_refused_with_how_far(tmp_path, kind):
    east, north = 399_000.0, 4_985_000.0  # UTM
    directions = np.linspace(0, 2 * np.pi, 2000)
    points = np.stack([3 * np.cos(directions), 2 * np.sin(directions), 0 * directions + 0.4], 1)
    points += (east, north, 0)
    size = kind[1]
    path = tmp_path / "utm.pcd"
    header = PCD.replace("4 4 4", f"{size} {size} {size}").replace("WIDTH 2", "WIDTH 2000")
    header = header.replace("POINTS 2", "POINTS 2000").partition("ascii")[0] + "binary\n"
    path.write_bytes(header.encode() + points.astype(f"<f{size}").tobytes())
    with pytest.raises(lf.SourceError, match=r"5000940 m away: x = 39.*y = 49.*--origin"):
        lf.open_source(path, slice_band=(0.3, 0.5))
    with lf.open_source(path, slice_band=(0.3, 0.5), slice_origin=(east, north)) as source:
        assert next(source).valid.any()


def test_a_wall_that_is_seen_from_afar_is_a_scan(tmp_path):
    points = np.random.default_rng(0).uniform((90, -40, 0.3), (91, 40, 0.5), (50_000, 3))
    o3d.io.write_point_cloud(str(tmp_path / "a.pcd"), cloud_of(points))
    with lf.open_source(tmp_path / "a.pcd", slice_band=(0.3, 0.5)) as source:
        assert next(source).valid.any()
