"""A generated folder compiled into a shared library, kept in the cache."""

from __future__ import annotations

import hashlib
import subprocess
from collections.abc import Sequence
from pathlib import Path

from softsoil.codegen.compiled import compiler_version, find_compiler, machine
from softsoil.files.cache import scratch_folder, writable_cache

FLAGS = ("-O3", "-march=native", "-fno-math-errno")
SOURCES = ("src/softsoil_filter.c", "src/softsoil_model.c", "src/softsoil_horizon.c", "src/softsoil_vehicle.c",
           "src/softsoil_rows.c")  # fmt: skip
"""Of the library; the last two only where the vehicle's file states errors of its numbers, and where a vehicle's six states are
measured."""


def sources(folder: Path) -> list[Path]:
    """Those sources that a generated folder has."""
    return [path for path in (folder / source for source in SOURCES) if path.is_file()]


def build_c_library(folder: str | Path, flags: Sequence[str] = FLAGS, compiler: str | None = None) -> Path:
    """The library in `folder` as a shared library, kept in the cache under its content, compiler, processor and flags.

    Raises ValueError where there is no compiler or it refuses.
    """
    compiler = compiler or find_compiler()
    if compiler is None:
        raise ValueError("C library: expected a C compiler ($CC, cc, gcc or clang), found none")
    folder = Path(folder)
    texts = [path.read_bytes() for path in sorted(folder.rglob("*.[ch]"))]
    built_by = (compiler, compiler_version(compiler), machine(), *flags)
    key = hashlib.sha256(b"\0".join([*texts, *(part.encode() for part in built_by)])).hexdigest()
    library = writable_cache() / f"softsoil_{key[:24]}.so"
    if not library.is_file():
        with scratch_folder(library.parent) as scratch:
            built = scratch / library.name
            command = [compiler, *flags, "-shared", "-fPIC", f"-I{folder / 'include'}"]
            command += [str(path) for path in sources(folder)] + ["-lm", "-o", str(built)]
            run = subprocess.run(command, capture_output=True, text=True, check=False)
            if run.returncode != 0:
                raise ValueError(f"C library: {compiler} refused {folder}: {run.stderr.strip()}")
            built.replace(library)
    return library
