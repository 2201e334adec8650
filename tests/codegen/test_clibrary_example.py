"""The folder as an engineer meets it: the README's one line, a log, a number."""

import gzip
import re
import shutil
import subprocess

import numpy as np
import pytest

from c_folders import SCALAR, folder
from drives import CLAY_LOG
from softsoil.codegen.c_library.binding import CFilter, CLibrary
from softsoil.codegen.c_library.horizon_binding import CHorizon
from softsoil.control.c_horizon import SENTENCES
from softsoil.recording.read import read_drive
from softsoil.recording.states import measured_states
from softsoil.symbolic.bicycle import INPUTS
from softsoil.windows.inputs import measured_inputs

pytestmark = pytest.mark.compiler
SKIP = 2.0
PRINTED = 1e-3
"""The example takes its clock from the log, the last digit is rounded."""


def test_example_prints_n(tmp_path):
    if shutil.which("cc") is None:
        pytest.skip("cc is not installed")
    shutil.copytree(folder("plain"), tmp_path / "c")
    log = tmp_path / "c" / "LOG.csv"
    log.write_bytes(gzip.decompress(CLAY_LOG.read_bytes()))
    readme = (tmp_path / "c" / "README.md").read_text(encoding="utf-8")
    (line,) = [line for line in readme.splitlines() if line.startswith("cc ")]
    done = subprocess.run(line, shell=True, cwd=tmp_path / "c", capture_output=True, text=True, check=False)
    assert done.returncode == 0 and not done.stderr, done.stderr
    found = re.findall(r"n_f (\S+) \+- (\S+)\s+n_r (\S+) \+- (\S+)", done.stdout)[-2:]

    library = CLibrary(folder("plain"), SCALAR)
    drive = read_drive(CLAY_LOG)
    first = int(np.searchsorted(drive.t, drive.t[0] + SKIP))
    assert list(INPUTS.names) == library.names["inputs"]
    u = measured_inputs(drive, INPUTS)[0][first:]
    y = measured_states(drive)[first:]
    x0 = np.concatenate([y[0], [0.5, 0.5]])
    own = CFilter(library, x0, t=drive.t[first])
    own.replay(drive.t[first:], u, y, every=1)
    expected = [own.x[6], own.std[6], own.x[7], own.std[7]]
    filtered, judged = np.array(found, dtype=float)
    assert np.allclose(filtered, expected, rtol=0, atol=PRINTED)

    horizon = CHorizon(library)
    horizon.options.dt = float(drive.t[-1] - drive.t[0]) / (len(drive) - 1)
    horizon.options.start_up = SKIP
    horizon.start(drive.t[0])
    for t, inputs, seen in zip(drive.t, measured_inputs(drive, INPUTS)[0], measured_states(drive), strict=True):
        horizon.push(inputs, seen, t)
        horizon.update()
    assert np.allclose(judged, np.stack([horizon.n, horizon.std], axis=1).ravel(), rtol=0, atol=PRINTED)
    (said,) = re.findall(r"^verdict: (.*)$", done.stdout, re.M)
    assert said == SENTENCES[horizon.verdict]


def test_example_says_what_it_expected(tmp_path):
    if shutil.which("cc") is None:
        pytest.skip("cc is not installed")
    sources = [str(path) for path in (*folder("plain").glob("src/*.c"), folder("plain") / "example.c")]
    include = f"-I{folder('plain') / 'include'}"
    subprocess.run(["cc", include, *sources, "-lm", "-o", str(tmp_path / "example")], check=True)
    done = subprocess.run([str(tmp_path / "example"), "nothing.csv"], capture_output=True, text=True, check=False)
    assert done.returncode == 2 and "expected a table" in done.stderr and "nothing.csv" in done.stderr
