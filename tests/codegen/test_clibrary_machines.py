"""The C library on another machine (32-bit ARM under emulation), and under a fuzzer for a moment."""

import importlib.util
import shutil
import subprocess

import pytest

from c_folders import NAMES, folder
from drives import PROJECT

pytestmark = pytest.mark.compiler


def trust():
    path = PROJECT / "benchmarks" / "clibrary_trust.py"
    spec = importlib.util.spec_from_file_location("clibrary_trust", path)
    module = importlib.util.module_from_spec(spec)
    spec.loader.exec_module(module)
    return module


@pytest.mark.parametrize("name", NAMES)
def test_the_same_numbers_on_arm(name, tmp_path):
    commands = trust()
    if any(shutil.which(tool) is None for tool in ("gcc", commands.ARM[0], "qemu-arm")):
        pytest.skip("gcc, the ARM compiler or qemu-arm is not installed")
    here, there = commands.arm_numbers(folder(name), tmp_path)
    assert len(here) == len(there) >= 14
    assert max(abs(a - b) for a, b in zip(here, there, strict=True)) < 1e-9


def test_fuzz_target_runs_its_corpus(tmp_path):
    commands = trust()
    if shutil.which("clang") is None:
        pytest.skip("clang is not installed")
    compiler = ["clang", "-O0", "-fsanitize=fuzzer,address,undefined", *commands.SANITIZERS[1:]]
    try:
        program = commands.build(compiler, folder("plain"), "clibrary_fuzz.c", tmp_path / "fuzz")
    except subprocess.CalledProcessError:
        pytest.skip("clang has no libFuzzer")
    seeds = sorted(commands.CORPUS.iterdir())
    assert len(seeds) >= 20
    done = subprocess.run([str(program), *map(str, seeds)], capture_output=True, text=True, check=False, cwd=tmp_path)
    assert done.returncode == 0, done.stderr[-2000:]
