"""The plot: error against time, both logarithmic, one column for each held-out set, the Pareto front drawn."""

from __future__ import annotations

import io
from collections.abc import Callable, Sequence
from dataclasses import dataclass
from typing import Any

from risorius.errors import MissingExtraError
from risorius.report.candidates import Family
from risorius.report.results import Results, Row, front

FULL = "#D55E00"
MARKER = 11.0  # points: a number fits in
FINEST = 1e-3  # mm: smaller errors are drawn there, where nobody sees them


@dataclass(frozen=True)
class Theme:
    """Colours of paper, ink and grid."""

    paper: str
    ink: str
    grid: str


LIGHT = Theme("#ffffff", "#1b1f24", "#d8dde3")
DARK = Theme("#14181d", "#e6e9ed", "#3a424c")


@dataclass(frozen=True)
class _Axis:
    title: str
    seconds: Callable[[Row], tuple[float, float]]


AXES = (
    _Axis("time to coordinates, µs", lambda row: (row.coordinates.median, row.coordinates.p99)),
    _Axis("time of the whole frame, µs", lambda row: (row.frame.median, row.frame.p99)),
)


def require_matplotlib() -> None:
    """Raise MissingExtraError when there is nothing to draw with: better before the measurement than after it."""
    try:
        import matplotlib  # noqa: F401
    except ImportError as error:
        raise MissingExtraError("the plot of the report", "report", "matplotlib") from error


def draw(results: Results, theme: Theme, kind: str) -> bytes:
    """Picture of the results; kind: svg or png."""
    from matplotlib import rc_context
    from matplotlib.figure import Figure

    settings = {"svg.hashsalt": "risorius", "font.size": 9, "text.color": theme.ink, "axes.labelcolor": theme.ink,
                "xtick.color": theme.ink, "ytick.color": theme.ink, "axes.edgecolor": theme.ink,
                "axes.facecolor": theme.paper, "axes.titlesize": 10}  # fmt: skip
    with rc_context(settings):
        columns = len(results.sets)
        figure = Figure(figsize=(1.0 + 6.0 * columns, 9.5), facecolor=theme.paper, layout="constrained")
        panels = figure.subplots(len(AXES), columns, sharey=True, sharex="row", squeeze=False)
        for panel_row, axis in zip(panels, AXES, strict=True):
            for panel, held_out in zip(panel_row, results.sets, strict=True):
                _panel(panel, results, held_out, axis, theme)
            panel_row[0].set_xlim(*_limits(results, axis))
        for panel, held_out in zip(panels[0], results.sets, strict=True):
            panel.set_title(f"{held_out} held-out input")
        for panel_row in panels:
            panel_row[0].set_ylabel("error of visible vertices, mm")
        _legend(figure, results, theme)
        picture = io.BytesIO()
        nothing = {"Date": None, "Creator": None, "Format": None, "Type": None} if kind == "svg" else None
        figure.savefig(picture, format=kind, dpi=160, metadata=nothing)
    return picture.getvalue()


def _panel(panel: Any, results: Results, held_out: str, axis: _Axis, theme: Theme) -> None:
    rows = results.of(held_out)
    panel.set_xscale("log")
    panel.set_yscale("log")
    panel.grid(True, which="major", color=theme.grid, linewidth=0.6)
    panel.set_axisbelow(True)
    panel.yaxis.set_major_formatter(lambda value, _: f"{value:g}")
    panel.set_xlabel(axis.title)
    full = results.full.get(held_out)
    end = 1e6 * (full.seconds if full else max(axis.seconds(row)[1] for row in rows))
    _draw_front(panel, [(1e6 * axis.seconds(row)[0], _drawn(row.errors.p95)) for row in rows], end, theme)
    for layer, row in enumerate(rows, start=4):
        median, p99 = (1e6 * time for time in axis.seconds(row))
        mean, p95, largest = (_drawn(error) for error in (row.errors.mean, row.errors.p95, row.errors.maximum))
        faint: dict[str, Any] = {"color": row.family.colour, "linewidth": 1.0, "alpha": 0.6, "zorder": 3}
        panel.plot([median, median], [mean, largest], marker="_", markersize=7, **faint)
        panel.plot([median, p99], [p95, p95], linestyle=":", **faint)
        panel.plot([median], [p95], color=row.family.colour, marker=row.family.marker, markersize=MARKER,
                   markeredgecolor=theme.paper, markeredgewidth=0.8, zorder=layer)  # fmt: skip
        panel.annotate(_number(results, row.name), (median, p95), ha="center", va="center", fontsize=7,
                       color=_readable_on(row.family.colour), zorder=layer)  # fmt: skip
    if full:
        panel.axvline(end, color=FULL, linewidth=1.6, linestyle="--")


def _limits(results: Results, axis: _Axis) -> tuple[float, float]:
    """Microseconds from and to which all panels of a row reach, with room for markers."""
    times = [time for row in results.rows for time in axis.seconds(row)]
    return 0.5e6 * min(times), 2e6 * max(*times, *(full.seconds for full in results.full.values()))


def _drawn(metres: float) -> float:
    """Millimetres, as the plot has them."""
    return max(1e3 * metres, FINEST)


def _draw_front(panel: Any, points: Sequence[tuple[float, float]], end: float, theme: Theme) -> None:
    """Steps: what error can be had within a time."""
    best = sorted({point for point, keep in zip(points, front(points), strict=True) if keep})
    times, errors = [time for time, _ in best] + [end], [error for _, error in best] + [best[-1][1]]
    panel.plot(times, errors, drawstyle="steps-post", color=theme.ink, linewidth=1.0, alpha=0.75, zorder=2)


def _legend(figure: Any, results: Results, theme: Theme) -> None:
    """Operating points by number, with their families; then what the lines are."""
    from matplotlib.lines import Line2D

    families = {row.name: row.family for row in results.rows}
    handles = [
        Line2D([], [], color=family.colour, marker=family.marker, linestyle="", markersize=8,
               label=f"{_number(results, name)}  {_described(name, family)}")
        for name, family in families.items()
    ]  # fmt: skip
    handles.append(Line2D([], [], color=theme.ink, linewidth=1.0, label="Pareto front"))
    if results.full:
        handles.append(Line2D([], [], color=FULL, linewidth=1.6, linestyle="--", label="full model, the reference"))
    figure.legend(
        handles=handles,
        loc="outside lower center",
        ncols=3 if len(results.sets) > 1 else 1,
        frameon=False,
        title="marker: 95 % of vertices, median time; bar: mean to largest error; dots: time to the 99th percentile",
        title_fontsize=8,
        fontsize=8,
    )


def _described(name: str, family: Family) -> str:
    return name if family.name in name else f"{name} ({family.name})"


def _number(results: Results, name: str) -> str:
    """Number of an operating point, as in the tables."""
    return str(results.names.index(name) + 1)


def _readable_on(colour: str) -> str:
    """Black or white, whichever stands out: by the luminance of sRGB (Rec. 709)."""
    red, green, blue = (int(colour[at : at + 2], 16) / 255.0 for at in (1, 3, 5))
    return "#000000" if 0.2126 * red + 0.7152 * green + 0.0722 * blue > 0.45 else "#ffffff"
