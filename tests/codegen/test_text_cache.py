"""Texts of the C library that are kept: for the same request, and for no other."""

from pathlib import Path

from drives import reference_vehicle
from softsoil.codegen.text_cache import asked_for, texts_from_cache
from softsoil.declaration.model_file import Declaration, declaration_toml
from softsoil.symbolic.soil import CLAY


def test_a_request_is_what_was_said_and_what_stands_in_its_files(tmp_path: Path) -> None:
    file = tmp_path / "soil.toml"
    file.write_text("n = 0.5", encoding="utf-8")
    first = asked_for(file, "turn_slip", 0.012)
    assert asked_for(file, "turn_slip", 0.012) == first
    assert asked_for(file, "turn_slip", 0.01) != first
    file.write_text("n = 0.6", encoding="utf-8")
    assert asked_for(file, "turn_slip", 0.012) != first
    assert asked_for("ab", "c") != asked_for("a", "bc")


def test_a_declaration_is_no_name_of_a_file() -> None:
    text = declaration_toml(Declaration(reference_vehicle(), CLAY))
    assert text.encode() in asked_for(text, 0.012)


def test_texts_are_made_once(tmp_path: Path, monkeypatch) -> None:
    monkeypatch.setenv("SOFTSOIL_CACHE", str(tmp_path))
    made: list[int] = []

    def make() -> dict[str, str]:
        made.append(1)
        return {"README.md": "text"}

    assert texts_from_cache(b"one", make) == texts_from_cache(b"one", make) == {"README.md": "text"}
    assert len(made) == 1
    texts_from_cache(b"other", make)
    assert len(made) == 2


def test_a_cache_that_cannot_be_written_keeps_nothing(tmp_path: Path, monkeypatch) -> None:
    (tmp_path / "file").write_text("", encoding="utf-8")
    monkeypatch.setenv("SOFTSOIL_CACHE", str(tmp_path / "file"))
    assert texts_from_cache(b"one", lambda: {"README.md": "text"}) == {"README.md": "text"}
