"""The tracing judged on the independent simulator's drives: what it names on each, against what was put in.

Run: python -m benchmarks.refine_drives [--data ../shared/data] [--noise table5] [--seed 3] [NAME ...]
The model is the reference vehicle with its declared effects; nothing in it was fitted to the effect_* drives. The tracing reads
sensor channels only; what is in each drive is used here, to score. `--low-pass 0.03 u v omega_z --both-ways` smooths channels and
their noise; the names then come before it.
"""

from __future__ import annotations

import argparse
from collections.abc import Callable, Iterator, Sequence
from pathlib import Path

from benchmarks.judges.low_passed import add_filter_options, filtered
from softsoil.commands.options_model import declaration
from softsoil.mpc_demo.blind_test import score
from softsoil.recording.drive import Recording
from softsoil.recording.log_names import named_soil
from softsoil.recording.noise import NOISES, add_noise
from softsoil.recording.read import read_drive
from softsoil.refinement.refine import refine
from softsoil.refinement.result import Refinement
from softsoil.refinement.words import falls

FULL = 0.4404
"""rad of road-wheel angle per unit of steering command, at small commands."""
EFFECTS = {
    "effect_bank": ("bank", "sandy_loam", {"bank": 0.0873}),
    "effect_payload": ("payload", "clay", {"payload_mass": 300.0}),
    "effect_steer_lag": ("steering_lag", "sandy_loam", {"steering_lag": 0.2}),
    "effect_steer_offset": ("steering_offset", "clay", {"steering_offset": 0.08 * FULL}),
    "effect_wind": ("side_force", "sandy_loam", {"side_force": 900.0}),
    "effect_yaw_moment": ("yaw_moment", "clay", {"yaw_moment": 700.0}),
    "effect_locked_axles": ("locked_differential", "sandy_loam", {}),
    "effect_backlash": ("backlash", "sandy_loam", {"backlash": 0.12 * FULL}),
}
"""Drive -> effect, soil class, parameters (data/README.md of the drives)."""
CLEAN = ("multi_", "steps_", "paper_")
"""Drives on which nothing may be named."""


Traced = tuple[str, str, dict[str, float], Refinement]
"""Name of a drive, the effect that was put in (empty for none), its true parameters, and what the tracing says."""


def traced(data: Path, names: Sequence[str], sensed: Callable[[Recording], Recording] = lambda drive: drive) -> Iterator[Traced]:
    """The drives below `data` (those of `names`, default all), as `sensed` makes of them, traced one after the other."""
    for path in sorted((data / "chrono_vehicle").glob("*.csv.gz")):
        name = _name(path)
        if name.startswith(("effect_", *CLEAN)) and (not names or name in names):
            effect, soil, truth = EFFECTS.get(name, ("", named_soil(name) or "clay", {}))
            drive = sensed(read_drive(path))
            found = refine([drive], declaration(None, soil, "turn_slip", None), workers=1)
            yield name, effect, truth, found


def main() -> None:
    """Trace the drives and print one line each."""
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--data", type=Path, default=Path("../shared/data"), help="folder of the shared data")
    parser.add_argument("--noise", default="none", choices=sorted(NOISES), help="of the sensors")
    parser.add_argument("--seed", type=int, default=3, help="of the noise")
    add_filter_options(parser)
    parser.add_argument("names", nargs="*", help="drives (default: effect_*, multi_*, steps_*, paper_*)")
    told = parser.parse_args()

    def sensed(drive: Recording) -> Recording:
        return filtered(add_noise(drive, told.noise, told.seed), told)

    right = count = 0
    for name, effect, truth, found in traced(told.data, told.names, sensed):
        good, why = score({"kind": "effect" if effect else "clean", "name": effect, "truth": truth}, found)
        right, count = right + good, count + 1
        named = " + ".join(e.name for e in found.effects) or found.verdict
        alike = "; ".join(", ".join(group) for group in found.inseparable)
        best = ", ".join(f"{c.name} {100 * c.gain:.0f} ± {100 * c.std:.0f} % ({100 * c.whole:.0f})" for c in found.ranking[:3])
        ratio = falls(found)
        print(
            f"{name:24s} {'right' if good else 'WRONG'}  {named} ({why})"
            + (f"; alike: {alike}" if alike else "")
            + f"; best: {best}; n {found.n_before[0]:.2f} -> {found.n_after[0]:.2f}"
            + (f"; mse at 2.5 s {ratio:.1f} times smaller" if ratio else "")
            + f"; left {max(found.structure[0].share.values()):.2f}; {found.seconds:.0f} s",
            flush=True,
        )
    print(f"{right} of {count} right")


def _name(path: Path) -> str:
    return path.name.removesuffix(".csv.gz")


if __name__ == "__main__":
    main()
