"""`python -m softsoil`: the command line."""

from softsoil.commands.start import main

if __name__ == "__main__":
    main()
