"""A library written where another one stood: none of the other's files stay to be built with it."""

from pathlib import Path

from drives import PROJECT
from softsoil.codegen.c_library.build import sources
from softsoil.codegen.c_library.folder import write_library

PLAIN = {path.relative_to(PROJECT / "generated").as_posix(): "text" for path in sorted((PROJECT / "generated").rglob("*.*"))}
MORE = dict.fromkeys(("src/softsoil_driver.c", "src/softsoil_nmpc_roll.c", "include/softsoil_driver.h"), "text")
MORE |= dict.fromkeys(("fmi/fmu_driver.c", "fmi/fmu_common.h"), "text")
MORE |= dict.fromkeys(("fmi/driverDescription.xml", "example_drive.c", "CONTROLLER.md"), "text")


def files_of(folder: Path) -> set[str]:
    return {path.relative_to(folder).as_posix() for path in folder.rglob("*") if path.is_file()}


def test_what_another_library_left_is_taken_away(tmp_path: Path) -> None:
    mine = {"main.c": "mine", "src/robot.c": "mine", "fmi/notes.md": "mine"}
    write_library(tmp_path, PLAIN | MORE | mine)
    (tmp_path / "softsoil_driver.fmu").write_text("", encoding="utf-8")
    without = {name: text for name, text in PLAIN.items() if "vehicle" not in name}
    paths = write_library(tmp_path, without)
    assert files_of(tmp_path) == set(without) | set(mine) and len(without) < len(PLAIN)
    assert {path.relative_to(tmp_path).as_posix() for path in paths} == set(without)
    assert "softsoil_vehicle.c" not in [path.name for path in sources(tmp_path)]
