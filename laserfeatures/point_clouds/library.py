"""Open3D itself: the one place that imports it."""

from typing import Any

from laserfeatures.optional import optional


def open3d() -> Any:
    """Return the package open3d.

    Raises
    ------
    MissingDependencyError
        If it is not installed, or lacks a library of the system.
    """
    return optional("open3d", "point clouds need open3d", "open3d")


def of_type(geometry: object, name: str, hint: str = "") -> Any:
    """Return `geometry` if it is an ``open3d.geometry`` of that name.

    Raises
    ------
    TypeError
        If it is anything else.
    MissingDependencyError
        As `open3d`.
    """
    if isinstance(geometry, getattr(open3d().geometry, name)):
        return geometry
    kind = type(geometry)
    tensor = " of Open3D's tensor kind; convert it with its to_legacy()"
    raise TypeError(
        f"expected an open3d.geometry.{name}{hint}, got a {kind.__name__}"
        + (tensor if hasattr(geometry, "to_legacy") else "")
    )
