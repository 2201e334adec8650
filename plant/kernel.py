"""How the compiled parts of the plant are compiled."""

from typing import Any

from numba import njit

_OPTIONS: dict[str, Any] = {"cache": True, "error_model": "numpy"}
_INNER: dict[str, Any] = {**_OPTIONS, "no_cpython_wrapper": True, "no_cfunc_wrapper": True}

kernel = njit(**_OPTIONS)
"""A compiled function that Python may call; division by zero gives inf, as in numpy."""

inner = njit(**_INNER)
"""A compiled function that only compiled ones call: without its Python side, which takes long to compile."""

geometry = njit(**_INNER, fastmath=True)
"""As `inner`, free to reorder sums and to divide by multiplying: for finite geometry whose last bit does not matter."""
