"""Texts in TOML read back as they were."""

import tomllib

import pytest

from softsoil.files.toml_file import table_inside, toml_text


@pytest.mark.parametrize("text", ["clay", 'a "b" \\ c', "a\nb\tc", "\x00\x7f", "grün", "tag\U000e0001x", "\U0001f69c"])
def test_a_text_reads_back(text):
    assert tomllib.loads(f"name = {toml_text(text)}")["name"] == text


@pytest.mark.parametrize(
    ("text", "words"),
    [
        (
            "[vehicle]\nmass = 3\n[uncertainty]\nmass = 1",
            "expected uncertainty inside .vehicle., as vehicle.uncertainty; found it beside",
        ),
        ("vehicle = 3", "expected a table .vehicle., found vehicle = 3"),
    ],
)
def test_what_would_not_be_read_is_refused(text, words):
    with pytest.raises(ValueError, match=rf"file: {words}"):
        table_inside(tomllib.loads(text), "vehicle", {"mass", "uncertainty"}, "file")


def test_a_table_may_be_the_file_or_stand_in_it():
    alone, inside = tomllib.loads("mass = 3"), tomllib.loads("[vehicle]\nmass = 3\n[soil]\nn = 0.5")
    assert table_inside(alone, "vehicle", {"mass"}, "file") == table_inside(inside, "vehicle", {"mass"}, "file") == {"mass": 3}
