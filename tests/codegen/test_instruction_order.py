"""The order of instructions in generated C: every operand before its use, nothing lost, chains taking turns."""

import casadi as ca
import numpy as np
import pytest

from softsoil.codegen.instruction_order import Instruction, chains, instructions, interleaved, occupancy
from softsoil.symbolic.soil import CLAY
from softsoil.symbolic.wheel import Contact, Wheel, force_law


def wheels(count: int) -> ca.Function:
    """Side forces of some wheels, one after the other."""
    x = ca.SX.sym("x", 4 * count)
    law, wheel = force_law("turn_slip"), Wheel(0.33, 0.21)
    forces = [law(CLAY, wheel, Contact(*ca.vertsplit(x[4 * i : 4 * i + 4]))).f_y for i in range(count)]
    return ca.Function("wheels", [x], [ca.vertcat(*forces)])


@pytest.mark.parametrize("count", [1, 3])
@pytest.mark.parametrize("together", [1, 2])
def test_operands_come_first_and_nothing_is_lost(count, together):
    sequence = instructions(wheels(count))
    order = interleaved(sequence, together)
    place = {k: i for i, k in enumerate(order)}
    assert sorted(order) == list(range(len(sequence)))
    assert all(place[j] < place[k] for k, item in enumerate(sequence) for j in item.reads)


def test_slots_that_are_used_again_are_told_apart():
    """Values through the sequence itself: CasADi's own numbers."""
    function = wheels(1)
    evaluate = {
        ca.OP_ADD: np.add, ca.OP_SUB: np.subtract, ca.OP_MUL: np.multiply, ca.OP_DIV: np.divide, ca.OP_SQ: np.square,
        ca.OP_NEG: np.negative, ca.OP_EXP: np.exp, ca.OP_LOG: np.log, ca.OP_SQRT: np.sqrt, ca.OP_TWICE: lambda a: 2 * a,
        ca.OP_INV: lambda a: 1 / a, ca.OP_ASSIGN: lambda a: a,
    }  # fmt: skip
    x = [5.0, -0.4, 18.0, 2500.0]
    sequence = instructions(function)
    value: dict[int, float] = {}
    for k in interleaved(sequence):
        item = sequence[k]
        if item.op == ca.OP_INPUT:
            value[k] = x[item.place[1]]
        elif item.op == ca.OP_CONST:
            value[k] = item.constant
        elif item.op == ca.OP_OUTPUT:
            assert value[item.reads[0]] == pytest.approx(float(function(x)), rel=1e-12)
        else:
            value[k] = evaluate[item.op](*(value[j] for j in item.reads))


def test_independent_chains_take_turns():
    x = ca.SX.sym("x", 2)
    ends = [x[0], x[1]]
    for i in range(2):
        for _ in range(20):
            ends[i] = ca.exp(ends[i] * 0.5)
    sequence = instructions(ca.Function("f", [x], [ca.vertcat(*ends)]))
    exponentials = [k for k in interleaved(sequence) if sequence[k].op == ca.OP_EXP]
    chain = [k < np.median(exponentials) for k in exponentials]
    assert sum(a != b for a, b in zip(chain[:-1], chain[1:], strict=True)) > 30


def test_occupancy_tells_a_chain_from_independent_work():
    assert occupancy(instructions(wheels(1))) < 1.0 < occupancy(instructions(wheels(3)))
    assert occupancy([]) == 1.0
    line = [Instruction(ca.OP_INPUT, ()), *[Instruction(ca.OP_SQ, (k,)) for k in range(10)]]
    assert chains(line)[0] == 40.0 and occupancy(line) == pytest.approx(10 / 2 / 40)
