"""The table of the documentation's figures and numbers: complete, and able to say that something changed."""

import tomllib

import matplotlib.image
import numpy as np
import pytest

from benchmarks.figures_of_docs import PICTURES, TABLE, difference, figure, nearest, number, picture, value_at
from drives import PROJECT

ENTRIES = tomllib.loads(TABLE.read_text(encoding="utf-8"))


def test_every_picture_has_its_command():
    assert {path.name for path in PICTURES.iterdir()} == {entry["picture"] for entry in ENTRIES["figure"]}


def test_every_picture_is_shown_on_a_page():
    text = "".join(page.read_text(encoding="utf-8") for page in (PROJECT / "docs").rglob("*.md"))
    for entry in ENTRIES["figure"]:
        if (PICTURES / entry["picture"]).is_file():
            assert f"pictures/{entry['picture']})" in text


@pytest.mark.parametrize("entry", ENTRIES["number"], ids=lambda entry: entry["shown"])
def test_the_page_shows_the_number(entry):
    assert entry["shown"] in (PROJECT / entry["page"]).read_text(encoding="utf-8")


def test_a_number_beyond_its_scatter_is_named(tmp_path):
    page = next(entry for entry in ENTRIES["number"] if "key" in entry)
    entry = {"page": page["page"], "shown": page["shown"], "pattern": r"ratio ([\d.]+)", "scatter": 0.1}
    said = float(page["shown"].split()[0])
    assert number(entry, tmp_path, f"ratio {1.05 * said}", False).startswith("as before")
    assert number(entry, tmp_path, f"ratio {1.2 * said}", False).startswith("changed")
    assert number({**entry, "shown": "no such words"}, tmp_path, "ratio 1", False).startswith("changed")
    assert value_at({"rows": [{"name": "a", "ratio": 2.0}]}, "rows.a.ratio") == 2.0


def test_a_picture_that_changed_is_named(tmp_path):
    stored = PICTURES / "conventions.png"
    same = (tmp_path / "conventions.png").write_bytes(stored.read_bytes())
    assert same and figure({"picture": "conventions.png"}, tmp_path, "", False) == "as before"
    image = matplotlib.image.imread(stored)[..., :3].copy()
    image[: len(image) // 2] = 1.0 - image[: len(image) // 2]
    matplotlib.image.imsave(tmp_path / "conventions.png", np.clip(image, 0.0, 1.0))
    assert figure({"picture": "conventions.png"}, tmp_path, "", False).startswith("changed")
    assert difference(tmp_path / "absent.png", picture(stored, 0)) == 1.0


def test_the_nearest_line_takes_the_place_of_an_old_one():
    printed = ("0.5 s: ratio 5.9", "2.5 s: ratio 6.1", "other 2.5 s")
    assert nearest("2.5 s: ratio 5.4", printed) == "2.5 s: ratio 6.1"
    assert nearest("...", printed) is None and nearest("nothing like it", printed) is None
