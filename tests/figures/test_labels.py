"""Words and units for people: every channel and law has them, angles are in degrees, reports read in the dark."""

import math
import re

import pytest

from softsoil.figures.labels import LAWS, QUANTITIES, in_degrees, law_words, plain, quantity
from softsoil.figures.page_html import STYLE, figure, write_page
from softsoil.recording.drive import CHANNEL_UNITS, STATE_CHANNELS, WHEEL_CHANNELS
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


def test_an_unknown_quantity_is_shown_by_its_name():
    assert quantity("rut_depth").label == "rut depth" and "rut_depth" not in QUANTITIES


def test_a_page_has_a_dark_mode_and_alternative_texts(tmp_path):
    def draw(path):
        path.write_bytes(b"png")
        return path

    page = write_page(tmp_path / "page.html", "title", [figure(draw, "caption", alt="what it shows"), figure(draw, "caption")])
    text = page.read_text(encoding="utf-8")
    assert "prefers-color-scheme: dark" in STYLE and STYLE in text
    assert re.findall(r'alt="([^"]+)"', text) == ["what it shows", "caption"]
