"""Sweeps: every point once, resumed where they stopped, failures told apart, the same on a Dask cluster."""

import json
import math
import warnings
from pathlib import Path

import pytest

from softsoil.mpc_demo.sweep import RESULTS, point_key, read_results, run_sweep

POINTS = [{"x": float(i), "name": f"p{i}"} for i in range(7)]


def root(point):
    """A task that fails for negative numbers."""
    return {"root": math.sqrt(point["x"])}


def count_calls(point):
    """A task that leaves a mark in a file, so that calls in other processes can be counted."""
    with Path(point["log"]).open("a", encoding="utf-8") as file:
        file.write("x")
    return {"x": point["x"]}


def test_results_in_order_with_progress(tmp_path):
    seen = []
    sweep = run_sweep(root, POINTS, tmp_path, workers=1, progress=lambda done, total: seen.append((done, total)))
    assert [r["root"] for r in sweep.results] == [math.sqrt(i) for i in range(7)]
    assert not sweep.failures and seen[0] == (0, 7) and seen[-1] == (7, 7)


def test_resumes_without_doing_anything_twice(tmp_path):
    log = tmp_path / "calls"
    points = [{"x": i, "log": str(log)} for i in range(6)]
    run_sweep(count_calls, points[:4], tmp_path, workers=2)
    again = run_sweep(count_calls, points, tmp_path, workers=2)
    assert again.resumed == 4
    assert len(log.read_text(encoding="utf-8")) == 6
    assert [r["x"] for r in again.results] == list(range(6))


def test_an_interrupted_line_is_done_again(tmp_path):
    run_sweep(root, POINTS, tmp_path, workers=1)
    store = tmp_path / RESULTS
    text = store.read_text(encoding="utf-8")
    store.write_text(text[:-9], encoding="utf-8")
    again = run_sweep(root, POINTS, tmp_path, workers=1)
    assert again.resumed == 6 and again.results[6] == {"root": math.sqrt(6)}
    assert len(read_results(store)) == 7


def test_a_line_interrupted_before_its_end_is_done_again(tmp_path):
    """The same file is read once more afterwards: nothing was written on in that line."""
    run_sweep(root, POINTS[:5], tmp_path, workers=1)
    store = tmp_path / RESULTS
    store.write_text(store.read_text(encoding="utf-8")[:-1], encoding="utf-8")
    assert run_sweep(root, POINTS, tmp_path, workers=1).resumed == 4
    assert run_sweep(root, POINTS, tmp_path, workers=1).resumed == len(POINTS)


def test_a_damaged_file_is_named(tmp_path):
    (tmp_path / RESULTS).write_text('nonsense\n{"key": "a", "result": {}}\n', encoding="utf-8")
    with pytest.raises(ValueError, match="line 1"):
        run_sweep(root, POINTS, tmp_path, workers=1)


def test_a_failure_is_reported_and_tried_again(tmp_path):
    points = [{"x": 4.0}, {"x": -1.0}]
    for _ in range(2):
        sweep = run_sweep(root, points, tmp_path, workers=1)
        assert sweep.results == [{"root": 2.0}, None]
        assert list(sweep.failures) == [1] and "ValueError" in sweep.failures[1]


def test_keys_tell_points_and_tasks_apart():
    assert point_key(root, {"a": 1, "b": 2}) == point_key(root, {"b": 2, "a": 1})
    assert len({point_key(root, {"a": 1}), point_key(root, {"a": 2}), point_key(count_calls, {"a": 1})}) == 3
    with pytest.raises(ValueError, match="JSON"):
        point_key(root, {"a": float("nan")})


def test_no_scheduler_is_said(tmp_path):
    with pytest.raises(ValueError, match="tcp://host"):
        run_sweep(root, POINTS, tmp_path, scheduler="localhost")


def test_the_same_on_a_dask_cluster(tmp_path):
    distributed = pytest.importorskip("distributed")
    with distributed.LocalCluster(
        n_workers=2, threads_per_worker=1, processes=False, dashboard_address=None
    ) as cluster:
        sweep = run_sweep(root, POINTS, tmp_path, scheduler=cluster.scheduler_address)
    here = run_sweep(root, POINTS, tmp_path / "here", workers=1)
    assert sweep.results == here.results
    assert json.loads((tmp_path / RESULTS).read_text(encoding="utf-8").splitlines()[0])["result"]


def noisy(point):
    """A task that warns."""
    warnings.warn("from a worker", RuntimeWarning, stacklevel=1)
    return {"x": point["x"]}


def test_warnings_of_tasks_stay_with_them(tmp_path):
    with warnings.catch_warnings():
        warnings.simplefilter("error")
        assert not run_sweep(noisy, POINTS[:2], tmp_path, workers=1).failures


def test_results_of_another_version_do_not_count(monkeypatch):
    key = point_key(root, {"a": 1})
    monkeypatch.setattr("softsoil.mpc_demo.sweep.version", lambda _: "9.9.9")
    assert point_key(root, {"a": 1}) != key
