"""Texts of figures stand as they are: a log may have any name."""

import numpy as np
from matplotlib.figure import Figure

from softsoil.figures.style import literal, page


def test_dollar_signs_in_a_name_are_no_mathematics(tmp_path):
    name = "cost$_$run"
    with page(tmp_path / "a.png", name, 4, 3) as axis:
        axis.plot([0, 1], [0, 1], label=name)
        axis.set(title=name, xlabel=name)
        axis.set_xticks([0, 1], [name, name])
        axis.legend()
    assert (tmp_path / "a.png").stat().st_size > 1000


def test_decades_of_a_logarithmic_scale_are():
    figure = Figure()
    axis = figure.subplots()
    axis.semilogy(np.arange(1, 4), [0.1, 1.0, 10.0])
    literal(figure)
    assert all(label.get_parse_math() for label in axis.yaxis.get_ticklabels())
    assert not any(label.get_parse_math() for label in axis.xaxis.get_ticklabels())
