"""The FMI unit of a generated folder: compiled and packed as softsoil.fmu."""

from __future__ import annotations

import platform
import subprocess
import tempfile
import zipfile
from pathlib import Path

from softsoil.codegen.c_library.build import SOURCES
from softsoil.codegen.c_library.fmi import IDENTIFIER
from softsoil.codegen.compiled import find_compiler

FLAGS = ("-O3", "-fno-math-errno", "-shared", "-fPIC", "-fvisibility=hidden")
"""No -march: a unit is carried to other machines."""
_DAY = (1980, 1, 1, 0, 0, 0)


def pack_fmu(folder: Path) -> Path:
    """softsoil.fmu in `folder`, from its src/ and fmi/: sources, description and the library for this machine.

    Raises ValueError where there is no compiler or it refuses.
    """
    compiler = find_compiler()
    if compiler is None:
        raise ValueError("--fmi: expected a C compiler ($CC, cc, gcc or clang), found none")
    system = {"Linux": ("linux", ".so"), "Darwin": ("darwin", ".dylib")}.get(platform.system())
    if system is None:
        raise ValueError(f"--fmi: expected Linux or macOS to build on, found {platform.system()}")
    machine = {"amd64": "x86_64", "arm64": "aarch64"}.get(platform.machine().lower(), platform.machine().lower())
    sources = [folder / "fmi" / "fmu.c", *(folder / source for source in SOURCES)]
    with tempfile.TemporaryDirectory() as scratch:
        library = Path(scratch) / f"{IDENTIFIER}{system[1]}"
        command = [compiler, *FLAGS, f"-I{folder / 'include'}", *map(str, sources), "-lm", "-o", str(library)]
        run = subprocess.run(command, capture_output=True, text=True, check=False)
        if run.returncode != 0:
            raise ValueError(f"--fmi: {compiler} refused: {run.stderr.strip()}")
        content = {f"binaries/{machine}-{system[0]}/{library.name}": library.read_bytes()}
        content["modelDescription.xml"] = (folder / "fmi" / "modelDescription.xml").read_bytes()
        for source in (*sources, *(folder / "src").glob("*.h"), *(folder / "include").glob("*.h")):
            content[f"sources/{source.name}"] = source.read_bytes()
    path = folder / f"{IDENTIFIER}.fmu"
    with zipfile.ZipFile(path, "w", zipfile.ZIP_DEFLATED) as archive:
        for name in sorted(content):
            archive.writestr(zipfile.ZipInfo(name, _DAY), content[name])
    return path
