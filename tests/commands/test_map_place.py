"""Soil maps of logs whose place on the globe is known: longitude and latitude, one frame for logs of several origins."""

import json
from dataclasses import replace

import numpy as np
import pytest
from typer.testing import CliRunner

from drives import MULTI_LOG
from softsoil.commands.cli import app
from softsoil.estimator.verdict import Verdict
from softsoil.importing.local_frame import latitude_longitude, other_frame
from softsoil.mapping.drive_soil import DriveSoil
from softsoil.mapping.frame import frame_of, placed
from softsoil.mapping.soil_map import laid
from softsoil.recording.drive import Recording
from softsoil.recording.read import read_drive, write_drive

HERE, THERE = (48.1374, 11.5755), (48.1392, 11.5790)


def soil(origin, x, y):
    points = np.array(x), np.array(y)
    return DriveSoil("a", Verdict("identified", ""), *points, np.full(len(x), 0.5), np.full(len(x), 9.0), 0.03, origin)


def synthetic_log(k):
    """A straight drive at 2 m/s, k m to the side."""
    t = 0.02 * np.arange(400)
    still = dict.fromkeys(("psi", "v", "omega_z"), np.zeros(400))
    return Recording(f"log_{k}", {"t": t, "x": 2.0 * t, "y": np.full(400, float(k)), "u": np.full(400, 2.0), **still})


def test_a_degree_of_latitude_is_111_kilometres():
    east, north = other_frame("test", np.zeros(1), np.zeros(1), THERE, HERE)
    assert north[0] == pytest.approx((THERE[0] - HERE[0]) * 111.2e3, rel=2e-3)
    assert east[0] == pytest.approx((THERE[1] - HERE[1]) * 111.3e3 * np.cos(np.deg2rad(HERE[0])), rel=4e-3)
    latitude, longitude = latitude_longitude("test", east, north, HERE)
    assert (latitude[0], longitude[0]) == pytest.approx(THERE, abs=1e-7)


def test_logs_of_several_origins_come_into_the_frame_of_the_first():
    east, north = other_frame("test", np.array([3.0]), np.array([-4.0]), THERE, HERE)
    soils = [soil(HERE, [0.0, 1.0], [0.0, 1.0]), soil(THERE, [3.0, 4.0], [-4.0, -4.0])]
    first, second = laid(soils, HERE, 10.0).drives
    assert second.origin == first.origin == HERE
    assert (second.x[0], second.y[0]) == pytest.approx((east[0], north[0]), abs=1e-6)


def test_maps_of_one_origin_share_their_cells_whichever_log_is_first():
    soils = [soil(HERE, [0.0, 1.0], [0.0, 1.0]), soil(THERE, [3.0, 4.0], [-4.0, -4.0])]
    one, other = laid(soils, HERE, 10.0), laid(soils[::-1], HERE, 10.0)
    assert [(c.column, c.row) for c in one.cells] == [(c.column, c.row) for c in other.cells]
    logs = [replace(synthetic_log(0), origin=THERE), synthetic_log(1)]
    assert frame_of(logs) == THERE and frame_of(logs, HERE) == HERE and frame_of(logs[1:]) is None
    with pytest.raises(ValueError, match="an import made of fixes for a map with an origin, found none"):
        frame_of(logs[1:], HERE)
    with pytest.raises(ValueError, match="expected an origin of latitude and longitude in degrees, found 111, 48"):
        frame_of(logs, (111.0, 48.0))


def test_a_log_without_a_place_or_of_another_field_does_not_lose_the_map():
    logs = [replace(synthetic_log(k), origin=place) for k, place in enumerate((HERE, None, (HERE[0] + 1.0, HERE[1])))]
    first, nowhere, far = placed(logs, HERE, 10.0)
    assert first == "" and "its place on the globe is not known" in nowhere and "111 km from the map's origin" in far
    assert placed([replace(log, origin=None) for log in logs], None, 10.0) == ["", "", ""]


def test_a_far_log_that_comes_first_does_not_take_the_map_from_the_others():
    far = HERE[0] + 1.0, HERE[1]
    logs = [replace(synthetic_log(k), origin=place) for k, place in enumerate((far, HERE, THERE))]
    assert frame_of(logs) == HERE and [bool(why) for why in placed(logs, frame_of(logs), 10.0)] == [True, False, False]
    assert frame_of(logs[:2]) == far
    islands = [replace(synthetic_log(k), origin=place) for k, place in enumerate((far, (-17.0, 179.99), (-17.0, -179.99)))]
    assert frame_of(islands) == (-17.0, 179.99)


@pytest.mark.slow
def test_the_map_is_in_longitude_and_latitude(tmp_path):
    log = write_drive(replace(read_drive(MULTI_LOG).between(0.0, 15.0), origin=HERE), tmp_path / "log.parquet")
    assert read_drive(log).origin == HERE
    arguments = ["--soil", "clay", "--all", "--origin", "48.1370", "11.5750", "--out", str(tmp_path / "map")]
    done = CliRunner().invoke(app, ["map", str(log), *arguments])
    assert done.exit_code == 0, done.output
    content = json.loads((tmp_path / "map" / "map.json").read_text(encoding="utf-8"))
    assert content["origin"] == [48.1370, 11.5750] and content["frame"].startswith("WGS 84")
    corners = np.array([cell["geometry"]["coordinates"][0] for cell in content["features"]])
    x, y = (np.ptp(corners[0, :, i]) for i in (0, 1))
    assert y * 111.2e3 == pytest.approx(10.0, rel=5e-3)
    assert x * 111.3e3 * np.cos(np.deg2rad(HERE[0])) == pytest.approx(10.0, rel=1e-2)
    assert np.abs(corners - np.array(HERE[::-1])).max() < 0.005


@pytest.mark.study
@pytest.mark.slow
def test_one_log_that_cannot_be_used_does_not_lose_the_map(tmp_path):
    log = write_drive(read_drive(MULTI_LOG).between(0.0, 12.0), tmp_path / "good.parquet")
    other = read_drive(MULTI_LOG).between(0.0, 1.0)
    short = write_drive(other.with_channels(y=other["y"] + 1.0), tmp_path / "short.parquet")
    (tmp_path / "bad.csv").write_text("a,b\n1,2\n", encoding="utf-8")
    arguments = ["map", str(log), str(short), str(tmp_path / "bad.csv"), "--soil", "clay", "--out", str(tmp_path / "map")]
    done = CliRunner().invoke(app, arguments)
    said = " ".join(done.output.split())
    assert done.exit_code == 0 and "from 1 of 3 drives" in said and "short: left out: expected at least" in said, said
    content = json.loads((tmp_path / "map" / "map.json").read_text(encoding="utf-8"))
    assert [log["used"] for log in content["logs"]] == [True, False, False]
    assert all(log["left_out"] and log["verdict"] is None and log["common"] is None for log in content["logs"][1:])
    hard = CliRunner().invoke(app, ["map", str(log), "--soil", "clay", "--law", "hard_ground", "--out", str(tmp_path / "h")])
    assert hard.exit_code == 2 and "laid on it" not in hard.output, hard.output
    more = [str(tmp_path / "none.csv"), "--soil", "clay", "--out", str(tmp_path / "o")]
    missing = CliRunner().invoke(app, ["map", str(log), *more])
    assert missing.exit_code == 2 and "none.csv" in missing.output and not (tmp_path / "o").exists()
