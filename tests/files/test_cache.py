"""The cache: scratch of killed processes is removed, that of living ones stays; a read-only home costs the cache only."""

import os
import platform
import signal
import subprocess
import sys
import time

from drives import PROJECT
from softsoil.files import cache
from softsoil.files.cache import ABANDONED, SCRATCH, cache_folder, scratch_folder, writable_cache

HOLD = """
import sys, time
from pathlib import Path
from softsoil.files.cache import scratch_folder
with scratch_folder(Path(sys.argv[1])) as folder:
    print(folder, flush=True)
    time.sleep(60)
"""


def test_a_scratch_folder_disappears(tmp_path):
    with scratch_folder(tmp_path) as folder:
        assert folder.parent == tmp_path and list(tmp_path.iterdir()) == [folder]
    assert list(tmp_path.iterdir()) == []


def test_what_a_killed_process_left_is_removed_by_the_next(tmp_path):
    environment = os.environ | {"PYTHONPATH": str(PROJECT)}
    command = [sys.executable, "-c", HOLD, str(tmp_path)]
    with subprocess.Popen(command, stdout=subprocess.PIPE, text=True, env=environment) as process:
        assert process.stdout is not None
        held = process.stdout.readline().strip()
        with scratch_folder(tmp_path) as own:
            assert {str(path) for path in tmp_path.iterdir()} == {held, str(own)}, "a living process keeps its folder"
        process.send_signal(signal.SIGKILL)
    assert [str(path) for path in tmp_path.iterdir()] == [held]
    with scratch_folder(tmp_path):
        pass
    assert list(tmp_path.iterdir()) == []


def test_old_scratch_of_other_machines_is_removed(tmp_path):
    for name, age in (("elsewhere_1_a", 2 * ABANDONED), ("elsewhere_1_b", 0.0), (f"{platform.node()}_99999999999_c", 0.0)):
        path = tmp_path / f"{SCRATCH}{name}"
        path.mkdir()
        os.utime(path, (time.time() - age,) * 2)
    with scratch_folder(tmp_path):
        names = {path.name for path in tmp_path.iterdir()}
    assert f"{SCRATCH}elsewhere_1_a" not in names and len(names) == 3


def test_a_cache_that_cannot_be_made_is_a_folder_of_the_process(tmp_path, monkeypatch):
    (tmp_path / "file").write_text("", encoding="utf-8")
    monkeypatch.setenv("SOFTSOIL_CACHE", str(tmp_path / "file" / "cache"))
    folder = writable_cache()
    assert folder.is_dir() and tmp_path not in folder.parents


def test_a_container_of_the_same_name_does_not_take_this_ones_scratch(tmp_path, monkeypatch):
    """Its processes have numbers of their own: one that is not there may live here."""
    with scratch_folder(tmp_path) as own:
        monkeypatch.setattr(cache.Path, "readlink", lambda _: "pid:[42]")
        monkeypatch.setattr(cache.os, "kill", lambda *_: (_ for _ in ()).throw(ProcessLookupError))
        with scratch_folder(tmp_path):
            assert own.is_dir()


def test_a_number_that_no_process_has_ends_nothing(tmp_path):
    strange = tmp_path / f"{cache._here()}99999999999_c"
    strange.mkdir()
    with scratch_folder(tmp_path):
        assert strange.is_dir()


def test_a_user_without_a_home_has_a_cache(tmp_path, monkeypatch):
    def nowhere():
        raise RuntimeError("Could not determine home directory.")

    monkeypatch.delenv("SOFTSOIL_CACHE", raising=False)
    monkeypatch.setattr(cache.Path, "home", nowhere)
    monkeypatch.setenv("XDG_CACHE_HOME", str(tmp_path))
    assert cache_folder() == tmp_path / "softsoil"
    monkeypatch.delenv("XDG_CACHE_HOME")
    assert writable_cache().is_dir()
