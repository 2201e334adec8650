"""Each of several logs has a name of its own."""

import numpy as np

from softsoil.recording.drive import Recording
from softsoil.recording.log_names import distinct


def drive(name, path=None):
    return Recording(name, {"t": np.arange(3.0)}, meta={} if path is None else {"path": path})


def names(*drives):
    return [one.name for one in distinct(drives)]


def test_other_names_stay():
    assert names(drive("a", "monday/a.csv"), drive("b", "monday/b.csv")) == ["a", "b"]


def test_logs_that_share_a_name_are_called_by_their_folders():
    drives = drive("run", "monday/run.csv"), drive("b"), drive("run", "friday/run.csv")
    assert names(*drives) == ["run (monday)", "b", "run (friday)"]


def test_where_folders_do_not_help_they_are_numbered():
    assert names(drive("run", "monday/run.csv"), drive("run", "monday/run.csv")) == ["run (1)", "run (2)"]
    assert names(drive("run"), drive("run")) == ["run (1)", "run (2)"]
