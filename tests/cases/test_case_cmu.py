"""The sand-wheel case on the laboratory's own data: bearing from plates, the missing effect found, judged on angles left out."""

import numpy as np
import pytest

from softsoil.cases.cmu import CANDIDATES, REFINED, run_cmu
from softsoil.cases.cmu_data import SINKAGE_FILE, WHEEL_FILE, SinkageTest, read_sinkage_tests, read_steady_wheel
from softsoil.cases.ploughing_fit import at_bound
from softsoil.cases.sinkage_tests import fit_bearing, standing_force

FOLDER = "cmu_single_wheel_sand"


@pytest.fixture
def folder(shared_data):
    path = shared_data / "real" / FOLDER
    if not path.is_dir():
        pytest.skip("the measured data are not beside the project")
    return path


def test_bearing_is_recovered_from_made_up_tests():
    h = np.linspace(1e-4, 0.045, 400)
    rng = np.random.default_rng(1)
    plates = [
        SinkageTest(f"p{i}", "plate", d, h, 3e6 * (d / 0.06) * h**1.3 * np.pi / 4 * d**2 * np.exp(0.05 * rng.normal()))
        for i, d in enumerate([0.06, 0.08, 0.1] * 4)
    ]
    wheels = [SinkageTest(f"w{i}", "wheel", 0.0, h, standing_force(h, 3.2e6, 1.3, 0.058, 0.05)) for i in range(3)]
    found = fit_bearing([*plates, *wheels], 0.058, 0.05, 22.0, "wheel")
    assert found.n == pytest.approx(1.3, abs=1e-3)
    assert found.k_wheel == pytest.approx(3.2e6, rel=1e-2)
    assert found.width_exponent == pytest.approx(1.0, abs=3 * found.width_exponent_std)
    with pytest.raises(ValueError, match="expected 3 or more of other, found 0"):
        fit_bearing(plates, 0.058, 0.05, 22.0, "other")


def test_faults_are_named(tmp_path):
    with pytest.raises(ValueError, match=WHEEL_FILE):
        read_steady_wheel(tmp_path / WHEEL_FILE, {})
    (tmp_path / WHEEL_FILE).write_text("beta_deg,trial\n0,1\n", encoding="utf-8")
    with pytest.raises(ValueError, match="expected column 'angle_deg'"):
        read_steady_wheel(tmp_path / WHEEL_FILE, {})


@pytest.mark.shared
def test_plates_and_wheel_agree_on_the_sand(folder):
    tests = read_sinkage_tests(folder / SINKAGE_FILE)
    found = fit_bearing(tests, 0.058, 0.05, 22.0, "wheel_smooth")
    assert found.tests == (18, 3)
    assert 1.16 < found.n < 1.45 and found.n_std < 0.03
    assert found.k_plates == pytest.approx(found.k_wheel, rel=0.15)


@pytest.mark.shared
def test_side_wall_and_digging_halve_the_held_out_error(folder):
    chosen = [c for c in CANDIDATES if c.name in ("as_declared", "digging", "side_wall", REFINED)]
    case = run_cmu(folder, bases=("turn_slip",), candidates=chosen)
    error = {c.name: case.error("turn_slip", c.name) for c in chosen}
    assert error[REFINED] < 0.3 * error["as_declared"]
    assert case.error("turn_slip", REFINED, "trial") < 0.3 * error["as_declared"]
    assert min(error["digging"], error["side_wall"]) > 0.7 * error["as_declared"]  # neither alone
    found = case.judged["turn_slip"][REFINED]
    assert not any(at_bound(name, found.values[name]) for name in found.std)
    assert all(
        case.error("turn_slip", REFINED, angle=a) < 0.5 * case.error("turn_slip", "as_declared", angle=a)
        for a in case.angles[1:]
    )


@pytest.mark.shared
def test_a_second_wheel_is_judged_with_nothing_fitted_on_it(folder):
    """The same table as a second wheel without grousers gives the fitted law's own error."""
    chosen = [c for c in CANDIDATES if c.name in ("as_declared", REFINED)]
    case = run_cmu(folder, judge=folder / WHEEL_FILE, bases=("turn_slip",), candidates=chosen)
    other = case.others[0]
    assert other.refined["turn_slip"] == pytest.approx(case.judged["turn_slip"][REFINED].fitted, rel=1e-9)
    taller = run_cmu(folder, folder / WHEEL_FILE, 0.005, ("turn_slip",), chosen).others[0]
    locked = taller.wheel.rim_speed == 0
    assert taller.wheel.run.radius == pytest.approx(0.063)
    assert np.all(
        taller.refined["turn_slip"][locked & (taller.wheel.angle > 0)]
        > other.refined["turn_slip"][locked & (taller.wheel.angle > 0)]
    )
