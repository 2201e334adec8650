"""The C library's programs: built with sanitizers, and run on 32-bit ARM under emulation."""

from __future__ import annotations

import subprocess
from dataclasses import dataclass
from functools import lru_cache
from pathlib import Path
from tempfile import mkdtemp

HERE = Path(__file__).resolve().parents[1]
SANITIZERS = ("-fsanitize=address,undefined", "-fno-sanitize-recover=all", "-g")
CORPUS = HERE.parent / "tests" / "codegen" / "clibrary_corpus"
ARM = ("arm-linux-gnueabihf-gcc", "-static", "-O2", "-mcpu=cortex-a9", "-mfpu=neon")


def compiles(compiler: list[str], program: str = "int main(void) { return 0; }") -> bool:
    """Whether a compiler with its flags builds a small program, so that what it does not build afterwards is at fault itself."""
    command = [*compiler, "-x", "c", "-", "-o", "/dev/null"]
    return subprocess.run(command, input=program, capture_output=True, text=True, check=False).returncode == 0


def build(compiler: list[str], folder: Path, source: str, target: Path, more: tuple[str, ...] = ()) -> Path:
    """The program `source` of the benchmarks with the library, at `target`; CalledProcessError where it does not build.

    compiler: with flags for both; more: flags and sources of the program alone. The library of a folder, which no longer changes,
    is compiled once for a compiler and its flags.
    """
    library = objects(tuple(compiler), folder)
    program = [str(HERE / source), *more, f"-I{folder / 'include'}", *library, "-lm", "-o", str(target)]
    subprocess.run([*compiler, *program], check=True)
    return target


@lru_cache(maxsize=8)
def objects(compiler: tuple[str, ...], folder: Path) -> tuple[str, ...]:
    """Object files of a library's sources, in a temporary folder."""
    there, made = Path(mkdtemp(prefix="softsoil_objects_")), []
    for file in sorted((folder / "src").glob("*.c")):
        made.append(str(there / f"{file.stem}.o"))
        subprocess.run([*compiler, f"-I{folder / 'include'}", "-c", str(file), "-o", made[-1]], check=True)
    return tuple(made)


@dataclass(frozen=True)
class Part:
    """What a source of the library takes (bytes): code with its constants, data that can be written to, the largest frame of a
    function on the stack, and which function's it is."""

    name: str
    code: int
    data: int
    frame: int
    function: str


def parts_memory(compiler: tuple[str, ...], folder: Path, scratch: Path) -> list[Part]:
    """Memory of every source, compiled by gcc with its flags; `size` of the binutils reads the objects."""
    found = []
    for file in sorted((folder / "src").glob("*.c")):
        made = scratch / f"{file.stem}.o"
        command = [*compiler, "-fstack-usage", f"-I{folder / 'include'}", "-c", str(file), "-o", str(made)]
        subprocess.run(command, check=True)
        sized = subprocess.run(["size", str(made)], capture_output=True, text=True, check=True).stdout.splitlines()[1].split()
        frames = [line.split("\t")[:2] for line in made.with_suffix(".su").read_text(encoding="utf-8").splitlines()]
        frame, function = max((int(size), place.rsplit(":", 1)[1]) for place, size in frames)
        found.append(Part(file.stem, int(sized[0]), int(sized[1]) + int(sized[2]), frame, function.split(".")[0]))
    return found


def arm_numbers(folder: Path, scratch: Path, source: str = "clibrary_arm.c") -> tuple[list[float], list[float]]:
    """Numbers that a program prints on this machine in the vector form, and on emulated 32-bit ARM."""
    here = numbers(["gcc", "-O2", "-march=native"], folder, source, scratch / "here")
    return here, numbers(list(ARM), folder, source, scratch / "there", ("qemu-arm",))


def numbers(
    compiler: list[str], folder: Path, source: str, target: Path, runner: tuple[str, ...] = (), steps: int = 200
) -> list[float]:  # fmt: skip
    """Numbers that the program `source` prints after so many steps, built by `compiler` and run by `runner`."""
    program = build(compiler, folder, source, target)
    done = subprocess.run([*runner, str(program), str(steps)], capture_output=True, text=True, check=True)
    return [float(word) for word in done.stdout.split()]


def arm_instructions(folder: Path, scratch: Path) -> float:
    """ARM instructions of one prediction, update and model step (which makes the measurement).

    Counted by single-stepping the emulator, as the difference of two runs.
    """
    there = build(list(ARM), folder, "clibrary_arm.c", scratch / "counted")
    counts = []
    for steps in ("2", "6"):
        log = scratch / "trace"
        # One line for each instruction: -singlestep makes translation blocks of one, nochain traces every pass.
        command = ["qemu-arm", "-singlestep", "-d", "exec,nochain", "-D", str(log), str(there), steps]
        subprocess.run(command, capture_output=True, check=True)
        with log.open("rb") as lines:
            counts.append(sum(line.startswith(b"Trace") for line in lines))
        log.unlink()
    return (counts[1] - counts[0]) / 4
