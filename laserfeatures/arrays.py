"""The array checks that the data types share."""

from typing import Any, Self

import numpy as np
from numpy.typing import ArrayLike, NDArray

FloatArray = NDArray[np.float64]
IntArray = NDArray[np.int64]
BoolArray = NDArray[np.bool_]


def unmasked(value: ArrayLike) -> ArrayLike:
    """Return a masked array of NumPy with nan where it is masked, and any other as it is."""
    if isinstance(value, np.ma.MaskedArray):
        filled: FloatArray = np.ma.filled(np.ma.asarray(value, np.float64), np.nan)
        return filled
    return value


def read_only(
    value: ArrayLike, name: str, shape: tuple[int | None, ...], dtype: type[np.generic] = np.float64
) -> NDArray[Any]:
    """Return `value` as a read-only C-contiguous array; None in `shape` stands for any length.

    A read-only array is taken as it is, any other is copied; numbers that are masked are nan.

    Raises
    ------
    ValueError
        If the shape differs, or it is no array of numbers.
    """
    value = unmasked(value) if dtype is np.float64 else value
    try:
        array = np.asarray(value, dtype=dtype, order="C")
    except (TypeError, ValueError, OverflowError) as error:
        raise ValueError(f"{name} must be an array of numbers: {error}") from error
    if array.flags.writeable or not array.flags.aligned:  # kernels are compiled for no other
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

    @classmethod
    def packed(cls, numbers: FloatArray, **fields: object) -> Self:
        """Make a trusted record of some fields, and of others in one locked array of numbers.

        They are taken out when one of them is first looked at: to take all out of each scan's
        records takes as long as to find corners, and who wants corners needs no lines.
        """
        return cls.trusted(numbers=numbers, **fields)

    def __getattr__(self, name: str) -> Any:
        """Take the fields out of the array of numbers, where there is one."""
        if "numbers" in self.__dict__ and name in self.__dataclass_fields__:
            self._unpack(self.__dict__["numbers"])
            return self.__dict__[name]
        raise AttributeError(f"{type(self).__name__!r} object has no attribute {name!r}")

    def _unpack(self, numbers: FloatArray) -> None:
        """Set the fields that `numbers` holds."""
        raise NotImplementedError

    def __getstate__(self) -> dict[str, Any]:
        """Return what is pickled or copied: the fields, not the array that they are parts of."""
        state = dict(self.__dict__)
        if state.pop("numbers", None) is not None:
            state.update({name: getattr(self, name) for name in self.__dataclass_fields__})
        return state

    def __setstate__(self, state: dict[str, Any]) -> None:
        """Take what was pickled or copied; its arrays come back writable, and are locked again."""
        lock(*(value for value in state.values() if isinstance(value, np.ndarray)))
        self.__dict__.update(state)

    def _set(self, **fields: object) -> None:
        """Put the checked arrays in place of what was passed (a frozen dataclass bars setattr)."""
        self.__dict__.update(fields)
