"""Texts in TOML read back as they were."""

import tomllib

import pytest

from softsoil.files.toml_file import toml_text


@pytest.mark.parametrize("text", ["clay", 'a "b" \\ c', "a\nb\tc", "\x00\x7f", "grün", "tag\U000e0001x", "\U0001f69c"])
def test_a_text_reads_back(text):
    assert tomllib.loads(f"name = {toml_text(text)}")["name"] == text
