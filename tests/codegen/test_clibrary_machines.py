"""The C library on another machine (32-bit ARM under emulation), and under a fuzzer for a moment."""

import shutil
import subprocess

import pytest

import benchmarks.judges.c_library as judge
from c_folders import NAMES, folder

pytestmark = pytest.mark.compiler
TARGET = "int LLVMFuzzerTestOneInput(const unsigned char *data, unsigned long size) { return data == 0 && size; }"


@pytest.mark.parametrize("name", NAMES)
def test_the_same_numbers_on_arm(name, tmp_path):
    if any(shutil.which(tool) is None for tool in ("gcc", judge.ARM[0], "qemu-arm")):
        pytest.skip("gcc, the ARM compiler or qemu-arm is not installed")
    here, there = judge.arm_numbers(folder(name), tmp_path)
    assert len(here) == len(there) >= 14
    assert max(abs(a - b) for a, b in zip(here, there, strict=True)) < 1e-9


def test_fuzz_target_runs_its_corpus(tmp_path):
    if shutil.which("clang") is None:
        pytest.skip("clang is not installed")
    compiler = ["clang", "-O0", "-fsanitize=fuzzer,address,undefined", *judge.SANITIZERS[1:]]
    if not judge.compiles(compiler, TARGET):
        pytest.skip("clang has no libFuzzer")
    program = judge.build(compiler, folder("plain"), "clibrary_fuzz.c", tmp_path / "fuzz")
    seeds = sorted(judge.CORPUS.iterdir())
    assert len(seeds) >= 20
    done = subprocess.run([str(program), *map(str, seeds)], capture_output=True, text=True, check=False, cwd=tmp_path)
    assert done.returncode == 0, done.stderr[-2000:]
