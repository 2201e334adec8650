"""Generated C, compiled once into a cache keyed by its content, called through buffers."""

from __future__ import annotations

import hashlib
import os
import shutil
import subprocess
import tempfile
import warnings
from functools import lru_cache
from pathlib import Path

import casadi as ca
import numpy as np
from numpy.typing import ArrayLike, NDArray

from symbolic.codegen import write_c

FLAGS = ("-O3", "-march=native", "-fno-math-errno", "-shared", "-fPIC")


def cache_folder() -> Path:
    """Where compiled functions are kept: $SOFTSOIL_CACHE, else the user's cache folder."""
    chosen = os.environ.get("SOFTSOIL_CACHE")
    base = Path(chosen) if chosen else Path(os.environ.get("XDG_CACHE_HOME", Path.home() / ".cache")) / "softsoil"
    return base


@lru_cache(maxsize=1)
def find_compiler() -> str | None:
    """Path of a C compiler ($CC, cc, gcc or clang), or None."""
    for candidate in (os.environ.get("CC"), "cc", "gcc", "clang"):
        found = shutil.which(candidate) if candidate else None
        if found:
            return found
    return None


@lru_cache(maxsize=1)
def _compiler_version(compiler: str) -> str:
    run = subprocess.run([compiler, "--version"], capture_output=True, text=True, check=False)
    return run.stdout.splitlines()[0] if run.stdout else compiler


@lru_cache(maxsize=1)
def _machine() -> str:
    """What -march=native depends on, so that a cache on a shared disk is not used by another processor."""
    try:
        lines = Path("/proc/cpuinfo").read_text(encoding="utf-8").splitlines()
        return next((line for line in lines if line.startswith("flags")), "")
    except OSError:
        return ""


@lru_cache(maxsize=1)
def _warn_no_compiler() -> None:
    warnings.warn(
        "no C compiler found (tried $CC, cc, gcc, clang): functions run in the CasADi virtual machine, about ten times "
        "slower",
        stacklevel=4,
    )


def compile_function(function: ca.Function) -> ca.Function:
    """The function as compiled C where a compiler works, else the function itself with one warning.

    The shared library is kept in `cache_folder()` under a name made of its content, compiler and flags.
    """
    compiler = find_compiler()
    if compiler is None:
        _warn_no_compiler()
        return function
    with tempfile.TemporaryDirectory() as scratch:
        source = write_c([function], scratch, header=False)[0]
        key = hashlib.sha256(source.read_bytes())
        key.update(repr((_compiler_version(compiler), FLAGS, _machine())).encode())
        library = cache_folder() / f"{function.name()}_{key.hexdigest()[:24]}.so"
        if not library.is_file() and not _build(compiler, source, library):
            return function
    return ca.external(function.name(), str(library))


def _build(compiler: str, source: Path, library: Path) -> bool:
    """Compile into the cache under a scratch name, then move: another process never sees half a file."""
    library.parent.mkdir(parents=True, exist_ok=True)
    with tempfile.TemporaryDirectory(dir=library.parent) as scratch:
        built = Path(scratch) / library.name
        command = [compiler, *FLAGS, str(source), "-o", str(built), "-lm"]
        run = subprocess.run(command, capture_output=True, text=True, check=False)
        if run.returncode != 0:
            reason = (run.stderr.strip().splitlines() or ["no message"])[0]
            warnings.warn(
                f"{compiler} could not compile {library.name}: {reason}; running in the CasADi VM", stacklevel=4
            )
            return False
        built.replace(library)
    return True


class CompiledFunction:
    """A CasADi function as compiled C, called on NumPy buffers without copies of its own.

    function: dense inputs and outputs. `inputs` and `outputs` are the arrays that the C code reads and writes (Fortran
    order, shapes of the function's arguments); `run()` evaluates them in place, which is the hot path. Calling the
    object copies arguments in and results out.
    """

    def __init__(self, function: ca.Function, compiled: bool = True) -> None:
        self.symbolic = _dense(function)
        self.function = compile_function(self.symbolic) if compiled else self.symbolic
        self.is_compiled = self.function is not self.symbolic
        self._buffer, self.run = self.function.buffer()
        self.inputs = tuple(_matrix(function.size_in(i)) for i in range(function.n_in()))
        self.outputs = tuple(_matrix(function.size_out(i)) for i in range(function.n_out()))
        for i, array in enumerate(self.inputs):
            self._buffer.set_arg(i, memoryview(array.reshape(-1, order="A")))
        for i, array in enumerate(self.outputs):
            self._buffer.set_res(i, memoryview(array.reshape(-1, order="A")))

    def __call__(self, *args: ArrayLike) -> NDArray[np.float64] | tuple[NDArray[np.float64], ...]:
        """Outputs for the given inputs: vectors as (n,), matrices as (n, m); one output is returned bare.

        Raises ValueError for another number or size of inputs.
        """
        if len(args) != len(self.inputs):
            names = ", ".join(self.symbolic.name_in())
            raise ValueError(f"{self.symbolic.name()}: expected {len(self.inputs)} inputs ({names}), found {len(args)}")
        for i, (array, arg) in enumerate(zip(self.inputs, args, strict=True)):
            value = np.asarray(arg, dtype=float)
            if value.size != array.size:
                raise ValueError(
                    f"{self.symbolic.name()}: input {self.symbolic.name_in(i)}: expected shape {array.shape}, "
                    f"found {value.shape}"
                )
            array[...] = value.reshape(array.shape)
        self.run()
        results = tuple(out[:, 0].copy() if out.shape[1] == 1 else out.copy() for out in self.outputs)
        return results[0] if len(results) == 1 else results


def _matrix(shape: tuple[int, int]) -> NDArray[np.float64]:
    """Zeros in column-major order, as CasADi stores a matrix."""
    return np.zeros(shape, order="F")


def _dense(function: ca.Function) -> ca.Function:
    """The function with dense inputs and outputs, so that buffers have the plain shapes."""
    sparse = [i for i in range(function.n_out()) if not function.sparsity_out(i).is_dense()]
    if not sparse and all(function.sparsity_in(i).is_dense() for i in range(function.n_in())):
        return function
    args = [ca.MX.sym(function.name_in(i), *function.size_in(i)) for i in range(function.n_in())]
    results = [ca.densify(r) for r in function.call(args)]
    return ca.Function(function.name(), args, results, function.name_in(), function.name_out())
