"""The console script: what was answered before is answered at once, all else goes to the command line."""

from __future__ import annotations

import sys

from softsoil.commands.generate_again import generated_again


def main() -> None:
    """Run the command line; exits with 0 (done), 2 (bad input) or 1 (a failure of its own)."""
    if sys.argv[1:2] == ["generate"] and generated_again(sys.argv[1:]):
        return
    from softsoil.commands.cli import app

    app()


if __name__ == "__main__":
    main()
