"""The command line: one console script, `softsoil`; each command stands in its own module."""

from __future__ import annotations

import typer

from mpc_demo.commands_bench import bench
from mpc_demo.commands_blind import blind_test
from mpc_demo.commands_calibrate import calibrate
from mpc_demo.commands_case import case_app
from mpc_demo.commands_drive import drive
from mpc_demo.commands_estimate import estimate
from mpc_demo.commands_generate import generate
from mpc_demo.commands_refine import refine_command
from mpc_demo.commands_residual import residual
from mpc_demo.commands_study import study
from mpc_demo.commands_sweep import sweep
from mpc_demo.guard import Guarded

app = typer.Typer(
    cls=Guarded,
    name="softsoil",
    help="Vehicles on deformable soil: terrain estimated, states predicted, models refined from logs.",
    no_args_is_help=True,
    add_completion=False,
    pretty_exceptions_enable=False,
)

for command in (study, estimate, residual, generate, calibrate, sweep, bench, drive):
    app.command()(command)
app.command("refine")(refine_command)
app.command("blind-test")(blind_test)
app.add_typer(case_app, name="case")


def main() -> None:
    """Run the command line; exits with 0 (done), 2 (bad input) or 1 (a failure of its own)."""
    app()


if __name__ == "__main__":
    main()
