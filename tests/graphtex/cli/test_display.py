"""Displays of progress, fed with events."""

import io

import pytest
from rich.console import Console

from graphtex import events
from graphtex.cli.display import PlainDisplay, QuietDisplay
from graphtex.cli.displays import make_display
from graphtex.cli.live import MOST_LINES, LiveDisplay
from graphtex.cli.tally import Tally
from graphtex.cli.terminal import duration, size, table

STORY = (
    events.Planned("a", "Flat"),
    events.Planned("b", "Slow"),
    events.Planned("c", "Slow"),
    events.Cached("a", 0.001),
    events.Warned("a", "pale"),
    events.Started("b", "parameter seconds: 1 -> 2"),
    events.Progress("b", 0.25, "searching"),
)


def drawn(display: LiveDisplay) -> list[str]:
    """Return the lines that the display would show."""
    console = Console(file=io.StringIO(), width=80)
    with console.capture() as captured:
        console.print(display.picture())
    return captured.get().splitlines()


class Clock:
    """A clock that is set by hand."""

    def __init__(self) -> None:
        self.now = 0.0

    def __call__(self) -> float:
        return self.now


def test_tally_counts_and_tells_warnings_once() -> None:
    tally = Tally()
    assert all(tally.see(event) for event in STORY)
    assert not tally.see(events.Warned("a", "pale"))
    assert tally.see(events.Warned("b", "pale"))
    assert (tally.ended, list(tally.running)) == ({"a": "cached"}, ["b"])
    assert (tally.running["b"].fraction, tally.running["b"].message) == (0.25, "searching")
    tally.see(events.Progress("b", 0.5, ""))  # a message stays until the next
    assert (tally.running["b"].fraction, tally.running["b"].message) == (0.5, "searching")
    tally.see(events.Failed("b", "no"))
    tally.see(events.Skipped("c", "b"))
    assert tally.counts() == "1 cached, 1 failed, 1 skipped"
    assert not tally.see(events.Progress("b", 0.6, "late"))
    assert Tally().counts() == "nothing ran"


def test_a_long_reason_is_cut() -> None:
    stream = io.StringIO()
    PlainDisplay(stream)(events.Started("b", "; ".join(f"input images[{i}]: 0 -> 1" for i in range(20))))
    assert stream.getvalue().endswith("...)\n")
    assert len(stream.getvalue()) < 120


def test_plain_lines_limit_the_rate_of_progress() -> None:
    clock, stream = Clock(), io.StringIO()
    display = PlainDisplay(stream, clock)
    for event in STORY:
        display(event)
    for now in (0.5, 1.9, 2.5, 3.0, 4.6):
        clock.now = now
        display(events.Progress("b", now / 5, "searching"))
    display(events.Finished("b", 4.6))
    display(events.Started("c", ""))
    display(events.Stopped("c"))
    display(events.Stopped(""))
    assert stream.getvalue().splitlines() == [
        "a: cached",
        "warning: a: pale",
        "b: Slow runs (parameter seconds: 1 -> 2)",
        "b: 50% searching",
        "b: 92% searching",
        "b: done in 4.6 s",
        "c: Slow runs",
        "c: stopped",
    ]


def test_the_live_display_has_a_line_for_each_running_node_and_totals() -> None:
    stream = io.StringIO()
    console = Console(file=stream, width=80, force_terminal=True, color_system=None, legacy_windows=False)
    with LiveDisplay(console) as display:
        for event in STORY:
            display(event)
        first, total = drawn(display)
        assert first.split()[0] == "b"
        assert "25%" in first
        assert first.rstrip().endswith("searching")
        assert total.startswith("1 of 3 nodes: 1 cached; ")
        display(events.Finished("b", 2.0))
    shown = stream.getvalue()
    assert "warning: a: pale" in shown
    assert "b: done in 2.0 s" in shown
    assert "a: cached" not in shown
    assert shown.count("\x1b[?25l") == shown.count("\x1b[?25h") == 1  # the cursor is hidden and comes back
    display.close()


def test_the_live_display_shows_some_of_very_many() -> None:
    display = LiveDisplay(Console(file=io.StringIO(), width=80))
    for index in range(MOST_LINES + 5):
        display(events.Started(f"cell[{index}]", ""))
    lines = drawn(display)
    assert len(lines) == MOST_LINES + 2
    assert lines[-2].strip() == "and 5 more"


def test_the_display_fits_stderr(monkeypatch: pytest.MonkeyPatch) -> None:
    assert type(make_display(quiet=True)) is QuietDisplay
    assert type(make_display(quiet=False)) is PlainDisplay
    monkeypatch.setattr("sys.stderr.isatty", lambda: True)
    assert type(make_display(quiet=False)) is LiveDisplay


def test_durations_and_sizes() -> None:
    assert [duration(seconds) for seconds in (0, 0.0996, 59.94, 59.96, 3600)] == [
        "0 ms",
        "100 ms",
        "59.9 s",
        "1 min 00 s",
        "60 min 00 s",
    ]
    assert [size(count) for count in (1023, 1024, 1 << 20, 5 << 40)] == ["1023 bytes", "1.0 KiB", "1.0 MiB", "5.0 TiB"]


def test_tables_wrap_their_last_column_on_terminals(monkeypatch: pytest.MonkeyPatch) -> None:
    rows = [("a", "one two three four five six seven eight nine ten eleven")]
    assert table(rows) == "a  one two three four five six seven eight nine ten eleven"
    monkeypatch.setattr("sys.stdout.isatty", lambda: True)
    monkeypatch.setenv("COLUMNS", "40")
    assert table(rows).splitlines() == ["a  one two three four five six seven", "   eight nine ten eleven"]
    assert table([]) == ""
