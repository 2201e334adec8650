"""Tables from CSV, CSV.gz and Parquet as plain numbers: data only, with every fault named by file, column and row."""

from __future__ import annotations

import difflib
import re
import warnings
from pathlib import Path
from typing import Any

import numpy as np
import pandas as pd

SUFFIXES = (".csv", ".csv.gz", ".parquet")


def read_table(path: str | Path) -> pd.DataFrame:
    """The table in a CSV, CSV.gz or Parquet file.

    Raises ValueError for a missing file, a folder, another kind of file, an empty table or a file that cannot be read.
    """
    path = Path(path)
    if path.is_dir():
        raise ValueError(f"{path}: expected a log ({', '.join(SUFFIXES)}), found a folder")
    if not path.is_file():
        raise ValueError(f"{path}: expected a log ({', '.join(SUFFIXES)}), found no such file")
    if not path.name.endswith(SUFFIXES):
        raise ValueError(
            f"{path}: expected a file name ending in {', '.join(SUFFIXES)}, found {path.suffix or 'none'!r}"
        )
    if path.stat().st_size == 0:
        raise ValueError(f"{path}: expected a table, found an empty file")
    try:
        table = pd.read_parquet(path) if path.suffix == ".parquet" else cells(path)
    except (ValueError, OSError, EOFError, UnicodeDecodeError, pd.errors.ParserError) as error:
        reason = (str(error).strip().splitlines() or [type(error).__name__])[0]
        raise ValueError(f"{path}: expected a table, found a file that cannot be read: {reason}") from None
    if len(table) == 0:
        raise ValueError(f"{path}: expected rows of data, found {'a header only' if len(table.columns) else 'nothing'}")
    table.columns = [str(column).strip() for column in table.columns]
    return table


def cells(path: Path, **how: Any) -> pd.DataFrame:
    """The table of a text file as `pandas.read_csv` reads it, each cell under its own name: a separator at the end of rows shifts
    none. ValueError for rows with more cells than names."""
    try:
        with warnings.catch_warnings():
            warnings.simplefilter("error", pd.errors.ParserWarning)
            return pd.read_csv(path, index_col=False, **how)
    except pd.errors.ParserWarning:
        raise ValueError("rows have more cells than there are names of columns: name each, also one of row numbers") from None


def numbers(table: pd.DataFrame, column: str, path: str | Path) -> np.ndarray:
    """(N,) floats of a column; empty cells are NaN. ValueError for a missing column or text, with its row (1: first data row)."""
    if column not in table.columns:
        with_unit = [name for name in table.columns if re.split(r"[\s\[(]", name)[0] == column]
        near = with_unit or difflib.get_close_matches(column, list(table.columns), n=1)
        hint = f"; nearest is {near[0]!r}" if near else ""
        hint += ", whose unit softsoil import reads" if with_unit else ""
        if len(table.columns) == 1 and re.search(r"[;\t|]", table.columns[0]):
            hint = ", separated by commas; softsoil import reads other separators"
        sensors = ", ".join(c for c in table.columns if not c.startswith("true_"))
        raise ValueError(f"{path}: expected column {column!r}{hint}; found columns {sensors}")
    values = pd.to_numeric(table[column], errors="coerce").to_numpy(dtype=float)
    wrong = np.isnan(values) & table[column].notna().to_numpy()
    if pd.api.types.is_float_dtype(table[column]):
        wrong[:] = False
    if wrong.any():
        row = int(np.argmax(wrong))
        raise ValueError(
            f"{path}: column {column!r}, row {row + 1}: expected a number, found {table[column].iloc[row]!r}"
        )
    return values
