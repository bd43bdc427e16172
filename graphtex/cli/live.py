"""The live display of a run on a terminal: a line for each running node, with a bar, and a line of totals."""

from rich.console import Console, Group, RenderableType
from rich.live import Live
from rich.progress_bar import ProgressBar
from rich.table import Table
from rich.text import Text

from graphtex import events
from graphtex.cli.display import Display, told
from graphtex.cli.terminal import duration

MOST_LINES = 12  # of running nodes at once
BAR = 20
STYLES: dict[type[events.Event], str] = {
    events.Finished: "green",
    events.Failed: "bold red",
    events.Skipped: "red",
    events.Warned: "yellow",
    events.Stopped: "yellow",
}


class LiveDisplay(Display):
    """Redraws itself ten times a second. What has ended scrolls away above it; cached nodes are only counted."""

    def __init__(self, console: Console | None = None) -> None:
        super().__init__()
        self.console = console or Console(stderr=True, highlight=False)
        self._live = Live(console=self.console, get_renderable=self.picture, refresh_per_second=10, transient=True,
                          redirect_stdout=False, redirect_stderr=True)  # fmt: skip
        self._open = False

    def __enter__(self) -> "LiveDisplay":
        self._live.start()
        self._open = True
        return self

    def close(self) -> None:
        """Take the display away; the lines above it stay."""
        if self._open:
            self._open = False
            self._live.stop()

    def note(self, text: str) -> None:
        """Print a line above the display."""
        self.console.print(Text(text), soft_wrap=True)

    def show(self, event: events.Event) -> None:
        """Print a line above the display for what has ended, and for warnings."""
        if isinstance(event, events.Cached):
            return
        line = told(event)
        if line:
            self.console.print(Text(line, style=STYLES.get(type(event), "")), soft_wrap=True)

    def picture(self) -> RenderableType:
        """Return what is to be seen now."""
        tally = self.tally
        rows = Table.grid(padding=(0, 1))
        for column in ("left", "left", "right", "right"):
            rows.add_column(justify=column, no_wrap=True)
        rows.add_column(ratio=1, no_wrap=True, overflow="ellipsis")
        running = list(tally.running.items())
        for task, state in running[:MOST_LINES]:
            bar = ProgressBar(total=1.0, completed=state.fraction, width=BAR, pulse=False)
            passed = duration(self.clock() - state.began)
            rows.add_row(Text(task, style="bold"), bar, f"{state.fraction:.0%}", passed, Text(state.message, "dim"))
        parts: list[RenderableType] = [rows] if running else []
        if len(running) > MOST_LINES:
            parts.append(Text(f"and {len(running) - MOST_LINES} more", style="dim"))
        total = f"{len(tally.ended)} of {len(tally.nodes)} nodes: {tally.counts()}; {duration(tally.seconds)}"
        parts.append(Text(total, style="dim"))
        return Group(*parts)
