"""What the C library must stand, at length: python -m benchmarks.clibrary_trust WHAT [--amount N].

WHAT is storm, fuzz, arm, memory, generate, controller or driver.

storm: ten million steps of random driving with everything that can go wrong, under address and undefined sanitizers;
fuzz: libFuzzer (clang) for ten minutes on the estimator from the corpus in tests/codegen/clibrary_corpus, or with --of on the
controller or the driver; arm: the library on 32-bit ARM under emulation against this machine, and the instructions of a step;
memory: bytes of code, of the largest stack frame and of the structure, source by source, by this machine's gcc at
-O2 in scalars, then of all the stack that a drive writes to;
generate: `softsoil generate --model refined.toml` with an empty cache and again, in seconds, and its bytes (--model: another
refined.toml than one made of the reference vehicle);
controller: a million solves of the controller on the plain bicycle with everything that can go wrong, under sanitizers;
driver: the same of 200,000 ticks of the whole driver, on hard ground.
"""

from __future__ import annotations

import argparse
import os
import shutil
import subprocess
import sys
import tempfile
import time
from pathlib import Path

from benchmarks.judges.c_library import CORPUS, SANITIZERS, arm_instructions, arm_numbers, build, parts_memory

PROJECT = Path(__file__).resolve().parents[1]
STEPS, SECONDS = 10_000_000, 600
SMALL = ("gcc", "-O2", "-fno-math-errno", "-DSOFTSOIL_SCALAR")
"""As a small processor would have it."""
FAST = ("gcc", "-O3", "-march=native", "-fno-math-errno")
"""As the README's line builds it."""


def storm(folder: Path, scratch: Path, steps: int, sanitizers: tuple[str, ...] = SANITIZERS) -> None:
    """Ten million steps in the vector form."""
    program = build(["gcc", "-O2", "-march=native", *sanitizers], folder, "clibrary_storm.c", scratch / "storm")
    subprocess.run([str(program), str(steps), "1"], check=True)


def controller_library(folder: Path) -> None:
    """The controller of the plain bicycle among obstacles, as C."""
    from softsoil.codegen.c_library.folder import write_library
    from softsoil.control.c_controller import controller_files
    from softsoil.control.ocp import Ocp, OcpSettings
    from softsoil.control.ocp_examples import tanh_bicycle
    from softsoil.symbolic.vehicle import load_vehicle

    vehicle = load_vehicle(PROJECT / "vehicles" / "reference.toml")
    write_library(folder, controller_files(Ocp(tanh_bicycle(vehicle), vehicle, OcpSettings(obstacles=2))))


def driver_library(folder: Path) -> None:
    """The driver of the reference vehicle with its effects, on hard ground, as C."""
    from softsoil.codegen.c_library.folder import write_library
    from softsoil.control.c_folder import controller_texts
    from softsoil.declaration.model_file import Declaration
    from softsoil.symbolic.soil import CLAY
    from softsoil.symbolic.vehicle import load_vehicle

    declared = Declaration(load_vehicle(PROJECT / "vehicles" / "reference.toml"), CLAY, "hard_ground")
    write_library(folder, controller_texts(declared))


LIBRARIES = {"controller": controller_library, "driver": driver_library}


def closed_loop_storm(what: str, scratch: Path, steps: int, sanitizers: tuple[str, ...] = SANITIZERS) -> None:
    """A storm of `steps` solves of the controller or ticks of the driver."""
    LIBRARIES[what](scratch)
    program = build(["gcc", "-O2", "-march=native", *sanitizers], scratch, f"{what}_storm.c", scratch / "storm")
    subprocess.run([str(program), str(steps), "1"], check=True)


def fuzz(what: str, folder: Path, scratch: Path, seconds: int) -> None:
    """libFuzzer on the estimator, controller or driver, the estimator from its committed corpus; what it finds stays in the
    scratch folder."""
    if shutil.which("clang") is None:
        raise SystemExit("fuzz: expected clang with libFuzzer (its compiler-rt), found no clang")
    compiler = ["clang", "-O1", "-fsanitize=fuzzer,address,undefined", *SANITIZERS[1:]]
    found = scratch / "corpus"
    found.mkdir()
    if what == "estimator":
        program, corpus = build(compiler, folder, "clibrary_fuzz.c", scratch / "fuzz"), [str(CORPUS)]
    else:
        LIBRARIES[what](scratch / "library")
        program, corpus = build([*compiler, "-DFUZZ"], scratch / "library", f"{what}_storm.c", scratch / "fuzz"), []
    limits = [f"-max_total_time={seconds}", "-max_len=2000", "-print_final_stats=1"]
    subprocess.run([str(program), *limits, str(found), *corpus], check=True, cwd=scratch)


def arm(folder: Path, scratch: Path) -> None:
    """Numbers and instructions."""
    here, there = arm_numbers(folder, scratch)
    worst = max(abs(a - b) for a, b in zip(here, there, strict=True))
    print(f"32-bit ARM against this machine after 200 steps: largest difference {worst:.3g}")
    print(f"one prediction, update and model step on 32-bit ARM: {arm_instructions(folder, scratch):.0f} instructions")


def memory(folder: Path, scratch: Path) -> None:
    """A line for every source of the library, then what a drive writes to on the stack."""
    sizes = structures(folder, scratch)
    print(f"{'source':<20}{'code':>9}{'data':>6}{'structure':>11}{'largest frame':>15}")
    for part in parts_memory(SMALL, folder, scratch):
        print(f"{part.name:<20}{part.code:>9}{part.data:>6}{sizes.get(part.name, 0):>11}{part.frame:>15}  {part.function}")
    look = ("-DLOOK",) if (folder / "include" / "softsoil_vehicle.h").is_file() else ()
    for words, compiler in (("in scalars", SMALL), ("in this machine's vectors", FAST)):
        program = build(list(compiler), folder, "clibrary_stack.c", scratch / "stack", (*look, "-pthread"))
        done = subprocess.run([str(program)], capture_output=True, text=True, check=True)
        alone, *more = (int(line.split()[1]) for line in done.stdout.splitlines())
        beside = zip(("the horizon", "the look at the vehicle"), more, strict=False)
        print(f"bytes of stack, {words}: filter {alone}", *(f"with {name} {size}" for name, size in beside), sep="; ")


def structures(folder: Path, scratch: Path) -> dict[str, int]:
    """Bytes of the structure that each source works on, by the source's name."""
    sources = {"softsoil": "softsoil_filter"}
    headers = sorted((folder / "include").glob("softsoil*.h"))
    names = [file.stem for file in headers if f"{file.stem}_size(void)" in file.read_text(encoding="utf-8")]
    includes = "".join(f'#include "{name}.h"\n' for name in names)
    lines = "".join(f'  printf("{sources.get(name, name)} %lu\\n", (unsigned long){name}_size());\n' for name in names)
    source = scratch / "structures.c"
    source.write_text(f"#include <stdio.h>\n{includes}int main(void) {{\n{lines}  return 0;\n}}\n", encoding="utf-8")
    program = build(list(SMALL), folder, str(source), scratch / "structures")
    done = subprocess.run([str(program)], capture_output=True, text=True, check=True)
    return {name: int(size) for name, size in (line.split() for line in done.stdout.splitlines())}


def reference_declaration() -> str:
    """A refined.toml of the reference vehicle with its effects, on clay."""
    from softsoil.declaration.model_file import Declaration, declaration_toml
    from softsoil.symbolic.soil import CLAY
    from softsoil.symbolic.vehicle import load_vehicle

    return declaration_toml(Declaration(load_vehicle(PROJECT / "vehicles" / "reference.toml"), CLAY))


def _seconds(command: list[str], environment: dict[str, str]) -> float:
    """On the clock, from the start of the process to its end."""
    began = time.perf_counter()
    subprocess.run(command, env=environment, capture_output=True, check=True)
    return time.perf_counter() - began


def generate(model: Path | None, scratch: Path) -> None:
    """Seconds of the command with an empty cache and with nothing changed (best of five); exit 1 for other bytes."""
    bare = [sys.executable, "-c", "pass"]
    if model is None:
        model = scratch / "refined.toml"
        model.write_text(reference_declaration(), encoding="utf-8")
    folders = [scratch / name for name in ("first", "second")]
    for place, folder in enumerate(folders):
        path = os.pathsep.join(filter(None, [str(PROJECT), os.environ.get("PYTHONPATH")]))
        environment = os.environ | {"SOFTSOIL_CACHE": str(scratch / f"cache{place}"), "PYTHONPATH": path}
        for state in ("empty cache", "nothing changed"):
            command = [sys.executable, "-m", "softsoil.commands.start", "generate", str(folder), "--model", str(model)]
            spent = min(_seconds(command, environment) for _ in range(1 if state == "empty cache" else 5))
            print(
                f"{state}: {spent:.2f} s for the command, of which Python's own start {_seconds(bare, environment):.2f} s"
            )
    files = [sorted(path.relative_to(folder) for path in folder.rglob("*") if path.is_file()) for folder in folders]
    same = files[0] == files[1] and all(
        (folders[0] / f).read_bytes() == (folders[1] / f).read_bytes() for f in files[0]
    )
    print(f"{len(files[0])} files generated twice from nothing: {'the same bytes' if same else 'DIFFERENT BYTES'}")
    if not same:
        raise SystemExit(1)


def main() -> None:
    """Read the command line and run."""
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("what", choices=("storm", "fuzz", "arm", "memory", "generate", "controller", "driver"))
    parser.add_argument("--amount", type=int, help="steps of the storm, seconds of fuzzing")
    parser.add_argument("--of", choices=("estimator", *LIBRARIES), default="estimator", help="what is fuzzed")
    parser.add_argument("--folder", type=Path, default=PROJECT / "generated")
    parser.add_argument("--plain", action="store_true", help="the storm without sanitizers, five times as fast")
    parser.add_argument("--model", type=Path, help="refined.toml for generate")
    given = parser.parse_args()
    if given.what == "generate":
        with tempfile.TemporaryDirectory() as scratch:
            generate(given.model, Path(scratch))
        return
    amounts = {"storm": STEPS, "fuzz": SECONDS, "arm": 0, "memory": 0, "controller": STEPS // 10, "driver": STEPS // 50}
    amount, sanitizers = given.amount or amounts[given.what], () if given.plain else SANITIZERS
    with tempfile.TemporaryDirectory() as scratch:
        if given.what in LIBRARIES:
            closed_loop_storm(given.what, Path(scratch), amount, sanitizers)
        elif given.what == "fuzz":
            fuzz(given.of, given.folder, Path(scratch), amount)
        elif given.what == "storm":
            storm(given.folder, Path(scratch), amount, sanitizers)
        elif given.what == "memory":
            memory(given.folder, Path(scratch))
        else:
            arm(given.folder, Path(scratch))


if __name__ == "__main__":
    main()
