"""The folder as an engineer meets it: the README's one line, a log, a number."""

import gzip
import re
import shutil
import subprocess

import numpy as np
import pandas as pd
import pytest

from c_folders import folder
from c_folders import library as compiled
from drives import CLAY_LOG
from softsoil.codegen.c_library.binding import CFilter
from softsoil.codegen.c_library.horizon_binding import CHorizon
from softsoil.codegen.c_library.vehicle_binding import CVehicle
from softsoil.control.c_horizon import SENTENCES
from softsoil.recording.read import read_drive
from softsoil.recording.states import measured_states
from softsoil.symbolic.bicycle import INPUTS
from softsoil.windows.inputs import measured_inputs

pytestmark = pytest.mark.compiler
SKIP = 2.0
PRINTED = 1e-3
"""The example takes its clock from the log, the last digit is rounded."""


@pytest.fixture(scope="module")
def built(tmp_path_factory):
    """A copy of the declared vehicle's folder, where the first half of the README's line has built the example; the other half,
    which runs it."""
    if shutil.which("cc") is None:
        pytest.skip("cc is not installed")
    where = tmp_path_factory.mktemp("example") / "c"
    shutil.copytree(folder("tracks"), where)
    readme = (where / "README.md").read_text(encoding="utf-8")
    (line,) = [line for line in readme.splitlines() if line.startswith("cc ")]
    build, _, runs = line.partition(" && ")
    subprocess.run(build, shell=True, cwd=where, check=True)
    return where, runs


@pytest.fixture(scope="module")
def example(built):
    """Runs the example of the declared vehicle on a table: its output."""
    where, runs = built

    def run(table, code=0):
        table.to_csv(where / "LOG.csv", index=False)
        done = subprocess.run(runs, shell=True, cwd=where, capture_output=True, text=True, check=False)
        assert done.returncode == code and bool(done.stderr) == bool(code), done.stderr
        return done.stdout

    return run


@pytest.fixture(scope="module")
def whole(example):
    """The undisturbed log and what the example says of it."""
    table = pd.read_csv(CLAY_LOG)
    return table, said(example(table))


ROWS = r"^(\d+) of (\d+) rows not used for their time stamps, the motion started again (\d+) times$"


def said(output):
    """(n, its standard deviation) at the end by the filter, of each axle where these differ; the same by the horizon; (rows not
    used, rows, starts)."""
    lines = [re.findall(r" n\w* (\S+) \+- (\S+)", line) for line in output.splitlines()]
    filtered, judged = (np.array(line, dtype=float).ravel() for line in [line for line in lines if line][-2:])
    (rows,) = re.findall(ROWS, output, re.M)
    return filtered, judged, tuple(map(int, rows))


def test_example_prints_n(built):
    where, runs = built
    (where / "LOG.csv").write_bytes(gzip.decompress(CLAY_LOG.read_bytes()))
    done = subprocess.run(runs, shell=True, cwd=where, capture_output=True, text=True, check=False)
    assert done.returncode == 0 and not done.stderr, done.stderr
    filtered, judged, counted = said(done.stdout)

    library = compiled("tracks")
    drive = read_drive(CLAY_LOG)
    first = int(np.searchsorted(drive.t, drive.t[0] + SKIP))
    assert list(INPUTS.names) == library.names["inputs"]
    t, u, y = drive.t[first:], measured_inputs(drive, INPUTS)[0][first:], measured_states(drive)[first:]
    own = CFilter(library, np.append(y[0], 0.5), t=t[0])
    own.replay(t, u, y, every=1)
    expected = [own.x[6], own.std[6]]
    assert np.allclose(filtered, expected, rtol=0, atol=PRINTED)
    assert counted == (0, len(t) - 1, 0)

    horizon = CHorizon(library)
    horizon.options.dt = float(np.diff(drive.t).mean())
    horizon.options.start_up = 0.0
    horizon.start(t[0])
    look = CVehicle(horizon)
    for at, inputs, seen in zip(t, u, y, strict=True):
        horizon.push(inputs, seen, at)
        horizon.update()
        look.update()
    assert np.allclose(judged, np.stack([horizon.n, horizon.std], axis=1).ravel(), rtol=0, atol=PRINTED)
    (verdict,) = re.findall(r"^verdict: (.*)$", done.stdout, re.M)
    assert verdict == SENTENCES[horizon.verdict]


GAP, BACK, SET_BACK, AHEAD = 3.0, 0.5, 5.0, 100.0
"""s: a pause, one stamp too early, the clock set back for good, one stamp too late."""
PATIENCE = 5
AGREES = 0.3
"""Share of its standard deviation by which n at the end of the undisturbed log may be missed: that of rows that are not there."""


def disturbed(table, how):
    """A log with faults of the clock half-way; and (refused rows, starts) that they must cost."""
    out, middle = table.copy(), len(table) // 2
    if how == "gap and stamp":
        out.loc[middle // 2, "t"] -= BACK
        begin = out["t"][middle]
        return out[(out["t"] < begin) | (out["t"] > begin + GAP)], (1 + PATIENCE, 1)
    if how == "set back":
        out.loc[middle:, "t"] -= SET_BACK
        return out, (PATIENCE, 1)
    if how == "ahead":
        out.loc[middle, "t"] += AHEAD
        return out, (1, 0)
    out.loc[middle : middle + 1, "t"] = np.nan
    return out, (2, 0)


@pytest.mark.parametrize("how", ["gap and stamp", "set back", "ahead", "no stamp"])
def test_example_goes_on_after_faults_of_the_clock(example, whole, how):
    table, (filtered, judged, _) = whole
    bad, (refused, starts) = disturbed(table, how)
    theirs, their_judged, counted = said(example(bad))
    assert counted[0] == refused and counted[2] == starts
    for ours, found in ((filtered, theirs), (judged, their_judged)):
        assert np.abs(found - ours)[::2].max() < AGREES * ours[1::2].min()


@pytest.mark.parametrize("missing", [("v",), ("omega_z",), ("v", "omega_z"), ("psi",), ("a_x_imu",)], ids="-".join)
def test_example_on_a_log_without_a_column(example, whole, missing):
    """n within two standard deviations of that of the whole log, no input that is no number, and few measurements gated."""
    table, (filtered, _, _) = whole
    output = example(table.drop(columns=list(missing)))
    theirs, _, (refused, rows, _) = said(output)
    assert refused == 0 and "an input that is not a finite number" not in output
    assert np.abs(theirs - filtered)[::2].max() < 2 * filtered[1::2].min()
    gated = [int(count) for count in re.findall(r"(\d+) x a measurement too far from its prediction", output)]
    assert sum(gated) < 0.01 * rows


def test_example_fails_where_most_rows_are_refused(example, whole):
    """A clock that repeats every stamp three times."""
    table = whole[0].copy()
    table["t"] = np.repeat(table["t"].to_numpy()[::3], 3)[: len(table)]
    output = example(table, code=1)
    assert said(output)[2][0] > len(table) / 2


def test_example_says_what_it_expected(built):
    done = subprocess.run(["./example", "nothing.csv"], cwd=built[0], capture_output=True, text=True, check=False)
    assert done.returncode == 2 and "expected a table" in done.stderr and "nothing.csv" in done.stderr
