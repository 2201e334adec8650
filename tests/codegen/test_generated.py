"""The committed library is what the code writes, byte for byte, and stands on its own."""

import re
import shutil
import subprocess

import pytest

from c_folders import IDENTIFIED, NAMES, declared, folder
from drives import PROJECT, reference_vehicle
from softsoil.codegen.c_library.build import sources
from softsoil.control.c_estimator import c_library_texts
from softsoil.declaration.model_file import Declaration
from softsoil.symbolic.soil import CLAY

GENERATED = PROJECT / "generated"
EVERY = (*NAMES, IDENTIFIED)
STRICT = ("-Wall", "-Wextra", "-Wconversion", "-Wpedantic", "-Werror")
FRONT = "-fsyntax-only"
"""Enough for what a compiler says of the text; some warnings come with optimisation only, which costs seconds."""
COMPILERS = [
    ("gcc", "-std=c99", "-O1"), ("clang", "-std=c99", FRONT), ("g++", FRONT, "-x", "c++"), ("clang++", FRONT, "-x", "c++"),
    ("gcc", "-std=c99", FRONT, "-DSOFTSOIL_SCALAR"), ("gcc", FRONT, "-mavx512f", "-mavx512dq"), ("clang", FRONT, "-mavx2"),
]  # fmt: skip


def test_committed_library_is_fresh():
    texts = c_library_texts(Declaration(reference_vehicle(), CLAY))
    found = {str(path.relative_to(GENERATED)) for path in GENERATED.rglob("*") if path.is_file()}
    assert found == set(texts), "run: softsoil generate generated --soil clay"
    for name, text in texts.items():
        stale = f"{name} is stale: run softsoil generate generated --soil clay"
        assert (GENERATED / name).read_bytes() == text.encode(), stale


@pytest.mark.parametrize("name", EVERY)
def test_the_same_bytes_every_time(name):
    assert c_library_texts(declared(name)) == c_library_texts(declared(name))


def test_nothing_of_the_machine_in_the_files():
    for text in c_library_texts(declared("plain")).values():
        assert not re.search(r"@[a-z_0-9]+@|/home/|/work/|/tmp/|20[2-9][0-9]-", text)


def test_readme_names_files_that_exist():
    text = (GENERATED / "README.md").read_text(encoding="utf-8")
    named = set(re.findall(r"`((?:include|src)/[\w.]+|[\w.]+\.(?:c|json|txt))`", text))
    assert named and all((GENERATED / name).is_file() for name in named), named


def run(*command, **more):
    return subprocess.run(command, capture_output=True, text=True, check=False, **more)


@pytest.mark.slow
@pytest.mark.compiler
@pytest.mark.parametrize(
    ("name", "compiler"),
    [
        pytest.param(name, compiler, id=f"{name}-{' '.join(compiler)}",
                     marks=[pytest.mark.study] if "-O1" in compiler and name != "tracks" else [])
        for name in EVERY for compiler in COMPILERS
    ],
)  # fmt: skip
def test_compilers_have_nothing_to_say(name, compiler, tmp_path):
    if shutil.which(compiler[0]) is None:
        pytest.skip(f"{compiler[0]} is not installed")
    for source in (*sources(folder(name)), folder(name) / "example.c"):
        target = () if FRONT in compiler else ("-o", str(tmp_path / "object.o"))
        include = f"-I{folder(name) / 'include'}"
        built = run(*compiler, *STRICT, include, "-c", str(source), *target)
        assert built.returncode == 0 and not built.stderr, built.stderr[:2000]


@pytest.mark.slow
@pytest.mark.compiler
@pytest.mark.parametrize("name", EVERY)
def test_no_allocation_no_globals_libm_only(name, tmp_path):
    """What the objects ask for and own: mathematics, memory copies, and nothing that can be written to."""
    if shutil.which("gcc") is None or shutil.which("nm") is None:
        pytest.skip("gcc and nm are not installed")
    wanted, writable = set(), set()
    for source in sources(folder(name)):
        target = tmp_path / "object.o"
        command = ("gcc", "-O0", f"-I{folder(name) / 'include'}", "-c", str(source), "-o", str(target))
        assert run(*command).returncode == 0
        for line in run("nm", str(target)).stdout.splitlines():
            kind, symbol = line.split()[-2:]
            if kind == "U":
                wanted.add(symbol)
            elif kind in "BbDdCSs":
                writable.add(symbol)
    foreign = {s for s in wanted if not s.startswith("softsoil_")} - MATHEMATICS
    assert not foreign and not writable


MATHEMATICS = {
    "exp", "log", "sqrt", "sin", "cos", "tan", "asin", "acos", "atan", "atan2", "sinh", "cosh", "tanh", "floor", "ceil", "pow",
    "hypot", "log1p", "expm1", "fabs", "memcpy", "memset", "memmove", "sincos", "_GLOBAL_OFFSET_TABLE_", "__stack_chk_fail",
}  # fmt: skip


@pytest.mark.slow
@pytest.mark.compiler
def test_size_in_the_readme_is_the_size(tmp_path):
    if shutil.which("gcc") is None:
        pytest.skip("gcc is not installed")
    program = tmp_path / "size.c"
    program.write_text(
        '#include <stdio.h>\n#include "softsoil.h"\n'
        'int main(void) { printf("%lu", (unsigned long)sizeof(softsoil_t)); return 0; }\n',
        encoding="utf-8",
    )
    for name in EVERY:
        built = run("gcc", f"-I{folder(name) / 'include'}", str(program), "-o", str(tmp_path / "size"))
        size = run(str(tmp_path / "size")).stdout
        assert built.returncode == 0 and f"({size} bytes" in (folder(name) / "README.md").read_text(encoding="utf-8")
