"""Words and units for people: every channel and law has them, angles are in degrees, reports read in the dark."""

import math
import re

import pytest

from softsoil.commands import output
from softsoil.commands.error_table import error_table
from softsoil.figures.error_table import rms_table
from softsoil.figures.labels import LAWS, QUANTITIES, law_words, per_cent, plain, quantity, rms
from softsoil.figures.page_html import STYLE, figure, table, words, write_page
from softsoil.recording.drive import CHANNEL_UNITS, STATE_CHANNELS, WHEEL_CHANNELS
from softsoil.refinement.words import in_degrees, with_unit
from softsoil.symbolic.vehicle import NUMBERS
from softsoil.symbolic.wheel import law_names


@pytest.mark.parametrize("name", [*STATE_CHANNELS, *WHEEL_CHANNELS, "steer", "a_x_imu", "a_y_imu"])
def test_a_channel_has_words_and_angles_are_in_degrees(name):
    shown = quantity(name)
    assert "_" not in shown.label and shown.unit
    if CHANNEL_UNITS[name].startswith("rad") and name not in WHEEL_CHANNELS:
        assert shown.unit.startswith("deg") and shown.factor == pytest.approx(180.0 / math.pi)
    else:
        assert shown.factor == 1.0


def test_every_law_has_words():
    assert set(LAWS) == set(law_names())
    assert all("_" not in law_words(name) for name in law_names())
    assert law_words("my_law") == "my law" == plain("my_law")


def test_a_value_in_radians_becomes_degrees_with_its_error():
    assert in_degrees(math.pi, 0.1 * math.pi, "rad") == (pytest.approx(180.0), pytest.approx(18.0), "deg")
    assert in_degrees(math.pi, 0.0, "rad/s")[2] == "deg/s"
    assert in_degrees(2.0, 0.1, "1/rad") == (2.0, 0.1, "1/rad")
    assert with_unit(0.1, 0.01, "rad") == "5.73 ± 0.57 deg" and with_unit(2560.0, 130.0, "kg m^2") == "2560 ± 130 kg m²"
    assert with_unit(0.5, 0.02, "") == "0.500 ± 0.020"


def test_an_error_is_shown_as_its_root_in_the_unit_of_the_channel(capsys):
    assert rms("u", 4.0) == 2.0 and rms("psi", math.pi**2) == pytest.approx(180.0)
    before = {"0.5": dict.fromkeys(STATE_CHANNELS, 4.0)}
    after = {"0.5": {**before["0.5"], "v": 1.0}}
    output.console.print(error_table("Rms error", before, after))
    said = capsys.readouterr().out
    assert re.search(r"lateral velocity, m/s │ +2 │ +1 │ +2.00 ", said) and re.search(r"heading, deg +│ +115 │", said)


def test_an_unknown_quantity_is_shown_by_its_name():
    assert quantity("rut_depth").label == "rut depth" and "rut_depth" not in QUANTITIES


def test_a_page_has_a_dark_mode_and_alternative_texts(tmp_path):
    def draw(path):
        path.write_bytes(b"png")
        return path

    page = write_page(tmp_path / "page.html", "title", [figure(draw, "caption", alt="what it shows"), figure(draw, "caption")])
    text = page.read_text(encoding="utf-8")
    assert "prefers-color-scheme: dark" in STYLE and "invert(1) hue-rotate" in STYLE and STYLE in text
    assert re.findall(r'alt="([^"]+)"', text) == ["what it shows", "caption"]


def test_an_identifier_becomes_words_and_a_share_never_minus_zero():
    assert plain("aligning_f") == "aligning front" and plain("toe_rear") == "toe rear" and plain("load_front") == "load front"
    assert all("_" not in plain(name.name) and len(plain(name.name)) > 2 for name in NUMBERS)
    assert per_cent(-0.004) == "0 %" and per_cent(0.0004, 1, "+") == "+0.0 %" and per_cent(-0.25) == "-25 %"


def test_a_line_of_the_terminal_reads_as_on_paper_and_a_table_scrolls():
    assert words("a bias of 1 +- 2 m/s^2 & more") == "a bias of 1 ± 2 m/s² &amp; more"
    assert table(["<tr></tr>"]).startswith('<div class="scroll"><table><tr>')


def test_a_table_of_errors_has_before_and_after_only_where_something_changed():
    mse = {"0.5": dict.fromkeys(STATE_CHANNELS, 4.0)}
    better = {"0.5": {**mse["0.5"], "v": 1.0}}
    assert rms_table(mse, None).count("rms error") == 1 and "before" not in rms_table(mse, None)
    changed = rms_table(mse, better)
    assert changed.count('class="r better"') == 1 and '<td class="r">2.00</td>' in changed
