"""Summary of a refinement on the terminal."""

from __future__ import annotations

from rich.table import Table

from softsoil.commands.error_table import error_table
from softsoil.commands.output import console
from softsoil.refinement.result import Refinement
from softsoil.refinement.words import (
    bound_words,
    falls_sentence,
    ground_sentences,
    group_sentences,
    left_sentences,
    n_sentences,
    number_words,
    parameter_words,
    split_sentence,
    verdict_sentence,
)

SHOWN = 5
"""Candidates of the ranking that are printed; refine.json and the report have them all."""


def say(found: Refinement) -> None:
    """Print the summary."""
    console.print(verdict_sentence(found), style="bold", highlight=False)
    for effect in found.effects:
        console.print(f"  {effect.name}: {effect.doc}", highlight=False)
        for words in parameter_words(effect):
            console.print(f"    {words}", highlight=False)
    for number_ in found.contradicted:
        console.print(f"  {number_words(number_)}", highlight=False)
    for line in (*group_sentences(found), falls_sentence(found), split_sentence(found)):
        if line:
            console.print(line, highlight=False)
    console.print(ranking_table(found))
    console.print(error_table("Rms error on the part that judges", found.before, found.after))
    if found.fitted:
        console.print(f"Declared numbers as fitted beside {found.unknown}, within what is stated of them:", highlight=False)
    for number_ in found.fitted:
        console.print(f"  {number_words(number_)}", highlight=False)
    lines = (*n_sentences(found), *ground_sentences(found), *left_sentences(found), *found.notes)
    for line in (*lines, f"computed in {found.seconds:.0f} s"):
        console.print(line, highlight=False)


def ranking_table(found: Refinement) -> Table:
    """The best candidates by the share of the held-out cost that each removes on its own."""
    table = Table(title=f"Candidates, each alone beside {found.unknown}", title_justify="left")
    for heading in ("candidate", "held-out gain", "std", ""):
        table.add_column(heading, justify="right" if heading in ("held-out gain", "std") else "left")
    for candidate in found.ranking[:SHOWN]:
        gain, std = f"{100 * candidate.gain:z.1f} %", f"{100 * candidate.std:.1f} %"
        table.add_row(candidate.name, gain, std, bound_words(candidate))
    return table
