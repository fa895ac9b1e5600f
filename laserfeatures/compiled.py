"""How the kernels are compiled, and when what an earlier run has compiled still holds."""

import hashlib
import inspect
import operator
from collections.abc import Callable, Mapping
from string import hexdigits
from types import CodeType, FunctionType, ModuleType
from typing import TYPE_CHECKING, Any, TypeVar, get_args, get_type_hints

import numpy as np
from numba import njit
from numba.core.registry import CPUDispatcher

from laserfeatures.compiled_cache import Cache, NoCache
from laserfeatures.compiled_signals import heard_outside_of_callbacks

if TYPE_CHECKING:
    from numba.core.dispatcher import Dispatcher

_F = TypeVar("_F", bound=Callable[..., object])
_NUMBERS = int | np.bool_ | np.integer | np.floating  # but Python's float: it fits as it is
_PLAIN = {int, float, bool, str, type(None)}


def kernel(function: _F) -> "Dispatcher[_F]":
    """Compile what Python calls: once for all runs, until any code or constant in it changes.

    Division by zero gives inf or nan, as in NumPy: Python's check would double the code.
    """
    dispatcher = njit(error_model="numpy")(function)
    if type(dispatcher) is CPUDispatcher:
        dispatcher.__class__ = _Kernel
        dispatcher._cache = _cache(dispatcher)  # type: ignore[attr-defined] # noqa: SLF001
    return dispatcher


def interruption(error: BaseException) -> BaseException:
    """Return what a signal's handler raised while compiled code ran; else the error itself.

    What compiled code returns is wrapped up by Python, which runs handlers then. numba does not
    look whether one has raised, so that Python finds a result and an exception at once: to it that
    is a `SystemError`, maybe within another one.
    """
    while isinstance(error, SystemError) and error.__cause__ is not None:
        error = error.__cause__
    return error


class _Kernel(CPUDispatcher):
    """A kernel as Python calls it: Ctrl-C is heard, and numbers are of the types it is written for.

    Ctrl-C comes out of it as `KeyboardInterrupt`, which costs 0.15 us a call.
    """

    def __call__(self, *args: Any) -> Any:
        """Run it."""
        try:
            return _call(self, *args)
        except SystemError as error:
            raise interruption(error) from None

    def _compile_for_args(self, *args: Any, **named: Any) -> Any:
        """Return what is to be called in place of code for such arguments, which there is not.

        Numbers of other types than the kernel's annotations are made to fit: compiling for them
        takes long. Code for the others is compiled.
        """
        fitted = tuple(map(_fitted, args, self._hints()))
        if named or len(fitted) != len(args) or all(map(operator.is_, args, fitted)):
            with heard_outside_of_callbacks():
                return super()._compile_for_args(*args, **named)  # type: ignore[misc] # it has one
        return lambda *_: self(*fitted)

    def _hints(self) -> list[Any]:
        names = inspect.signature(self.py_func).parameters
        try:
            hints = get_type_hints(self.py_func)
        except NameError:  # of what is only there for type checkers
            hints = self.py_func.__annotations__
        return [hints.get(name) for name in names]


_call = CPUDispatcher.__call__


def _fitted(value: Any, hint: Any) -> Any:
    """Return a number, or a tuple of them, in the types of an annotation; the rest as it is."""
    if hint is float and isinstance(value, _NUMBERS):
        return float(value)
    if hint is int and isinstance(value, bool | np.bool_ | np.integer):
        return int(value)
    if isinstance(value, tuple):
        hints = get_type_hints(hint).values() if hasattr(hint, "_fields") else get_args(hint)
        if len(hints) == len(value):
            items = list(map(_fitted, value, hints))
            if not all(map(operator.is_, items, value)):
                return type(value)(*items) if hasattr(value, "_fields") else tuple(items)
    return value


# What only kernels call is a helper: a part of them, which compiles in half the time without the
# wrapper that Python would need. So Python must not call it: that would end the interpreter.
helper = njit(  # type: ignore[call-overload] # options that the stubs of numba leave out
    error_model="numpy", no_cpython_wrapper=True, no_cfunc_wrapper=True
)
# A helper that makes no array counts no references to those it is given: taking them out of their
# named tuple would count each time, which takes longer than most of what is done with them.
leaf = njit(  # type: ignore[call-overload] # as above
    error_model="numpy", no_cpython_wrapper=True, no_cfunc_wrapper=True, _nrt=False
)
# A helper's code is optimised again in each that calls it, through all levels. What only strings
# helpers together is therefore put into its callers before anything is compiled.
inlined = njit(  # type: ignore[call-overload] # as above
    error_model="numpy", no_cpython_wrapper=True, no_cfunc_wrapper=True, inline="always"
)
# A variable begins with this, not with 0, where helpers take it: they would be compiled for the
# type of the literal, too.
ZERO: int = np.int64(0)  # type: ignore[assignment] # as good as one


def _cache(dispatcher: Any) -> Any:
    try:
        return Cache(dispatcher.py_func, lambda: _Contents(dispatcher).digest())
    except (AttributeError, TypeError, RuntimeError):  # an unknown numba; no folder for it
        return NoCache(dispatcher.py_func)


class _Contents:
    """All code and constants that a kernel is compiled from, whatever files they come from.

    They are taken from memory, as numba takes them: times of files do not matter. Not seen is what
    numba finds in tables of its own: overloads, and the methods of jitclasses.
    """

    def __init__(self, dispatcher: Any) -> None:
        self._parts: list[str] = []
        self._seen: dict[tuple[int, tuple[str, ...]], int] = {}
        self._add(dispatcher)

    def digest(self) -> str:
        """Return a digest, the same in all processes."""
        text = "\n".join(self._parts)
        return hashlib.sha256(text.encode("utf-8", "backslashreplace")).hexdigest()

    def _add(self, value: Any, names: tuple[str, ...] = ()) -> None:
        """Add a value that code with these names refers to."""
        if type(value) in _PLAIN:  # most are: that is quick
            self._parts.append(repr(value))
        elif isinstance(value, FunctionType):
            if self._is_new(value):
                self._add_function(value)
        elif isinstance(value, ModuleType):
            if self._is_new(value, names):
                self._add_named(names, vars(value))
        elif isinstance(value, tuple):
            self._parts.append(f"{type(value)} {len(value)}")
            for each in value:
                self._add(each, names)
        elif isinstance(value, np.ndarray):
            self._parts.append(
                f"{value.dtype} {value.shape} {value.strides} {value.tobytes().hex()}"
            )
        elif isinstance(value, frozenset):  # its order differs between processes
            self._parts.append(repr(sorted(map(repr, value))))
        elif isinstance(value, type):  # maybe an enumeration or a named tuple
            fields = getattr(value, "__members__", None), getattr(value, "_fields", None)
            self._parts.append(f"{value} {fields}")
        elif isinstance(value, _Kernel) or (
            type(value).__module__.startswith("numba.") and hasattr(value, "__wrapped__")
        ):
            self._parts.append(_text(getattr(value, "targetoptions", None)))
            self._add(value.__wrapped__)
        else:
            self._parts.append(_text(value))

    def _is_new(self, value: object, names: tuple[str, ...] = ()) -> bool:
        known = len(self._seen)
        number = self._seen.setdefault((id(value), names), known)
        self._parts.append(f"{type(value)} {number}")
        return number == known

    def _add_function(self, function: FunctionType) -> None:
        self._add_code(function.__code__, function.__globals__)
        self._add(function.__defaults__)
        self._parts.append(_text(function.__kwdefaults__))
        for cell in function.__closure__ or ():
            self._add(cell.cell_contents, function.__code__.co_names)

    def _add_code(self, code: CodeType, scope: Mapping[str, Any]) -> None:
        instructions = code.co_code.hex(), code.co_exceptiontable.hex(), code.co_flags
        parameters = code.co_argcount, code.co_posonlyargcount, code.co_kwonlyargcount
        names = code.co_names, code.co_varnames, code.co_freevars, code.co_cellvars
        self._parts.append(f"{instructions} {parameters} {names}")
        for constant in code.co_consts:
            if isinstance(constant, CodeType):  # of a function within the function
                self._add_code(constant, scope)
            else:
                self._add(constant)
        self._add_named(code.co_names, scope)

    def _add_named(self, names: tuple[str, ...], scope: Mapping[str, Any]) -> None:
        for name in names:
            if name in scope:
                self._parts.append(name)
                self._add(scope[name], names)


def _text(value: object) -> str:
    """Return the value's text without addresses: they differ between processes."""
    first, *others = repr(value).split(" at 0x")
    return first + "".join(each.lstrip(hexdigits) for each in others)
