"""The joint error of identified numbers: lengths and ranges, its table in a file, and back."""

import tomllib

import numpy as np
import pytest

from softsoil.files.joint_error import joint_error_from_table, joint_error_of

COVARIANCE = np.array([[4.0, 1.2, 0.0], [1.2, 9.0, -2.0], [0.0, -2.0, 1.0]])
NAMES = ("track", "scrub", "toe")


def test_a_covariance_comes_back_from_its_table():
    error = joint_error_of(NAMES, COVARIANCE)
    assert error.covariance == pytest.approx(COVARIANCE, rel=1e-5, abs=1e-9)
    table = tomllib.loads("\n".join(error.toml()))["joint_error"]
    assert joint_error_from_table(table, {*NAMES, "other"}, "here") == error
    assert joint_error_from_table({}, {*NAMES}, "here") is None


def test_the_error_of_some_numbers_is_their_part():
    error = joint_error_of(NAMES, COVARIANCE)
    part = error.only({"toe", "scrub"})
    assert part.names == ("scrub", "toe") and part.covariance == pytest.approx(error.covariance[1:, 1:])
    assert error.only({"colour"}) is None


@pytest.mark.parametrize(
    ("change", "words"),
    [
        ({"std": [1.0, 2.0]}, "expected a std and a row"),
        ({"std": [1.0, -2.0, 1.0]}, "expected positive standard deviations"),
        ({"correlation": [[], [2.0], [0.0, 0.0]]}, "expected correlations from -1 to 1"),
        ({"correlation": [[], [0.9], [0.9, -0.9]]}, "found an eigenvalue of -0.80"),
        ({"correlation": [[], [0.2], [0.0]]}, "expected a std and a row"),
        ({"names": ["track", "track", "toe"]}, "different names"),
        ({"names": ["track", "colour", "toe"]}, "found 'colour'"),
        ({"names": ["track", ["scrub"], "toe"]}, "found \\['scrub'\\]"),
        ({"names": "track"}, "expected lists"),
        ({"names": [], "std": [], "correlation": []}, "expected a std and a row"),
        ({"std": [1.0, "wide", 1.0]}, "joint_error.std"),
        ({"size": 3}, "expected a table"),
    ],
)
def test_what_is_wrong_is_named_with_its_file(change, words):
    table = {"names": [*NAMES], "std": [1.0, 2.0, 1.0], "correlation": [[], [0.2], [0.0, 0.1]], **change}
    with pytest.raises(ValueError, match=f"here: .*{words}"):
        joint_error_from_table(table, {*NAMES}, "here")
