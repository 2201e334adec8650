"""Effects and force laws in a user's own folder."""

import os
import re
import subprocess
import sys

import pytest

from drives import PROJECT
from softsoil.codegen.text_cache import _key
from softsoil.files.own_modules import EFFECTS, LARGE, LAWS, module_names
from softsoil.files.package_data import VEHICLES

PAGE = PROJECT / "docs" / "tutorials" / "add-an-effect.md"
LAW = '''"""Half of the forces of turn_slip."""

from dataclasses import dataclass, replace

from softsoil.symbolic.wheel import force_law


@dataclass(frozen=True)
class HalfForce:
    name = "half_force"

    def __call__(self, soil, wheel, contact):
        whole = force_law("turn_slip")(soil, wheel, contact)
        return replace(whole, f_x=whole.f_x / 2, f_y=whole.f_y / 2)
'''
ASKED = """
import softsoil
from softsoil.symbolic.wheel import force_law
vehicle = softsoil.load_vehicle("reference")
model = softsoil.bicycle(vehicle, softsoil.load_soil("clay"), LAW, effects={"air_drag": {"drag": 5.0}})
print("drag" in model.p.names, force_law(LAW).name)
"""


@pytest.fixture
def own(tmp_path):
    """The tutorial's effect and a law, in folders of a user."""
    code = re.search(r"```python\n(.*?)```", PAGE.read_text(encoding="utf-8"), re.S)[1]
    for name, text in (("effects/air_drag.py", code), ("laws/half_force.py", LAW)):
        (tmp_path / name).parent.mkdir()
        (tmp_path / name).write_text(text, encoding="utf-8")
    return {EFFECTS: str(tmp_path / "effects"), LAWS: str(tmp_path / "laws")}


def run(*words, **own):
    return subprocess.run([sys.executable, *words], env={**os.environ, **own}, capture_output=True, text=True, check=False)


def test_effects_and_laws_of_a_users_folders_are_known(own):
    done = run("-c", ASKED.replace("LAW", "'half_force'"), **own)
    assert done.stdout.split() == ["True", "half_force"], done.stderr
    without = run("-c", ASKED.replace("LAW", "'bekker'"))
    assert f"found 'air_drag'; one of your own has its file in a folder that {EFFECTS} names" in without.stderr


def test_commands_take_an_effect_of_a_users_folder(own, tmp_path):
    vehicle = (VEHICLES / "paper.toml").read_text(encoding="utf-8") + "\n[effects.air_drag]\ndrag = 5.0\n"
    (tmp_path / "mine.toml").write_text(vehicle, encoding="utf-8")
    declared = ("--vehicle", str(tmp_path / "mine.toml"), "--soil", "clay", "--law", "hard_ground")
    done = run("-m", "softsoil", "generate", str(tmp_path / "out"), *declared, **own)
    assert done.returncode == 0, done.stderr
    assert "SOFTSOIL_P_drag" in (tmp_path / "out" / "include" / "softsoil.h").read_text(encoding="utf-8")


def test_a_file_that_cannot_be_imported_is_named(own, tmp_path):
    (tmp_path / "effects" / "broken.py").write_text("import no_such_library\n", encoding="utf-8")
    done = run("-m", "softsoil", "generate", str(tmp_path / "out"), "--soil", "clay", **own)
    assert done.returncode == 2
    words = r"error: .*broken\.py: expected a file that can be used, found ModuleNotFoundError: .*\n"
    assert re.fullmatch(words, done.stderr)


CLASH = """
from softsoil.symbolic.effect import Correction, Effect, Layout, Signal

def effect(vehicle):
    mass = Layout.of(Signal("payload_mass", "kg", "its own", 0.0, 0.0, 9.0))
    corrections = {"rates": Correction(lambda q: {}, reads=(), adds=())}
    return Effect("mine", "mine", "load", "mine", mass, {"payload_mass": 1.0}, corrections)
"""


@pytest.mark.parametrize(
    ("text", "words"),
    [
        ("def effect(vehicle):\n    return vehicle.no_such\n", "found AttributeError: 'Vehicle' object has no attribute"),
        (CLASH, "expected parameters with names of their own, found payload_mass, which payload has"),
    ],
)
def test_an_effect_that_cannot_be_made_is_named(text, words, own, tmp_path):
    (tmp_path / "effects" / "mine.py").write_text(text, encoding="utf-8")
    done = run("-c", "import softsoil; softsoil.catalogue(softsoil.load_vehicle('paper'))", **own)
    assert "effects/mine.py: " in done.stderr and words in done.stderr


@pytest.mark.parametrize("text", ["class HalfForce:\n    pass\n", LAW.replace("name =", "called ="), "x = 1\n"])
def test_a_law_that_is_none_is_named(text, own, tmp_path):
    (tmp_path / "laws" / "half_force.py").write_text(text, encoding="utf-8")
    done = run("-c", "from softsoil.symbolic.wheel import force_law; force_law('half_force')", **own)
    assert "force law half_force: expected a dataclass HalfForce with a `name` in half_force.py, found " in done.stderr


def test_what_cannot_be_is_refused(tmp_path, monkeypatch):
    monkeypatch.setenv(EFFECTS, str(tmp_path / "none"))
    with pytest.raises(ValueError, match=f"{EFFECTS}: expected a folder, found none at .*none"):
        module_names([], EFFECTS)
    (tmp_path / "payload.py").touch()
    (tmp_path / "_helper.py").touch()
    monkeypatch.setenv(EFFECTS, str(tmp_path))
    assert module_names([], EFFECTS) == ("payload",)
    with pytest.raises(ValueError, match=r"expected names that no other file has, found payload\.py"):
        module_names([str(PROJECT / "symbolic" / "effects")], EFFECTS)


def test_texts_that_are_kept_are_those_of_the_users_code(tmp_path, monkeypatch):
    monkeypatch.setenv(LAWS, str(tmp_path))
    before = _key(b"")
    (tmp_path / "half_force.py").write_text(LAW, encoding="utf-8")
    with_law = _key(b"")
    (tmp_path / "tyre").mkdir()
    (tmp_path / "tyre" / "coefficients.toml").write_text("share = 0.5\n", encoding="utf-8")
    assert len({before, with_law, _key(b"")}) == 3
    (tmp_path / ".hidden").write_text("x", encoding="utf-8")
    small = _key(b"")
    (tmp_path / "runs.bin").write_bytes(bytes(LARGE + 1))
    large = _key(b"")
    os.utime(tmp_path / "runs.bin", (1.0, 1.0))
    assert small != large != _key(b"") and len({with_law, small, large}) == 3
    monkeypatch.setenv(LAWS, f"{tmp_path}{os.pathsep}{tmp_path}{os.sep}")
    assert module_names([], LAWS) == ("half_force",)
