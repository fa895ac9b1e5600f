"""The array checks that the data types share."""

from typing import Any, Self

import numpy as np
from numpy.typing import ArrayLike, NDArray

FloatArray = NDArray[np.float64]
IntArray = NDArray[np.int64]
BoolArray = NDArray[np.bool_]


def read_only(
    value: ArrayLike, name: str, shape: tuple[int | None, ...], dtype: type[np.generic] = np.float64
) -> NDArray[Any]:
    """Return `value` as a read-only C-contiguous array; None in `shape` stands for any length.

    A read-only array is taken as it is, any other is copied.

    Raises
    ------
    ValueError
        If the shape differs.
    """
    array = np.asarray(value, dtype=dtype, order="C")
    if array.flags.writeable:
        array = array.copy()
        array.flags.writeable = False
    if array.shape != shape and (
        array.ndim != len(shape)
        or any(n is not None and n != m for n, m in zip(shape, array.shape, strict=True))
    ):
        wanted = ", ".join("n" if n is None else str(n) for n in shape)
        raise ValueError(f"{name} must have shape ({wanted}), got {array.shape}")
    return array


def lock(*arrays: NDArray[Any]) -> None:
    """Make arrays read-only, and so all views that are taken of them later."""
    for array in arrays:
        array.setflags(False)  # type: ignore[call-arg] # by position takes a third of the time


class Record:
    """Base of the frozen dataclasses of arrays."""

    @classmethod
    def trusted(cls, **fields: object) -> Self:
        """Make a record of what our own kernels returned and was locked: not checked again."""
        record = object.__new__(cls)
        record.__dict__.update(fields)
        return record

    def __setstate__(self, state: dict[str, Any]) -> None:
        """Take what was pickled or copied; its arrays come back writable, and are locked again."""
        lock(*(value for value in state.values() if isinstance(value, np.ndarray)))
        self.__dict__.update(state)

    def _set(self, **arrays: NDArray[Any]) -> None:
        """Put the checked arrays in place of what was passed (a frozen dataclass bars setattr)."""
        self.__dict__.update(arrays)
