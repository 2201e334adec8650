"""Sweeps: many independent tasks on all cores, or on a Dask cluster, with progress, and resumable where they stopped.

Each finished task is one line of JSON in `results.jsonl`, under a key made of the software's version, the task's name and its
point; a sweep that runs again skips what is there. Results are data only: no pickle is written or read.
"""

from __future__ import annotations

import hashlib
import json
import re
import warnings
from collections.abc import Callable, Iterator, Mapping, Sequence
from contextlib import contextmanager
from dataclasses import dataclass
from importlib.metadata import version
from pathlib import Path
from typing import Any

import joblib

RESULTS = "results.jsonl"
BATCH = 64
"""Tasks handed out together: results reach the disk after each batch at the latest."""
_ADDRESS = re.compile(r"(tcp|tls|ucx|inproc)://\S+\Z")

Point = Mapping[str, Any]
Result = dict[str, Any]


@dataclass(frozen=True)
class Sweep:
    """What a sweep gave: results in the order of the points (None where a task failed); failures: point index -> reason;
    resumed: how many were there before.
    """

    results: Sequence[Result | None]
    failures: Mapping[int, str]
    resumed: int


def run_sweep(
    task: Callable[[Point], Result],
    points: Sequence[Point],
    out: Path,
    workers: int = -1,
    scheduler: str | None = None,
    progress: Callable[[int, int], None] = lambda done, total: None,
) -> Sweep:
    """Run `task` on each point (a mapping of JSON values) and keep the results in `out`.

    task: a module-level function of a point that returns JSON values; workers: processes here (-1: one per core);
    scheduler: address of a Dask scheduler (tcp://host:port), which then has the workers; progress: called with (done, total).
    A task that raises is a failure with its reason, is not kept, and is tried again by the next run.
    Raises ValueError for points that are not JSON, an address that is none, or a results file that is damaged.
    """
    out.mkdir(parents=True, exist_ok=True)
    store = out / RESULTS
    known = read_results(store)
    keys = [point_key(task, point) for point in points]
    todo = [i for i, key in enumerate(keys) if key not in known]
    resumed, failures = len(points) - len(todo), {}
    progress(resumed, len(points))
    with _engine(workers, scheduler) as parallel, store.open("a", encoding="utf-8") as file:
        done = resumed
        for start in range(0, len(todo), BATCH):
            chosen = todo[start : start + BATCH]
            calls = (joblib.delayed(_guarded)(task, dict(points[i])) for i in chosen)
            for i, (result, reason) in zip(chosen, parallel(calls), strict=True):
                done += 1
                if reason is None:
                    known[keys[i]] = result
                    file.write(json.dumps({"key": keys[i], "point": dict(points[i]), "result": result}) + "\n")
                else:
                    failures[i] = reason
                progress(done, len(points))
            file.flush()
    return Sweep([known.get(key) for key in keys], failures, resumed)


def point_key(task: Callable[..., Any], point: Point) -> str:
    """Key of a result: a hash of the software's version, the task's qualified name and the point; ValueError for a point that is
    not JSON."""
    try:
        of_task = f"{version('softsoil')} {task.__module__}.{task.__qualname__}"
        text = json.dumps([of_task, dict(point)], sort_keys=True, allow_nan=False)
    except (TypeError, ValueError) as error:
        raise ValueError(f"sweep: expected points of finite JSON values, found {dict(point)!r}: {error}") from None
    return hashlib.sha256(text.encode()).hexdigest()[:24]


def read_results(store: Path) -> dict[str, Result]:
    """Results by key; a last line cut off by an interruption is dropped. ValueError for any other damaged line."""
    if not store.is_file():
        return {}
    lines = store.read_text(encoding="utf-8").splitlines(keepends=True)
    found: dict[str, Result] = {}
    for number, line in enumerate(lines, 1):
        try:
            entry = json.loads(line if line.endswith("\n") else "")  # a line without its end would be written on
            found[entry["key"]] = entry["result"]
        except (json.JSONDecodeError, KeyError, TypeError):
            if number < len(lines):
                raise ValueError(f"{store}: line {number}: expected a result (JSON), found {line[:60]!r}") from None
            store.write_text("".join(lines[:-1]), encoding="utf-8")
    return found


def _guarded(task: Callable[[Point], Result], point: Point) -> tuple[Result, str | None]:
    """The task's result, or why it failed: one bad point must not end a sweep of thousands."""
    try:
        with warnings.catch_warnings():
            warnings.simplefilter("ignore")  # a worker's would come with file names, once per process
            return task(point), None
    except Exception as error:
        return {}, f"{type(error).__name__}: {error}"


@contextmanager
def _engine(workers: int, scheduler: str | None) -> Iterator[joblib.Parallel]:
    """joblib on this machine's processes, or on the cluster behind `scheduler`."""
    if scheduler is None:
        with joblib.Parallel(n_jobs=workers) as parallel:
            yield parallel
        return
    if not _ADDRESS.match(scheduler):
        raise ValueError(f"--scheduler: expected an address like tcp://host:8786, found {scheduler!r}")
    try:
        from distributed import Client
    except ImportError:
        raise ValueError(
            "--scheduler: expected the package 'distributed' (pip install .[cluster]), found none"
        ) from None
    try:
        client = Client(scheduler, timeout=10)
    except (OSError, TimeoutError) as error:
        raise ValueError(f"--scheduler: expected a Dask scheduler at {scheduler}, found none: {error}") from None
    with client, joblib.parallel_config(backend="dask"), joblib.Parallel() as parallel:
        yield parallel
