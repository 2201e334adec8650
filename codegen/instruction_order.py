"""The instructions of a CasADi function in an order that keeps a processor busy.

CasADi's order finishes one expression before it starts the next: a chain in which each operation waits for the one before,
longer than what a processor looks ahead. Here independent chains take turns, as a compiler would schedule them if it could
see past a few hundred instructions. No operation changes, so that no digit does.
"""

from __future__ import annotations

import heapq
from collections.abc import Sequence
from dataclasses import dataclass
from types import MappingProxyType

import casadi as ca

WIDTH = 2.0
"""Operations that are issued in a cycle, about."""
REACH = 1000
"""Instructions that may be brought forward past one that waits: further gains nothing, and compilers take twice the time."""
_COST = MappingProxyType(
    {
        ca.OP_EXP: (70.0, 22.0), ca.OP_LOG: (90.0, 24.0), ca.OP_SQRT: (28.0, 8.0), ca.OP_DIV: (22.0, 5.0), ca.OP_INV: (22.0, 4.0),
        ca.OP_SIN: (70.0, 30.0), ca.OP_COS: (70.0, 30.0),
    }
)  # fmt: skip
"""Latency (cycles) and number of operations in vector registers; everything else is _SIMPLE."""
_SIMPLE = (4.0, 1.0)


@dataclass(frozen=True)
class Instruction:
    """One operation: its CasADi id, what it reads (places in the sequence), and for leaves and outputs where they stand.

    place: (argument, element) of an input or output; constant: value of a constant.
    """

    op: int
    reads: tuple[int, ...]
    place: tuple[int, int] = (0, 0)
    constant: float = 0.0


def instructions(function: ca.Function) -> list[Instruction]:
    """The function's instructions in CasADi's order, reading each other instead of slots of memory that are used again."""
    holds: dict[int, int] = {}
    found: list[Instruction] = []
    for k in range(function.n_instructions()):
        op, into, out = function.instruction_id(k), function.instruction_input(k), function.instruction_output(k)
        if op == ca.OP_INPUT:
            item = Instruction(op, (), (into[0], into[1]))
        elif op == ca.OP_CONST:
            item = Instruction(op, (), constant=function.instruction_constant(k))
        elif op == ca.OP_OUTPUT:
            item = Instruction(op, (holds[into[0]],), (out[0], out[1]))
        else:
            item = Instruction(op, tuple(holds[slot] for slot in into))
        if op != ca.OP_OUTPUT:
            holds[out[0]] = k
        found.append(item)
    return found


def chains(sequence: Sequence[Instruction]) -> list[float]:
    """Cycles from the start of each instruction to the end of the longest chain that waits for it."""
    length = [0.0] * len(sequence)
    for k in reversed(range(len(sequence))):
        if _is_work(sequence[k]):
            length[k] += _latency(sequence[k])
        for j in sequence[k].reads:
            length[j] = max(length[j], length[k])
    return length


def occupancy(sequence: Sequence[Instruction]) -> float:
    """Share of a processor that one run of the sequence can use: cycles of issue over the cycles of its longest chain."""
    longest = max(chains(sequence), default=0.0)
    return sum(_size(item) for item in sequence if _is_work(item)) / WIDTH / longest if longest > 0.0 else 1.0


def _is_work(item: Instruction) -> bool:
    return bool(item.reads) and item.op != ca.OP_OUTPUT


def _latency(item: Instruction) -> float:
    return _COST.get(item.op, _SIMPLE)[0]


def _size(item: Instruction) -> float:
    return _COST.get(item.op, _SIMPLE)[1]


def interleaved(sequence: Sequence[Instruction], together: int = 1) -> list[int]:
    """Places of `sequence` in the new order: what the longest chain waits for first, as soon as its operands are there.

    together: how many times each instruction will stand. Leaves come first, an output right after its value; nothing is
    done more than REACH instructions before its turn.
    """
    work = [k for k, item in enumerate(sequence) if _is_work(item)]
    turn = {k: r for r, k in enumerate(work)}
    chain = chains(sequence)
    readers: list[list[int]] = [[] for _ in sequence]
    stores: list[list[int]] = [[] for _ in sequence]
    for k, item in enumerate(sequence):
        for j in set(item.reads):
            (readers if _is_work(item) else stores)[j].append(k)
    missing = {k: sum(_is_work(sequence[j]) for j in set(sequence[k].reads)) for k in work}
    operands_at = dict.fromkeys(work, 0.0)
    early = [(turn[k], k) for k in work if missing[k] == 0]  # three heaps: operands known, by turn ...
    waiting: list[tuple[float, int]] = []  # ... in reach, by the time of the operands ...
    ready: list[tuple[float, int]] = []  # ... operands there, by the chain behind
    order: list[int] = []
    done, first, clock = [False] * len(work), 0, 0.0
    while first < len(work):
        while early and early[0][0] < first + REACH:
            k = heapq.heappop(early)[1]
            heapq.heappush(waiting, (operands_at[k], k))
        while waiting and (waiting[0][0] <= clock or not ready):
            time, k = heapq.heappop(waiting)
            clock = max(clock, time)
            heapq.heappush(ready, (-chain[k], k))
        k = heapq.heappop(ready)[1]
        order += [k, *stores[k]]
        done[turn[k]] = True
        while first < len(work) and done[first]:
            first += 1
        for j in readers[k]:
            missing[j] -= 1
            operands_at[j] = max(operands_at[j], clock + _latency(sequence[k]))
            if missing[j] == 0:
                heapq.heappush(early, (turn[j], j))
        clock += together * _size(sequence[k]) / WIDTH
    leaves = [k for k, item in enumerate(sequence) if not item.reads]
    return [*leaves, *(k for j in leaves for k in stores[j]), *order]
