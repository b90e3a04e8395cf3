"""What element_choice.py measured, as a picture (error against seconds) and as a table in Markdown."""

from __future__ import annotations

import csv
from pathlib import Path

import matplotlib

matplotlib.use("Agg")
import matplotlib.pyplot as plt
from matplotlib.axes import Axes

POISSON = "0.49"
ERROR_TICKS = (0.2, 0.5, 1, 2, 5, 10, 20, 50, 100)
TITLES = {
    "cook": "Cook's membrane",
    "slab": "layered cheek",
    "cheek": "cheek of the published face",
    "face": "published face",
}
COLOURS = {"hexahedron": "#0b6e99", "wedge": "#b7791f", "tetra": "#b03a2e", "tetra10": "#2e7d32"}
NAMES = {"hexahedron": "hexahedra", "wedge": "wedges", "tetra": "tetrahedra", "tetra10": "quadratic tetrahedra"}
LABEL_OFFSETS = {"hexahedron": (7, -8), "wedge": (7, -3), "tetra": (7, 0), "tetra10": (7, -1)}

Row = dict[str, str]


def report(directory: Path) -> None:
    """Draw the measurements found in a directory as elements.png and print their table."""
    found = {name: directory / f"elements_{name}.csv" for name in TITLES}
    measured = {name: list(csv.DictReader(path.open())) for name, path in found.items() if path.exists()}
    figure, panels = plt.subplots(2, 2, figsize=(10.0, 7.6), sharey=True)
    for axes, (name, rows) in zip(panels.flat, measured.items(), strict=False):
        _panel(axes, [row for row in rows if row["poisson"] == POISSON and float(row["error_percent"]) > 0.0])
        axes.set_title(TITLES[name], fontsize=11)
        axes.set_xlabel("seconds of one equilibrium, one core")
        axes.set_ylabel("error of the displacement, %")
    figure.suptitle(f"Poisson's ratio {POISSON}; solid with mean dilatation, dashed without", fontsize=11)
    figure.tight_layout()
    figure.savefig(directory / "elements.png", dpi=110)
    plt.close(figure)
    print("\n".join(_table(measured)))


def _table(measured: dict[str, list[Row]]) -> list[str]:
    """Lines of a table: error and seconds of linear elements on the finest level, quadratic ones with as many nodes."""
    columns = [(element, mean) for element in COLOURS for mean in ("False", "True")]
    columns.remove(("tetra", "True"))
    heads = [NAMES[element] + (", mean dilatation" if mean == "True" else "") for element, mean in columns]
    lines = [" | ".join(["| problem", "components", "nu", *heads, ""]).rstrip(), "|---" * (3 + len(heads)) + "|"]
    for name, rows in measured.items():
        finest = max(int(row["level"]) for row in rows if row["element"] == "tetra")
        level = {**dict.fromkeys(COLOURS, str(finest)), "tetra10": str(finest - 1)}
        size = next(
            row["free_components"] for row in rows if (row["element"], row["level"]) == ("tetra", level["tetra"])
        )
        for poisson in dict.fromkeys(row["poisson"] for row in rows):
            same = [row for row in rows if row["poisson"] == poisson and row["level"] == level[row["element"]]]
            cells = {(row["element"], row["mean_dilatation"]): row for row in same}
            texts = [_cell(cells.get(column)) for column in columns]
            lines.append(" | ".join([f"| {TITLES[name]}", size, poisson, *texts, ""]).rstrip())
    return lines


def _cell(row: Row | None) -> str:
    if row is None:
        return "-"
    error = float(row["error_percent"])
    return f"{error:.2g} %, {float(row['seconds']):.2g} s" if error else "reference"


def _panel(axes: Axes, rows: list[Row]) -> None:
    for element, colour in COLOURS.items():
        for mean_dilatation, style in (("True", "-"), ("False", "--")):
            line = [row for row in rows if (row["element"], row["mean_dilatation"]) == (element, mean_dilatation)]
            if not line:
                continue
            seconds, errors = ([float(row[key]) for row in line] for key in ("seconds", "error_percent"))
            axes.loglog(seconds, errors, style, color=colour, marker="o", markersize=4, linewidth=1.6)
            if mean_dilatation == "True" or element == "tetra":
                axes.annotate(NAMES[element], (seconds[-1], errors[-1]), LABEL_OFFSETS[element],
                              textcoords="offset points", color=colour, fontsize=9)  # fmt: skip
    axes.grid(which="major", color="0.9")
    axes.set_axisbelow(True)
    left, right = axes.get_xlim()
    axes.set_xlim(left, right * (right / left) ** 0.5)  # room for the names
    axes.minorticks_off()
    axes.set_yticks(ERROR_TICKS)
    for axis in (axes.xaxis, axes.yaxis):
        axis.set_major_formatter("{x:g}")
