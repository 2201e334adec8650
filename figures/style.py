"""One look for all figures: colours by meaning, light axes, a title that says what is seen."""

from __future__ import annotations

from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path
from types import MappingProxyType
from typing import Any

import matplotlib
from matplotlib.backends.backend_agg import FigureCanvasAgg
from matplotlib.figure import Figure
from matplotlib.text import Text

TRUE = "#1f2933"
INITIAL = "#d1495b"
ESTIMATED = "#00798c"
REAR = "#edae49"
SOFT = "#9aa5b1"

RC: Any = MappingProxyType(
    {
        "font.size": 9,
        "axes.titlesize": 10,
        "axes.titleweight": "bold",
        "axes.titlelocation": "left",
        "axes.spines.top": False,
        "axes.spines.right": False,
        "axes.edgecolor": SOFT,
        "axes.grid": True,
        "grid.color": "#e4e7eb",
        "grid.linewidth": 0.6,
        "axes.axisbelow": True,
        "legend.frameon": True,
        "legend.framealpha": 0.85,
        "legend.edgecolor": "none",
        "legend.fontsize": 8,
        "lines.linewidth": 1.4,
        "figure.dpi": 150,
    }
)


@contextmanager
def page(
    path: Path, title: str, width: float, height: float, rows: int = 1, columns: int = 1, **more: Any
) -> Iterator[Any]:
    """Axes of a page (inches) that is written to `path` as PNG when the block ends; no window system, no global state.

    more: of Figure.subplots, or `mosaic` and more of Figure.subplot_mosaic, which names the axes. The bytes are the same for
    the same content.
    """
    with matplotlib.rc_context(dict(RC)):
        figure = Figure(figsize=(width, height), layout="constrained")
        FigureCanvasAgg(figure)
        figure.suptitle(title, x=0.01, ha="left", fontsize=12, fontweight="bold")
        yield figure.subplot_mosaic(**more) if "mosaic" in more else figure.subplots(rows, columns, **more)
        literal(figure)
        figure.savefig(path, metadata={"Software": None})


def literal(figure: Figure) -> None:
    """Take every text as it stands: two dollar signs in a log's name are no mathematics; decades of logarithmic scales are."""
    scales = [scale for axes in figure.axes for scale in (axes.xaxis, axes.yaxis) if scale.get_scale() == "log"]
    decades = {label for scale in scales for which in ("major", "minor") for label in scale.get_ticklabels(which=which)}
    for text in figure.findobj(Text):
        if text not in decades:
            text.set_parse_math(False)


def second_scale(axis: Any, label: str, color: str) -> Any:
    """A second vertical scale to the right, in the colour of what it measures."""
    right = axis.twinx()
    right.set_ylabel(label, color=color)
    right.grid(False)
    right.spines["right"].set_visible(True)
    right.tick_params(axis="y", colors=color)
    return right
