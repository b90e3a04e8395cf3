"""What is seen of a training while it runs."""

from io import StringIO

from rich.console import Console
from rich.progress import Progress

from risorius.commands.stage_display import Bars, Lines, stage_display


def test_a_log_has_a_line_for_each_stage_and_each_quarter_of_one_that_tells(monkeypatch):
    monkeypatch.setattr("time.monotonic", iter([100.4, 172.0, 180.0, 300.0]).__next__)
    text = StringIO()
    lines = Lines(Console(file=text), begun=100.0)
    lines.begin("modes")
    lines.begin("network")
    for share in (0.1, 0.26, 0.3, 0.9, 1.0):
        lines.reached(share)
    assert text.getvalue().splitlines() == [
        "training 0:00:00 modes",
        "training 0:01:12 network",
        "training 0:01:20 network, 25 %",
        "training 0:03:20 network, 75 %",
    ]


def test_a_terminal_has_a_bar_for_each_stage_and_all_end_full():
    with Progress(console=Console(file=StringIO(), force_terminal=True)) as progress:
        bars = Bars(progress)
        bars.begin("modes")
        assert progress.tasks[0].total is None  # to and fro, as long as nobody knows
        bars.begin("network")
        bars.reached(0.25)
        assert [task.percentage for task in progress.tasks] == [100.0, 25.0]
        bars.end()
        assert progress.finished


def test_what_is_no_terminal_gets_lines_on_standard_error(capsys):
    with stage_display() as stages:
        stages.begin("modes")
    output = capsys.readouterr()
    assert output.out == ""
    assert output.err.endswith("modes\n")
