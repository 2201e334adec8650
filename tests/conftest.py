"""Shared fixtures: the data beside the project, where it is."""

from pathlib import Path

import pytest

SHARED_DATA = Path(__file__).resolve().parents[2] / "shared" / "data"


@pytest.fixture
def shared_data() -> Path:
    """Folder of the shared data; the test skips where it is absent."""
    if not SHARED_DATA.is_dir():
        pytest.skip("the shared data are not beside the project")
    return SHARED_DATA
