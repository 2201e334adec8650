"""Single-wheel runs: read, checked, judged; laws against the reference rig where its runs are."""

from dataclasses import replace

import numpy as np
import pandas as pd
import pytest

from softsoil.calibration.single_wheel import call_cost, law_for, predict, quantiles, run_errors
from softsoil.calibration.wheel_report import table_text, wheel_residual
from softsoil.commands.calibrate import split
from softsoil.figures.single_wheel import draw_force_against_slip
from softsoil.recording.rig import SOIL_KEYS, moving_mean, read_rig, read_rigs
from softsoil.recording.wheel_table import hold_out, read_wheel, read_wheel_table
from wheel_runs import SOIL, own_data, sine_run

WHEEL = {"radius": 0.33, "width": 0.21, "contact_step": 0.0}
MAP = """
speed = {column = "v_kmh", unit = "km/h"}
slip_angle = {column = "alpha", unit = "deg"}
slip = "s"
load = {column = "load_kN", unit = "kN"}
f_x = "fx"
f_y = {column = "fy", sign = -1}
"""


def archive(path, **changes):
    names = [("name", "<U8"), *[(k, "<f8") for k in (*SOIL_KEYS, "load", "slip", "speed")]]
    conditions = np.array([("a", *SOIL.values(), 2000.0, 0.1, 5.0)], dtype=names)
    series = np.zeros((1, 20, 5), dtype=np.float32)
    arrays = {
        "conditions": conditions,
        "t": np.arange(20) * 0.005,
        "series": series,
        "channels": np.array(["wheel_yaw", "omega", "fx", "fy", "fz"]),
        **changes,
    }
    np.savez(path, **{key: value for key, value in arrays.items() if value is not None})
    return path


def test_frames_turn_there_and_back():
    run = replace(sine_run(), f_x=np.full(300, 30.0), f_y=np.full(300, 200.0))
    side, ahead = run.lateral(run.f_x, run.f_y), run.longitudinal(run.f_x, run.f_y)
    assert np.allclose(np.hypot(side, ahead), np.hypot(30, 200))


def test_rows_of_a_steady_table_have_their_own_loads():
    still = np.zeros(300)
    table = replace(sine_run(), dt=None, yaw_rate=still, steer_rate=still, dv_y=still, load=np.repeat([1000.0, 3000.0], 150))
    law = law_for("turn_slip", [table])
    moment, mean = (predict(law, [table], load)[0] for load in ("moment", "mean"))
    assert np.array_equal(moment, mean) and np.ptp(moment[1]) > 0.0


def test_moving_mean_keeps_lines_and_ends():
    assert np.allclose(moving_mean(np.full(11, 3.0), 5), 3.0)
    line = np.arange(30.0)
    assert np.allclose(moving_mean(line, 5)[2:-2], line[2:-2])


@pytest.mark.parametrize(
    ("changes", "words"),
    [
        ({"series": None}, "expected arrays conditions"),
        ({"channels": np.array(["wheel_yaw", "omega", "fx", "fy", "f_z"])}, "expected channel 'fz'"),
        ({"t": np.arange(19) * 0.005}, "expected series of shape"),
        ({"series": np.full((1, 20, 5), np.nan, dtype=np.float32)}, "expected finite"),
    ],
)
def test_a_bad_archive_is_named(tmp_path, changes, words):
    path = archive(tmp_path / "clay_val.npz", **changes)
    with pytest.raises(ValueError, match=words):
        read_rig(path)


def test_no_archive_is_named(tmp_path):
    assert len(read_rig(archive(tmp_path / "clay_val.npz"))) == 1
    with pytest.raises(ValueError, match="single-wheel archive"):
        read_rig(tmp_path / "absent.npz")
    (tmp_path / "text.npz").write_text("no archive", encoding="utf-8")
    with pytest.raises(ValueError, match=r"text\.npz"):
        read_rig(tmp_path / "text.npz")
    with pytest.raises(ValueError, match="found none"):
        read_rigs([])


def test_a_folder_s_archives_are_fitted_on_and_judged_on_by_their_names(tmp_path):
    """Several folders, and --judge beside one, as well as one folder alone."""
    folders = [tmp_path / name for name in ("clay", "sand")]
    for i, folder in enumerate(folders):
        folder.mkdir()
        for k, part in enumerate(("cal", "val")):
            series = np.full((1, 20, 5), 10.0 * i + k, dtype=np.float32)
            archive(folder / f"{folder.name}_{part}.npz", series=series)
    fitted, judging = split(folders, None, None, None, None)
    assert [run.omega[0] for run in fitted] == [0.0, 10.0] and [run.omega[0] for run in judging] == [1.0, 11.0]
    fitted, judging = split(folders[:1], folders[1:], None, None, None)
    assert [run.omega[0] for run in fitted] == [0.0] and [run.omega[0] for run in judging] == [11.0]
    with pytest.raises(ValueError, match="--wheel, --soil: expected none beside archives"):
        split(folders, None, None, tmp_path / "wheel.toml", "clay")


def write_table(tmp_path, text="v_kmh,alpha,s,load_kN,fx,fy\n18,10,0.1,2.5,50,-300\n18,-5,-0.2,2.0,-50,150\n"):
    (tmp_path / "rig.csv").write_text(text, encoding="utf-8")
    (tmp_path / "map.toml").write_text(MAP, encoding="utf-8")
    return read_wheel_table(tmp_path / "rig.csv", tmp_path / "map.toml", WHEEL, SOIL, "clay")


def test_a_pause_of_the_logger_is_no_fast_turn_of_the_wheel(tmp_path):
    t = np.concatenate([np.arange(0.0, 5.0, 0.01), np.arange(7.0, 12.0, 0.01)])
    columns = {"t": t, "speed": 1.0, "slip_angle": 0.02 * t, "omega": 3.0, "load": 4000.0, "f_x": 0.0, "f_y": 0.0}
    pd.DataFrame(columns).to_csv(tmp_path / "rig.csv", index=False)
    (run,) = read_wheel_table(tmp_path / "rig.csv", None, WHEEL, SOIL, "clay")
    assert run.yaw_rate == pytest.approx(0.02, abs=1e-6) and np.abs(run.dv_y).max() < 0.03


def test_a_users_table_with_its_own_names_and_units(tmp_path):
    (run,) = write_table(tmp_path)
    assert run.dt is None and len(run) == 2
    assert run.load == pytest.approx([2500, 2000])
    assert run.f_y == pytest.approx([300, -150])
    assert run.v_y == pytest.approx([-5 * np.sin(np.radians(10)), 5 * np.sin(np.radians(5))])
    rim = 0.33 * run.omega
    assert 1 - run.v_x[0] / rim[0] == pytest.approx(0.1)
    assert rim[1] / run.v_x[1] - 1 == pytest.approx(-0.2)


@pytest.mark.parametrize(
    ("text", "words"),
    [
        ("v_kmh,alpha,s,load_kN,fx,fyy\n18,10,0.1,2.5,50,-300\n", "'fy'"),
        ("v_kmh,alpha,s,load_kN,fx,fy\n18,10,0.1,2.5,50,x\n", "row 1"),
        ("v_kmh,alpha,s,load_kN,fx,fy\n18,10,0.1,,50,-300\n", "row 1.*found none"),
        ("v_kmh,alpha,s,load_kN,fx,fy\n18,100,0.1,2.5,50,-300\n", "slip_angle.*degrees"),
        ("v_kmh,alpha,s,load_kN,fx,fy\n18,10,1.2,2.5,50,-300\n", "slip"),
    ],
)
def test_a_bad_table_is_named(tmp_path, text, words):
    with pytest.raises(ValueError, match=words):
        write_table(tmp_path, text)


def test_a_wheel_file(tmp_path):
    path = tmp_path / "wheel.toml"
    path.write_text("radius = 0.058\nwidth = 0.05\n", encoding="utf-8")
    assert read_wheel(path) == {"radius": 0.058, "width": 0.05, "contact_step": 0.0, "patch_length": 0.0}
    path.write_text("radius = -1\nwidth = 0.05\n", encoding="utf-8")
    with pytest.raises(ValueError, match="'radius'"):
        read_wheel(path)


def test_held_out_runs_are_not_fitted_on():
    runs = [replace(sine_run(), name=str(i)) for i in range(7)]
    fit, judge = hold_out(runs)
    assert {r.name for r in fit} & {r.name for r in judge} == set() and len(fit) + len(judge) == 7
    (fit,), (judge,) = hold_out(runs[:1])
    assert len(fit) + len(judge) == len(runs[0])
    with pytest.raises(ValueError, match="three runs"):
        hold_out(runs[:2])


def test_a_law_has_no_error_on_its_own_data(tmp_path):
    runs = [sine_run(n=0.5), sine_run(n=0.9, slip=0.3)]
    law = law_for("turn_slip", runs)
    mine = own_data(runs, law)
    assert max(e.lateral for e in run_errors(law, mine)) < 1e-12
    report = wheel_residual(mine, ("bekker", "dallas_refit", "turn_slip"))
    assert report["laws"]["turn_slip"]["p95"] < 1e-12 < report["laws"]["bekker"]["median"]
    assert report["laws"]["dallas_refit"] == {"median": None, "p95": None}
    assert "| turn_slip | 0.0 / 0.0 %" in table_text(report)
    assert draw_force_against_slip(mine, tmp_path / "f.png").stat().st_size > 1000


def test_a_run_outside_the_domain_is_named():
    law = law_for("turn_slip", [sine_run()])
    for change in ({"omega": np.full(300, -1.0)}, {"load": np.full(300, -5.0)}):
        with pytest.raises(ValueError, match=f"sine: contact: expected {next(iter(change))} >= 0"):
            predict(law, [replace(sine_run(), **change)])


def test_quantiles_of_nothing():
    assert quantiles([float("nan")]) == {"median": None, "p95": None}


@pytest.mark.shared
def test_laws_on_the_reference_rig(shared_data):
    """All `val` runs, every seventh for the slow baseline; `softsoil residual` prints the full table."""
    names = ("clay", "sandyloam", "sand")
    runs = [run for soil in names for run in read_rig(shared_data / "chrono_rig" / f"{soil}_val.npz")]
    found = {
        name: quantiles([e.lateral for e in run_errors(law_for(name, runs), runs[::every])])
        for name, every in (("dallas_refit", 7), ("turn_slip", 1), ("turn_slip_calibrated", 1))
    }
    assert found["turn_slip"]["median"] < 0.025 and found["turn_slip"]["p95"] < 0.05
    assert found["turn_slip_calibrated"]["median"] < 0.014 and found["turn_slip_calibrated"]["p95"] < 0.028
    assert found["turn_slip_calibrated"]["median"] < found["dallas_refit"]["median"] / 3


@pytest.mark.shared
@pytest.mark.compiler
def test_a_calibrated_call_costs_no_more_than_half_again(shared_data):
    runs = read_rig(shared_data / "chrono_rig" / "sand_val.npz")[:1]
    names = ("turn_slip", "turn_slip_calibrated")
    costs = [[call_cost(law_for(name, runs), runs) for name in names] for _ in range(4)]  # best of four in turns
    plain, calibrated = np.min(costs, axis=0)
    assert calibrated < 1.5 * plain
