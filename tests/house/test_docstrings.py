"""Every public function and class says what it is for, and what each number that it takes means.

An argument whose type is a class of the project or of Python says itself what it is; a float, an array or an argument
without a type does not.
"""

import ast
import re
from pathlib import Path

import pytest

PROJECT = Path(__file__).resolve().parents[2]
ROOMS = (
    "files", "symbolic", "recording", "checking", "importing", "codegen", "windows", "estimator", "mapping", "calibration",
    "refinement", "identification", "cases", "control",
)  # fmt: skip
SAID_ELSEWHERE = {
    "self", "cls", "q", "x", "u", "p", "dt", "substeps", "args",
    "kwargs", "extra", "more", "key", "item", "other", "start", "stop",
}  # fmt: skip
"""Conventions: x, u, p, q are those of symbolic.model, dt and substeps of discretize; the rest are Python's own protocols."""
NUMBERS = re.compile(r"\b(float|int|bool|Array|ArrayLike|NDArray|ndarray|Scalar)\b")
FILES = sorted(path for room in ROOMS for path in (PROJECT / room).rglob("*.py"))


def public_functions(tree: ast.Module):
    """(function, the docstring that may document it) of a module: its own, and its class's for __init__ and __call__."""
    for node in tree.body:
        if isinstance(node, ast.FunctionDef) and not node.name.startswith("_"):
            yield node, ast.get_docstring(node) or ""
        if isinstance(node, ast.ClassDef) and not node.name.startswith("_"):
            for inner in node.body:
                if isinstance(inner, ast.FunctionDef) and (not inner.name.startswith("_") or inner.name == "__init__"):
                    yield inner, (ast.get_docstring(inner) or "") + " " + (ast.get_docstring(node) or "")


def undocumented(path: Path) -> list[str]:
    faults = []
    tree = ast.parse(path.read_text(encoding="utf-8"))
    module = ast.get_docstring(tree) or ""
    for function, text in public_functions(tree):
        decorators = {getattr(d, "attr", getattr(d, "id", "")) for d in function.decorator_list}
        if decorators & {"overload", "setter"} or (
            path.parent.name == "commands" and function.name == path.stem
        ):
            continue  # a command's options have their own help
        if not text.strip():
            faults.append(f"{function.name}: no docstring")
        for argument in [*function.args.posonlyargs, *function.args.args, *function.args.kwonlyargs]:
            name = argument.arg
            words = name.replace("_", " ")
            kind = ast.unparse(argument.annotation) if argument.annotation is not None else "Scalar"
            if not NUMBERS.search(kind) or kind.startswith("Callable"):
                continue
            if name in SAID_ELSEWHERE or re.search(
                rf"\b({re.escape(name)}|{re.escape(words)})s?\b", f"{text} {module}", re.I
            ):
                continue
            faults.append(f"{function.name}: argument {name!r} is not in its docstring")
    return faults


@pytest.mark.parametrize("path", FILES, ids=lambda path: str(path.relative_to(PROJECT)))
def test_public_docstrings_document_their_arguments(path):
    assert undocumented(path) == []


def test_the_docstring_test_can_fail(tmp_path):
    bad = tmp_path / "bad.py"
    bad.write_text('def f(height, x):\n    """f of x."""\n', encoding="utf-8")
    assert undocumented(bad) == ["f: argument 'height' is not in its docstring"]
