"""The FMI units of a generated folder, compiled and packed: softsoil.fmu and softsoil_driver.fmu."""

from __future__ import annotations

import platform
import subprocess
import tempfile
import zipfile
from pathlib import Path

from softsoil.codegen.c_library.build import sources
from softsoil.codegen.c_library.fmi import IDENTIFIER
from softsoil.codegen.compiled import find_compiler

DRIVER_IDENTIFIER = "softsoil_driver"
FLAGS = ("-O3", "-fno-math-errno", "-shared", "-fPIC", "-fvisibility=hidden")
"""No -march: a unit is carried to other machines."""
_DAY = (1980, 1, 1, 0, 0, 0)


def pack_fmus(folder: Path) -> list[Path]:
    """The units of `folder`, from its src/ and fmi/: softsoil.fmu, the model, and softsoil_driver.fmu where there is a driver.

    Raises ValueError where there is no compiler or it refuses.
    """
    units = [_pack(folder, IDENTIFIER, "fmu.c", "modelDescription.xml", sources(folder))]
    if (folder / "fmi" / "fmu_driver.c").is_file():
        every = sorted((folder / "src").glob("*.c"))
        units.append(_pack(folder, DRIVER_IDENTIFIER, "fmu_driver.c", "driverDescription.xml", every))
    return units


def _pack(folder: Path, identifier: str, main: str, description: str, library_sources: list[Path]) -> Path:
    """One unit: its description, its library for this machine, and the sources of it."""
    compiler = find_compiler()
    if compiler is None:
        raise ValueError("--fmi: expected a C compiler ($CC, cc, gcc or clang), found none")
    system = {"Linux": ("linux", ".so"), "Darwin": ("darwin", ".dylib")}.get(platform.system())
    if system is None:
        raise ValueError(f"--fmi: expected Linux or macOS to build on, found {platform.system()}")
    machine = {"amd64": "x86_64", "arm64": "aarch64"}.get(platform.machine().lower(), platform.machine().lower())
    sources = [folder / "fmi" / main, *library_sources]
    with tempfile.TemporaryDirectory() as scratch:
        library = Path(scratch) / f"{identifier}{system[1]}"
        headers = [f"-I{folder / name}" for name in ("include", "fmi")]
        command = [compiler, *FLAGS, *headers, *map(str, sources), "-lm", "-o", str(library)]
        run = subprocess.run(command, capture_output=True, text=True, check=False)
        if run.returncode != 0:
            raise ValueError(f"--fmi: {compiler} refused: {run.stderr.strip()}")
        content = {f"binaries/{machine}-{system[0]}/{library.name}": library.read_bytes()}
        content["modelDescription.xml"] = (folder / "fmi" / description).read_bytes()
        for source in (*sources, *(path for name in ("fmi", "src", "include") for path in (folder / name).glob("*.h"))):
            content[f"sources/{source.name}"] = source.read_bytes()
    path = folder / f"{identifier}.fmu"
    with zipfile.ZipFile(path, "w", zipfile.ZIP_DEFLATED) as archive:
        for name in sorted(content):
            archive.writestr(zipfile.ZipInfo(name, _DAY), content[name])
    return path
