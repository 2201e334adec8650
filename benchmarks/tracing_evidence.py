"""The evidence of the tracing's rules, printed again.

`python -m benchmarks.tracing_evidence rules`: every rule with its value, unit, meaning and where its evidence comes from.
`python -m benchmarks.tracing_evidence reference [--data ../shared/data] [NAME ...]`: the independent simulator's drives, each
traced as `benchmarks/refine_drives.py` does; per rule that they decide, the largest figure on drives with nothing added and the
smallest of the effects that were put in, beside the rule's value.
"""

from __future__ import annotations

import argparse
from pathlib import Path

from benchmarks.refine_drives import traced
from softsoil.refinement.excitation import strongest_line
from softsoil.refinement.result import Refinement
from softsoil.refinement.rules import EVIDENCE, RULES
from softsoil.refinement.selection import size
from softsoil.refinement.wheel_speeds import differential_shares
from softsoil.symbolic.catalogue import catalogue


def print_rules() -> None:
    """One line a rule, and the commands of their evidence."""
    for rule in RULES.table():
        print(f"{rule.name:24s} {rule.value!s:12.12s} {rule.unit:22s} {rule.meaning} [{', '.join(rule.evidence)}]")
    for name, command in EVIDENCE.items():
        print(f"[{name}] {command}")


def figures(found: Refinement, effect: str) -> dict[str, float]:
    """Rule -> what a drive says of it: of the effect that was put in, or the largest of any candidate where none was."""
    known = catalogue(found.declaration.vehicle)
    judged = [c for c in found.ranking if c.overall is not None and (not effect or c.name == effect)]
    shares = [share for r in found.recordings for share in differential_shares(r, found.declaration.vehicle).values()]
    table = {
        "least_gain": max((c.gain for c in judged), default=0.0),
        "least_whole": max((c.whole for c in judged), default=0.0),
        "least_size": max((min(size(c.fit, known[c.name]), 9.0) for c in judged), default=0.0),
        "largest_share": max(share for left in found.structure for share in left.share.values()),
        "one_wave": max(map(strongest_line, found.recordings)),
    }
    return table | ({"open": min(shares)} if shares else {})


def main() -> None:
    """Print the rules, or the evidence of the reference drives."""
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("what", choices=("rules", "reference"))
    parser.add_argument("names", nargs="*", help="drives (default: all of the benchmark)")
    parser.add_argument("--data", type=Path, default=Path("../shared/data"), help="folder of the shared data")
    told = parser.parse_args()
    if told.what == "rules":
        print_rules()
        return
    clean: dict[str, list[float]] = {}
    added: dict[str, list[float]] = {}
    for name, effect, _, found in traced(told.data, told.names):
        row = figures(found, effect)
        print(f"{name:24s} {effect or 'nothing added':20s} " + ", ".join(f"{k} {v:.3f}" for k, v in row.items()), flush=True)
        for key, value in row.items():
            (added if effect else clean).setdefault(key, []).append(value)
    for key in clean.keys() | added.keys():
        without = f"at most {max(clean[key]):.3f} with nothing added" if key in clean else ""
        with_ = f"at least {min(added[key]):.3f} with an effect" if key in added else ""
        print(f"{key} = {getattr(RULES, key):g}: " + ", ".join(filter(None, (without, with_))))


if __name__ == "__main__":
    main()
