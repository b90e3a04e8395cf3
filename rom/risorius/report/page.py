"""One page that needs nothing else: no network, no other file, light and dark."""

from __future__ import annotations

from base64 import b64encode
from html import escape
from pathlib import Path
from string import Template

from risorius.report.results import Results, Row, front
from risorius.report.verdict import verdict

COLUMNS = (
    ("operating point", ""),
    ("mean", "mm"),
    ("95 %", "mm"),
    ("max", "mm"),
    ("relative L2", "%"),
    ("coordinates, median", "µs"),
    ("99 %", "µs"),
    ("frame, median", "µs"),
    ("99 %", "µs"),
    ("full / frame", ""),
    ("snapshots", ""),
    ("their solves", "CPU s"),
    ("training", "CPU s"),
)
NOT_KNOWN = "–"


def page(results: Results, light: bytes, dark: bytes) -> str:
    """HTML of the results, with the plot as SVG for light and for dark surroundings."""
    template = Template(Path(__file__).with_name("page.html").read_text(encoding="utf-8"))
    return template.substitute(
        title=escape(results.model),
        size=f"{results.vertices:,}".replace(",", " ") + f" visible vertices, {results.rank} coordinates",
        verdict="\n".join(f"<li>{escape(sentence)}</li>" for sentence in verdict(results)),
        light=b64encode(light).decode(),
        dark=b64encode(dark).decode(),
        tables="\n".join(_table(results, held_out) for held_out in results.sets),
        origins="\n".join(f"<dt>{escape(name)}</dt><dd>{escape(text)}</dd>" for name, text in _origins(results)),
    )


def _table(results: Results, held_out: str) -> str:
    rows = results.of(held_out)
    flags = front([(row.frame.median, row.errors.p95) for row in rows])
    head = "".join(f"<th>{escape(name)}<small>{escape(unit)}</small></th>" for name, unit in COLUMNS)
    body = "\n".join(_line(results, row, flag) for row, flag in zip(rows, flags, strict=True))
    caption = f"{escape(held_out)} held-out input{_count(rows[0])}"
    return f"<table><caption>{caption}</caption><thead><tr>{head}</tr></thead><tbody>\n{body}\n</tbody></table>"


def _count(row: Row) -> str:
    return f", {row.errors.count} snapshots" if row.errors.count else ""


def _line(results: Results, row: Row, on_front: bool) -> str:
    full = results.full.get(row.held_out)
    errors, cost = row.errors, row.offline
    figures = (
        *(f"{1e3 * length:.3f}" for length in (errors.mean, errors.p95, errors.maximum)),
        f"{100 * errors.relative:.2f}",
        *(_us(time) for own in (row.coordinates, row.frame) for time in (own.median, own.p99)),
        _integer(full.seconds / row.frame.median) if full else NOT_KNOWN,
        *(NOT_KNOWN if value is None else _integer(value) for value in (cost.snapshots, cost.solves, cost.training)),
    )
    number = results.names.index(row.name) + 1
    swatch = f'<i style="background:{row.family.colour}"></i>'
    cells = "".join(f"<td>{figure}</td>" for figure in figures)
    return f"<tr{' class=front' if on_front else ''}><th>{swatch}{number} {escape(row.name)}</th>{cells}</tr>"


def _us(seconds: float) -> str:
    return f"{1e6 * seconds:.1f}" if seconds < 1e-4 else _integer(1e6 * seconds)


def _integer(number: float) -> str:
    return f"{number:,.0f}".replace(",", " ")


def _origins(results: Results) -> list[tuple[str, str]]:
    """What was measured where, item by item."""
    own = results.machine
    waiting = "; others used the cores too: 99 % times include waiting for them" if own.busy else ""
    origins = [
        ("errors", results.errors_from),
        (
            "times",
            f"measured in this run: {results.frames} frames of each method and set, in turn, {results.times_from}",
        ),
        *(
            (f"full model, {name}", f"{_integer(1e3 * time.seconds)} ms a solve; {time.origin}")
            for name, time in results.full.items()
        ),
        ("full model from the map", results.continued_from),
        ("machine", f"{own.processor}, {own.cores} cores, {own.date} UTC"),
        ("threads", f"one; of BLAS: {own.threads}"),
        ("load", f"{own.load_before:.1f} before, {own.load_after:.1f} after, processes{waiting}"),
        ("versions", ", ".join(f"{name} {number}" for name, number in own.versions.items())),
    ]
    if not results.full:
        origins.append(("full model", "neither measured nor known: the snapshots were not at hand"))
    if not results.peers:
        origins.append(("other codes", "not measured in this run; benchmarks/reduced_model_peers.py adds them"))
    return origins
