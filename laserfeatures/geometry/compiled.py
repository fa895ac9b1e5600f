"""How the kernels are compiled."""

from numba import njit

# Division by zero gives inf or nan, as in NumPy: Python's check would double the code. What Python
# calls is a kernel and compiled once for all runs. What only kernels call is a helper: a part of
# them, which compiles in half the time without the wrapper that Python would need. So Python must
# not call it: that would end the interpreter.
kernel = njit(cache=True, error_model="numpy")
helper = njit(  # type: ignore[call-overload] # options that the stubs of numba leave out
    error_model="numpy", no_cpython_wrapper=True, no_cfunc_wrapper=True
)
# A helper's code is optimised again in each that calls it, through all levels. What only strings
# helpers together is therefore put into its callers before anything is compiled.
inlined = njit(  # type: ignore[call-overload] # as above
    error_model="numpy", no_cpython_wrapper=True, no_cfunc_wrapper=True, inline="always"
)
