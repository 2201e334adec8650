"""What a public function is handed: a model where it takes one, a declaration where it builds the model itself."""

from __future__ import annotations

from typing import Any

from softsoil.declaration.model_file import Declaration
from softsoil.symbolic.model import Model


def check_model(where: str, model: Any) -> None:
    """TypeError, in the name of the function `where`, unless it is a model."""
    if not isinstance(model, Model):
        cure = "its build()" if isinstance(model, Declaration) else "softsoil.bicycle(vehicle, soil)"
        raise TypeError(f"{where}: expected a model, found {_kind(model)}: hand over {cure}")


def check_declaration(where: str, declaration: Any) -> None:
    """TypeError, in the name of the function `where`, unless it is a declaration."""
    if not isinstance(declaration, Declaration):
        cure = "softsoil.Declaration(vehicle, soil), or that of softsoil.load_declaration"
        raise TypeError(f"{where}: expected a declaration, found {_kind(declaration)}: hand over {cure}")


def _kind(value: Any) -> str:
    name = type(value).__name__
    return f"{'an' if name[0] in 'AEIOUaeiou' else 'a'} {name}"
