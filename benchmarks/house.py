"""The house as its own imports draw it: `python -m benchmarks.house`.

Rooms from the top down with their lines and what each imports from the rooms below (number of imports); then arrows upwards,
imports that a room's rules forbid, and circles between rooms and between modules. Exit 1 where there is one of the latter.
"""

from __future__ import annotations

from benchmarks.judges.house import ORDER, arrows, circles, forbidden, lines_of, modules, upward


def main() -> int:
    """Print the drawing; 0 for a house without faults."""
    counts = arrows()
    for room in reversed(ORDER):
        below = [(other, counts[room, other]) for other in reversed(ORDER) if (room, other) in counts]
        words = ", ".join(f"{other} {count}" for other, count in below) or "-"
        print(f"{room:<12}{lines_of(room):>6} lines -> {words}")
    edges = {room: {other for (one, other) in counts if one == room} for room in ORDER}
    faults = [f"upwards: {one} -> {other}" for one, other in upward(counts)]
    faults += [f"forbidden: {path.name} imports {module}" for path, module in forbidden()]
    faults += [f"circle of rooms: {', '.join(group)}" for group in circles(edges)]
    faults += [f"circle of modules: {', '.join(group)}" for group in circles(modules())]
    print("\n".join(faults) or "no arrow upwards, no forbidden import, no circle")
    return 1 if faults else 0


if __name__ == "__main__":
    raise SystemExit(main())
