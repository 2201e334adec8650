"""Summary of an identification on the terminal."""

from __future__ import annotations

from rich.table import Table

from softsoil.commands.error_table import error_table
from softsoil.commands.output import console
from softsoil.figures.labels import per_cent
from softsoil.identification.result import Identification, in_order
from softsoil.identification.words import (
    error_sentence,
    judged_sentences,
    state_words,
    taking_up_sentence,
    value_words,
    verdict_sentence,
)
from softsoil.refinement.words import with_error


def say(found: Identification) -> None:
    """Print the summary, the verdict first."""
    console.print(verdict_sentence(found), style="bold", highlight=False)
    for words in found.asks:
        console.print(f"Next: {words}.", highlight=False)
    console.print(number_table(found))
    if taking_up := taking_up_sentence(found):
        console.print(taking_up, highlight=False)
    for log, (value, std) in found.n.items():
        console.print(f"{log}: n {with_error(value, std)}", highlight=False)
    for line in (error_sentence(found), *judged_sentences(found)):
        console.print(line, highlight=False)
    console.print(error_table(f"Rms error on {found.judged.log}", found.judged.before, found.judged.after))
    said = (note for note in found.notes if ": warning: " not in note)  # where the log was read
    for line in (*said, f"computed in {found.seconds:.0f} s"):
        console.print(line, highlight=False)


def number_table(found: Identification) -> Table:
    """Every number with its state and what an error of one standard deviation costs n."""
    table = Table(title="Numbers of the vehicle", title_justify="left")
    for heading in ("number", "value ± std", "state", "n per std"):
        table.add_column(heading, justify="right" if heading in ("value ± std", "n per std") else "left")
    for name in in_order(found.numbers):
        one = found.numbers[name]
        table.add_row(name, value_words(one), state_words(one), per_cent(0.01 * one.n_percent_per_std, 1, "+"))
    return table
