"""Reading PCD and PLY files with Open3D, which warns about a bad one where this raises."""

import io
import re
from contextlib import redirect_stdout
from os import PathLike, fspath
from pathlib import Path
from typing import TYPE_CHECKING

import numpy as np

from laserfeatures.errors import SourceError
from laserfeatures.point_clouds.header import check_file
from laserfeatures.point_clouds.library import open3d

if TYPE_CHECKING:
    from open3d.geometry import PointCloud

DECORATION = re.compile(r"\x1b\[[\d;]*m|\[Open3D \w+\]")


def read_point_cloud(path: str | PathLike[str]) -> "PointCloud":
    """Read a PCD or PLY file, told by its content.

    Parameters
    ----------
    path : str or PathLike
        The file. Of a mesh in PLY the vertices are read.

    Returns
    -------
    open3d.geometry.PointCloud
        All that the file holds, points that are not finite included.

    Raises
    ------
    SourceError
        If it is missing, neither, damaged, cut, or holds no finite point.
    MissingDependencyError
        If Open3D is not installed.
    """
    path = Path(fspath(path))
    layout = check_file(path)
    o3d = open3d()
    levels = o3d.utility.VerbosityLevel
    # The tensor reader knows more types, but takes PLY of mixed ones for others.
    reader = o3d.t.io if layout.wide else o3d.io
    said = io.StringIO()
    # Open3D says what is wrong with a file by print.
    with o3d.utility.VerbosityContextManager(levels.Warning), redirect_stdout(said):
        try:
            cloud = reader.read_point_cloud(str(path), format=layout.form)
        except (RuntimeError, UnicodeError) as error:  # its own words may be no UTF-8
            raise _unreadable(path, str(error)) from error
    if said.getvalue():
        raise _unreadable(path, said.getvalue())
    if layout.wide:
        cloud = cloud.to_legacy()
    if not np.isfinite(np.asarray(cloud.points)).all(axis=1).any():
        raise SourceError(
            f"{path}: expected points with finite x, y and z, "
            f"got none among {len(cloud.points)} points"
        )
    return cloud


def _unreadable(path: Path, said: str) -> SourceError:
    reason = " ".join(DECORATION.sub("", said).split())
    return SourceError(f"{path}: the point cloud cannot be read: {reason}")
