"""Generated C, compiled once into a cache keyed by its content, called through buffers."""

from __future__ import annotations

import hashlib
import logging
import os
import shutil
import subprocess
import tempfile
import warnings
from collections.abc import Sequence
from functools import lru_cache
from pathlib import Path
from typing import Any

import casadi as ca
import numpy as np
from numpy.typing import ArrayLike, NDArray

from softsoil.codegen.c_source import write_c
from softsoil.codegen.lanes import write_group, write_lanes
from softsoil.codegen.text_cache import code_digest
from softsoil.files.cache import scratch_folder, writable_cache

FLAGS = ("-O3", "-march=native", "-fno-math-errno", "-fPIC")
LANES_FLAGS = ("-Og", *FLAGS[1:])
"""For `softsoil.codegen.lanes`: a step is one long straight line of vectors. -O1 takes a compiler half as long again, -O3 twice
as long. A call by itself takes 1.2 to 1.7 times as long as by -O3 (`benchmarks.kernel_compilers`), an estimate as a whole as
long by any of the three. Scalar code runs a fifth slower at -Og."""
PATIENCE = 2.0
"""s: a compilation that takes longer is announced, once per process."""
WRITERS = (("codegen", "*.py"), ("codegen/c_library", "kernels.py"), ("codegen/c_library/templates", "*lanes*"))
"""Rooms and files that write C for lanes."""
NATIVE = "-march=native"
"""Left out where a compiler does not know it."""


@lru_cache(maxsize=1)
def find_compiler() -> str | None:
    """Path of a C compiler ($CC, cc, gcc or clang), or None."""
    for candidate in (os.environ.get("CC"), "cc", "gcc", "clang"):
        found = shutil.which(candidate) if candidate else None
        if found:
            return found
    return None


@lru_cache(maxsize=1)
def compiler_version(compiler: str) -> str:
    """The first line of what a compiler says of its version."""
    run = subprocess.run([compiler, "--version"], capture_output=True, text=True, check=False)
    return run.stdout.splitlines()[0] if run.stdout else compiler


@lru_cache(maxsize=1)
def machine() -> str:
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


def compile_function(function: ca.Function, parts: Sequence[str] = ()) -> ca.Function:
    """The function as compiled C where a compiler works, else the function itself with one warning.

    parts: C sources of what the function calls from outside (`at_points`). The shared library is kept in
    `cache_folder()` under a name made of its content, compiler and flags.
    """
    compiler = find_compiler()
    if compiler is None:
        _warn_no_compiler()
        return function
    with tempfile.TemporaryDirectory() as scratch:
        source = write_c([function], scratch, header=False)[0].read_text(encoding="utf-8")
    library = _library(compiler, function.name(), (source,), parts)
    return function if library is None else ca.external(function.name(), str(library))


def at_points(function: ca.Function, count: int, repeats: int = 1) -> tuple[ca.Function, tuple[str, ...]]:
    """The function at many points, [X (n, count), u, p] -> [Y (m, count)], and the C sources that it needs when called in C.

    function: [x, u, p] -> [y], vectors; repeats: times that it is applied, y in the place of x (a loop in C). Several points
    at once in vector registers (`softsoil.codegen.lanes`) where the compiler has them, else CasADi's map, one after the other.
    """
    compiler = find_compiler()
    name = f"{function.name()}_points"
    if compiler is not None:
        source = write_lanes(function if function.is_a("SXFunction") else function.expand(), count, name, repeats)
        library = _library(compiler, name, (), (source,), warn=False)
        if library is not None:
            return ca.external(name, str(library)), (source,)
    mapped = function.map(count)
    if repeats == 1:
        return mapped, ()
    args = [ca.MX.sym(mapped.name_in(i), *mapped.size_in(i)) for i in range(mapped.n_in())]
    result = args[0]
    for _ in range(repeats):
        result = mapped(result, *args[1:])
    return ca.Function(name, args, [result]), ()


def build_library(name: str, sources: Sequence[str], flags: Sequence[str] = FLAGS) -> Path | None:
    """Path of the shared library of C `sources`, from the cache or built into it; None where there is no compiler that can.

    flags: of the compiler, -fPIC among them.
    """
    compiler = find_compiler()
    return None if compiler is None else _library(compiler, name, sources, flags=flags)


def group_library(function: ca.Function, driver: str) -> Path | None:
    """Path of the shared library of an SX `function`'s group (`write_group`, in parts) and of the C `driver` that calls it.

    What the same code made of the same function before is neither written nor compiled again. None as of `build_library`.
    """
    compiler = find_compiler()
    if compiler is None:
        return None
    asked = _key(compiler, LANES_FLAGS, function.serialize(), driver, code_digest(WRITERS).hex())
    library = writable_cache() / f"{function.name()}_loop_{asked}.so"
    if library.is_file():
        return library
    group = write_group(function, f"{function.name()}_group", parts=True)
    return _built(compiler, library, (), (f"{group}\n{driver}",), FLAGS)


def _library(
    compiler: str,
    name: str,
    sources: Sequence[str],
    lanes: Sequence[str] = (),
    warn: bool = True,
    flags: Sequence[str] = FLAGS,
) -> Path | None:
    """The shared library of `sources` and of `lanes`, which have flags of their own, from the cache or built into it."""
    library = writable_cache() / f"{name}_{_key(compiler, (*flags, *LANES_FLAGS), *sources, *lanes)}.so"
    return library if library.is_file() else _built(compiler, library, sources, lanes, flags, warn)


def _built(
    compiler: str, library: Path, sources: Sequence[str], lanes: Sequence[str], flags: Sequence[str], warn: bool = True
) -> Path | None:
    """The library, of its sources; None where the compiler refuses.

    Each source is compiled once and its object kept: a part that several libraries share costs once.
    """
    folder = library.parent
    try:
        objects = [_object(compiler, source, folder, flags) for source in sources]
        objects += [_object(compiler, source, folder, LANES_FLAGS) for source in lanes]
        _compile([compiler, "-shared", *map(str, objects), "-lm"], library)
    except OSError as error:
        if warn:
            warnings.warn(
                f"{compiler} could not compile {library.name}: {error}; running in the CasADi VM", stacklevel=5
            )
        return None
    return library


def _key(compiler: str, flags: Sequence[str], *sources: str) -> str:
    facts = repr((sources, compiler_version(compiler), tuple(flags), machine()))
    return hashlib.sha256(facts.encode()).hexdigest()[:24]


def _object(compiler: str, source: str, folder: Path, flags: Sequence[str]) -> Path:
    """The object file of one source, from the cache or compiled into it; OSError where the compiler refuses."""
    path = folder / f"{_key(compiler, flags, source)}.o"
    if not path.is_file():
        with scratch_folder(folder) as scratch:
            file = scratch / "part.c"
            file.write_text(source, encoding="utf-8")
            try:
                _compile([compiler, *flags, "-c", str(file)], path)
            except OSError:
                _compile([compiler, *(flag for flag in flags if flag != NATIVE), "-c", str(file)], path)
    return path


def _compile(command: Sequence[str], target: Path) -> None:
    """Run the compiler into a scratch name, then move: another process never sees half a file. OSError with its reason."""
    with scratch_folder(target.parent) as scratch:
        built = scratch / target.name
        code, said = _watched([*command, "-o", str(built)])
        if code != 0:
            raise OSError((said.strip().splitlines() or ["no message"])[0])
        built.replace(target)


def _watched(command: Sequence[str]) -> tuple[int, str]:
    """Exit code and error output of a compiler; one line to the log where it takes longer than PATIENCE."""
    with subprocess.Popen(command, stdout=subprocess.DEVNULL, stderr=subprocess.PIPE, text=True) as process:
        try:
            _, said = process.communicate(timeout=PATIENCE)
        except subprocess.TimeoutExpired:
            _say_compiling()
            _, said = process.communicate()
        except BaseException:
            process.kill()
            raise
    return process.returncode, said


@lru_cache(maxsize=1)
def _say_compiling() -> None:
    logging.getLogger("softsoil").warning("compiling the model, once; kept in the cache")


class CompiledFunction:
    """A CasADi function as compiled C, called on NumPy buffers without copies of its own.

    function: dense inputs and outputs; parts: C sources of functions that it calls (`at_points`). `inputs` and `outputs`
    are the arrays that the C code reads and writes (Fortran order, shapes of the function's arguments); `run()` evaluates
    them in place, which is the hot path. `bind_input` and `bind_output` put other arrays in their place, so that functions
    share them. Calling the object copies arguments in and results out.
    """

    def __init__(self, function: ca.Function, compiled: bool = True, parts: Sequence[str] = ()) -> None:
        self.symbolic = _dense(function)
        self.function = compile_function(self.symbolic, parts) if compiled else self.symbolic
        self.is_compiled = self.function is not self.symbolic
        buffer: tuple[Any, Any] = self.function.buffer()
        self._buffer, self._evaluate = buffer
        self.inputs: list[NDArray[np.float64]] = []
        self.outputs: list[NDArray[np.float64]] = []
        for i in range(function.n_in()):
            self.inputs.append(np.empty(0))
            self.bind_input(i, np.zeros(function.size_in(i), order="F"))
        for i in range(function.n_out()):
            self.outputs.append(np.empty(0))
            self.bind_output(i, np.zeros(function.size_out(i), order="F"))

    def run(self) -> None:
        """Evaluate `inputs` into `outputs`."""
        self._evaluate()

    def bind_input(self, index: int, array: NDArray[np.float64]) -> None:
        """Read input `index` from `array` from now on; ValueError unless it has the shape, in Fortran order."""
        self._buffer.set_arg(index, self._memory(array, self.symbolic.size_in(index)))
        self.inputs[index] = array

    def bind_output(self, index: int, array: NDArray[np.float64]) -> None:
        """Write output `index` to `array` from now on; ValueError unless it has the shape, in Fortran order."""
        self._buffer.set_res(index, self._memory(array, self.symbolic.size_out(index)))
        self.outputs[index] = array

    def _memory(self, array: NDArray[np.float64], shape: tuple[int, int]) -> memoryview:
        """The array's own memory."""
        if array.shape != shape or array.dtype != np.float64 or not array.flags.f_contiguous:
            raise ValueError(
                f"{self.symbolic.name()}: expected a float array of shape {shape} in Fortran order, "
                f"found {array.dtype} of shape {array.shape}"
            )
        flat: Any = array.reshape(-1, order="A")
        return memoryview(flat)

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


def _dense(function: ca.Function) -> ca.Function:
    """The function with dense inputs and outputs, so that buffers have the plain shapes."""
    sparse = [i for i in range(function.n_out()) if not function.sparsity_out(i).is_dense()]
    if not sparse and all(function.sparsity_in(i).is_dense() for i in range(function.n_in())):
        return function
    args = [ca.MX.sym(function.name_in(i), *function.size_in(i)) for i in range(function.n_in())]
    results = [ca.densify(r) for r in function.call(args)]
    return ca.Function(function.name(), args, results, function.name_in(), function.name_out())
